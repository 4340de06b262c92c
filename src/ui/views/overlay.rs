//! What lies over a picture: crosshair, side letters, scale bar, and the marks that tools ask for.

use crate::document::{SlicePlane, ViewName};
use crate::interact::{Aimed, Ink, Mark};
use crate::math::{DVec2, DVec3, Projection};
use crate::paint::Target;
use crate::ui::state::left_out::said_in_3d;
use crate::ui::style::theme;
use crate::ui::style::theme::view_colour;
use crate::ui::window::app::App;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// The crosshair leaves its own middle open, in points.
const OPENING: f32 = 8.0;
/// Letters and bars: read on white bone as on black air.
const MARK: Color32 = Color32::from_rgb(0xf4, 0xf0, 0xd8);
/// And the side letters: an I on a line would be a line.
const LETTERS: f32 = 24.0;

impl App {
    pub(crate) fn overlay(&mut self, painter: &Painter, view: ViewName, body: Rect) {
        let (Some(scene), Some(open)) = (&self.scene, self.opened()) else { return };
        let scale = painter.ctx().pixels_per_point();
        let size = crate::ui::state::pixels::pixels(body, scale);
        let to_screen = |px: DVec2| body.min + vec2(px.x as f32, px.y as f32) / scale;
        let mut views = scene.views.clone();
        if let Some(i) = view.slice() {
            views.slices[i].size = size;
        }
        let plane = SlicePlane::new(&open.grid, &views, view);
        if let Some(plane) = &plane {
            for (line, colour) in crosshair(body, view, to_screen(plane.pixel(views.crosshair)), scale) {
                self.backdrop.mark(line, colour);
            }
            self.slice_outlines(painter, plane, &to_screen);
            self.boxes(painter, Some(plane), size, &to_screen);
            letters(painter, body, plane.side_letters());
            scale_bar(painter, body, plane.mm_per_px * f64::from(scale));
        } else {
            let (right, up) = views.camera.right_up();
            let left_out = said_in_3d(scene);
            self.stroke_trail(painter, body);
            orientation_mark(painter, body, right, up);
            if let Some(text) = left_out {
                let (at, font) = (body.min + vec2(10.0, 8.0), FontId::proportional(13.0));
                shaded_text(painter, at, Align2::LEFT_TOP, text, font, theme::WARNING);
            }
            self.outlines(painter, body);
            self.boxes(painter, None, size, &to_screen);
            if let Projection::Orthographic { .. } = views.camera.projection {
                scale_bar(painter, body, views.camera.mm_per_pixel(1.0, size[1]) * f64::from(scale));
            }
        }
        self.written_overlay(painter, view, (body, size), &to_screen);
        let mut marks = self.interaction.gesture().map_or_else(Vec::new, |gesture| gesture.marks(view));
        marks.extend(self.tool_marks(painter, view, plane.as_ref(), size));
        self.draw_marks(painter, &marks, &to_screen, scale);
        self.draw_footprint(painter, view, plane.as_ref(), size, &to_screen);
    }

    /// What the tool in hand shows about the pointer.
    fn tool_marks(&self, painter: &Painter, view: ViewName, plane: Option<&SlicePlane>, size: [u32; 2]) -> Vec<Mark> {
        let Some(scene) = &self.scene else { return Vec::new() };
        let Some((_, px)) = self.viewports.hovered.filter(|(v, _)| *v == view) else { return Vec::new() };
        let mm_per_px = match plane {
            Some(plane) => Some(plane.mm_per_px),
            None => self.hit(px, size).map(|hit| scene.views.camera.mm_per_pixel(hit.depth_mm, size[1])),
        };
        let erase = painter.ctx().input(|i| i.key_down(egui::Key::E));
        self.interaction.tool().marks(scene, &Aimed { px, mm_per_px, erase })
    }

    fn ink(&self, ink: Ink) -> Color32 {
        match (ink, &self.scene) {
            (Ink::Paint, Some(scene)) => paint_colour(scene.brush.target, scene),
            (Ink::Erase, _) => theme::ERROR,
            (Ink::Accent | Ink::Paint, _) => theme::ACCENT,
        }
    }

    /// Marks in pixels of a view, drawn with a shade where bone and air must both let them be seen.
    fn draw_marks(&self, painter: &Painter, marks: &[Mark], to_screen: &dyn Fn(DVec2) -> Pos2, scale: f32) {
        for mark in marks {
            match mark.clone() {
                Mark::Line { from, to, ink } => {
                    let line = [to_screen(from), to_screen(to)];
                    painter.line_segment(line, Stroke::new(3.0, Color32::from_black_alpha(160)));
                    painter.line_segment(line, Stroke::new(1.5, self.ink(ink)));
                }
                Mark::Ring { at, radius_px, ink, faint: true } => {
                    let stroke = Stroke::new(1.0, self.ink(ink).gamma_multiply(0.4));
                    painter.circle_stroke(to_screen(at), radius_px as f32 / scale, stroke);
                }
                Mark::Ring { at, radius_px, ink, faint: false } => {
                    let (at, radius) = (to_screen(at), radius_px as f32 / scale);
                    painter.circle_stroke(at, radius + 1.0, Stroke::new(1.0, Color32::from_black_alpha(170)));
                    painter.circle_stroke(at, radius.max(1.0), Stroke::new(1.4, self.ink(ink)));
                }
                Mark::Dot { at, ink } => {
                    painter.circle_filled(to_screen(at), 1.2, self.ink(ink));
                }
                Mark::Note { at, text } => {
                    let (beside, font) = (to_screen(at) + vec2(14.0, 14.0), FontId::proportional(13.0));
                    // Never over the picture's right edge or under its lower one.
                    let said = painter.layout_no_wrap(text, font, theme::TEXT);
                    let room = painter.clip_rect().shrink(10.0);
                    let at = beside.min(room.max - said.size()).max(room.min);
                    let ground = Rect::from_min_size(at, said.size()).expand2(vec2(6.0, 3.0));
                    painter.rect_filled(ground, theme::ROUND, Color32::from_black_alpha(200));
                    painter.galley(at, said, theme::TEXT);
                }
                Mark::Minus { at, ink } => {
                    let (at, half) = (to_screen(at), vec2(4.0, 0.0));
                    painter.line_segment([at - half, at + half], Stroke::new(1.4, self.ink(ink)));
                }
            }
        }
    }
}

/// What a brush paints, as a colour.
pub(crate) fn paint_colour(target: Target, scene: &crate::document::Scene) -> Color32 {
    match target {
        Target::Label(id) => theme::rgb(scene.segments().colour_of(id)),
        Target::Colour([r, g, b, _]) => theme::rgb([r, g, b]),
        Target::Selection(_) => theme::rgb(crate::document::SELECTION_COLOUR),
        Target::Density(_) => Color32::WHITE,
    }
}

fn crosshair(body: Rect, view: ViewName, at: Pos2, scale: f32) -> Vec<(Rect, Color32)> {
    // Each line has the colour of the slice that it stands for.
    let (vertical, horizontal) = match view {
        ViewName::Axial => (ViewName::Sagittal, ViewName::Coronal),
        ViewName::Coronal => (ViewName::Sagittal, ViewName::Axial),
        _ => (ViewName::Coronal, ViewName::Axial),
    };
    let colour = |v: ViewName| view_colour(v).gamma_multiply(0.7);
    let inner = body.shrink(LETTERS);
    // One pixel wide, or two where two are a point.
    let half = scale.round().max(1.0) / scale * 0.5;
    let down = |a: f32, b: f32| (Rect::from_min_max(pos2(at.x - half, a), pos2(at.x + half, b)), colour(vertical));
    let across = |a: f32, b: f32| (Rect::from_min_max(pos2(a, at.y - half), pos2(b, at.y + half)), colour(horizontal));
    let lines = [
        down(inner.min.y, (at.y - OPENING).min(inner.max.y)),
        down((at.y + OPENING).max(inner.min.y), inner.max.y),
        across(inner.min.x, (at.x - OPENING).min(inner.max.x)),
        across((at.x + OPENING).max(inner.min.x), inner.max.x),
    ];
    lines.into_iter().map(|(line, c)| (line.intersect(body), c)).filter(|(line, _)| line.is_positive()).collect()
}

/// Text with a shade, so that it is read on white bone as on black air.
fn shaded_text(painter: &Painter, at: Pos2, anchor: Align2, text: impl ToString, font: FontId, colour: Color32) {
    let text = text.to_string();
    for shift in [vec2(1.0, 1.0), vec2(-1.0, 0.0), vec2(0.0, -1.0)] {
        painter.text(at + shift, anchor, &text, font.clone(), Color32::from_black_alpha(200));
    }
    painter.text(at, anchor, &text, font, colour);
}

fn letters(painter: &Painter, body: Rect, [left, right, top, bottom]: [char; 4]) {
    let font = FontId::proportional(15.0);
    let colour = MARK;
    let inner = body.shrink(6.0);
    shaded_text(painter, inner.left_center(), Align2::LEFT_CENTER, left, font.clone(), colour);
    shaded_text(painter, inner.right_center(), Align2::RIGHT_CENTER, right, font.clone(), colour);
    shaded_text(painter, inner.center_top(), Align2::CENTER_TOP, top, font.clone(), colour);
    shaded_text(painter, inner.center_bottom(), Align2::CENTER_BOTTOM, bottom, font, colour);
}

fn scale_bar(painter: &Painter, body: Rect, mm_per_point: f64) {
    // A view smaller than this would be covered by it.
    if !(mm_per_point.is_finite() && mm_per_point > 0.0) || body.width() < 150.0 {
        return;
    }
    let length_mm = crate::interact::readout::round_length(mm_per_point * f64::from(body.width() * 0.35).min(120.0));
    let points = (length_mm / mm_per_point) as f32;
    let at = pos2(body.min.x + 12.0, body.max.y - 12.0);
    let ends = [at, at + vec2(points, 0.0)];
    for (stroke, tick) in [(Stroke::new(4.5, Color32::from_black_alpha(210)), 6.0), (Stroke::new(2.0, MARK), 5.0)] {
        painter.line_segment(ends, stroke);
        for end in ends {
            painter.line_segment([end - vec2(0.0, tick), end + vec2(0.0, tick - 2.0)], stroke);
        }
    }
    let text = crate::interact::readout::length(length_mm);
    let middle = at + vec2(points * 0.5, -5.0);
    shaded_text(painter, middle, Align2::CENTER_BOTTOM, text, FontId::proportional(14.0), MARK);
}

/// The body's axes as they lie in the 3D picture: what points at the eye is bright and on top.
fn orientation_mark(painter: &Painter, body: Rect, right: DVec3, up: DVec3) {
    let size = (body.size().min_elem() * 0.1).clamp(22.0, 36.0);
    let centre = body.max - vec2(size, size) * 1.7;
    let forward = up.cross(right);
    let mut axes = [(DVec3::X, 'R', 'L'), (DVec3::Y, 'A', 'P'), (DVec3::Z, 'S', 'I')]
        .iter()
        .zip([ViewName::Sagittal, ViewName::Coronal, ViewName::Axial])
        .flat_map(|(&(axis, plus, minus), view)| [(axis, plus, view), (-axis, minus, view)])
        .collect::<Vec<_>>();
    axes.sort_by(|a, b| b.0.dot(forward).total_cmp(&a.0.dot(forward)));
    for (axis, letter, view) in axes {
        let flat = vec2(axis.dot(right) as f32, -axis.dot(up) as f32) * size;
        let nearness = (0.5 - 0.5 * axis.dot(forward) as f32).clamp(0.0, 1.0);
        let colour = view_colour(view).gamma_multiply(0.5 + 0.5 * nearness);
        painter.line_segment([centre, centre + flat], Stroke::new(4.5, Color32::from_black_alpha(150)));
        painter.line_segment([centre, centre + flat], Stroke::new(2.5, colour));
        let tip = centre + flat * 1.28;
        // What points away is a letter, what points at the eye a disc with it.
        if nearness > 0.45 {
            painter.circle_filled(tip, 9.5, Color32::from_black_alpha(150));
            painter.circle_filled(tip, 8.5, colour);
            painter.text(tip, Align2::CENTER_CENTER, letter, FontId::proportional(13.0), theme::DEEP);
        } else {
            // A letter alone must be read on whatever lies behind it.
            let colour = view_colour(view).lerp_to_gamma(Color32::WHITE, 0.25);
            shaded_text(painter, tip, Align2::CENTER_CENTER, letter, FontId::proportional(13.5), colour);
        }
    }
}
