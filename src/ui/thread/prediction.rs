//! The window's own copy of the scene follows a command at once, so that a slider stays under the hand while the document is busy.
//!
//! What a command does to it is the scene's to say, as it is for the document. The document's next snapshot replaces the copy, so that
//! a prediction can never become the truth. Cameras and slices are not predicted: they stay where the pictures on the screen are.

use crate::document::effects::Remembered;
use crate::document::{Command, Ground, Place, Scene, ViewCommand};

/// Lets the copy follow; what the document will refuse, or only a picture can tell, leaves it as it is.
pub(crate) fn predict(scene: &mut Scene, command: &Command, ground: &Ground<'_>) {
    let points = matches!(command, Command::View(ViewCommand::Crosshair { at: Place::Mm(_) }));
    if points || command.effects().past != Remembered::View {
        // Whoever refuses it says so.
        let _refused = scene.apply(command, ground);
    }
}
