//! A volume: a grid, the values measured on it, and what was painted over them.
//!
//! Owns the four fields and the source behind the density. Any number of volumes lie beside each other; `VolumeId` names one,
//! `FieldKey` one of its fields, everywhere. What a person calls it, where it is shown and how is the document's, as are files.

use crate::volume::brick::BrickIndex;
use crate::volume::computed::SubBox;
use crate::volume::field::{Field, FieldKind};
use crate::volume::grid::Grid;
use crate::volume::histogram::Histogram;
use crate::volume::source::{BrickSource, SourceError};
use crate::volume::texel::{DensityMap, TexelFormat};
use crate::volume::values::unit;
use crate::volume::voxels::Statistics;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Of a stroke in floats: of what was there, what is painted, their difference, its share and the sum, each half a unit in the last
/// place of up to twice the largest number.
const ROUNDINGS: f64 = 4.0;

/// Names a volume of a document; one that is gone never gives its name to another.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(transparent)]
pub struct VolumeId(pub u32);

impl VolumeId {
    /// The volume that a document begins with.
    pub const FIRST: Self = Self(0);

    /// Numbers of volumes that no scene names.
    const BEFORE: u32 = 1 << 31;

    /// What a sub-volume of this name is computed from: its parent as it was.
    #[must_use]
    pub const fn of_before(self) -> Self {
        Self(self.0 | Self::BEFORE)
    }

    /// The sub-volume that is computed from what this names.
    #[must_use]
    pub const fn of_sub_volume(self) -> Self {
        Self(self.0 & !Self::BEFORE)
    }

    /// Whether it names what a sub-volume is computed from.
    pub const fn is_of_before(self) -> bool {
        self.0 & Self::BEFORE != 0
    }
}

impl std::fmt::Display for VolumeId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// Names a field of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FieldKey {
    /// The volume.
    pub volume: VolumeId,
    /// Which of its fields.
    pub kind: FieldKind,
}

impl FieldKey {
    /// The key of a field.
    pub const fn new(volume: VolumeId, kind: FieldKind) -> Self {
        Self { volume, kind }
    }
}

impl From<FieldKind> for FieldKey {
    /// The field of the volume that a document begins with.
    fn from(kind: FieldKind) -> Self {
        Self::new(VolumeId::FIRST, kind)
    }
}

/// Four fields over one grid, with the source of density and what was measured of it. Cheap to clone: bricks are shared.
#[derive(Clone, Debug)]
pub struct Volume {
    /// The values with their edits.
    pub density: Field,
    /// Painted colour.
    pub colour: Field,
    /// Degree of interest.
    pub selection: Field,
    /// Labels.
    pub labels: Field,
    /// Where unedited density comes from.
    pub source: Arc<dyn BrickSource>,
    /// Of the source's values.
    pub statistics: Statistics,
    /// Of the source's values.
    pub histogram: Histogram,
    /// Between which values density was painted, once it was.
    pub painted: Option<[f64; 2]>,
}

impl Volume {
    /// Reads the source once; nothing is painted. `progress` gets the share done and answers whether to go on: `None` if not.
    ///
    /// # Errors
    /// If the source fails.
    pub fn new(
        source: Arc<dyn BrickSource>,
        map: DensityMap,
        statistics: Statistics,
        histogram: Histogram,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Option<Self>, SourceError> {
        let Some(density) = Field::from_source(source.clone(), map, progress)? else { return Ok(None) };
        let grid = *source.grid();
        let blank = |kind| Field::blank(kind, &grid);
        let (colour, selection, labels) =
            (blank(FieldKind::Colour), blank(FieldKind::Selection), blank(FieldKind::Labels));
        Ok(Some(Self { density, colour, selection, labels, source, statistics, histogram, painted: None }))
    }

    /// The same as it is now with the edits of some bricks alone, and without coarser levels: what a sub-volume is computed from.
    #[must_use]
    pub fn as_it_is(&self, bricks: impl Fn(BrickIndex) -> bool) -> Self {
        let field = |kind| self.field(kind).edits_alone(&bricks);
        Self {
            density: field(FieldKind::Density),
            colour: field(FieldKind::Colour),
            selection: field(FieldKind::Selection),
            labels: field(FieldKind::Labels),
            ..self.clone()
        }
    }

    /// The same without edits and coarser levels, its density by this map.
    #[must_use]
    pub fn unedited(&self, map: DensityMap) -> Self {
        let mut bare = self.as_it_is(|_| false);
        bare.density = bare.density.by_map(map);
        bare
    }

    /// The box of a parent that it is, if it is one.
    pub fn sub_box(&self) -> Option<SubBox> {
        self.density.sub_box()
    }

    /// The lattice that all fields share, where the source has it.
    pub fn grid(&self) -> &Grid {
        self.source.grid()
    }

    /// Bytes that a sample of all four fields takes where it is stored.
    pub fn sample_bytes(&self) -> u64 {
        FieldKind::ALL.iter().map(|kind| kind.format(self.density.format()).bytes() as u64).sum()
    }

    /// A field by its kind.
    pub fn field(&self, kind: FieldKind) -> &Field {
        match kind {
            FieldKind::Density => &self.density,
            FieldKind::Colour => &self.colour,
            FieldKind::Selection => &self.selection,
            FieldKind::Labels => &self.labels,
        }
    }

    /// The same, to change it; whoever does keeps the history.
    pub fn field_mut(&mut self, kind: FieldKind) -> &mut Field {
        match kind {
            FieldKind::Density => &mut self.density,
            FieldKind::Colour => &mut self.colour,
            FieldKind::Selection => &mut self.selection,
            FieldKind::Labels => &mut self.labels,
        }
    }

    /// The most by which a painted value may differ from what comes back of it, anywhere in the volume as it is now. What was not
    /// painted comes back as the source has it.
    pub fn half_step(&self) -> f64 {
        let map = self.density.map();
        // Extremes are known to 32 bits; codes end where their map does.
        let painted = match map.format {
            TexelFormat::R32Float => self.density.extremes().map(f64::from),
            _ => [map.lo, map.hi()],
        };
        let largest = [self.statistics.min, self.statistics.max, painted[0], painted[1]]
            .into_iter()
            .map(f64::abs)
            .filter(|v| v.is_finite())
            .fold(self.largest_painted(), f64::max);
        self.half_step_of(largest)
    }

    /// The same of a voxel that was painted to a value from this one of the source.
    pub fn half_step_at(&self, value: f64, own: f64) -> f64 {
        let mixed = value.abs().max(self.largest_painted());
        // What is so much larger than anything painted leaves no digit of it if it is mixed with that.
        let from = if own.abs() * f64::from(f32::EPSILON) <= 2.0 * mixed { own.abs() } else { 0.0 };
        self.half_step_of(if self.density.format() == TexelFormat::R32Float { mixed.max(from) } else { value })
    }

    fn largest_painted(&self) -> f64 {
        self.painted.map_or(0.0, |[lo, hi]| lo.abs().max(hi.abs()))
    }

    /// Of numbers of this size: rounding to the texel, and in the kernel's 32 bits to that of each number which it was made from.
    fn half_step_of(&self, size: f64) -> f64 {
        let map = self.density.map();
        let roundings = if map.format == TexelFormat::R32Float { ROUNDINGS } else { 1.0 };
        map.error_at(size, unit(self.source.as_ref()).is_some()) * roundings
    }
}
