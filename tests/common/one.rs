//! The volume of documents that have one.

use burin::document::{RestoredDocument, RestoredVolume, Scene, State};
use burin::volume::{FieldKey, Segments, Volume, VolumeId};

/// A document of one volume.
pub trait One {
    type Volume;
    fn one(&self) -> &Self::Volume;
    fn one_mut(&mut self) -> &mut Self::Volume;
}

impl One for State {
    type Volume = Volume;

    fn one(&self) -> &Volume {
        self.subject(VolumeId::FIRST).unwrap().volume
    }

    fn one_mut(&mut self) -> &mut Volume {
        self.volume_mut(VolumeId::FIRST).unwrap()
    }
}

impl One for RestoredDocument {
    type Volume = RestoredVolume;

    fn one(&self) -> &RestoredVolume {
        &self.volumes[&VolumeId::FIRST]
    }

    fn one_mut(&mut self) -> &mut RestoredVolume {
        self.volumes.get_mut(&VolumeId::FIRST).unwrap()
    }
}

/// What its labels mean.
pub fn segments(scene: &mut Scene) -> &mut Segments {
    scene.segments_mut(VolumeId::FIRST).unwrap()
}

/// What is said of the only field that was painted.
pub fn of_one<T>(mut said: Vec<(FieldKey, T)>) -> T {
    assert_eq!(said.len(), 1);
    said.remove(0).1
}
