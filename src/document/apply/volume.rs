//! Commands on the volume as a whole.

use crate::document::Document;
use crate::document::apply::open::Opened;
use crate::document::command::answers::{Answer, ExportedSaid, Said};
use crate::document::command::files::VolumeCommand;
use crate::document::command::paths::check_target;
use crate::document::error::DocumentError;
use crate::document::scene::Origin;
use crate::io::{Compression, export};

impl Document {
    pub(crate) fn volume(&mut self, command: &VolumeCommand) -> Result<Answer, DocumentError> {
        match command.clone() {
            VolumeCommand::Open { path, component, frame, range, open_as } => {
                let origin = Origin { path, component, frame };
                let watch = self.watch.clone();
                let opened = Opened::volume(origin, range, open_as, self.unsaved_in.as_deref(), &|x| watch.go_on(x))?;
                Ok(self.take(opened))
            }
            VolumeCommand::Export { field, path } => {
                let state = self.open()?;
                let subject = state.at(None)?;
                check_target(&path, &state.files)?;
                let exported = export(
                    path,
                    subject.field(field),
                    subject.volume.grid(),
                    subject.segments(),
                    Compression::default(),
                    &|x| self.watch.go_on(x),
                )?;
                let warnings = exported.warnings.clone();
                Ok(Said::from(ExportedSaid { exported, warnings }).into())
            }
        }
    }
}
