//! What comes back from the document, and what the window makes of it.

use crate::document::answers::{Answer, LostSaid, Said};
use crate::document::{
    Command, ProjectCommand, RenderCommand, SegmentCommand, SelectionCommand, ViewName, VolumeCommand,
};
use crate::interact::readout;
use crate::ui::browse::names::shown;
use crate::ui::state::dialog::Dialog;
use crate::ui::state::dialog::Lost;
use crate::ui::state::transfer_editor::TransferEditor;
use crate::ui::thread::session::{Report, Severity, Snapshot};
use crate::ui::window::app::{App, Busy};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is said of work that a crash left; gone once it is saved, or something else is open.
const RECOVERED: &str = "project.recover";

impl App {
    pub(crate) fn take_reports(&mut self, ctx: &egui::Context) {
        for report in self.session.reports() {
            match report {
                Report::Snapshot(snapshot) => {
                    let caught_up = snapshot.serial >= self.session.serial();
                    let opened_anew = match (&snapshot.open, &self.snapshot.open) {
                        (Some(new), Some(old)) => new.opening != old.opening,
                        (new, old) => new.is_some() != old.is_some(),
                    };
                    if opened_anew {
                        self.all_mended();
                        self.pictures.clear();
                        self.backdrop.forget();
                        self.trail.clear();
                        self.viewports.forget_sizes();
                        self.labels.clear();
                        self.remarks.clear();
                        self.writing.picked = None;
                    }
                    let histogram = |s: &Snapshot| s.open.as_ref().map(|open| Arc::as_ptr(&open.histogram));
                    if opened_anew || histogram(&snapshot) != histogram(&self.snapshot) {
                        // The panels show another volume; pictures show all of them anyway.
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
                    self.take_written();
                }
                Report::Picture(picture) => match self.backdrop.take(&picture) {
                    Ok(()) => {
                        if picture.view == ViewName::ThreeD {
                            self.trail.shown(picture.serial);
                        }
                        self.pictures.take(*picture);
                    }
                    Err(error) => {
                        self.pictures.lose(picture.view);
                        self.say(Severity::Error, error.to_string());
                    }
                },
                Report::Sketch(command, sketch) => self.take_sketch(&command, sketch),
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
                Report::Message(severity, text) => {
                    if severity == Severity::Error {
                        self.wait_no_more();
                    }
                    self.say(severity, text);
                }
                Report::Offer(_) if self.names_source() => {}
                Report::Offer(offer) => self.dialog = Some(Dialog::Offer(offer)),
                Report::Done(command, answer) => self.done(ctx, &command, &answer),
                Report::Refused(command, reason) => self.refused(&command, reason),
                Report::Complaint(topic, reason) => self.complain(&topic, reason),
                Report::Mended(topic) => self.mended(&topic),
            }
        }
    }

    fn done(&mut self, ctx: &egui::Context, command: &Command, answer: &Answer) {
        if let Said::Lost(LostSaid { lost }) = &answer.said
            && !lost.is_empty()
        {
            self.dialog = Some(Dialog::Lost(lost.iter().map(Lost::from).collect()));
        }
        if let Command::Volume(VolumeCommand::Open { .. })
        | Command::Project(
            ProjectCommand::Open { .. } | ProjectCommand::Recover { .. } | ProjectCommand::Save { .. },
        ) = command
        {
            self.mended(RECOVERED);
        }
        if let Some(text) = answer.recovered().and_then(readout::recovered) {
            self.warn_until(RECOVERED, text);
            self.messages_open = true;
        }
        self.written_done(command, answer);
        self.file_done(command);
        self.tell_of_file(command, answer);
        if let Command::Project(ProjectCommand::Save { .. }) = command {
            self.saved(ctx);
        }
    }

    fn refused(&mut self, command: &Command, reason: String) {
        if matches!(command, Command::Project(ProjectCommand::Save { .. })) {
            self.wait_no_more();
        }
        // Whoever typed the path reads the reason beside it.
        if !self.file_failed(command, &reason) {
            self.complain(command.effects().name, reason);
        }
    }

    /// Notes what was opened or saved, and says where what was written lies.
    fn tell_of_file(&mut self, command: &Command, answer: &Answer) {
        let named = |path: &Path| shown(path.file_name().unwrap_or(path.as_os_str()));
        match command {
            Command::Volume(VolumeCommand::Open { path, open_as, .. }) => {
                self.recent.note_volume(path, *open_as);
                self.begin_lesson(path);
            }
            Command::Volume(VolumeCommand::Add { path, open_as, .. }) => {
                self.recent.note_volume(path, *open_as);
                self.confirm(format!("Added {}", named(path)), None);
            }
            Command::Project(ProjectCommand::Open { path, .. }) => {
                self.recent.note_project(path);
                self.begin_lesson(path);
            }
            Command::Project(ProjectCommand::Save { path, .. }) => {
                let known = self.snapshot.project.clone();
                let said = match &answer.said {
                    Said::Saved(saved) => saved.path.as_ref().map(PathBuf::from),
                    _ => None,
                };
                let path = said.or_else(|| path.clone()).or(known);
                self.mended("project.save");
                if let Some(path) = path {
                    self.recent.note_project(&path);
                    self.confirm(format!("Saved project {}", named(&path)), Some(path));
                }
            }
            Command::Volume(VolumeCommand::Export { field, path, .. }) => {
                self.confirm(format!("Exported {} to {}", field.name(), named(path)), Some(path.clone()));
            }
            Command::Render(RenderCommand::Image { path, .. }) => {
                self.confirm(format!("Saved picture {}", named(path)), Some(path.clone()));
            }
            Command::Segment(SegmentCommand::Import { path, .. }) => {
                let count = match &answer.said {
                    Said::ImportedSegments(said) => said.labels.segments.len(),
                    _ => 0,
                };
                let segments = if count == 1 { "one segment".to_owned() } else { format!("{count} segments") };
                self.confirm(format!("Imported {segments} from {}", named(path)), None);
            }
            Command::Selection(SelectionCommand::Import { path, .. }) => {
                self.confirm(format!("Imported the selection from {}", named(path)), None);
            }
            _ => {}
        }
    }
}
