//! The short sentence at the pointer.

use egui::Pos2;

/// See the module's head.
#[derive(Clone, Debug)]
pub(crate) struct Note {
    pub(crate) text: String,
    pub(crate) at: Pos2,
    /// Seconds of egui's clock.
    pub(crate) since: f64,
}
