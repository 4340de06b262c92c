//! Errors and warnings, until they are read and dismissed.

use crate::ui::app::App;
use crate::ui::icons::Icon;
use crate::ui::session::Gravity;
use crate::ui::theme;
use crate::ui::widgets::{Face, from_right, icon_button};
use egui::{Frame, Margin, Panel, RichText, ScrollArea, Ui};

const fn colour(gravity: Gravity) -> egui::Color32 {
    match gravity {
        Gravity::Note => theme::TEXT_WEAK,
        Gravity::Warning => theme::WARNING,
        Gravity::Error => theme::ERROR,
    }
}

impl App {
    pub(in crate::ui) fn message_list(&mut self, ui: &mut Ui) {
        if !self.messages_open || self.messages.is_empty() {
            return;
        }
        let mut dismissed = None;
        let frame = Frame::new().inner_margin(Margin::symmetric(10, 6));
        let list = Panel::bottom("messages").frame(frame).max_size(180.0).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new(format!("Messages ({})", self.messages.len())).color(theme::TEXT));
                from_right(ui, |ui| {
                    if ui.button("Dismiss all").clicked() {
                        dismissed = Some(None);
                    }
                    if ui.button("Hide").clicked() {
                        self.messages_open = false;
                    }
                });
            });
            ScrollArea::vertical().id_salt("messages").max_height(120.0).auto_shrink([false, true]).show(ui, |ui| {
                for (i, (gravity, text)) in self.messages.iter().enumerate().rev() {
                    ui.horizontal(|ui| {
                        let name = format!("Dismiss message {}", i + 1);
                        if icon_button(ui, Face::small(Icon::Close, &name, "Dismiss")).clicked() {
                            dismissed = Some(Some(i));
                        }
                        ui.add(egui::Label::new(RichText::new(text).color(colour(*gravity))).wrap());
                    });
                }
            });
        });
        self.grounds.fill(list.response.rect, theme::BAR);
        match dismissed {
            Some(Some(i)) => {
                self.messages.remove(i);
            }
            Some(None) => self.messages.clear(),
            None => {}
        }
    }
}
