//! What comes back from the document, and what the window makes of it.

use super::app::{App, Busy};
use super::dialogs::{Dialog, Lost};
use super::panels::transfer::TransferEditor;
use super::session::{Gravity, Report};
use crate::document::{Command, ProjectCommand, ViewName};
use crate::interact::readout;
use std::sync::Arc;

impl App {
    pub(super) fn take_reports(&mut self, ctx: &egui::Context) {
        for report in self.session.reports() {
            match report {
                Report::Snapshot(snapshot) => {
                    let caught_up = snapshot.serial >= self.session.serial();
                    let opened_anew = match (&snapshot.open, &self.snapshot.open) {
                        (Some(new), Some(old)) => !Arc::ptr_eq(&new.histogram, &old.histogram),
                        (new, old) => new.is_some() != old.is_some(),
                    };
                    if opened_anew {
                        self.pictures.clear();
                        self.grounds.forget();
                        self.trail.clear();
                        self.viewports.forget_sizes();
                        self.transfer = TransferEditor::default();
                    }
                    if caught_up || opened_anew {
                        self.scene = snapshot.open.as_ref().map(|o| o.scene.as_ref().clone());
                    } else if let (Some(scene), Some(open)) = (&mut self.scene, &snapshot.open) {
                        // Views are never echoed in full: take the document's, so that the pointer is where the picture is.
                        scene.views = open.scene.views.clone();
                    }
                    // A motion asks once it is at rest: each look into the 3D view costs it a picture.
                    self.probe_again |= !snapshot.moving;
                    self.snapshot = snapshot;
                }
                Report::Picture(picture) => match self.grounds.take(&picture) {
                    Ok(()) => {
                        if picture.view == ViewName::ThreeD {
                            self.trail.shown(picture.serial);
                        }
                        self.pictures.take(*picture);
                    }
                    Err(error) => {
                        self.pictures.lose(picture.view);
                        self.say(Gravity::Error, error.to_string());
                    }
                },
                Report::Probe(value) => self.probe = value,
                Report::Refining(refining) => self.refining = refining,
                Report::Nothing(text) => self.note(ctx, text),
                Report::Started(what) => {
                    self.busy = Some(Busy { what, since: ctx.input(|i| i.time), percent: None, stopping: false });
                }
                Report::Progress(percent) => {
                    if let Some(busy) = &mut self.busy {
                        busy.percent = Some(percent);
                    }
                }
                Report::Finished => self.busy = None,
                Report::Message(gravity, text) => {
                    if gravity == Gravity::Error {
                        self.wait_no_more();
                    }
                    self.say(gravity, text);
                }
                Report::Done(command, answer) => self.done(ctx, &command, &answer),
            }
        }
    }

    fn done(&mut self, ctx: &egui::Context, command: &Command, answer: &serde_json::Value) {
        if let Command::Project(ProjectCommand::Lost {}) = command
            && let Some(lost) = answer["lost"].as_array().filter(|l| !l.is_empty())
        {
            self.dialog = Some(Dialog::Lost(lost.iter().map(Lost::from).collect()));
        }
        if let Some(text) = readout::recovered(&answer["recovered"]) {
            self.say(Gravity::Warning, text);
            self.messages_open = true;
        }
        if let Command::Project(ProjectCommand::Save { .. }) = command {
            self.saved(ctx);
        }
    }
}
