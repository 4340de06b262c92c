//! Saving, and what waits for it: the window that closes, what is opened next.
//!
//! While something waits nothing can be changed, so that what closes is what was saved.

use crate::document::{Command, ProjectCommand};
use crate::ui::state::dialog::Dialog;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::state::saving::AfterSave;
use crate::ui::state::saving::OpenTarget;
use crate::ui::style::theme;
use crate::ui::window::app::App;
use egui::{Button, ProgressBar, Ui, ViewportCommand, vec2};
use std::path::PathBuf;

impl App {
    /// Saves where the project is, or asks where.
    pub(crate) fn save(&mut self) {
        self.save_then(None);
    }

    /// Saves, and does something else once all is on disk.
    pub(crate) fn save_then(&mut self, then: Option<AfterSave>) {
        if !self.has_document() {
            return;
        }
        self.after_save = then;
        if self.snapshot.project.is_some() {
            self.send_save(None);
        } else {
            self.ask(PathPurpose::SaveAs);
        }
    }

    pub(crate) fn send_save(&mut self, path: Option<PathBuf>) {
        // What was painted meanwhile would be closed unsaved: nothing can be.
        if self.after_save.is_some() {
            self.dialog = Some(Dialog::Saving);
        }
        self.send(Command::Project(ProjectCommand::Save { path, density: None }));
    }

    /// Opens something, but asks first what becomes of unsaved work.
    pub(crate) fn open_guarded(&mut self, coming: OpenTarget) {
        if self.snapshot.unsaved {
            self.dialog = Some(Dialog::Replace(coming));
        } else {
            self.open_now(coming);
        }
    }

    /// What is open is replaced.
    pub(crate) fn open_now(&mut self, coming: OpenTarget) {
        match coming {
            OpenTarget::Path(path) => self.open(&path),
            OpenTarget::Volume(path, open_as) => self.open_as(path, open_as),
            OpenTarget::Lost { id, .. } => self.send(Command::Project(ProjectCommand::Recover { id })),
        }
    }

    /// Nothing follows a save that runs: it failed, or was stopped.
    pub(crate) fn wait_no_more(&mut self) {
        self.after_save = None;
        self.dialog.take_if(|d| matches!(d, Dialog::Saving));
    }

    /// All is on disk.
    pub(crate) fn saved(&mut self, ctx: &egui::Context) {
        let then = self.after_save.take();
        self.wait_no_more();
        match then {
            Some(AfterSave::Close) => {
                self.closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            Some(AfterSave::Open(coming)) => self.open_now(coming),
            None => {}
        }
    }

    pub(crate) fn saving_dialog(&mut self, ui: &mut Ui) -> Option<Dialog> {
        let name = self.document_title();
        ui.heading(format!("Saving {}", name.trim_end_matches('*')));
        ui.add_space(12.0);
        let share = self.busy.as_ref().and_then(|b| b.percent).unwrap_or(0) as f32 / 100.0;
        ui.add(ProgressBar::new(share).desired_height(6.0).fill(theme::ACCENT));
        ui.add_space(12.0);
        let cancelled = crate::ui::style::widgets::from_right_row(ui, |ui| {
            let cancel = ui.add(Button::new("Cancel").min_size(vec2(90.0, 30.0)));
            crate::ui::style::widgets::tipped(cancel, "Stops saving; the project on disk stays as it was").clicked()
        });
        if cancelled {
            self.stop();
            return None;
        }
        // What was waited for may have come in this very frame.
        self.after_save.is_some().then_some(Dialog::Saving)
    }
}
