//! What a field may be computed from where nobody edited it, of any kind and level, and the box of a volume that this is about.
//!
//! Knows neither fields nor volumes: a field holds what is computed behind [`Computed`].

use crate::math::{DAffine3, DMat3, DVec3};
use crate::volume::brick::BrickKey;
use crate::volume::cells::{BrickSummary, Cells};
use crate::volume::grid::Grid;
use crate::volume::source::SourceError;
use crate::volume::texel::DensityMap;
use serde::{Deserialize, Serialize};

/// Texels that are computed when they are asked for.
pub(super) trait Computed: Send + Sync + std::fmt::Debug {
    /// Texels of a box inside a level, appended to `out`, x fastest; density by this map.
    fn texels(&self, map: &DensityMap, of: (u8, [u32; 3], [u32; 3]), out: &mut Vec<u8>) -> Result<(), SourceError>;

    /// What is known of a brick without its texels: bounds of them.
    fn about(&self, map: &DensityMap, key: BrickKey) -> Result<(BrickSummary, Cells), SourceError>;

    /// The box of a volume that they are samples of.
    fn sub_box(&self) -> SubBox;
}

/// A box of a volume's voxels and how many samples of its own lie in one along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SubBox {
    /// The parent's voxel whose centre is the box's first corner.
    pub lo: [u32; 3],
    /// The one whose centre is its last corner: above `lo` along every axis.
    pub hi: [u32; 3],
    /// Samples a voxel along i, j, k, 1 to 8.
    pub scale: [u32; 3],
}

impl SubBox {
    /// The finest that a voxel is divided.
    pub const FINEST: u32 = 8;

    /// Samples along i, j, k; the first and the last lie on the box's faces.
    pub fn dims(&self) -> [u32; 3] {
        std::array::from_fn(|a| (self.hi[a] - self.lo[a]) * self.scale[a] + 1)
    }

    /// How many samples that are.
    pub fn samples(&self) -> u64 {
        self.dims().iter().fold(1, |all: u64, &d| all.saturating_mul(u64::from(d)))
    }

    /// Where its samples lie: number j along an axis at `lo + j / scale` of the parent's index.
    pub fn grid(&self, parent: &Grid) -> Grid {
        let step = DVec3::from_array(self.scale.map(|s| 1.0 / f64::from(s)));
        let shift =
            DAffine3 { matrix3: DMat3::from_diagonal(step), translation: DVec3::from_array(self.lo.map(f64::from)) };
        Grid { dims: self.dims(), world_from_index: parent.world_from_index * shift }
    }

    /// Whether no place lies inside both boxes; they may share a face.
    pub fn is_apart(&self, other: &Self) -> bool {
        (0..3).any(|a| self.hi[a] <= other.lo[a] || other.hi[a] <= self.lo[a])
    }

    /// Whether it holds all of another one.
    pub fn holds(&self, other: &Self) -> bool {
        (0..3).all(|a| self.lo[a] <= other.lo[a] && other.hi[a] <= self.hi[a])
    }

    /// All voxels of a volume as they are.
    pub fn whole(dims: [u32; 3]) -> Self {
        Self { lo: [0; 3], hi: dims.map(|d| d.saturating_sub(1)), scale: [1; 3] }
    }

    /// How a box that is cut out of this one, in its samples, lies to another box of the same volume.
    pub fn inner_lies(&self, inner: &Self, other: &Self) -> Lies {
        let end = |of_inner: u32, a: usize| u64::from(self.lo[a]) * u64::from(self.scale[a]) + u64::from(of_inner);
        let of_other = |v: u32, a: usize| u64::from(v) * u64::from(self.scale[a]);
        let all = |test: &dyn Fn(usize) -> bool| (0..3).all(test);
        if all(&|a| of_other(other.lo[a], a) <= end(inner.lo[a], a) && end(inner.hi[a], a) <= of_other(other.hi[a], a))
        {
            return Lies::Inside;
        }
        let meets =
            |a: usize| end(inner.lo[a], a) < of_other(other.hi[a], a) && of_other(other.lo[a], a) < end(inner.hi[a], a);
        if all(&meets) { Lies::InPart } else { Lies::Apart }
    }

    /// A box that is cut out of this one, in its samples, as the same box with the same samples in those of another box of the same
    /// volume; `None` if it is none of whole samples there, or not 1 to 8 times as fine.
    pub fn inner_in(&self, inner: &Self, other: &Self) -> Option<Self> {
        let mut of = Self { lo: [0; 3], hi: [0; 3], scale: [0; 3] };
        for a in 0..3 {
            let (own, its) = (u64::from(self.scale[a]), u64::from(other.scale[a]));
            let place = |v: u32| {
                let place = (u64::from(self.lo[a]) * own + u64::from(v)) * its;
                let place = place.checked_sub(u64::from(other.lo[a]) * its * own)?;
                let whole = place.is_multiple_of(own).then(|| u32::try_from(place / own).ok());
                whole.flatten().filter(|place| *place < other.dims()[a])
            };
            let scale = u64::from(inner.scale[a]) * own;
            let finer = scale.is_multiple_of(its).then(|| u32::try_from(scale / its).ok()).flatten();
            (of.lo[a], of.hi[a]) = (place(inner.lo[a])?, place(inner.hi[a])?);
            of.scale[a] = finer.filter(|scale| (1..=Self::FINEST).contains(scale))?;
        }
        Some(of)
    }
}

/// How one box lies to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lies {
    /// All of it in the other.
    Inside,
    /// They share a face at most.
    Apart,
    /// Some of it in the other.
    InPart,
}
