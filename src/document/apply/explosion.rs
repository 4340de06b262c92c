//! Commands on the explosion, as far as the scene alone does not say what they do: where forces take parts, and what is missing for it.

use crate::document::Document;
use crate::document::command::answers::{DegreeSaid, MovedSaid, Said, SettledSaid};
use crate::document::command::parts::ExplosionCommand;
use crate::document::error::DocumentError;
use crate::explode::PartPose;

/// Steps of one command: more than a minute of animation is a slip.
const MOST_STEPS: u32 = 3600;

impl Document {
    pub(crate) fn explosion(&mut self, command: &ExplosionCommand, said: Said) -> Result<Said, DocumentError> {
        match command {
            ExplosionCommand::Forces { .. } | ExplosionCommand::Seed { .. } => Ok(said),
            ExplosionCommand::Degree { value } => Ok(DegreeSaid { degree: *value, hint: self.hint() }.into()),
            ExplosionCommand::Settle {} => {
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let settled = self.motion.settle(state, &mut self.graphics, &self.watch)?;
                let said = SettledSaid {
                    poses: self.told_poses()?,
                    gains: settled.gains,
                    rounds: settled.rounds,
                    steps: settled.steps,
                    at_rest: settled.at_rest,
                    visible: settled.visible,
                    hint: self.hint(),
                };
                Ok(said.into())
            }
            ExplosionCommand::Step { steps } => {
                if *steps > MOST_STEPS {
                    return Err(DocumentError::invalid("steps", steps, format!("at most {MOST_STEPS}")));
                }
                let due = self.follow_stroke()?;
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let moved = self.motion.step(state, &mut self.graphics, *steps)?;
                let moving = moved.moving || due;
                Ok(MovedSaid { poses: self.told_poses()?, moving, visible: moved.visible }.into())
            }
        }
    }

    /// What is missing where parts are to make way for nothing.
    fn hint(&self) -> Option<&'static str> {
        let state = self.state.as_ref()?;
        let explosion = &state.scene.explosion;
        if explosion.degree > 0.0 && explosion.parts.len() < 2 {
            Some("there is one part, which nothing moves: cut it first (part.split)")
        } else if explosion.degree > 0.0 && state.subjects().all(|subject| subject.selection.is_blank()) {
            Some(
                "nothing is selected, so parts have nothing to make way for: select something first (paint with target \
                 selection, selection.from_label or selection.import)",
            )
        } else {
            None
        }
    }

    /// Poses by id of part.
    fn told_poses(&self) -> Result<Vec<PartPose>, DocumentError> {
        Ok(self.motion.poses().told(&self.open()?.scene.explosion.parts))
    }
}
