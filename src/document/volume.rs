//! Commands on the volume as a whole.

use super::{Document, DocumentError, Origin, VolumeCommand};
use crate::io::{Compression, export};
use serde_json::{Value, json};

impl Document {
    pub(super) fn volume(&mut self, command: VolumeCommand) -> Result<Value, DocumentError> {
        match command {
            VolumeCommand::Open { path, component, frame, range } => {
                self.open_volume(Origin { path, component, frame }, range)
            }
            VolumeCommand::Export { field, path } => {
                let state = self.open()?;
                let exported = export(
                    path,
                    state.field(field),
                    state.grid(),
                    &state.scene.segments,
                    Compression::default(),
                    &|_| true,
                )?;
                Ok(json!({ "exported": exported }))
            }
        }
    }
}
