//! A short sentence at the pointer that fades: what a hand has just done and nothing came of it.

use crate::ui::state::note::Note;
use crate::ui::style::theme;
use crate::ui::window::app::App;
use egui::{Area, Context, Frame, Id, Label, Margin, Order, RichText, vec2};

/// Seconds that a note can be read, and that it then takes to fade.
const READ_S: f64 = 3.0;
const FADE_S: f64 = 0.7;
/// Away from the pointer, in points, so that it hides nothing under it.
const AWAY: egui::Vec2 = vec2(14.0, 18.0);

impl App {
    /// Says something where the pointer is, or was last.
    pub(crate) fn note(&mut self, ctx: &Context, text: impl Into<String>) {
        let at = ctx.input(|i| i.pointer.latest_pos()).unwrap_or_else(|| ctx.viewport_rect().center());
        self.note = Some(Note { text: text.into(), at, since: ctx.input(|i| i.time) });
    }

    pub(crate) fn show_note(&mut self, ctx: &Context) {
        let Some(note) = &self.note else { return };
        let age = ctx.input(|i| i.time) - note.since;
        if age > READ_S + FADE_S {
            self.note = None;
            return;
        }
        let opacity = (1.0 - (age - READ_S) / FADE_S).clamp(0.0, 1.0) as f32;
        let area = Area::new(Id::unique("note")).order(Order::Tooltip).interactable(false);
        area.fixed_pos(note.at + AWAY).constrain(true).show(ctx, |ui| {
            ui.multiply_opacity(opacity);
            let frame = Frame::new().fill(theme::DEEP).stroke((1.0, theme::LINE)).corner_radius(theme::ROUND);
            frame.inner_margin(Margin::symmetric(8, 5)).show(ui, |ui| {
                ui.set_max_width(280.0);
                ui.add(Label::new(RichText::new(&note.text).color(theme::TEXT)).selectable(false).wrap());
            });
        });
        let wait = if age < READ_S { READ_S - age } else { 0.05 };
        ctx.request_repaint_after(std::time::Duration::from_secs_f64(wait.max(0.01)));
    }
}
