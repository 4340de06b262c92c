//! Questions that stop the work, one at a time: which file, what it is, how a picture shall be, what becomes of unsaved changes.
//!
//! Each has a file of its own here; this one holds which is asked, and lays it over the window. While one is asked keys and
//! pointer reach nothing else.

pub(crate) mod browser;
pub(crate) mod browser_list;
pub(crate) mod export;
pub(crate) mod files;
pub(crate) mod meaning;
pub(crate) mod offer;
pub(crate) mod picture;
pub(crate) mod questions;
pub(crate) mod what;

use crate::ui::state::dialog::Dialog;
use crate::ui::window::app::App;
use egui::{Align2, Color32, Id, Modal, RichText, Ui, vec2};

impl App {
    pub(super) fn dialogs(&mut self, ctx: &egui::Context) {
        let Some(dialog) = self.dialog.take() else { return };
        let frame = egui::Frame::popup(&ctx.style_of(egui::Theme::Dark)).inner_margin(20);
        self.backdrop.shade(ctx);
        let modal = Modal::new(Id::unique("dialog")).frame(frame).backdrop_color(Color32::TRANSPARENT);
        let width = dialog.width().min(ctx.viewport_rect().width() - 72.0);
        let next = modal.show(ctx, |ui| {
            ui.set_width(width);
            self.dialog_body(ui, dialog)
        });
        // An answer may have asked the next question already.
        if self.dialog.is_none() {
            self.dialog = next.inner;
        }
    }

    /// Draws it; answers the same while it is not answered.
    fn dialog_body(&mut self, ui: &mut Ui, dialog: Dialog) -> Option<Dialog> {
        match dialog {
            Dialog::Browse(browse) => self.browser_dialog(ui, browse),
            Dialog::Close => self.close_dialog(ui),
            Dialog::Replace(coming) => self.replace_dialog(ui, coming),
            Dialog::Lost(lost) => self.lost_dialog(ui, lost),
            Dialog::Meaning(meaning) => self.meaning_dialog(ui, meaning),
            Dialog::Export(export) => self.export_dialog(ui, export),
            Dialog::Picture(picturing) => self.picture_dialog(ui, picturing),
            Dialog::Offer(offer) => self.offer_dialog(ui, *offer),
            Dialog::Saving => self.saving_dialog(ui),
        }
    }

    /// Escape, while something is asked: the smallest thing that is open goes.
    pub(super) fn leave_dialog(&mut self) {
        let within = match &mut self.dialog {
            Some(Dialog::Saving) => return self.stop(),
            Some(Dialog::Browse(browse)) => browse.browser.back_out(),
            _ => false,
        };
        if !within {
            self.dialog = None;
        }
    }

    /// Shown while files hang over the window.
    pub(super) fn drop_hint(&self, ctx: &egui::Context) {
        if ctx.input(|i| i.raw.hovered_files.is_empty()) {
            return;
        }
        egui::Area::new(Id::unique("drop")).anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(ctx, |ui| {
            egui::Frame::popup(ui.style()).inner_margin(24).show(ui, |ui| {
                ui.label(RichText::new("Drop to open").size(18.0));
            });
        });
    }
}
