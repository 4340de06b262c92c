//! The host's fields of all volumes that pictures may name, as the device is given them.
//!
//! References only: cheap to make for every call. Knows no device.

use crate::volume::{Field, FieldKey, FieldKind, Grid, VolumeId};
use std::collections::BTreeMap;

/// The fields of one volume and where it lies; blank fields cost nothing.
#[derive(Clone, Copy, Debug)]
pub struct VolumeFields<'a> {
    /// The lattice that the fields share, in the world: the volume's own pose is in it.
    pub grid: Grid,
    /// Density.
    pub density: &'a Field,
    /// Painted colour.
    pub colour: &'a Field,
    /// Selection.
    pub selection: &'a Field,
    /// Labels.
    pub labels: &'a Field,
}

impl<'a> VolumeFields<'a> {
    /// The field of a kind.
    pub fn get(&self, kind: FieldKind) -> &'a Field {
        match kind {
            FieldKind::Density => self.density,
            FieldKind::Colour => self.colour,
            FieldKind::Selection => self.selection,
            FieldKind::Labels => self.labels,
        }
    }
}

/// All volumes by their names. Whoever leaves one out lets the device forget it.
#[derive(Clone, Debug, Default)]
pub struct Fields<'a>(BTreeMap<VolumeId, VolumeFields<'a>>);

impl<'a> Fields<'a> {
    /// One volume alone, [`VolumeId::FIRST`].
    pub fn one(volume: VolumeFields<'a>) -> Self {
        Self(BTreeMap::from([(VolumeId::FIRST, volume)]))
    }

    /// Adds a volume, or takes another in its place.
    pub fn put(&mut self, id: VolumeId, volume: VolumeFields<'a>) {
        self.0.insert(id, volume);
    }

    /// A volume.
    pub fn get(&self, id: VolumeId) -> Option<&VolumeFields<'a>> {
        self.0.get(&id)
    }

    /// A volume's field.
    pub fn field(&self, key: FieldKey) -> Option<&'a Field> {
        self.get(key.volume).map(|volume| volume.get(key.kind))
    }

    /// The volumes in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (VolumeId, &VolumeFields<'a>)> {
        self.0.iter().map(|(id, volume)| (*id, volume))
    }
}
