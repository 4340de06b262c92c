//! Questions that stop the work: which file, what becomes of unsaved changes.
//!
//! The system's file dialog runs beside the window; where there is none, a path is typed.

use super::app::{App, Chosen};
use super::saving::{AfterSave, Coming};
use super::theme;
use crate::document::{Command, ProjectCommand};
use crate::interact::readout;
use crate::volume::FieldKind;
use egui::{Align2, Color32, Id, Modal, RichText, TextEdit, Ui, vec2};
use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Dialog {
    /// A path for something.
    Path { what: What, path: String },
    /// The window closes with unsaved changes.
    Close,
    /// Something else is opened over unsaved changes.
    Replace(Coming),
    /// Documents that crashes left behind.
    Lost(Vec<Lost>),
    /// Nothing: the window waits for a save, after which it closes or opens something else.
    Saving,
}

/// A document that a crash left behind.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lost {
    id: String,
    /// The file that was open.
    origin: String,
    /// How long ago it was changed last, in words; empty if nobody knows.
    age: String,
    /// Thrown away at the next click.
    doomed: bool,
}

impl From<&serde_json::Value> for Lost {
    fn from(lost: &serde_json::Value) -> Self {
        let text = |name: &str| lost[name].as_str().unwrap_or_default().to_owned();
        let changed = lost["changed"]["secs_since_epoch"].as_u64().map(|s| UNIX_EPOCH + Duration::from_secs(s));
        let age = changed.and_then(|c| SystemTime::now().duration_since(c).ok());
        let age = age.map_or_else(String::new, |a| readout::ago(a.as_secs()));
        Self { id: text("id"), origin: text("origin"), age, doomed: false }
    }
}

/// What a path is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum What {
    Open,
    SaveAs,
    Export(FieldKind),
    Image,
    Selection,
}

impl What {
    const fn title(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::SaveAs => "Save project",
            Self::Export(FieldKind::Labels) => "Export labels",
            Self::Export(FieldKind::Selection) => "Export selection",
            Self::Export(_) => "Export density",
            Self::Image => "Save picture",
            Self::Selection => "Import selection",
        }
    }

    const fn hint(self) -> &'static str {
        match self {
            Self::Open => "A volume (.nii, .nii.gz, .nrrd) or a project folder",
            Self::SaveAs => "A folder; it is made if it is not there",
            Self::Export(_) => "A file that ends in .nrrd",
            Self::Image => "A file that ends in .png or .exr",
            Self::Selection => "A volume of the same place; what is above 0 is selected",
        }
    }

    fn chosen(self, path: PathBuf) -> Chosen {
        match self {
            Self::Open => Chosen::Open(path),
            Self::SaveAs => Chosen::SaveAs(path),
            Self::Export(field) => Chosen::Export(field, path),
            Self::Image => Chosen::Image(path),
            Self::Selection => Chosen::Selection(path),
        }
    }
}

impl Dialog {
    pub(super) fn open() -> Self {
        Self::Path { what: What::Open, path: String::new() }
    }

    pub(super) fn selection() -> Self {
        Self::Path { what: What::Selection, path: String::new() }
    }

    pub(super) fn save_as(app: &App) -> Self {
        Self::Path { what: What::SaveAs, path: beside(app, ".burin") }
    }

    pub(super) fn export(app: &App, field: FieldKind) -> Self {
        Self::Path { what: What::Export(field), path: beside(app, &format!("-{}.nrrd", field.name())) }
    }

    pub(super) fn image(app: &App) -> Self {
        Self::Path { what: What::Image, path: beside(app, ".png") }
    }
}

/// The volume's own path with another ending.
fn beside(app: &App, ending: &str) -> String {
    let Some(open) = app.opened() else { return String::new() };
    let path = &open.scene.origin.path;
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = [".nii.gz", ".nii", ".nrrd"].iter().find_map(|e| name.strip_suffix(e)).unwrap_or(&name);
    path.with_file_name(format!("{stem}{ending}")).display().to_string()
}

impl App {
    /// Asks for a path: by the system's dialog if there is one, else by a field.
    pub(super) fn ask_path(&mut self, dialog: Dialog) {
        let Dialog::Path { what, path } = &dialog else { return };
        if !has_file_dialog() {
            self.dialog = Some(dialog);
            return;
        }
        let (what, path, back) = (*what, PathBuf::from(path), self.chosen.0.clone());
        let fallback = dialog.clone();
        // The portal answers when the user does; the window goes on.
        let asked = std::thread::Builder::new().name("file dialog".into()).spawn(move || {
            let mut ask = rfd::FileDialog::new().set_title(what.title());
            if let Some(folder) = path.parent().filter(|p| p.is_dir()) {
                ask = ask.set_directory(folder);
            }
            if let Some(name) = path.file_name() {
                ask = ask.set_file_name(name.to_string_lossy());
            }
            let answer = match what {
                What::Open => ask.add_filter("Volumes", &["nii", "gz", "nrrd"]).pick_file(),
                What::Selection => ask.add_filter("Volumes", &["nii", "gz", "nrrd"]).pick_file(),
                What::SaveAs | What::Export(_) | What::Image => ask.save_file(),
            };
            // No answer may also mean that no portal answered; the typed path remains in the menu's reach.
            if let Some(path) = answer {
                let _gone = back.send(what.chosen(path));
            }
        });
        if asked.is_err() {
            self.dialog = Some(fallback);
        }
    }

    /// Holds the window open while there is something to lose.
    pub(super) fn guard_close(&mut self, ctx: &egui::Context) {
        if ctx.input(|i| i.viewport().close_requested()) && self.snapshot.unsaved && !self.closing {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.dialog = Some(Dialog::Close);
        }
    }

    pub(super) fn dialogs(&mut self, ctx: &egui::Context) {
        let Some(dialog) = self.dialog.clone() else { return };
        let frame = egui::Frame::popup(&ctx.style_of(egui::Theme::Dark)).inner_margin(20);
        self.grounds.shade(ctx);
        let modal = Modal::new(Id::unique("dialog")).frame(frame).backdrop_color(Color32::TRANSPARENT);
        modal.show(ctx, |ui| {
            ui.set_width(440.0);
            match dialog {
                Dialog::Path { what, path } => self.path_dialog(ui, what, path),
                Dialog::Close => self.close_dialog(ui),
                Dialog::Replace(coming) => self.replace_dialog(ui, coming),
                Dialog::Lost(lost) => self.lost_dialog(ui, lost),
                Dialog::Saving => self.saving_dialog(ui),
            }
        });
    }

    fn path_dialog(&mut self, ui: &mut Ui, what: What, mut path: String) {
        ui.heading(what.title());
        ui.add_space(4.0);
        ui.label(RichText::new(what.hint()).color(theme::TEXT_WEAK));
        ui.add_space(8.0);
        let field = TextEdit::singleline(&mut path).desired_width(f32::INFINITY).hint_text("/path/to/file");
        let response = ui.add(field).accessible_name("Path");
        if !response.has_focus() && !response.lost_focus() {
            response.request_focus();
            // The cursor is seen a frame later.
            ui.ctx().request_repaint();
        }
        let entered = response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        ui.add_space(12.0);
        let (yes, no) = two_buttons(ui, what.title(), "Cancel", !path.trim().is_empty());
        if no {
            self.dialog = None;
        } else if (yes || entered) && !path.trim().is_empty() {
            self.dialog = None;
            self.choose(what.chosen(PathBuf::from(path.trim())));
        } else {
            self.dialog = Some(Dialog::Path { what, path });
        }
    }

    fn unsaved_question(&self, ui: &mut Ui, title: &str) {
        ui.add(egui::Label::new(RichText::new(title).heading()).truncate());
        ui.add_space(4.0);
        let name = self.document_title();
        let text = format!("{} has changes that are not saved.", name.trim_end_matches('*'));
        ui.label(RichText::new(text).color(theme::TEXT_WEAK));
        ui.add_space(16.0);
    }

    fn close_dialog(&mut self, ui: &mut Ui) {
        self.unsaved_question(ui, "Save before closing?");
        match three_buttons(ui) {
            Some(Answer::Yes) => {
                self.dialog = None;
                self.save_then(Some(AfterSave::Close));
            }
            Some(Answer::No) => {
                self.dialog = None;
                self.closing = true;
                ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Some(Answer::Cancel) => self.dialog = None,
            None => {}
        }
    }

    fn replace_dialog(&mut self, ui: &mut Ui, coming: Coming) {
        self.unsaved_question(ui, &format!("Save before {} is opened?", coming.name()));
        match three_buttons(ui) {
            Some(Answer::Yes) => {
                self.dialog = None;
                self.save_then(Some(AfterSave::Open(coming)));
            }
            Some(Answer::No) => {
                self.dialog = None;
                self.open_now(coming);
            }
            Some(Answer::Cancel) => self.dialog = None,
            None => {}
        }
    }

    fn lost_dialog(&mut self, ui: &mut Ui, mut lost: Vec<Lost>) {
        ui.heading("Unsaved work was found");
        ui.add_space(4.0);
        let text = "The program did not end in order. These documents can be brought back as they were.";
        ui.label(RichText::new(text).color(theme::TEXT_WEAK));
        ui.add_space(12.0);
        let mut clicked = None;
        for (i, Lost { id, origin, age, doomed }) in lost.iter().enumerate() {
            super::widgets::from_right_row(ui, |ui| {
                let name = format!("Recover {}", short_path(origin));
                if ui.add(primary("Recover")).accessible_name(name).clicked() {
                    self.dialog = None;
                    self.open_guarded(Coming::Lost { id: id.clone(), origin: origin.clone() });
                }
                ui.add_space(24.0);
                let name = format!("Throw away {}", short_path(origin));
                let (text, name) =
                    if *doomed { ("Really throw away", format!("{name} for good")) } else { ("Throw away", name) };
                let discard = egui::Button::new(RichText::new(text).color(theme::ERROR));
                if ui.add(discard.min_size(vec2(0.0, 30.0))).accessible_name(name).clicked() {
                    clicked = Some(i);
                }
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.vertical(|ui| {
                        ui.spacing_mut().item_spacing.y = 0.0;
                        ui.add(egui::Label::new(short_path(origin)).truncate()).on_hover_text(origin);
                        ui.label(RichText::new(age).small().color(theme::TEXT_WEAK));
                    });
                });
            });
        }
        // Nothing brings it back: it takes a second click.
        if let Some(i) = clicked {
            if lost[i].doomed {
                let Lost { id, .. } = lost.remove(i);
                self.send(Command::Project(ProjectCommand::Forget { id }));
            } else {
                lost[i].doomed = true;
            }
            self.dialog = (!lost.is_empty()).then_some(Dialog::Lost(lost));
        }
        ui.add_space(12.0);
        let later = super::widgets::from_right_row(ui, |ui| {
            ui.add(egui::Button::new("Decide later").min_size(vec2(110.0, 30.0))).clicked()
        });
        if later {
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

enum Answer {
    Yes,
    No,
    Cancel,
}

fn primary(text: &str) -> egui::Button<'_> {
    egui::Button::new(RichText::new(text).color(Color32::WHITE)).fill(theme::ACCENT_FILL).min_size(vec2(110.0, 30.0))
}

fn two_buttons(ui: &mut Ui, yes: &str, no: &str, can: bool) -> (bool, bool) {
    super::widgets::from_right_row(ui, |ui| {
        let name = format!("{yes} at this path");
        let yes = ui.add_enabled(can, primary(yes)).accessible_name(name).clicked();
        let no = ui.add(egui::Button::new(no).min_size(vec2(90.0, 30.0))).clicked();
        (yes, no)
    })
}

fn three_buttons(ui: &mut Ui) -> Option<Answer> {
    // A key that is held since the question before answers only that.
    let entered = ui.input(|i| {
        i.events.iter().any(|e| {
            matches!(e, egui::Event::Key { key: egui::Key::Enter, pressed: true, repeat: false, modifiers, .. }
                if modifiers.is_none())
        })
    });
    let entered = entered && ui.memory(|m| m.focused().is_none());
    super::widgets::from_right_row(ui, |ui| {
        let mut answer = None;
        if ui.add(primary("Save")).accessible_name("Save and go on").clicked() || entered {
            answer = Some(Answer::Yes);
        }
        if ui.add(egui::Button::new("Cancel").min_size(vec2(90.0, 30.0))).clicked() {
            answer = Some(Answer::Cancel);
        }
        // Far from the other two: the one that loses work must not be hit by mistake.
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            let discard =
                egui::Button::new(RichText::new("Discard changes").color(theme::ERROR)).min_size(vec2(130.0, 30.0));
            if ui.add(discard).clicked() {
                answer = Some(Answer::No);
            }
        });
        answer
    })
}

/// Whether the system can show a file dialog: on Linux that takes a session bus with a portal on it.
fn has_file_dialog() -> bool {
    if cfg!(any(target_os = "windows", target_os = "macos")) {
        return true;
    }
    let bus = std::env::var_os("DBUS_SESSION_BUS_ADDRESS").is_some_and(|a| !a.is_empty());
    let desktop = std::env::var_os("XDG_CURRENT_DESKTOP").is_some_and(|a| !a.is_empty());
    bus && desktop
}

fn short_path(path: &str) -> String {
    std::path::Path::new(path).file_name().map_or_else(|| path.to_owned(), |n| n.to_string_lossy().into_owned())
}
