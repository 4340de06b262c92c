//! What a box of a volume has for itself, carried to another box of it, to another resolution, or into another parent.
//!
//! That is what was edited in it, and whatever else it has that its parent as it is now would not give it, since that was painted after the
//! box was made. Where both boxes have the same samples, texels stay bit for bit. Elsewhere density carries what it has more than its
//! parent gives, linear between samples, and other fields the texel of the nearest sample. The cost is that of the bricks with edits,
//! and of those that lie on bricks of the parent which were painted since.

use crate::volume::brick::{BRICK, Brick, BrickIndex};
use crate::volume::computed::SubBox;
use crate::volume::field::{Field, FieldKind};
use crate::volume::source::SourceError;
use crate::volume::texel::{DensityMap, TexelFormat};
use crate::volume::volume::Volume;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A box that is to become another one.
#[derive(Clone, Debug)]
pub struct Carry<'a> {
    /// As it was.
    pub from: &'a Volume,
    /// What it was computed from.
    pub before: &'a Volume,
    /// Its parent as it is now, with as much of what is painted on that as the box needs.
    pub parent: Arc<Volume>,
    /// Where it is to lie, in voxels of that parent.
    pub to: SubBox,
}

impl Carry<'_> {
    /// Gives `new`, in which nothing is edited, what the box had for itself. Answers how many edited samples lie outside of it.
    ///
    /// # Errors
    /// If a parent cannot be read.
    pub fn into(self, new: &mut Volume) -> Result<u64, SourceError> {
        let Some(from_box) = self.from.sub_box() else { return Ok(0) };
        let given = Volume::refined(&self.parent, from_box);
        let map = map_of(self.from, new);
        let mut lost = 0;
        for kind in FieldKind::ALL {
            let old = self.from.field(kind);
            let mut given = given.field(kind).clone();
            if kind == FieldKind::Density {
                given = given.by_map(*old.map());
                if map != *new.density.map() {
                    new.density = new.density.edits_alone(|_| false).by_map(map);
                }
            }
            let edits: BTreeSet<BrickIndex> = old.edits().into_keys().collect();
            let own: BTreeSet<BrickIndex> = edits.iter().copied().chain(self.painted_since(kind, from_box)).collect();
            let fields = Fields { to: self.to, from: from_box, old, given: &given, new: new.field(kind) };
            lost += fields.outside(&edits)?;
            let changes = fields.bricks(&own).into_par_iter().map(|index| fields.brick(index));
            let changes = changes.collect::<Result<Vec<_>, SourceError>>()?;
            new.field_mut(kind).swap(changes.into_iter().flatten().map(|(i, brick)| (i, Some(brick))).collect())?;
        }
        new.painted = match (self.from.painted, new.painted) {
            (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
            (one, other) => one.or(other),
        };
        Ok(lost)
    }

    /// Bricks of the box that lie on what was painted of its parent since it was made.
    fn painted_since(&self, kind: FieldKind, of: SubBox) -> Vec<BrickIndex> {
        let (was, is) = (self.before.field(kind), self.parent.field(kind));
        let other_map = kind == FieldKind::Density && was.map() != is.map();
        let painted: BTreeSet<BrickIndex> = was.edits().into_keys().chain(is.edits().into_keys()).collect();
        let dims = of.dims();
        let mut all = Vec::new();
        for index in painted.into_iter().filter(|index| other_map || was.edit(*index) != is.edit(*index)) {
            // A sample is made of voxels up to one and a half away.
            let ends: [Option<[u32; 2]>; 3] = std::array::from_fn(|a| {
                let first = i64::from(index.origin()[a]) - 2;
                let place = |v: i64| (v - i64::from(of.lo[a])) * i64::from(of.scale[a]);
                let (from, to) = (place(first), place(first + i64::from(BRICK) + 4));
                let last = i64::from(dims[a]) - 1;
                (to >= 0 && from <= last).then(|| [from, to].map(|s| s.clamp(0, last) as u32 / BRICK))
            });
            let [Some(x), Some(y), Some(z)] = ends else { continue };
            all.extend(blocks([x, y, z]));
        }
        all
    }
}

/// The map for density that holds what the box has and what its new parent gives.
fn map_of(from: &Volume, new: &Volume) -> DensityMap {
    let (old, own) = (*from.density.map(), *new.density.map());
    let statistics = new.statistics;
    let [lo, hi] = new
        .painted
        .map_or([statistics.min, statistics.max], |[lo, hi]| [statistics.min.min(lo), statistics.max.max(hi)]);
    let holds = old.format == TexelFormat::R32Float || old.lo <= lo && hi <= old.hi();
    if old == own || holds { old } else { old.in_floats() }
}

/// One kind of field of a box that becomes another.
struct Fields<'a> {
    to: SubBox,
    from: SubBox,
    old: &'a Field,
    /// What its parent as it is now gives the old box, in the old texels.
    given: &'a Field,
    new: &'a Field,
}

/// Texels of a block of the old box: as they are, as they were computed, as they would be now.
struct Block {
    lo: [u32; 3],
    size: [u32; 3],
    bytes: usize,
    is: Vec<u8>,
    was: Vec<u8>,
    given: Vec<u8>,
}

impl Block {
    /// Of a sample of the old box: what it is and what it would be; `None` where it has nothing for itself.
    fn own(&self, sample: [u32; 3]) -> Option<([u8; 4], [u8; 4])> {
        let at: [u32; 3] = std::array::from_fn(|a| sample[a] - self.lo[a]);
        let i = (at[0] + self.size[0] * (at[1] + self.size[1] * at[2])) as usize * self.bytes;
        let range = i..i + self.bytes;
        let (is, was, given) = (&self.is[range.clone()], &self.was[range.clone()], &self.given[range]);
        (is != was || is != given).then(|| (padded(is), padded(given)))
    }
}

impl Fields<'_> {
    /// Where a sample of the new box lies among those of the old one.
    fn old_place(&self, axis: usize, sample: u32) -> f64 {
        let place = f64::from(self.to.lo[axis]) + f64::from(sample) / f64::from(self.to.scale[axis]);
        (place - f64::from(self.from.lo[axis])) * f64::from(self.from.scale[axis])
    }

    /// Edited samples that lie outside of the new box. What only followed the parent at the faces is nobody's.
    fn outside(&self, edits: &BTreeSet<BrickIndex>) -> Result<u64, SourceError> {
        let (of, to) = (&self.from, &self.to);
        let inside = |axis: usize, sample: u32| {
            let place = of.lo[axis] * of.scale[axis] + sample;
            (to.lo[axis] * of.scale[axis]..=to.hi[axis] * of.scale[axis]).contains(&place)
        };
        let dims = of.dims();
        let bytes = self.old.format().bytes();
        let counts = edits.par_iter().map(|&index| {
            let block = self.block(index.origin(), self.old.valid(0, index))?;
            let mut count = 0;
            each(block.size, |at| {
                let sample: [u32; 3] = std::array::from_fn(|a| block.lo[a] + at[a]);
                if (0..3).all(|a| inside(a, sample[a])) {
                    return;
                }
                let i = (at[0] + block.size[0] * (at[1] + block.size[1] * at[2])) as usize * bytes;
                let [is, was, given] = [&block.is, &block.was, &block.given].map(|t| &t[i..i + bytes]);
                let in_band = (0..3).any(|a| 2 * sample[a].min(dims[a] - 1 - sample[a]) < of.scale[a]);
                let follows = is == given || in_band && self.nearly(padded(is), padded(given));
                count += u64::from(is != was && !follows);
            });
            Ok(count)
        });
        counts.sum()
    }

    /// Whether two texels are the same but for rounding.
    fn nearly(&self, a: [u8; 4], b: [u8; 4]) -> bool {
        match self.old.kind() {
            FieldKind::Density => {
                let map = self.old.map();
                let (a, b) = (map.decode(a), map.decode(b));
                (a - b).abs() <= 2.0 * map.error_at(a.abs().max(b.abs()), false) + f64::MIN_POSITIVE
            }
            FieldKind::Labels => a == b,
            _ => a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 1),
        }
    }

    /// Bricks of the new box in which something of these of the old one may lie.
    fn bricks(&self, own: &BTreeSet<BrickIndex>) -> Vec<BrickIndex> {
        let mut all = BTreeSet::new();
        for index in own {
            let (origin, valid) = (index.origin(), self.old.valid(0, *index));
            let ends: [Option<[u32; 2]>; 3] = std::array::from_fn(|a| {
                let place = |sample: f64| {
                    let parent = f64::from(self.from.lo[a]) + sample / f64::from(self.from.scale[a]);
                    (parent - f64::from(self.to.lo[a])) * f64::from(self.to.scale[a])
                };
                let last = f64::from(self.new.dims(0)[a] - 1);
                let (from, to) = (place(f64::from(origin[a]) - 1.0), place(f64::from(origin[a] + valid[a])));
                (to >= 0.0 && from <= last).then(|| [from, to].map(|s| s.clamp(0.0, last) as u32 / BRICK))
            });
            let [Some(x), Some(y), Some(z)] = ends else { continue };
            all.extend(blocks([x, y, z]));
        }
        all.into_iter().collect()
    }

    fn block(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Block, SourceError> {
        let from = lo.map(i64::from);
        Ok(Block {
            lo,
            size,
            bytes: self.old.format().bytes(),
            is: self.old.read(0, from, size)?,
            was: self.old.read_unedited(lo, size)?,
            given: self.given.read(0, from, size)?,
        })
    }

    /// A brick of the new box with what the old one had for itself; `None` if none of that lies in it.
    fn brick(&self, index: BrickIndex) -> Result<Option<(BrickIndex, Brick)>, SourceError> {
        let (origin, valid) = (index.origin(), self.new.valid(0, index));
        let dims = self.old.dims(0);
        let [mut lo, mut end] = [[0; 3]; 2];
        for a in 0..3 {
            let (first, last) = (self.old_place(a, origin[a]), self.old_place(a, origin[a] + valid[a] - 1));
            let most = f64::from(dims[a] - 1);
            if last < -0.5 || first > most + 0.5 {
                return Ok(None);
            }
            (lo[a], end[a]) = (first.floor().clamp(0.0, most) as u32, last.ceil().clamp(0.0, most) as u32);
        }
        let block = self.block(lo, std::array::from_fn(|a| end[a] - lo[a] + 1))?;
        if block.is == block.was && block.is == block.given {
            return Ok(None);
        }
        let (old_map, map, bytes) = (*self.old.map(), *self.new.map(), self.new.format().bytes());
        let is_density = self.old.kind() == FieldKind::Density;
        let same_samples = self.from.scale == self.to.scale;
        let as_it_is = |texel: [u8; 4]| match is_density && old_map != map {
            true => map.encode(old_map.decode(texel)),
            false => texel,
        };
        let mut some = false;
        let base = self.new.base_brick(index)?;
        let brick = base.edited(bytes, |out| {
            each(valid, |at| {
                let p: [f64; 3] = std::array::from_fn(|a| self.old_place(a, origin[a] + at[a]));
                let to = (at[0] + BRICK * (at[1] + BRICK * at[2])) as usize * bytes;
                let near = nearest(p, dims);
                let new = match is_density && !same_samples {
                    false => near.and_then(|near| Some(as_it_is(block.own(near)?.0))),
                    true => {
                        let given = map.decode(padded(&out[to..to + bytes]));
                        let value = |near| Some(old_map.decode(block.own(near)?.0));
                        let sum = given + added(&block, p, dims, &old_map);
                        match sum.is_finite() {
                            true => (sum != given).then_some(sum),
                            // There is no difference from what is no number.
                            false => near.and_then(value),
                        }
                        .map(|value| map.encode(value))
                    }
                };
                if let Some(new) = new {
                    some = true;
                    out[to..to + bytes].copy_from_slice(&new[..bytes]);
                }
            });
        });
        Ok((some && brick != base).then_some((index, brick)))
    }
}

/// The sample of the old box next to a place among them; `None` outside.
fn nearest(p: [f64; 3], dims: [u32; 3]) -> Option<[u32; 3]> {
    let inside = (0..3).all(|a| p[a] >= -0.5 && p[a] < f64::from(dims[a]) - 0.5);
    inside.then(|| std::array::from_fn(|a| (p[a] + 0.5).floor() as u32))
}

/// What the old box has more than its parent gives, linear between samples; nothing outside.
fn added(block: &Block, p: [f64; 3], dims: [u32; 3], map: &DensityMap) -> f64 {
    if (0..3).any(|a| p[a] < 0.0 || p[a] > f64::from(dims[a] - 1)) {
        return 0.0;
    }
    let mut added = 0.0;
    for corner in 0..8 {
        let mut weight = 1.0;
        let tap: [u32; 3] = std::array::from_fn(|a| {
            let (below, share) = (p[a].floor(), p[a] - p[a].floor());
            let up = corner >> a & 1 == 1;
            weight *= if up { share } else { 1.0 - share };
            (below as u32 + u32::from(up)).min(dims[a] - 1)
        });
        if weight > 0.0
            && let Some((is, given)) = block.own(tap)
        {
            added += weight * (map.decode(is) - map.decode(given));
        }
    }
    added
}

fn padded(texel: &[u8]) -> [u8; 4] {
    std::array::from_fn(|i| texel.get(i).copied().unwrap_or(0))
}

/// Bricks from the first to the last along each axis.
fn blocks([x, y, z]: [[u32; 2]; 3]) -> impl Iterator<Item = BrickIndex> {
    (z[0]..=z[1]).flat_map(move |k| (y[0]..=y[1]).flat_map(move |j| (x[0]..=x[1]).map(move |i| BrickIndex([i, j, k]))))
}

fn each(size: [u32; 3], mut visit: impl FnMut([u32; 3])) {
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                visit([x, y, z]);
            }
        }
    }
}
