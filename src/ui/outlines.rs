//! Parts over the 3D picture: their seams, the one that is meant, and the cut that a click would make.

use super::app::App;
use super::theme;
use crate::document::ViewName;
use crate::explode::Axis;
use crate::interact::preview;
use crate::math::{Camera, DVec2, DVec3};
use egui::{Color32, Painter, Pos2, Stroke};

impl App {
    /// `to_screen` takes pixels of the 3D view of `size` pixels.
    pub(super) fn outlines(&self, painter: &Painter, to_screen: &dyn Fn(DVec2) -> Pos2, size: [u32; 2]) {
        let Some(scene) = &self.scene else { return };
        let (tool, gesture) = (self.interaction.tool(), self.interaction.gesture());
        let parts = &scene.explosion.parts;
        // The picture may be a moment older than the scene; lines belong to what is seen.
        let camera = self.pictures.camera().unwrap_or(scene.views.camera);
        let draw = |ring: &[DVec3], stroke: Stroke| outline(painter, &camera, ring, to_screen, size, stroke);
        let meant = self.pointed_part.or_else(|| self.hovered_part().filter(|_| tool.is_three_d_only()));
        if tool.is_three_d_only() {
            let faint = Stroke::new(1.0, Color32::from_white_alpha(56));
            let others = parts.iter().filter(|p| p.visible && Some(p.id) != meant);
            others.flat_map(preview::seams).for_each(|ring| draw(&ring, faint));
        }
        if let Some(part) = parts.iter().find(|p| Some(p.id) == meant) {
            for ring in preview::seams(part) {
                draw(&ring, Stroke::new(3.0, Color32::from_black_alpha(110)));
                draw(&ring, Stroke::new(1.3, theme::TEXT));
            }
        }
        let Some((_, px)) = self.viewports.hovered.filter(|(view, _)| *view == ViewName::ThreeD) else { return };
        let axis = if painter.ctx().input(|i| i.modifiers.shift) { Axis::Vertical } else { Axis::Horizontal };
        let hit = self.pictures.hit(px, size, scene);
        for ring in preview::cuts((tool, gesture), scene, (px, size), hit, axis) {
            draw(&ring, Stroke::new(3.0, Color32::from_black_alpha(150)));
            draw(&ring, Stroke::new(1.5, theme::ACCENT));
        }
    }
}

/// A closed ring; sides that reach behind the eye are left out.
fn outline(
    painter: &Painter,
    camera: &Camera,
    ring: &[DVec3],
    to_screen: &dyn Fn(DVec2) -> Pos2,
    size: [u32; 2],
    stroke: Stroke,
) {
    let corners: Vec<_> = ring.iter().map(|&c| camera.project(c, size).map(|(px, _)| to_screen(px))).collect();
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        if let (Some(a), Some(b)) = (a, b) {
            painter.line_segment([*a, *b], stroke);
        }
    }
}
