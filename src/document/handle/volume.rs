//! Commands on the volume as a whole.

use super::open::Opened;
use super::{Document, DocumentError, Origin, VolumeCommand};
use crate::io::{Compression, export};
use serde_json::{Value, json};

impl Document {
    pub(in crate::document) fn volume(&mut self, command: VolumeCommand) -> Result<Value, DocumentError> {
        match command {
            VolumeCommand::Open { path, component, frame, range } => {
                let origin = Origin { path, component, frame };
                let watch = self.watch.clone();
                let opened = Opened::volume(origin, range, self.unsaved_in.as_deref(), &|x| watch.go_on(x))?;
                Ok(self.take(opened))
            }
            VolumeCommand::Export { field, path } => {
                let state = self.open()?;
                let exported = export(
                    path,
                    state.field(field),
                    state.grid(),
                    &state.scene.segments,
                    Compression::default(),
                    &|x| self.watch.go_on(x),
                )?;
                Ok(json!({ "exported": exported }))
            }
        }
    }
}
