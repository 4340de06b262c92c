//! Commands on the volume as a whole.

use crate::document::Document;
use crate::document::apply::export::{beside_the_file, export};
use crate::document::apply::open::ReadDocument;
use crate::document::apply::sub_volume;
use crate::document::command::Command;
use crate::document::command::answers::{AddedSaid, Answer, Said, VolumeRemovedSaid};
use crate::document::command::files::VolumeCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::history::step::Bare;
use crate::document::paths::check_target;
use crate::document::scene::Origin;
use crate::document::scene::Scene;
use crate::document::scene::first_look;
use crate::document::scene::volumes::{OwnLook, VolumeLook};
use crate::volume::VolumeId;

impl Document {
    pub(crate) fn volume(&mut self, command: &VolumeCommand) -> Result<Answer, DocumentError> {
        match command.clone() {
            VolumeCommand::Open { path, component, frame, range, open_as } => {
                let origin = Origin { path, component, frame };
                let watch = self.watch.clone();
                let opened =
                    ReadDocument::volume(origin, range, open_as, self.unsaved_in.as_deref(), &|x| watch.proceed(x))?;
                Ok(self.take(opened))
            }
            VolumeCommand::Add { path, component, frame, range, open_as, .. } if self.state.is_none() => {
                self.volume(&VolumeCommand::Open { path, component, frame, range, open_as })
            }
            altering @ (VolumeCommand::Add { .. } | VolumeCommand::Remove { .. } | VolumeCommand::Set { .. }) => {
                let whole = Command::Volume(altering.clone());
                self.record(&whole, |document, said, edit| document.alter_volumes(altering, said, edit))
            }
            VolumeCommand::Export { field, label, path, volume } => {
                let state = self.open()?;
                let id = state.at(volume)?.id;
                check_target(&path, &state.files)?;
                let warning = beside_the_file(state, id, field)?;
                Ok(export(&state.at(Some(id))?, field, label, &path, &self.watch, warning)?.into())
            }
        }
    }

    /// Does with voxels what `command` does to volumes; what it does to the scene alone is done, and `said` is what is said of it.
    fn alter_volumes(&mut self, command: VolumeCommand, said: Said, edit: &mut Edit) -> Result<Said, DocumentError> {
        edit.takes_looks();
        match command {
            VolumeCommand::Add { path, component, frame, range, open_as, name, opacity } => {
                let watch = self.watch.clone();
                let origin = Origin { path, component, frame };
                let opened = ReadDocument::volume(origin, range, open_as, None, &|x| watch.proceed(x))?;
                self.put_beside(opened, (name, opacity), edit)
            }
            VolumeCommand::Remove { volume } => {
                let state = self.open_mut()?;
                edit.name(format!("Remove volume {}", state.at(Some(volume))?.settings.name));
                if state.scene.sub_volume(volume).is_ok() {
                    sub_volume::remove(state, volume, edit)?;
                    return Ok(VolumeRemovedSaid { removed: volume, active: Some(state.scene.volumes.active) }.into());
                }
                // What is cut out of it goes with it.
                for inner in state.scene.cut_out_of(volume).into_iter().rev() {
                    sub_volume::remove_with_inner(state, inner, edit)?;
                }
                edit.remove(state, volume)?;
                let volumes = &mut state.scene.volumes;
                volumes.all.remove(&volume);
                let next = volumes.all.keys().next().copied();
                if volumes.active == volume {
                    volumes.active = next.unwrap_or_default();
                }
                let active = next.map(|_| volumes.active);
                state.scene.shown.remove(&volume);
                state.scene.keep_own_looks();
                Ok(VolumeRemovedSaid { removed: volume, active }.into())
            }
            VolumeCommand::Set { volume, .. } => {
                // In a document without volumes nobody has looked for it.
                self.open()?.at(Some(volume))?;
                Ok(said)
            }
            // They change no volume of the document.
            VolumeCommand::Open { .. } | VolumeCommand::Export { .. } => Ok(Said::Nothing),
        }
    }

    /// Puts a volume that was read as a document of its own beside those of this one.
    fn put_beside(
        &mut self,
        opened: ReadDocument,
        (name, opacity): (Option<String>, Option<f32>),
        edit: &mut Edit,
    ) -> Result<Said, DocumentError> {
        let (mut read, about) = opened.into_parts();
        let watch = self.watch.clone();
        for files in read.files.values() {
            edit.has_read(files, &|| watch.proceed(1.0))?;
        }
        let state = self.open_mut()?;
        let first = VolumeId::FIRST;
        let (Some(volume), Some(mut settings)) = (read.volumes.remove(&first), read.scene.volumes.all.remove(&first))
        else {
            return Err(DocumentError::NothingOpen);
        };
        settings.name = name.unwrap_or(settings.name);
        settings.opacity = opacity.unwrap_or(settings.opacity);
        settings.check()?;
        edit.name(format!("Add volume {}", settings.name));
        let id = VolumeId(state.scene.volumes.next);
        let mut shown = VolumeLook::new(read.scene.window_of(first));
        if state.volumes.is_empty() {
            // What is seen was that of nothing.
            let Scene { transfer, look, views, explosion, brush, .. } = read.scene;
            let scene = &mut state.scene;
            (scene.transfer, scene.look, scene.views) = (transfer, look, views);
            (scene.explosion, scene.brush, scene.volumes.active) = (explosion, brush, id);
            // Its parts are none of those that had looks.
            if !scene.own_looks.parts.is_empty() {
                scene.own_looks.parts.clear();
            }
        } else {
            let Scene { transfer, look, .. } = read.scene;
            // Labels are told apart by the colours of their segments.
            settings.label_map = !volume.labels.is_blank();
            let transfer = if settings.label_map {
                first_look::of_labels(volume.grid(), &volume.histogram)
            } else {
                (*transfer).clone()
            };
            shown.own = Some(OwnLook { transfer, mode: look.mode, lighting: look.lighting });
        }
        state.scene.volumes.next = id.0.saturating_add(1);
        state.scene.volumes.all.insert(id, settings);
        state.scene.shown.insert(id, shown);
        edit.add(state, id, Bare { volume, files: read.files.remove(&first) });
        Ok(AddedSaid { volume: id, about }.into())
    }
}
