//! Commands on the volume as a whole.

use super::{Document, DocumentError, Origin, VolumeCommand};
use serde_json::Value;

impl Document {
    pub(super) fn volume(&mut self, command: VolumeCommand) -> Result<Value, DocumentError> {
        match command {
            VolumeCommand::Open { path, component, frame, range } => {
                self.open_volume(Origin { path, component, frame }, range)
            }
            VolumeCommand::Export { field, path } => {
                self.open()?;
                Err(DocumentError::NotNow(format!("this build cannot export {} to {}", field.name(), path.display())))
            }
        }
    }
}
