//! Commands on the degree of explosion and the forces.

use super::edit::Edit;
use super::{Document, DocumentError, ExplosionCommand};
use serde_json::{Value, json};

impl Document {
    pub(super) fn explosion(&mut self, command: ExplosionCommand, edit: &mut Edit) -> Result<Value, DocumentError> {
        let explosion = &mut self.open_mut()?.scene.explosion;
        match command {
            ExplosionCommand::Degree { value } => {
                edit.name("Degree of explosion");
                explosion.degree = value;
                explosion.check()?;
                Ok(json!({ "degree": value }))
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
            ExplosionCommand::Settle {} | ExplosionCommand::Step { .. } => {
                Err(DocumentError::NotNow("this build has no simulation".into()))
            }
        }
    }
}
