//! The short sentence at the pointer.

use egui::Pos2;

/// A sentence, where it stands in points of the toolkit, and since when.
#[derive(Clone, Debug)]
pub(crate) struct Note {
    pub(crate) text: String,
    pub(crate) at: Pos2,
    /// Seconds of egui's clock.
    pub(crate) since: f64,
}
