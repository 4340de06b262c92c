//! The page of keys.

use crate::interact::SHORTCUTS;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::widgets::{Face, from_right, icon_button};
use crate::ui::window::app::App;
use egui::{Align2, Color32, Grid, Id, RichText, ScrollArea, Ui, vec2};

/// Width of the page with its groups in two columns, and in one.
const WIDTHS: [f32; 2] = [1040.0, 540.0];
/// The groups of each column, and the column's share of the width.
const COLUMNS: [(&[&str], f32); 2] = [(&["Paint", "Parts", "Document"], 0.46), (&["Look", "Annotate", "Panels"], 0.54)];
/// Height of a line: all of them are in sight in a window of 800 points.
const LINE: f32 = 18.0;

impl App {
    pub(crate) fn key_page(&mut self, ctx: &egui::Context) {
        if !self.keys_open {
            return;
        }
        let window = ctx.viewport_rect().size();
        // A small window scrolls one column.
        let wide = window.x >= WIDTHS[0] + 60.0;
        let width = if wide { WIDTHS[0] } else { WIDTHS[1] };
        // As large as it is: a window that does not know its size yet cuts its text off until the next frame.
        let page =
            egui::Window::new("Keys and pointer").id(Id::unique(("keys", wide))).title_bar(false).resizable(false);
        page.fixed_size(vec2(width, window.y - 80.0)).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(ctx, |ui| {
            ui.set_width(width);
            ui.horizontal(|ui| {
                ui.label(RichText::new("Help: keys and pointer").color(Color32::WHITE).size(16.0));
                from_right(ui, |ui| {
                    let tip = "Closes this page (F1 or Escape)";
                    if icon_button(ui, Face::small(Icon::Close, "Close the page of keys", tip)).clicked() {
                        self.keys_open = false;
                    }
                });
            });
            ui.add_space(6.0);
            ScrollArea::vertical().id_salt("keys").max_height(window.y - 130.0).auto_shrink([false, true]).show(
                ui,
                |ui| {
                    if wide {
                        ui.horizontal_top(|ui| {
                            for (groups, share) in COLUMNS {
                                ui.vertical(|ui| column(ui, width * share, groups));
                            }
                        });
                    } else {
                        for (groups, _) in COLUMNS {
                            column(ui, width, groups);
                        }
                    }
                },
            );
        });
    }
}

fn column(ui: &mut Ui, width: f32, groups: &[&str]) {
    ui.set_width(width - 12.0);
    for &group in groups {
        ui.label(RichText::new(group).color(theme::ACCENT).size(14.0));
        Grid::new(("keys", group)).num_columns(2).min_col_width(180.0).min_row_height(LINE).spacing([14.0, 2.0]).show(
            ui,
            |ui| {
                for line in SHORTCUTS.iter().filter(|s| s.group == group) {
                    ui.label(RichText::new(line.keys).color(Color32::WHITE));
                    ui.label(RichText::new(line.what).color(theme::TEXT));
                    ui.end_row();
                }
            },
        );
        ui.add_space(10.0);
    }
}
