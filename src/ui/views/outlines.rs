//! Parts over the pictures: where they end, the one that is meant, and the cut that a click would make.
//!
//! In 3D all of it lies on the surface that is seen; slices show parts at rest as lines. Owns no state: what is drawn is what the
//! pointer means now, and nothing stays when it goes.

use crate::document::SlicePlane;
use crate::explode::{Axis, Cut, Part};
use crate::interact::preview;
use crate::interact::surface::Piece;
use crate::interact::{Aim, CutSlice};
use crate::math::{DVec2, Plane};
use crate::ui::style::theme;
use crate::ui::window::app::App;
use egui::{Color32, Mesh, Painter, Pos2, Rect, Stroke, pos2};

impl App {
    /// What a splitter would cut now, wherever the pointer is.
    fn pending_cuts(&self, painter: &Painter) -> Vec<Cut> {
        let tool = self.interaction.tool();
        let (Some(scene), Some(open)) = (&self.scene, self.opened()) else { return Vec::new() };
        let Some((view, px)) = self.viewports.hovered.filter(|_| tool.is_of_parts()) else { return Vec::new() };
        let Some(&size) = self.viewports.sizes.get(&view) else { return Vec::new() };
        let axis = if painter.ctx().input(|i| i.modifiers.shift) { Axis::Vertical } else { Axis::Horizontal };
        let aim = match CutSlice::new(&open.grid, scene, view, size) {
            Some(slice) => Aim::Slice { px, slice },
            None => Aim::Solid { px, size, hit: self.hit(px, size) },
        };
        let line = self.interaction.gesture().and_then(|gesture| gesture.line());
        preview::cuts((tool, line.map(|(_, ends)| ends)), (scene, &open.poses), aim, axis)
    }

    /// The part in whose row, or over which with a tool for parts, the pointer is.
    fn meant_part(&self) -> Option<&Part> {
        let of_parts = self.interaction.tool().is_of_parts();
        let id = self.pointed_part.or_else(|| self.hovered_part().filter(|_| of_parts))?;
        self.scene.as_ref()?.explosion.parts.iter().find(|p| p.id == id)
    }

    /// Over the 3D view's picture in `body`.
    pub(crate) fn outlines(&self, painter: &Painter, body: Rect) {
        let (Some(scene), Some(open)) = (&self.scene, self.opened()) else { return };
        let meant = self.meant_part();
        let tool = self.interaction.tool();
        if meant.is_none() && !tool.is_of_parts() {
            return;
        }
        let Some(surface) = self.pictures.surface() else { return };
        let (parts, poses) = (&scene.explosion.parts, &*open.poses);
        let line = |pieces: &[Piece], width: f32, colour: Color32| pieces_on(painter, body, pieces, width, colour);
        let cuts = self.pending_cuts(painter);
        if let Some(part) = meant.filter(|p| parts.len() > 1 && cuts.iter().all(|c| c.part != p.id)) {
            tint(painter, body, &surface.side((parts, poses), part, None), Color32::from_white_alpha(26));
        }
        if tool.is_of_parts() {
            let seams = surface.seams(parts, poses);
            line(&seams, 2.6, Color32::from_black_alpha(90));
            line(&seams, 1.2, Color32::from_white_alpha(150));
        }
        for cut in cuts {
            let Some(part) = parts.iter().find(|p| p.id == cut.part) else { continue };
            if tool.peels() {
                let side = surface.side((parts, poses), part, Some(&cut.plane));
                tint(painter, body, &side, theme::ACCENT.gamma_multiply(0.38));
            }
            let trace = surface.trace((parts, poses), part, &cut.plane, open.grid.voxel_mm());
            line(&trace, 3.4, Color32::from_black_alpha(150));
            line(&trace, 1.8, theme::ACCENT);
        }
    }

    /// Over a slice's picture: borders of parts at rest, and where the cut to come crosses it.
    pub(crate) fn slice_outlines(&self, painter: &Painter, slice: &SlicePlane, to_screen: &dyn Fn(DVec2) -> Pos2) {
        let Some(scene) = &self.scene else { return };
        let parts = &scene.explosion.parts;
        let draw = |part: &Part, plane: &Plane, stroke: Stroke| {
            if let Some(ends) = preview::crossing(part, plane, slice) {
                let ends = ends.map(|end| to_screen(slice.pixel(end)));
                painter.line_segment(ends, Stroke::new(stroke.width + 1.6, Color32::from_black_alpha(120)));
                painter.line_segment(ends, stroke);
            }
        };
        if parts.len() > 1 {
            for part in parts {
                let colour = part.colour.map_or(Color32::from_rgb(0xc8, 0xcb, 0xd2), theme::rgb);
                preview::seams(part).for_each(|plane| draw(part, &plane, Stroke::new(1.1, colour)));
            }
            if let Some(part) = self.meant_part() {
                let faces = part.faces.iter().map(|f| f.plane);
                faces.for_each(|plane| draw(part, &plane, Stroke::new(1.8, Color32::WHITE)));
            }
        }
        for cut in self.pending_cuts(painter) {
            let Some(part) = parts.iter().find(|p| p.id == cut.part) else { continue };
            let stroke = Stroke::new(1.8, theme::ACCENT);
            let lies_in_slice = cut.plane.normal.cross(slice.right.cross(slice.up)).length() < 1e-9;
            if lies_in_slice && cut.plane.distance(slice.centre).abs() < slice.mm_per_px {
                part.faces.iter().for_each(|f| draw(part, &f.plane, stroke));
            } else {
                draw(part, &cut.plane, stroke);
            }
        }
    }

    /// The stroke that no picture shows yet.
    pub(crate) fn stroke_trail(&mut self, painter: &Painter, body: Rect) {
        let Some(surface) = self.pictures.surface() else { return };
        let Some((colour, tinted)) = self.trail.tint(surface) else { return };
        tint(painter, body, &surface.boxes(|i| tinted[i]), colour.gamma_multiply(0.6));
    }
}

fn place(body: Rect, share: DVec2) -> Pos2 {
    pos2(body.min.x + share.x as f32 * body.width(), body.min.y + share.y as f32 * body.height())
}

fn pieces_on(painter: &Painter, body: Rect, pieces: &[Piece], width: f32, colour: Color32) {
    let stroke = Stroke::new(width, colour);
    painter.extend(pieces.iter().map(|piece| egui::Shape::line_segment(piece.map(|end| place(body, end)), stroke)));
}

/// Boxes of one colour as one mesh: they meet without overlapping.
fn tint(painter: &Painter, body: Rect, boxes: &[Piece], colour: Color32) {
    let mut mesh = Mesh::default();
    for [from, to] in boxes {
        mesh.add_colored_rect(Rect::from_min_max(place(body, *from), place(body, *to)), colour);
    }
    painter.add(mesh);
}
