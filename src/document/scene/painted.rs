//! Which volumes a stroke paints: those that it names, or the active one and what was chosen besides it.
//!
//! Owns the rules for lists of volumes. Knows no voxels: what a brush can paint is found where it begins.

use crate::document::error::DocumentError;
use crate::document::scene::Scene;
use crate::volume::VolumeId;

impl Scene {
    /// What a stroke paints that names no volume: the active one, then those that were chosen besides it and are seen. Nothing is
    /// painted unseen that was not named.
    pub fn painted(&self) -> Vec<VolumeId> {
        let active = self.volumes.active;
        let also = self.also.iter().copied().filter(|id| *id != active && self.is_seen(*id));
        std::iter::once(active).chain(also).collect()
    }

    /// What a stroke paints that names one volume, several, or none.
    ///
    /// # Errors
    /// If it names both one and several, none of several, one twice, or one that is not there.
    pub(crate) fn painted_by(
        &self,
        volume: Option<VolumeId>,
        volumes: Option<&[VolumeId]>,
    ) -> Result<Vec<VolumeId>, DocumentError> {
        match (volume, volumes) {
            (None, None) => Ok(self.painted()),
            (Some(_), None) => Ok(vec![self.meant(volume)?]),
            (None, Some([])) => Err(DocumentError::invalid(
                "volumes",
                "[]",
                "at least one volume; without the field the active one is painted",
            )),
            (None, Some(ids)) => self.told_apart(ids).map(|()| ids.to_vec()),
            (Some(one), Some(_)) => Err(DocumentError::invalid(
                "volumes",
                format!("beside `volume`: {one}"),
                "either `volume` or `volumes`",
            )),
        }
    }

    /// # Errors
    /// If one of them is named twice or is not there.
    pub(crate) fn told_apart(&self, volumes: &[VolumeId]) -> Result<(), DocumentError> {
        for (i, id) in volumes.iter().enumerate() {
            if !self.volumes.all.contains_key(id) {
                return Err(self.volumes.none_of("volumes", *id));
            }
            if volumes[..i].contains(id) {
                return Err(DocumentError::invalid("volumes", format!("{id} twice"), "each volume once"));
            }
        }
        Ok(())
    }

    /// Whether pictures show a volume.
    fn is_seen(&self, volume: VolumeId) -> bool {
        self.volumes.all.get(&volume).is_some_and(|settings| settings.visible && settings.opacity > 0.0)
    }
}
