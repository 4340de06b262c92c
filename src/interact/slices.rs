//! Gestures on slices: crosshair, and the grey window under the right button.

use crate::document::{Command, Place, ViewCommand, ViewName, Window};
use crate::math::DVec2;

/// Moves the crosshair to a pixel of a view.
pub(super) fn crosshair(view: ViewName, px: DVec2, size: [u32; 2]) -> Command {
    let at = Place::Pixel { view, px: px.to_array(), size: Some(size) };
    Command::View(ViewCommand::Crosshair { at })
}

/// The grey window after a drag: right widens, down darkens. The picture's height is worth twice the width at the start, so that
/// the hand's measure follows the data's.
pub(super) fn windowed(start: Window, moved_px: DVec2, height_px: u32) -> Window {
    let share = moved_px / f64::from(height_px.max(1));
    let width = (start.width * (share.x * 2.0).exp2()).max(f64::MIN_POSITIVE);
    Window { level: start.level + share.y * start.width * 2.0, width }
}

/// As a command.
pub(super) fn set_window(window: Window) -> Command {
    Command::View(ViewCommand::Window { level: window.level, width: window.width })
}
