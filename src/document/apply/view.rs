//! Commands on cameras, slices, looks and layers, as far as the scene alone does not say what they do: walking the past.

use crate::document::Document;
use crate::document::command::answers::{PastSaid, Said};
use crate::document::command::views::ViewCommand;
use crate::document::error::DocumentError;
use crate::document::scene::past::{PastGroup, PastOf};
use crate::document::state::State;

impl Document {
    pub(crate) fn view(&mut self, command: &ViewCommand, said: Said) -> Result<Said, DocumentError> {
        match command {
            ViewCommand::Back { of } => self.walk_past(*of, true),
            ViewCommand::Forward { of } => self.walk_past(*of, false),
            // What the others do to the scene is all they do.
            _ => Ok(said),
        }
    }

    /// Shows what was seen before, or again what comes after it.
    fn walk_past(&mut self, of: Option<PastOf>, back: bool) -> Result<Said, DocumentError> {
        let State { scene, past, .. } = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        // What the open group changed is behind or ahead now: the rest of it is a change of its own.
        self.past_group = PastGroup::default();
        let walked = past.walk(scene, of, back);
        let (behind, ahead) = past.counts(of);
        let (kind, name) = walked.unzip();
        let said = PastSaid {
            moved: kind.is_some(),
            of: kind,
            change: name,
            back: behind,
            forward: ahead,
            camera: scene.views.camera,
        };
        Ok(said.into())
    }
}
