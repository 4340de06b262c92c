//! What the window keeps of things that are written on surfaces: where they are, which one is picked, what was said of them.

use crate::document::answers::{Answer, Said};
use crate::document::{AnnotationCommand, Command, CutawayCommand};
use crate::interact::{Written, readout};
use crate::ui::thread::session::Severity;
use crate::ui::window::app::App;

impl App {
    /// Whether a thing that is written is there.
    fn is_there(&self, one: Written) -> bool {
        self.scene.as_ref().is_some_and(|scene| match one {
            Written::Annotation(id) => scene.annotations.all.contains_key(&id),
            Written::Label(id) => scene.labels.all.contains_key(&id),
            Written::Cutaway(id) => scene.cutaways.all.contains_key(&id),
        })
    }

    /// Takes in where the document has them.
    pub(crate) fn take_written(&mut self) {
        if let Some(open) = &self.snapshot.open {
            self.writing.places.clone_from(&open.written);
            self.writing.extent_mm = 2.0 * open.grid.world_bounds().half_diagonal();
        }
        // What a control asks for and was not sent yet.
        if let Some(waiting) = self.waiting.clone() {
            self.expect(&waiting);
        }
        if self.writing.picked.is_some_and(|one| !self.is_there(one)) {
            self.writing.picked = None;
        }
    }

    /// Picks what was made, and tells how it lies.
    pub(crate) fn written_done(&mut self, command: &Command, answer: &Answer) {
        let (one, name, remarks) = match &answer.said {
            Said::Annotation(said) => {
                self.remarks.of_annotation(said);
                if matches!(command, Command::Annotation(AnnotationCommand::Add(_))) {
                    self.writing.picked = Some(Written::Annotation(said.id));
                }
                (Written::Annotation(said.id), &said.annotation.name, said.grid.as_ref().map(|grid| &grid.remarks))
            }
            Said::Cutaway(said) => {
                self.remarks.of_cutaway(said);
                if matches!(command, Command::Cutaway(CutawayCommand::Add(_))) {
                    self.writing.picked = Some(Written::Cutaway(said.id));
                }
                (Written::Cutaway(said.id), &said.cutaway.name, said.mesh.as_ref().map(|mesh| &mesh.remarks))
            }
            Said::Label(said) => {
                self.writing.picked = Some(Written::Label(said.id));
                return;
            }
            _ => return,
        };
        // Of what is picked the panel says it.
        if self.writing.picked == Some(one) {
            return;
        }
        let text: Vec<String> = remarks.into_iter().flatten().map(|remark| format!("{name}: {remark}.")).collect();
        for text in text {
            self.say(Severity::Warning, readout::sentence(&text));
        }
    }

    /// Removes what is picked.
    pub(crate) fn remove_picked(&mut self) {
        if let Some(one) = self.writing.picked.take().filter(|one| self.is_there(*one)) {
            self.send(one.remove());
        }
    }
}
