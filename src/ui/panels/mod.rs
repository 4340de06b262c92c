//! The panels around the views. Each shows one noun of the command set and changes it by commands.

mod bar;
mod brush;
mod explosion;
mod history;
mod keys;
mod layers;
mod look;
mod messages;
mod parts;
mod segments;
mod status;
pub(super) mod transfer;

use super::app::App;
use super::theme;
use super::widgets::section;
use egui::{Frame, Margin, Panel, ScrollArea, Ui};

impl App {
    pub(super) fn left_panel(&mut self, ui: &mut Ui) {
        if self.opened().is_none() {
            return;
        }
        let panel = side(Panel::left("tools")).default_size(288.0).size_range(272.0..=420.0).show(ui, |ui| {
            scrolled(ui, "left", |ui| {
                section(ui, "Brush", true, |ui| self.brush_panel(ui));
                section(ui, "Segments", true, |ui| self.segment_panel(ui));
                section(ui, "Layers", true, |ui| self.layer_panel(ui));
                section(ui, "3D look", true, |ui| self.look_panel(ui));
            });
        });
        self.grounds.fill(panel.response.rect, theme::PANEL);
    }

    pub(super) fn right_panel(&mut self, ui: &mut Ui) {
        if self.opened().is_none() {
            return;
        }
        let panel = side(Panel::right("properties")).default_size(288.0).size_range(248.0..=520.0).show(ui, |ui| {
            // Below what scrolls, so that what was done is always in sight.
            let under = Frame::new().inner_margin(Margin { left: 0, right: 8, top: 6, bottom: 0 });
            Panel::bottom("steps").resizable(false).show_separator_line(false).frame(under).show(ui, |ui| {
                section(ui, "History", true, |ui| self.history_panel(ui));
            });
            scrolled(ui, "right", |ui| {
                section(ui, "Transfer function", true, |ui| self.transfer_panel(ui));
                section(ui, "Explosion", true, |ui| self.explosion_panel(ui));
                section(ui, "Parts", true, |ui| self.part_panel(ui));
            });
        });
        self.grounds.fill(panel.response.rect, theme::PANEL);
    }
}

fn side(panel: Panel) -> Panel {
    panel.resizable(true).frame(Frame::new().inner_margin(Margin { left: 10, right: 6, top: 6, bottom: 0 }))
}

fn scrolled(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui)) {
    ScrollArea::vertical().id_salt(name).auto_shrink([false, false]).show(ui, |ui| {
        // Room for the scroll bar, so that nothing moves when it appears.
        let width = ui.available_width() - 8.0;
        ui.set_max_width(width);
        body(ui);
    });
}
