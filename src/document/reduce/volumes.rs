//! What commands on volumes do to the scene; see `reduce`.
//!
//! Volumes come and go with their voxels, which is the document's to do; what is given of one that is there is changed here.

use crate::document::command::answers::VolumeSetSaid;
use crate::document::command::files::VolumeCommand;
use crate::document::error::DocumentError;
use crate::document::reduce::Changed;
use crate::document::scene::Scene;
use crate::document::scene::volumes::OwnLook;

impl Scene {
    pub(crate) fn apply_volume(&mut self, command: &VolumeCommand) -> Result<Changed, DocumentError> {
        let VolumeCommand::Set { volume, name, visible, opacity, look, shared_look, pose, active } = command else {
            return Ok(Changed::default());
        };
        let volume = *volume;
        let Some(mut settings) = self.volumes.all.get(&volume).cloned() else {
            return Err(self.volumes.none_of("volume", volume));
        };
        if look.is_some() && *shared_look {
            return Err(DocumentError::invalid("shared_look", "true beside a look", "one of the two"));
        }
        let step = match (name, visible) {
            (Some(_), _) => format!("Rename volume {}", settings.name),
            (_, Some(true)) => format!("Show volume {}", settings.name),
            (_, Some(false)) => format!("Hide volume {}", settings.name),
            _ if pose.is_some() => format!("Move volume {}", settings.name),
            _ if *active && opacity.is_none() && look.is_none() && !*shared_look => {
                format!("Choose volume {}", settings.name)
            }
            _ => format!("Change volume {}", settings.name),
        };
        if let Some(name) = name {
            settings.name.clone_from(name);
        }
        settings.visible = visible.unwrap_or(settings.visible);
        settings.opacity = opacity.unwrap_or(settings.opacity);
        settings.pose = pose.unwrap_or(settings.pose);
        settings.check()?;
        settings.pose.rotation = settings.pose.rotation.normalize();
        let mut own = None;
        if let Some(shown) = self.shown.get(&volume) {
            let changed = if *shared_look { None } else { look.as_deref().or(shown.own.as_ref()) };
            changed.map_or(Ok(()), OwnLook::check)?;
            own = changed.cloned();
        }
        // What stays as it was is still the same pointer.
        if self.shown.get(&volume).is_some_and(|shown| shown.own != own)
            && let Some(shown) = self.shown.get_mut(&volume)
        {
            shown.own.clone_from(&own);
        }
        self.volumes.all.insert(volume, settings.clone());
        if *active {
            self.volumes.active = volume;
        }
        let active = self.volumes.active == volume;
        Ok(Changed::new(step, VolumeSetSaid { volume, settings, look: own, active }))
    }
}
