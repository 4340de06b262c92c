//! What a command does to the scene: one pure function, for whoever does commands and for whoever foretells them.
//!
//! The document calls it and then does what needs voxels, disk or GPU; the window calls it on its own copy, so that a slider stays
//! under the hand while the document is busy. Owns names of steps and what is said of the scene; may not know voxels, past or pictures:
//! places that only a picture can tell are refused here, and put in numbers by the document before.

pub(crate) mod annotations;
pub(crate) mod cutaways;
pub(crate) mod labels;
pub(crate) mod looks;
pub(crate) mod parts;
pub(crate) mod place;
pub(crate) mod sub_volumes;
pub(crate) mod views;
pub(crate) mod volumes;

use crate::document::command::answers::Said;
use crate::document::command::{Command, SelectionCommand};
use crate::document::error::DocumentError;
use crate::document::scene::Scene;
use crate::explode::Poses;
use crate::math::Aabb;
use crate::volume::{Grid, Histogram};

/// What a scene stands on and does not hold.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The lattice where it lies of the volume that the command means.
    pub grid: &'a Grid,
    /// The box of all volumes, world mm.
    pub bounds: Aabb,
    /// Of its source's values.
    pub histogram: &'a Histogram,
    /// Where parts stand.
    pub poses: &'a Poses,
}

/// What a command did to a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changed {
    /// What the step is called; empty where the scene stays as it is.
    pub name: String,
    /// What is said of it.
    pub said: Said,
}

impl Changed {
    pub(crate) fn new(name: impl Into<String>, said: impl Into<Said>) -> Self {
        Self { name: name.into(), said: said.into() }
    }

    /// Of a command that changes voxels: its name alone.
    pub(crate) fn named(name: impl Into<String>) -> Self {
        Self::new(name, Said::Nothing)
    }
}

impl Scene {
    /// Does to the scene what a command does to it; nothing where a command leaves it alone.
    ///
    /// # Errors
    /// If the command cannot be done, or names a place that only a picture can tell; the scene is then as it was.
    pub fn apply(&mut self, command: &Command, ground: &Ground<'_>) -> Result<Changed, DocumentError> {
        let mut next = self.clone();
        let changed = match command {
            Command::Transfer(command) => next.apply_transfer(command, ground),
            Command::View(command) => next.apply_view(command, ground),
            Command::Brush(command) => next.apply_brush(command),
            Command::Segment(command) => next.apply_segment(command),
            Command::Part(command) => next.apply_part(command, ground),
            Command::Explosion(command) => next.apply_explosion(command),
            Command::Annotation(command) => next.apply_annotation(command, ground),
            Command::Label(command) => next.apply_label(command, ground),
            Command::Cutaway(command) => next.apply_cutaway(command, ground),
            Command::Volume(command) => next.apply_volume(command),
            Command::Component(command) => Ok(Changed::named(command.step_name())),
            Command::SubVolume(command) => next.apply_sub_volume(command),
            Command::Selection(SelectionCommand::Set { look, volume }) => next.set_selection_look(look, *volume),
            Command::Selection(command) => Ok(Changed::named(match command {
                SelectionCommand::Set { .. } => String::new(),
                SelectionCommand::Import { .. } => "Import selection".into(),
                SelectionCommand::FromLabel { label, .. } => format!("Select label {label}"),
                SelectionCommand::Clear { .. } => "Clear selection".into(),
            })),
            // Voxels, history, files, questions.
            Command::Stroke(_) | Command::History(_) | Command::Project(_) | Command::Ask(_) | Command::Render(_) => {
                return Ok(Changed::default());
            }
        }?;
        *self = next;
        Ok(changed)
    }
}
