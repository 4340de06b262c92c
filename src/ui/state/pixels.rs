//! From points of the toolkit to pixels of a view.

use crate::math::DVec2;
use egui::Pos2;
use egui::Rect;

/// Pixel of a view, and its size.
pub(crate) fn pixel(rect: Rect, pos: Pos2, scale: f32) -> DVec2 {
    DVec2::new(f64::from(pos.x - rect.min.x), f64::from(pos.y - rect.min.y)) * f64::from(scale)
}

pub(crate) fn pixels(rect: Rect, scale: f32) -> [u32; 2] {
    [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32)
}
