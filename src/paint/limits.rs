//! What of a volume a stroke may touch: a bit for every texel of the slots that it meets, of all limits that its brush has together.
//!
//! Owns the limits a brush may name and how each is told from the fields as they were at the stroke's start, or from the sets of voxels
//! that were found for it (the visible surface, what is connected, a drawn contour). Cost: that of the slots asked for. Knows neither how
//! such sets are found nor the GPU.

use crate::paint::brush::Brush;
use crate::paint::gate::{GATE_WORDS, Gate};
use crate::paint::only::{OfSegment, Side};
use crate::paint::voxel_set::VoxelSet;
use crate::volume::{BrickIndex, BrickKey, Field, Grid, SLOT, SourceError, squared_distances};
use std::sync::Arc;

/// One of the limits that a stroke keeps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// The visible surface.
    Visible,
    /// What lies within a depth of it.
    Depth,
    /// What is connected to where the stroke began.
    Connected,
    /// A contour that was drawn.
    Contour,
    /// What no sub-volume stands for.
    SubVolumes,
    /// A side of the selection.
    Selection,
    /// A side of a segment.
    Segment,
    /// A range of values.
    Range,
}

/// Sets of voxels that a stroke keeps within.
pub type Confines = Vec<(Limit, Arc<VoxelSet>)>;

impl Brush {
    /// Whether its strokes have to look at what the 3D view shows under their dabs.
    pub fn keeps_to_surface(&self) -> bool {
        self.visible_only || self.within_mm.is_some()
    }

    /// Whether it may leave voxels alone that it covers.
    pub fn is_limited(&self) -> bool {
        self.keeps_to_surface() || self.connected || self.range.is_some() || !self.only.is_anything()
    }

    /// The same where no 3D view is looked at.
    #[must_use]
    pub fn off_surface(&self) -> Self {
        Self { visible_only: false, within_mm: None, ..*self }
    }
}

/// What a stroke's limits are told from.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a> {
    /// The brush.
    pub brush: &'a Brush,
    /// The volume's lattice.
    pub grid: &'a Grid,
    /// Density at the stroke's start.
    pub density: &'a Field,
    /// The selection at its start.
    pub selection: &'a Field,
    /// Labels at its start.
    pub labels: &'a Field,
    /// Voxels of the visible surface, as far as they were looked for.
    pub seen: &'a VoxelSet,
    /// Sets that it keeps within.
    pub confines: &'a [(Limit, Arc<VoxelSet>)],
}

impl Limits<'_> {
    /// A bit for every texel of a slot of level 0, x fastest, set where the brush may paint; apron texels as the voxels that they
    /// repeat.
    ///
    /// # Errors
    /// If the source fails.
    pub fn slot(&self, index: BrickIndex) -> Result<Vec<u32>, SourceError> {
        let mut all = vec![u32::MAX; GATE_WORDS];
        for (_, bits) in self.each(index)? {
            all.iter_mut().zip(bits).for_each(|(a, b)| *a &= b);
        }
        Ok(all)
    }

    /// The same of each limit for itself.
    ///
    /// # Errors
    /// If the source fails.
    pub fn each(&self, index: BrickIndex) -> Result<Vec<(Limit, Vec<u32>)>, SourceError> {
        let Self { brush, grid, density, selection, labels, seen, confines } = *self;
        let key = BrickKey { level: 0, index };
        let mut bits = Vec::new();
        if brush.visible_only {
            bits.push((Limit::Visible, seen.slot(index, grid.dims)));
        }
        if let Some(depth) = brush.within_mm {
            bits.push((Limit::Depth, near(seen, depth, index, grid)));
        }
        bits.extend(confines.iter().map(|(limit, set)| (*limit, set.slot(index, grid.dims))));
        if let Some(side) = brush.only.selection {
            let codes = selection.slot(key)?;
            bits.push((Limit::Selection, packed(codes.iter().map(|&code| (code >= 128) == (side == Side::Inside)))));
        }
        if let Some(OfSegment { id, side }) = brush.only.segment {
            let ids = labels.slot(key)?;
            let of = |t: &[u8]| (u16::from_le_bytes([t[0], t[1]]) == id) == (side == Side::Inside);
            bits.push((Limit::Segment, packed(ids.chunks_exact(2).map(of))));
        }
        if let Some(range) = brush.range {
            bits.push((Limit::Range, Gate::new(range, density).slot(density, index)?));
        }
        Ok(bits)
    }
}

fn packed(open: impl Iterator<Item = bool>) -> Vec<u32> {
    let mut bits = vec![0_u32; GATE_WORDS];
    for (texel, open) in open.enumerate() {
        bits[texel / 32] |= u32::from(open) << (texel % 32);
    }
    bits
}

/// How many voxels a depth reaches along each axis.
pub fn margin(depth_mm: f64, grid: &Grid) -> [u32; 3] {
    grid.spacing().to_array().map(|spacing| (depth_mm / spacing).floor().min(f64::from(u32::MAX / 4)) as u32)
}

/// Which texels of a slot lie no further than a depth from a voxel of a set, mm between centres along the voxel axes at their spacings.
fn near(set: &VoxelSet, depth_mm: f64, index: BrickIndex, grid: &Grid) -> Vec<u32> {
    let (margin, dims, origin) = (margin(depth_mm, grid), grid.dims, index.origin());
    let lo: [u32; 3] = std::array::from_fn(|a| origin[a].saturating_sub(1 + margin[a]));
    let end: [u32; 3] = std::array::from_fn(|a| origin[a].saturating_add(SLOT - 1 + margin[a]).min(dims[a]));
    let Some(held) = set.within(lo, end) else { return vec![0; GATE_WORDS] };
    let size: [usize; 3] = std::array::from_fn(|a| (end[a] - lo[a]) as usize);
    let squared = squared_distances(size, grid.spacing(), |i| held[i]);
    let most = depth_mm * depth_mm * (1.0 + 1e-9);
    let voxel = |a: usize, t: u32| ((origin[a] + t).saturating_sub(1).min(dims[a] - 1) - lo[a]) as usize;
    packed((0..SLOT * SLOT * SLOT).map(|texel| {
        let [x, y, z] = [texel % SLOT, texel / SLOT % SLOT, texel / (SLOT * SLOT)];
        squared[voxel(0, x) + size[0] * (voxel(1, y) + size[1] * voxel(2, z))] <= most
    }))
}
