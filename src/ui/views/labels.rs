//! Labels over the 3D view: texts beside what is shown, each joined by a leader to what it names, placed anew in every frame.
//!
//! What they name comes from the document, whether that is seen from the picture's depths, where they go from `annotate::labels`.

use crate::annotate::labels::{Label, Style, Viewport, key_lines};
use crate::document::ViewName;
use crate::math::{DVec2, DVec3};
use crate::ui::state::labels_shown::Again;
use crate::ui::style::theme;
use crate::ui::window::app::App;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2, vec2};
use std::time::Duration;

/// Room about a text, in its size.
const ROOM: DVec2 = DVec2::new(0.35, 0.12);
/// Between two frames in which labels move.
const STEP: Duration = Duration::from_millis(16);
/// After a rest they may be tidied.
const REST: Duration = Duration::from_millis(300);
/// From the top of the view to the key of numbers: below what is said there.
const KEY_TOP: f32 = 30.0;

impl App {
    pub(crate) fn draw_labels(&mut self, painter: &Painter, body: Rect) {
        let (Some(scene), Some(open)) = (&self.scene, self.opened()) else { return };
        let style = scene.labels.style;
        if !style.visible || open.labels.is_empty() {
            self.labels.clear();
            return;
        }
        let background = scene.look.background;
        let [ink, shade] = style.inks(background).map(theme::rgb);
        let anchors = open.labels.clone();
        let size = DVec2::new(f64::from(body.width()), f64::from(body.height()));
        let letters = f64::from(style.size_px);
        let font = FontId::proportional(style.size_px);
        let measured = |text: &str| {
            let text = painter.layout_no_wrap(text.to_owned(), font.clone(), ink).size();
            DVec2::new(f64::from(text.x), f64::from(text.y)) + 2.0 * ROOM * letters
        };
        let Some(eye) = self.pictures.camera().map(|camera| camera.eye) else { return };
        let texts: Vec<String> = anchors.iter().map(|anchor| anchor.text.clone()).collect();
        let mut wanted: Vec<Label> = Vec::new();
        for anchor in anchors.iter() {
            let seen = self.pictures.seen(anchor);
            wanted.push(Label {
                id: u64::from(anchor.id.0),
                anchor: seen.map_or(DVec2::splat(-1.0), |(at, _)| at * size),
                depth: anchor.place.distance(eye),
                visible: seen.is_some_and(|(_, seen)| seen),
                size: measured(&anchor.text),
                priority: 0.0,
            });
        }
        let mut written = texts.clone();
        if style.numbers {
            let key = key_lines(&mut wanted, &texts, &measured);
            written = key.iter().map(|line| line.number.to_string()).collect();
        }
        let corners = open.grid.world_bounds().corners();
        let shown = |corner: &DVec3| Some(self.pictures.share(*corner)? * size);
        let viewport = Viewport { size, outline: corners.iter().filter_map(shown).collect() };
        let now = painter.ctx().input(|i| i.time);
        let (frame, again) = self.labels.place(&viewport, &Style::of_letters(letters), &wanted, now);
        match again {
            Again::Soon => painter.ctx().request_repaint_after(STEP),
            Again::Later => painter.ctx().request_repaint_after(REST),
            Again::Never => {}
        }
        let at = |p: DVec2| body.min + vec2(p.x as f32, p.y as f32);
        let wide = (style.size_px / 13.0).max(0.7);
        for placed in frame.labels.iter().filter(|placed| placed.opacity > 0.0) {
            let opacity = placed.opacity as f32;
            let leader: Vec<Pos2> = placed.leader.iter().map(|p| at(*p)).collect();
            let (ink, dim) = (ink.gamma_multiply(opacity), shade.gamma_multiply(0.5 * opacity));
            painter.add(Shape::line(leader.clone(), Stroke::new(2.8 * wide, dim)));
            painter.add(Shape::line(leader.clone(), Stroke::new(1.2 * wide, ink)));
            if let Some(end) = leader.first() {
                painter.circle_filled(*end, 2.4 * wide + 1.0, dim);
                painter.circle_filled(*end, 2.4 * wide, ink);
            }
            let text = wanted.iter().position(|label| label.id == placed.id).and_then(|i| written.get(i));
            let middle = at(placed.rect.min.midpoint(placed.rect.max));
            halo_text(painter, (middle, Align2::CENTER_CENTER), text.map_or("", String::as_str), &font, (ink, shade));
        }
        if style.numbers {
            let mut top = body.min + vec2(10.0, KEY_TOP);
            for (label, (number, text)) in wanted.iter().zip(written.iter().zip(&texts)) {
                if frame.labels.iter().any(|placed| placed.id == label.id) && top.y < body.max.y {
                    let line = format!("{number}  {text}");
                    halo_text(painter, (top, Align2::LEFT_TOP), &line, &font, (ink, shade));
                    top.y += 1.35 * style.size_px;
                }
            }
        }
    }

    /// The middles of what the tool in hand works on: what is taken there moves.
    pub(crate) fn draw_handles(&self, painter: &Painter, size: [u32; 2], to_screen: &dyn Fn(DVec2) -> Pos2) {
        let (Some(scene), Some(of_tool)) = (&self.scene, self.interaction.tool().picks()) else { return };
        let camera = scene.views.camera;
        for (one, place) in self.writing.places.iter().filter(|(one, _)| of_tool(**one)) {
            let Some((px, depth)) = camera.project(*place, size) else { continue };
            if self.hit(px, size).is_some_and(|hit| depth > hit.depth_mm * 1.02) {
                continue;
            }
            let at = to_screen(px);
            let picked = self.writing.picked == Some(*one);
            let (radius, colour) = if picked { (6.0, theme::ACCENT) } else { (4.0, Color32::WHITE) };
            painter.circle_stroke(at, radius + 1.0, Stroke::new(3.0, Color32::from_black_alpha(170)));
            painter.circle_stroke(at, radius, Stroke::new(1.6, colour));
        }
    }

    /// All that lies over the 3D view of what is written.
    pub(crate) fn written_overlay(
        &mut self,
        painter: &Painter,
        view: ViewName,
        (body, size): (Rect, [u32; 2]),
        to_screen: &dyn Fn(DVec2) -> Pos2,
    ) {
        if view == ViewName::ThreeD {
            self.draw_labels(painter, body);
            self.draw_handles(painter, size, to_screen);
        }
    }
}

/// Text with a shade all about it.
fn halo_text(
    painter: &Painter,
    (at, align): (Pos2, Align2),
    text: &str,
    font: &FontId,
    (ink, shade): (Color32, Color32),
) {
    let galley = painter.layout_no_wrap(text.to_owned(), font.clone(), Color32::PLACEHOLDER);
    let first = align.anchor_size(at, galley.size()).min;
    // On whole points, so that letters are as crisp as those of panels.
    let first = pos2(first.x.round(), first.y.round());
    let dim = shade.gamma_multiply(0.55 * f32::from(ink.a()) / 255.0);
    for turn in 0..8 {
        let by = Vec2::angled(turn as f32 * std::f32::consts::FRAC_PI_4) * 1.2;
        painter.galley(first + by, galley.clone(), dim);
    }
    painter.galley(first, galley, ink);
}
