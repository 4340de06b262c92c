//! Every step that can be taken back, by name; a click goes there.

use crate::document::HistoryCommand;
use crate::ui::style::theme;
use crate::ui::style::widgets::{cut_text, list};
use crate::ui::window::app::App;
use egui::{Align2, Rect, Sense, Ui, vec2};

/// Height of a step.
const STEP: f32 = 20.0;

impl App {
    pub(super) fn history_panel(&mut self, ui: &mut Ui, height: f32) {
        let snapshot = self.snapshot.clone();
        let done = snapshot.undo.len();
        let rows = done + 1 + snapshot.redo.len();
        let mut jump = None;
        self.backdrop.detail(ui, Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), height)), theme::DEEP);
        list(ui, "history", height, STEP, rows, true, |ui, range| {
            for i in range {
                let name = match i {
                    0 => "Opened",
                    i if i <= done => snapshot.undo[i - 1].as_str(),
                    i => snapshot.redo[i - done - 1].as_str(),
                };
                let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), STEP), Sense::click());
                let here = i == done;
                response.widget_info(|| {
                    egui::WidgetInfo::selected(egui::Role::ListItem, true, here, format!("Step {i}: {name}"))
                });
                let tip =
                    if here { "This is where you are" } else { "Click to go back or forward to just after this step" };
                // Names of parts and volumes may be longer than the list is wide.
                let response = response.on_hover_text(format!("{name}\n{tip}"));
                let fill = match (here, response.hovered()) {
                    (true, _) => theme::ACCENT_FILL,
                    (false, true) => theme::CONTROL,
                    _ => egui::Color32::TRANSPARENT,
                };
                ui.painter().rect_filled(rect, theme::ROUND, fill);
                let colour = match i {
                    _ if here => egui::Color32::WHITE,
                    i if i > done => theme::TEXT_WEAK,
                    _ => theme::TEXT,
                };
                let mono = egui::TextStyle::Monospace.resolve(ui.style());
                ui.painter().text(
                    rect.left_center() + vec2(26.0, 0.0),
                    Align2::RIGHT_CENTER,
                    i,
                    mono,
                    theme::TEXT_WEAK,
                );
                let font = egui::TextStyle::Body.resolve(ui.style());
                let text = cut_text(ui, name, font, colour, rect.width() - 40.0);
                let at = rect.left_center() + vec2(36.0, -text.size().y * 0.5);
                ui.painter().galley(at, text, colour);
                if response.clicked() && !here {
                    jump = Some(i);
                }
            }
        });
        match jump {
            Some(i) if i < done => self.undo_redo(HistoryCommand::Undo { steps: (done - i) as u32 }),
            Some(i) => self.undo_redo(HistoryCommand::Redo { steps: (i - done) as u32 }),
            None => {}
        }
    }
}
