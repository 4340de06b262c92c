//! What everything in the window is drawn with: colours, lengths, icons, small controls.

pub(crate) mod colour;
pub(crate) mod icons;
pub(crate) mod naming;
pub mod theme;
pub(crate) mod widgets;
