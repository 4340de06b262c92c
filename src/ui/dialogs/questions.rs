//! Questions about what would be lost: before the window closes, before something else is opened, and what a crash left.

use crate::document::{Command, ProjectCommand, answers};
use crate::interact::readout;
use crate::ui::state::dialog::Dialog;
use crate::ui::state::dialog::Lost;
use crate::ui::state::saving::{AfterSave, OpenTarget};
use crate::ui::style::theme;
use crate::ui::style::widgets::{from_right_row, tipped};
use crate::ui::style::widgets::{plain, primary};
use crate::ui::window::app::App;
use egui::{RichText, Ui, vec2};
use std::time::SystemTime;

impl From<&answers::Lost> for Lost {
    fn from(lost: &answers::Lost) -> Self {
        let age = SystemTime::now().duration_since(lost.changed).ok();
        let age = age.map_or_else(String::new, |a| readout::ago(a.as_secs()));
        Self { id: lost.id.clone(), origin: lost.origin.to_string_lossy().into_owned(), age, doomed: false }
    }
}

impl App {
    /// Holds the window open while there is something to lose.
    pub(crate) fn guard_close(&mut self, ctx: &egui::Context) {
        if ctx.input(|i| i.viewport().close_requested()) && self.snapshot.unsaved && !self.closing {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.dialog = Some(Dialog::Close);
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

    pub(super) fn close_dialog(&mut self, ui: &mut Ui) -> Option<Dialog> {
        self.unsaved_question(ui, "Save before closing?");
        match three_buttons(ui) {
            Some(Answer::Yes) => self.save_then(Some(AfterSave::Close)),
            Some(Answer::No) => {
                self.closing = true;
                ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Some(Answer::Cancel) => {}
            None => return Some(Dialog::Close),
        }
        None
    }

    pub(super) fn replace_dialog(&mut self, ui: &mut Ui, coming: OpenTarget) -> Option<Dialog> {
        self.unsaved_question(ui, &format!("Save before {} is opened?", coming.name()));
        match three_buttons(ui) {
            Some(Answer::Yes) => self.save_then(Some(AfterSave::Open(coming))),
            Some(Answer::No) => self.open_now(coming),
            Some(Answer::Cancel) => {}
            None => return Some(Dialog::Replace(coming)),
        }
        None
    }

    pub(super) fn lost_dialog(&mut self, ui: &mut Ui, mut lost: Vec<Lost>) -> Option<Dialog> {
        ui.heading("Unsaved work was found");
        ui.add_space(4.0);
        let text = "The program did not end in order. These documents can be brought back as they were.";
        ui.label(RichText::new(text).color(theme::TEXT_WEAK));
        ui.add_space(12.0);
        let (mut clicked, mut recover) = (None, None);
        for (i, Lost { id, origin, age, doomed }) in lost.iter().enumerate() {
            from_right_row(ui, |ui| {
                let name = format!("Recover {}", short_path(origin));
                let recovered = ui.add(primary("Recover")).accessible_name(name);
                if tipped(recovered, "Opens it as it was when the program ended").clicked() {
                    recover = Some(OpenTarget::Lost { id: id.clone(), origin: origin.clone() });
                }
                ui.add_space(24.0);
                let name = format!("Throw away {}", short_path(origin));
                let (text, name) =
                    if *doomed { ("Really throw away", format!("{name} for good")) } else { ("Throw away", name) };
                let discard = egui::Button::new(RichText::new(text).color(theme::ERROR));
                let discarded = ui.add(discard.min_size(vec2(0.0, 30.0))).accessible_name(name);
                let tip = "Nothing brings it back afterwards: it takes a second click";
                if tipped(discarded, tip).clicked() {
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
        }
        ui.add_space(12.0);
        let later = from_right_row(ui, |ui| {
            tipped(ui.add(plain("Decide later")), "It stays where it is and is offered at the next start").clicked()
        });
        if let Some(coming) = recover {
            self.open_guarded(coming);
            return None;
        }
        (!later && !lost.is_empty()).then_some(Dialog::Lost(lost))
    }
}

enum Answer {
    Yes,
    No,
    Cancel,
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
    from_right_row(ui, |ui| {
        let mut answer = None;
        let save = ui.add(primary("Save")).accessible_name("Save and go on");
        if tipped(save, "Saves the project, then goes on (Enter)").clicked() || entered {
            answer = Some(Answer::Yes);
        }
        if tipped(ui.add(plain("Cancel")), "Everything stays as it is (Esc)").clicked() {
            answer = Some(Answer::Cancel);
        }
        // Far from the other two: the one that loses work must not be hit by mistake.
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            let discard =
                egui::Button::new(RichText::new("Discard changes").color(theme::ERROR)).min_size(vec2(130.0, 30.0));
            if tipped(ui.add(discard), "Goes on without saving: what changed since the last save is lost").clicked() {
                answer = Some(Answer::No);
            }
        });
        answer
    })
}

fn short_path(path: &str) -> String {
    std::path::Path::new(path).file_name().map_or_else(|| path.to_owned(), |n| n.to_string_lossy().into_owned())
}
