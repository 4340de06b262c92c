//! The page of keys.

use crate::interact::SHORTCUTS;
use crate::ui::app::App;
use crate::ui::icons::Icon;
use crate::ui::theme;
use crate::ui::widgets::{Face, from_right, icon_button};
use egui::{Align2, Grid, RichText};

impl App {
    pub(in crate::ui) fn key_page(&mut self, ctx: &egui::Context) {
        if !self.keys_open {
            return;
        }
        egui::Window::new("Keys and pointer")
            .title_bar(false)
            .resizable(false)
            // As wide as it becomes: a window that does not know its width yet cuts its text off until the next frame.
            .default_width(860.0)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ctx, |ui| {
                ui.horizontal(|ui| {
                    ui.label(RichText::new("Keys and pointer").color(egui::Color32::WHITE).size(16.0));
                    from_right(ui, |ui| {
                        let tip = "Closes this page (F1 or Escape)";
                        if icon_button(ui, Face::small(Icon::Close, "Close the page of keys", tip)).clicked() {
                            self.keys_open = false;
                        }
                    });
                });
                ui.add_space(8.0);
                ui.horizontal_top(|ui| {
                    ui.spacing_mut().item_spacing.x = 32.0;
                    for groups in [["Paint", "Parts"], ["Look", "Document"]] {
                        ui.vertical(|ui| {
                            for group in groups {
                                ui.label(RichText::new(group).color(theme::ACCENT).size(14.0));
                                Grid::new(("keys", group)).num_columns(2).spacing([20.0, 4.0]).show(ui, |ui| {
                                    ui.spacing_mut().item_spacing.x = 20.0;
                                    for line in SHORTCUTS.iter().filter(|s| s.group == group) {
                                        ui.label(RichText::new(line.keys).color(egui::Color32::WHITE));
                                        ui.label(RichText::new(line.what).color(theme::TEXT));
                                        ui.end_row();
                                    }
                                });
                                ui.add_space(12.0);
                            }
                        });
                    }
                });
            });
    }
}
