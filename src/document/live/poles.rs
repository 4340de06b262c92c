//! Where segments are: which have voxels, and the voxel of each that lies deepest inside it.
//!
//! Found when a label first asks, again after labels changed. Owns what was found; nothing here is saved.

use crate::annotate::labels::pole;
use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;
use crate::document::state::State;
use crate::math::DVec3;
use crate::volume::{Brick, BrickKey, FieldKind, VolumeId};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// Voxels of a box in which a pole is searched: of larger ones every second, or third, and so on.
const MOST_VOXELS: u64 = 1 << 24;

/// First and last index of a label's voxels.
type Bounds = [[u32; 3]; 2];

/// What was found of the segments of all volumes that were asked for.
#[derive(Debug, Default)]
pub(crate) struct Poles {
    bounds: BTreeMap<VolumeId, BTreeMap<u16, Bounds>>,
    poles: BTreeMap<(VolumeId, u16), Option<DVec3>>,
}

impl Poles {
    /// Another document is open.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Labels have changed.
    pub(crate) fn mirror(&mut self, refreshed: &Refreshed) {
        let painted =
            refreshed.slots.iter().filter(|(key, _)| key.kind == FieldKind::Labels).map(|(key, _)| key.volume);
        for id in painted.chain(refreshed.exchanged.iter().copied()).collect::<BTreeSet<_>>() {
            self.bounds.remove(&id);
            self.poles.retain(|(of, _), _| *of != id);
        }
    }

    /// The labels that voxels of a volume have.
    ///
    /// # Errors
    /// If there is no such volume.
    pub(crate) fn present(&mut self, state: &State, id: VolumeId) -> Result<BTreeSet<u16>, DocumentError> {
        Ok(self.bounds(state, id)?.keys().copied().collect())
    }

    fn bounds(&mut self, state: &State, id: VolumeId) -> Result<&BTreeMap<u16, Bounds>, DocumentError> {
        Ok(match self.bounds.entry(id) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => unknown.insert(bounds_of(state, id)?),
        })
    }

    /// The deepest place of a segment, continuous index; `None` if it has no voxel.
    ///
    /// # Errors
    /// If there is no such volume, or its labels cannot be read.
    pub(crate) fn pole(&mut self, state: &State, id: VolumeId, label: u16) -> Result<Option<DVec3>, DocumentError> {
        if let Some(known) = self.poles.get(&(id, label)) {
            return Ok(*known);
        }
        let found = match self.bounds(state, id)?.get(&label).copied() {
            Some(bounds) => deepest(state, id, label, bounds)?,
            None => None,
        };
        self.poles.insert((id, label), found);
        Ok(found)
    }
}

fn bounds_of(state: &State, id: VolumeId) -> Result<BTreeMap<u16, Bounds>, DocumentError> {
    let field = &state.at(Some(id))?.volume.labels;
    let mut all: BTreeMap<u16, Bounds> = BTreeMap::new();
    let mut add = |label: u16, at: [u32; 3], last: [u32; 3]| {
        let bounds = all.entry(label).or_insert([at, last]);
        *bounds = std::array::from_fn(|end| {
            let here = [at, last][end];
            std::array::from_fn(|a| if end == 0 { bounds[0][a].min(here[a]) } else { bounds[1][a].max(here[a]) })
        });
    };
    for index in field.present() {
        let size = field.valid(0, index);
        let origin = index.origin();
        let brick = field.brick(BrickKey { level: 0, index })?;
        let last: [u32; 3] = std::array::from_fn(|a| origin[a] + size[a] - 1);
        if let Brick::Uniform(texel) = &brick {
            add(u16::from_le_bytes([texel[0], texel[1]]), origin, last);
            continue;
        }
        let texels = field.read(0, origin.map(i64::from), size)?;
        for (i, texel) in texels.chunks_exact(2).enumerate() {
            let i = i as u32;
            let at = [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
            let at = std::array::from_fn(|a| origin[a] + at[a]);
            add(u16::from_le_bytes([texel[0], texel[1]]), at, at);
        }
    }
    all.remove(&0);
    Ok(all)
}

fn deepest(state: &State, id: VolumeId, label: u16, [lo, hi]: Bounds) -> Result<Option<DVec3>, DocumentError> {
    let subject = state.at(Some(id))?;
    let size: [u32; 3] = std::array::from_fn(|a| hi[a] - lo[a] + 1);
    let count: u64 = size.iter().map(|s| u64::from(*s)).product();
    let every = (count as f64 / MOST_VOXELS as f64).cbrt().ceil().max(1.0) as u32;
    let coarse: [usize; 3] = std::array::from_fn(|a| size[a].div_ceil(every) as usize);
    // Layer by layer, so that no more is held than a layer and the mask.
    let mut mask = vec![false; coarse.iter().product()];
    for k in 0..coarse[2] {
        let z = i64::from(lo[2] + k as u32 * every);
        let layer = subject.volume.labels.read(0, [i64::from(lo[0]), i64::from(lo[1]), z], [size[0], size[1], 1])?;
        for j in 0..coarse[1] {
            for i in 0..coarse[0] {
                let at = 2 * ((j as u32 * every) * size[0] + i as u32 * every) as usize;
                mask[(k * coarse[1] + j) * coarse[0] + i] = u16::from_le_bytes([layer[at], layer[at + 1]]) == label;
            }
        }
    }
    let spacing = subject.grid().spacing() * f64::from(every);
    let found = pole(&|i, j, k| mask[(k * coarse[1] + j) * coarse[0] + i], coarse, spacing);
    let index = |at: [usize; 3]| std::array::from_fn(|a| f64::from(lo[a]) + at[a] as f64 * f64::from(every));
    Ok(found.map(|(at, _)| DVec3::from_array(index(at))))
}
