//! What was edited in a box of a volume, carried to another box of it or another resolution.
//!
//! An edit of density is what it added to the unedited samples, linear between them; other fields keep the texel of the nearest sample.
//! Where both have the same samples nothing is lost. The cost is that of the bricks with edits.

use crate::volume::brick::{BRICK, BrickIndex};
use crate::volume::computed::SubBox;
use crate::volume::field::{Field, FieldKind};
use crate::volume::source::SourceError;
use crate::volume::volume::Volume;
use rayon::prelude::*;
use std::collections::BTreeSet;

impl Volume {
    /// Takes over what was edited in another box of the same parent. Answers how many edited samples lie outside of this one.
    ///
    /// # Errors
    /// If the parent cannot be read.
    pub fn take_edits(&mut self, from: &Self) -> Result<u64, SourceError> {
        let (Some(to_box), Some(from_box)) = (self.sub_box(), from.sub_box()) else { return Ok(0) };
        let carry = Carry { to: to_box, from: from_box };
        let mut lost = 0;
        for kind in FieldKind::ALL {
            let old = from.field(kind);
            if old.edits().is_empty() {
                continue;
            }
            if kind == FieldKind::Density && old.map() != self.density.map() {
                self.density = self.density.unedited(*old.map(), &|_| true)?.unwrap_or_else(|| self.density.clone());
            }
            lost += carry.outside(old)?;
            let new = self.field(kind);
            let changes = carry.bricks(old, new).into_par_iter().map(|index| carry.brick(old, new, index));
            let changes = changes.collect::<Result<Vec<_>, SourceError>>()?;
            self.field_mut(kind).swap(changes.into_iter().flatten().map(|(i, brick)| (i, Some(brick))).collect())?;
        }
        self.painted = from.painted;
        Ok(lost)
    }
}

struct Carry {
    to: SubBox,
    from: SubBox,
}

impl Carry {
    /// Where a sample of the new box lies among those of the old one.
    fn old_place(&self, axis: usize, sample: u32) -> f64 {
        let place = f64::from(self.to.lo[axis]) + f64::from(sample) / f64::from(self.to.scale[axis]);
        (place - f64::from(self.from.lo[axis])) * f64::from(self.from.scale[axis])
    }

    /// Edited samples that lie outside of the new box.
    fn outside(&self, old: &Field) -> Result<u64, SourceError> {
        let inside = |axis: usize, sample: u32| {
            let (scale, to) = (self.from.scale[axis], &self.to);
            let place = self.from.lo[axis] * scale + sample;
            (to.lo[axis] * scale..=to.hi[axis] * scale).contains(&place)
        };
        let edits: Vec<BrickIndex> = old.edits().into_keys().collect();
        let counts = edits.into_par_iter().map(|index| {
            let (now, was) = (old.brick_at(index)?, old.base_brick(index)?);
            let (origin, bytes) = (index.origin(), old.format().bytes());
            let mut count = 0;
            each(old.valid(0, index), |at| {
                let out = (0..3).any(|a| !inside(a, origin[a] + at[a]));
                count += u64::from(out && now.texel(at, bytes) != was.texel(at, bytes));
            });
            Ok(count)
        });
        counts.sum()
    }

    /// Bricks of the new box in which an edit of the old one may lie.
    fn bricks(&self, old: &Field, new: &Field) -> Vec<BrickIndex> {
        let mut all = BTreeSet::new();
        for index in old.edits().into_keys() {
            let (origin, valid) = (index.origin(), old.valid(0, index));
            let range = |a: usize| {
                let place = |sample: f64| {
                    let parent = f64::from(self.from.lo[a]) + sample / f64::from(self.from.scale[a]);
                    (parent - f64::from(self.to.lo[a])) * f64::from(self.to.scale[a])
                };
                let last = f64::from(new.dims(0)[a] - 1);
                let (from, to) = (place(f64::from(origin[a]) - 1.0), place(f64::from(origin[a] + valid[a])));
                if to < 0.0 || from > last {
                    return None;
                }
                Some((from.clamp(0.0, last) as u32 / BRICK, to.clamp(0.0, last) as u32 / BRICK))
            };
            let (Some(x), Some(y), Some(z)) = (range(0), range(1), range(2)) else { continue };
            for k in z.0..=z.1 {
                for j in y.0..=y.1 {
                    all.extend((x.0..=x.1).map(|i| BrickIndex([i, j, k])));
                }
            }
        }
        all.into_iter().collect()
    }

    /// A brick of the new box with the edits of the old one; `None` if none lies in it.
    fn brick(
        &self,
        old: &Field,
        new: &Field,
        index: BrickIndex,
    ) -> Result<Option<(BrickIndex, crate::volume::Brick)>, SourceError> {
        let (origin, valid, bytes) = (index.origin(), new.valid(0, index), new.format().bytes());
        let ends: [[i64; 2]; 3] = std::array::from_fn(|a| {
            let (first, last) = (self.old_place(a, origin[a]), self.old_place(a, origin[a] + valid[a] - 1));
            [first.floor() as i64, last.ceil() as i64]
        });
        let dims = old.dims(0);
        let clamped = |a: usize, i: i64| i.clamp(0, i64::from(dims[a]) - 1);
        let lo: [u32; 3] = std::array::from_fn(|a| clamped(a, ends[a][0]) as u32);
        let size: [u32; 3] = std::array::from_fn(|a| (clamped(a, ends[a][1]) as u32) - lo[a] + 1);
        let (now, was) = (old.read(0, lo.map(i64::from), size)?, old.read_unedited(lo, size)?);
        if now == was {
            return Ok(None);
        }
        let place = |at: [u32; 3]| (at[0] + size[0] * (at[1] + size[1] * at[2])) as usize * bytes;
        let texel = |from: &[u8], at: [u32; 3]| {
            let i = place(at);
            let mut texel = [0; 4];
            texel[..bytes].copy_from_slice(&from[i..i + bytes]);
            texel
        };
        let map = *new.map();
        let base = new.base_brick(index)?;
        let mut some = false;
        let brick = base.edited(bytes, |out| {
            each(valid, |at| {
                let p: [f64; 3] = std::array::from_fn(|a| self.old_place(a, origin[a] + at[a]));
                let inside = (0..3).all(|a| p[a] > -1.0 && p[a] < f64::from(dims[a]));
                if !inside {
                    return;
                }
                let to = (at[0] + BRICK * (at[1] + BRICK * at[2])) as usize * bytes;
                if old.kind() != FieldKind::Density {
                    let near: [u32; 3] =
                        std::array::from_fn(|a| clamped(a, (p[a] + 0.5).floor() as i64) as u32 - lo[a]);
                    let (a, b) = (texel(&now, near), texel(&was, near));
                    if a != b {
                        some = true;
                        out[to..to + bytes].copy_from_slice(&a[..bytes]);
                    }
                    return;
                }
                let mut added = 0.0;
                let mut touched = false;
                for corner in 0..8 {
                    let mut weight = 1.0;
                    let tap: [u32; 3] = std::array::from_fn(|a| {
                        let (below, share) = (p[a].floor(), p[a] - p[a].floor());
                        let up = corner >> a & 1 == 1;
                        weight *= if up { share } else { 1.0 - share };
                        clamped(a, below as i64 + i64::from(up)) as u32 - lo[a]
                    });
                    if weight == 0.0 {
                        continue;
                    }
                    let (a, b) = (texel(&now, tap), texel(&was, tap));
                    if a != b {
                        touched = true;
                        added += weight * (map.decode(a) - map.decode(b));
                    }
                }
                if touched {
                    some = true;
                    let own = std::array::from_fn(|i| if i < bytes { out[to + i] } else { 0 });
                    let value = map.encode(map.decode(own) + added);
                    out[to..to + bytes].copy_from_slice(&value[..bytes]);
                }
            });
        });
        Ok(some.then_some((index, brick)))
    }
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
