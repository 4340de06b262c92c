//! Where segments are: which have voxels, and the voxel of each that lies deepest inside it.
//!
//! Found when a label first asks, again after labels changed. Owns what was found; nothing here is saved.

use crate::annotate::labels::pole;
use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;
use crate::document::state::State;
use crate::math::DVec3;
use crate::volume::{Brick, BrickIndex, BrickKey, Field, FieldKind, VolumeId};
use std::collections::{BTreeMap, BTreeSet};

/// Voxels of a box in which a pole is searched: of larger ones every second, or third, and so on.
const MOST_VOXELS: u64 = 1 << 24;

/// First and last index of a label's voxels.
type Bounds = [[u32; 3]; 2];

/// What of each label lies in a brick.
type InBrick = BTreeMap<u16, Bounds>;

/// The labels of a volume, by the brick, so that a stroke costs the bricks that it painted.
#[derive(Debug, Default)]
struct Labels {
    bricks: BTreeMap<BrickIndex, InBrick>,
    /// Bricks to look at again; `None`: all of them.
    stale: Option<BTreeSet<BrickIndex>>,
}

/// What was found of the segments of all volumes that were asked for.
#[derive(Debug, Default)]
pub(crate) struct Poles {
    labels: BTreeMap<VolumeId, Labels>,
    poles: BTreeMap<(VolumeId, u16), Option<DVec3>>,
}

impl Poles {
    /// Another document is open.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Labels have changed.
    pub(crate) fn mirror(&mut self, refreshed: &Refreshed) {
        for id in &refreshed.exchanged {
            self.labels.remove(id);
            self.poles.retain(|(of, _), _| of != id);
        }
        for (key, slots) in refreshed.slots.iter().filter(|(key, _)| key.kind == FieldKind::Labels) {
            if let Some(Labels { stale: Some(stale), .. }) = self.labels.get_mut(&key.volume) {
                stale.extend(slots.finest());
            }
        }
    }

    /// The labels that voxels of a volume have.
    ///
    /// # Errors
    /// If there is no such volume.
    pub(crate) fn present(&mut self, state: &State, id: VolumeId) -> Result<BTreeSet<u16>, DocumentError> {
        Ok(self.labels(state, id)?.bricks.values().flat_map(|brick| brick.keys().copied()).collect())
    }

    /// Labels as they are now: those of which a brick has changed have their poles found anew.
    fn labels(&mut self, state: &State, id: VolumeId) -> Result<&Labels, DocumentError> {
        let field = &state.at(Some(id))?.volume.labels;
        let known = self.labels.entry(id).or_default();
        let stale = known.stale.replace(BTreeSet::new());
        let stale = stale.unwrap_or_else(|| field.present().into_iter().collect());
        let mut changed = BTreeSet::new();
        for index in stale {
            // What was not looked at is looked at again.
            let now = in_brick(field, index).inspect_err(|_| known.stale = None)?;
            let before = known.bricks.insert(index, now).unwrap_or_default();
            let now = &known.bricks[&index];
            changed.extend(before.keys().chain(now.keys()).copied());
            if now.is_empty() {
                known.bricks.remove(&index);
            }
        }
        self.poles.retain(|(of, label), _| *of != id || !changed.contains(label));
        Ok(known)
    }

    /// The deepest place of a segment, continuous index; `None` if it has no voxel.
    ///
    /// # Errors
    /// If there is no such volume, or its labels cannot be read.
    pub(crate) fn pole(&mut self, state: &State, id: VolumeId, label: u16) -> Result<Option<DVec3>, DocumentError> {
        let of_label = self.labels(state, id)?.bricks.values().filter_map(|brick| brick.get(&label).copied());
        let bounds = of_label.reduce(both);
        if let Some(known) = self.poles.get(&(id, label)) {
            return Ok(*known);
        }
        let found = bounds.map_or(Ok(None), |bounds| deepest(state, id, label, bounds))?;
        self.poles.insert((id, label), found);
        Ok(found)
    }
}

fn both(a: Bounds, b: Bounds) -> Bounds {
    [std::array::from_fn(|i| a[0][i].min(b[0][i])), std::array::from_fn(|i| a[1][i].max(b[1][i]))]
}

fn in_brick(field: &Field, index: BrickIndex) -> Result<InBrick, DocumentError> {
    let mut all = InBrick::new();
    let mut add = |label: u16, bounds: Bounds| {
        if label != 0 {
            all.entry(label).and_modify(|known| *known = both(*known, bounds)).or_insert(bounds);
        }
    };
    let (size, origin) = (field.valid(0, index), index.origin());
    if let Brick::Uniform(texel) = field.brick(BrickKey { level: 0, index })? {
        let last = std::array::from_fn(|a| origin[a] + size[a] - 1);
        add(u16::from_le_bytes([texel[0], texel[1]]), [origin, last]);
        return Ok(all);
    }
    let texels = field.read(0, origin.map(i64::from), size)?;
    for (i, texel) in (0..).zip(texels.chunks_exact(2)) {
        let at = [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
        let at = std::array::from_fn(|a| origin[a] + at[a]);
        add(u16::from_le_bytes([texel[0], texel[1]]), [at; 2]);
    }
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
