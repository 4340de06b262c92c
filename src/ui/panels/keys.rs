//! The page of keys.

use crate::interact::SHORTCUTS;
use crate::ui::app::App;
use crate::ui::theme;
use egui::{Align2, Grid, RichText};

impl App {
    pub(in crate::ui) fn key_page(&mut self, ctx: &egui::Context) {
        let mut open = self.keys_open;
        egui::Window::new("Keys and pointer")
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            // As wide as it becomes: a window that does not know its width yet cuts its text off until the next frame.
            .default_width(860.0)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ctx, |ui| {
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
        self.keys_open &= open;
    }
}
