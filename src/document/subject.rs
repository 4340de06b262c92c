//! The volume that a command is about, with what a person decided about it.
//!
//! Whoever reads voxels, places or segments asks here, so that nobody mixes the fields of one volume with the grid or the segments
//! of another. Changes nothing.

use crate::document::error::DocumentError;
use crate::document::scene::Scene;
use crate::document::scene::histogram::histogram;
use crate::document::scene::volumes::VolumeSettings;
use crate::document::state::State;
use crate::io;
use crate::math::{Aabb, DAffine3, DVec3};
use crate::volume::{BrickSource, Grid, Measured, Mode, Segments, TransferFunction, Volume, VolumeId};
use std::ops::Deref;
use std::sync::Arc;

/// One volume of the document with its settings; derefs to the volume, its grid has the volume's own pose.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Its name.
    pub id: VolumeId,
    /// Its voxels.
    pub volume: &'a Volume,
    /// What was decided about it.
    pub settings: &'a VolumeSettings,
    /// The scene that it is in.
    pub scene: &'a Scene,
    grid: Grid,
}

impl State {
    /// A volume, the active one if none is named.
    ///
    /// # Errors
    /// If there is no such volume, or none at all.
    pub fn at(&self, volume: Option<VolumeId>) -> Result<Subject<'_>, DocumentError> {
        self.subject(volume.unwrap_or(self.scene.volumes.active)).ok_or_else(|| self.no_volume(volume))
    }

    /// A volume; `None` if there is none of that name.
    pub fn subject(&self, id: VolumeId) -> Option<Subject<'_>> {
        let (volume, settings) = (self.volumes.get(&id)?, self.scene.volumes.all.get(&id)?);
        let own = volume.grid();
        let grid = match self.scene.lies_in(id) {
            // It lies in its parent, wherever that is put.
            Some(sub) => Grid { dims: own.dims, ..sub.of.grid(self.subject(sub.parent)?.grid()) },
            None => Grid { world_from_index: placed(settings, own.world_from_index), ..*own },
        };
        Some(Subject { id, volume, settings, scene: &self.scene, grid })
    }

    /// The box of all volumes where they lie, world mm; where there is none, that of an empty scene.
    pub fn bounds(&self) -> Aabb {
        let boxes = self.subjects().map(|subject| subject.grid().world_bounds());
        let all = boxes.reduce(|a, b| Aabb { min: a.min.min(b.min), max: a.max.max(b.max) });
        all.unwrap_or(Aabb { min: DVec3::splat(-50.0), max: DVec3::splat(50.0) })
    }

    /// All volumes in order.
    pub fn subjects(&self) -> impl Iterator<Item = Subject<'_>> {
        self.volumes.keys().filter_map(|&id| self.subject(id))
    }

    /// The volume of that name, to change it; the active one if none is named.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn volume_mut(&mut self, id: VolumeId) -> Result<&mut Volume, DocumentError> {
        if !self.volumes.contains_key(&id) {
            return Err(self.no_volume(Some(id)));
        }
        self.volumes.get_mut(&id).ok_or(DocumentError::NoVolume)
    }

    fn no_volume(&self, named: Option<VolumeId>) -> DocumentError {
        match named {
            Some(id) if !self.volumes.is_empty() => self.scene.volumes.none_of("volume", id),
            _ => DocumentError::NoVolume,
        }
    }
}

/// Where a volume lies, by where its file puts it. One that was never moved lies there to the last digit.
fn placed(settings: &VolumeSettings, world_from_index: DAffine3) -> DAffine3 {
    if settings.pose == crate::math::Pose::IDENTITY {
        world_from_index
    } else {
        settings.pose.world_from_rest() * world_from_index
    }
}

impl<'a> Subject<'a> {
    /// Its lattice where it lies, its own pose included.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What its labels mean.
    pub fn segments(&self) -> &'a Segments {
        self.scene.segments_of(self.id)
    }

    /// What is known of a sub-volume's own samples as they are now, edited ones among them: found when it is asked for. Nothing of another
    /// volume, of which its source is measured when it is opened.
    ///
    /// # Errors
    /// If what it is cut out of cannot be read.
    pub(crate) fn measured(&self) -> Result<Option<Arc<Measured>>, DocumentError> {
        let find = |source: &dyn BrickSource| -> Result<Measured, DocumentError> {
            let statistics = io::statistics(source, &|_| true)?;
            let histogram = histogram(source, &statistics, &|_| true)?;
            Ok(Measured { statistics, histogram })
        };
        match self.volume.sub_box() {
            Some(_) => Ok(Some(self.volume.density.measured(self.volume.source.as_ref(), find)?)),
            None => Ok(None),
        }
    }

    /// Colours and opacities that it is shown with.
    pub fn transfer(&self) -> &'a TransferFunction {
        self.scene.transfer_of(self.id)
    }

    /// How rays through it become colour.
    pub fn mode(&self) -> Mode {
        self.scene.mode_of(self.id)
    }
}

impl Deref for Subject<'_> {
    type Target = Volume;

    fn deref(&self) -> &Volume {
        self.volume
    }
}
