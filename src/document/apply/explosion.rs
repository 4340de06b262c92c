//! Commands on the degree of explosion and the forces.

use crate::document::Document;
use crate::document::command::parts::ExplosionCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::explode::PartPose;
use serde_json::{Value, json};

/// Steps of one command: more than a minute of animation is a slip.
const MOST_STEPS: u32 = 3600;

impl Document {
    pub(crate) fn explosion(&mut self, command: ExplosionCommand, edit: &mut Edit) -> Result<Value, DocumentError> {
        let explosion = &mut self.open_mut()?.scene.explosion;
        match command {
            ExplosionCommand::Degree { value } => {
                edit.name("Degree of explosion");
                explosion.degree = value;
                explosion.check()?;
                let mut answer = json!({ "degree": value });
                self.hint(&mut answer);
                Ok(answer)
            }
            ExplosionCommand::Forces { forces } => {
                edit.name("Forces");
                forces.check()?;
                explosion.forces = forces;
                Ok(json!({ "forces": forces }))
            }
            ExplosionCommand::Seed { value } => {
                edit.name("Seed of explosion points");
                explosion.seed = value;
                Ok(json!({ "seed": value }))
            }
            ExplosionCommand::Settle {} => {
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let settled = self.motion.settle(state, &mut self.graphics, &self.watch)?;
                let mut answer = json!({
                    "poses": self.told_poses()?,
                    "gains": settled.gains,
                    "rounds": settled.rounds,
                    "steps": settled.steps,
                    "at_rest": settled.at_rest,
                    "visible": settled.visible,
                });
                self.hint(&mut answer);
                Ok(answer)
            }
            ExplosionCommand::Step { steps } => {
                if steps > MOST_STEPS {
                    return Err(DocumentError::invalid("steps", steps, format!("at most {MOST_STEPS}")));
                }
                let due = self.follow_stroke()?;
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let moved = self.motion.step(state, &mut self.graphics, steps)?;
                Ok(json!({ "poses": self.told_poses()?, "moving": moved.moving || due, "visible": moved.visible }))
            }
        }
    }

    /// Says what is missing where parts are to make way for nothing.
    fn hint(&self, answer: &mut Value) {
        let Some(state) = &self.state else { return };
        let explosion = &state.scene.explosion;
        if explosion.degree > 0.0 && explosion.parts.len() < 2 {
            answer["hint"] = json!("there is one part, which nothing moves: cut it first (part.split)");
        } else if explosion.degree > 0.0 && state.selection.is_blank() {
            answer["hint"] = json!(
                "nothing is selected, so parts have nothing to make way for: select something first (paint with target \
                 selection, selection.from_label or selection.import)"
            );
        }
    }

    /// Poses by id of part.
    fn told_poses(&self) -> Result<Vec<PartPose>, DocumentError> {
        Ok(self.motion.poses().told(&self.open()?.scene.explosion.parts))
    }
}
