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
        let shown_now = OwnLook {
            transfer: self.transfer_of(volume).clone(),
            mode: self.mode_of(volume),
            lighting: self.lighting_of(volume),
        };
        let given = look.as_ref().map(|look| look.of_volume(shown_now)).transpose()?;
        let of_look = given.as_ref().and_then(|(_, opacity)| *opacity);
        if opacity.is_some() && of_look.is_some() {
            return Err(DocumentError::invalid("look.opacity", "given beside the volume's", "one of the two"));
        }
        settings.opacity = opacity.or(of_look).unwrap_or(settings.opacity);
        if let (Some(sub), Some(_)) = (settings.sub_volume, pose) {
            let expected = format!("none: a sub-volume lies where volume {} lies", sub.parent);
            return Err(DocumentError::invalid("pose", "one of its own", expected));
        }
        settings.pose = pose.unwrap_or(settings.pose);
        settings.check()?;
        settings.pose.rotation = settings.pose.rotation.normalize();
        let mut own = None;
        if let Some(shown) = self.shown.get(&volume) {
            own = match (given, shared_look) {
                (Some((own, _)), _) => own,
                (None, true) => None,
                (None, false) => shown.own.clone(),
            };
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
