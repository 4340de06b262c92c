//! What commands on sub-volumes do to the scene; see `reduce`.
//!
//! They come, change and go with their voxels, which is the document's to do: here is how their steps are called.

use crate::document::command::sub_volumes::SubVolumeCommand;
use crate::document::error::DocumentError;
use crate::document::reduce::Changed;
use crate::document::scene::Scene;
use crate::document::scene::volumes::SubVolume;
use crate::volume::VolumeId;

impl Scene {
    pub(crate) fn apply_sub_volume(&mut self, command: &SubVolumeCommand) -> Result<Changed, DocumentError> {
        let name = |id: &VolumeId| self.volumes.all.get(id).map_or("", |volume| volume.name.as_str());
        Ok(match command {
            SubVolumeCommand::Add { .. } => Changed::named("Add sub-volume"),
            SubVolumeCommand::Set { volume, .. } => Changed::named(format!("Change {}", name(volume))),
            SubVolumeCommand::Remove { volume, .. } => Changed::named(format!("Remove {}", name(volume))),
            SubVolumeCommand::Bake { volume, .. } => Changed::named(format!("Bake {}", name(volume))),
            SubVolumeCommand::Export { .. } => Changed::default(),
        })
    }

    /// Where a sub-volume lies.
    ///
    /// # Errors
    /// If there is none of that name.
    pub(crate) fn sub_volume(&self, id: VolumeId) -> Result<SubVolume, DocumentError> {
        let sub = self.volumes.all.get(&id).and_then(|volume| volume.sub_volume);
        sub.ok_or_else(|| {
            let known = self.volumes.all.iter().filter(|(_, volume)| volume.sub_volume.is_some());
            let known: Vec<String> = known.map(|(id, volume)| format!("{id} ({})", volume.name)).collect();
            let expected = match known.is_empty() {
                true => "a sub-volume, of which there is none; sub_volume.add makes one".to_owned(),
                false => format!("one of the sub-volumes: {}", known.join(", ")),
            };
            DocumentError::invalid("volume", id, expected)
        })
    }

    /// The sub-volumes that are cut out of a volume and out of no other.
    pub(crate) fn boxes_of(&self, id: VolumeId) -> impl Iterator<Item = (VolumeId, SubVolume)> {
        let subs = self.volumes.all.iter().filter_map(|(id, volume)| Some((*id, volume.sub_volume?)));
        subs.filter(move |(_, sub)| sub.parent == id)
    }

    /// The sub-volumes that are cut out of a volume, or out of one of these; parents first.
    pub(crate) fn cut_out_of(&self, id: VolumeId) -> Vec<VolumeId> {
        let mut all = vec![id];
        let mut at = 0;
        while let Some(&parent) = all.get(at) {
            for (child, _) in self.boxes_of(parent) {
                if !all.contains(&child) {
                    all.push(child);
                }
            }
            at += 1;
        }
        all.split_off(1)
    }
}
