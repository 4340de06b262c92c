//! The band at the faces of a sub-volume follows what it is cut out of: what is painted there goes on into it.
//!
//! On a face a sample has what its parent has, linear between voxels; half a voxel inside it has nothing of it, and in between as much as the
//! ramp of [`resample`](crate::volume::resample) leaves. So a change of the parent changes the band's samples by their share of it, and
//! nothing steps at the faces whatever is painted on either side. Labels go by the nearest voxel. Cost: that of the bricks of the band
//! that lie on changed bricks.

use crate::volume::brick::{BRICK, Brick, BrickIndex, BrickKey};
use crate::volume::computed::SubBox;
use crate::volume::field::{Field, FieldKind};
use crate::volume::source::SourceError;
use crate::volume::texel::{DensityMap, TexelFormat};

/// A brick of a sub-volume that lies in its band, and what of the parent's field it goes by, as it was.
#[derive(Debug)]
pub struct BandBrick {
    index: BrickIndex,
    lo: [u32; 3],
    size: [u32; 3],
    before: Vec<u8>,
}

/// How much of the parent a sample has, by its place in voxels of the parent.
fn outside(of: &SubBox, x: [f64; 3]) -> f64 {
    let off = |a: usize| (x[a] - f64::from(of.lo[a])).min(f64::from(of.hi[a]) - x[a]);
    (1.0 - 2.0 * off(0).min(off(1)).min(off(2))).clamp(0.0, 1.0)
}

fn place(of: &SubBox, sample: [u32; 3]) -> [f64; 3] {
    std::array::from_fn(|a| f64::from(of.lo[a]) + f64::from(sample[a]) / f64::from(of.scale[a]))
}

impl BandBrick {
    /// Those that go by bricks of the parent's field which are about to change.
    ///
    /// # Errors
    /// If the parent cannot be read.
    pub fn of(of: &SubBox, parent: &Field, changed: &[BrickIndex]) -> Result<Vec<Self>, SourceError> {
        let dims = of.dims();
        let mut all = Vec::new();
        let touches = |lo: [u32; 3], end: [u32; 3]| {
            changed.iter().any(|brick| {
                let origin = brick.origin();
                (0..3).all(|a| origin[a] < end[a] && lo[a] < origin[a] + BRICK)
            })
        };
        if !touches(of.lo, of.hi.map(|v| v + 1)) {
            return Ok(all);
        }
        let bricks = dims.map(|d| d.div_ceil(BRICK));
        for z in 0..bricks[2] {
            for y in 0..bricks[1] {
                for x in 0..bricks[0] {
                    let index = BrickIndex([x, y, z]);
                    let origin = index.origin();
                    let last: [u32; 3] = std::array::from_fn(|a| (origin[a] + BRICK).min(dims[a]) - 1);
                    // Half a voxel of the parent from a face.
                    let in_band =
                        (0..3).any(|a| 2 * origin[a] < of.scale[a] || 2 * (dims[a] - 1 - last[a]) < of.scale[a]);
                    let (from, to) = (place(of, origin), place(of, last));
                    let lo: [u32; 3] = from.map(|v| v.floor() as u32);
                    let end: [u32; 3] = to.map(|v| v.ceil() as u32 + 1);
                    if in_band && touches(lo, end) {
                        let size = std::array::from_fn(|a| end[a] - lo[a]);
                        let before = parent.read(0, lo.map(i64::from), size)?;
                        all.push(Self { index, lo, size, before });
                    }
                }
            }
        }
        Ok(all)
    }

    /// Whether the parent's density holds values there by now for which a map has no codes.
    ///
    /// # Errors
    /// If the parent cannot be read.
    pub fn is_beyond(&self, map: &DensityMap, parent: &Field) -> Result<bool, SourceError> {
        if map.format == TexelFormat::R32Float || parent.format() != TexelFormat::R32Float {
            return Ok(false);
        }
        let now = parent.read(0, self.lo.map(i64::from), self.size)?;
        let values = now.as_chunks::<4>().0.iter().map(|texel| parent.map().decode(*texel));
        let (lo, hi) = (map.lo - map.half_step(), map.hi() + map.half_step());
        Ok(values.into_iter().any(|value| value < lo || value > hi))
    }

    /// The brick as it follows what changed of the parent since; `None` if nothing of it does.
    ///
    /// # Errors
    /// If the parent cannot be read.
    pub fn followed(
        &self,
        of: &SubBox,
        own: &Field,
        parent: &Field,
    ) -> Result<Option<(BrickIndex, Brick)>, SourceError> {
        let now = parent.read(0, self.lo.map(i64::from), self.size)?;
        if now == self.before {
            return Ok(None);
        }
        let (bytes, kind) = (own.format().bytes(), own.kind());
        let from_bytes = parent.format().bytes();
        let (origin, valid) = (self.index.origin(), own.valid(0, self.index));
        let texel = |from: &[u8], at: [u32; 3]| -> [u8; 4] {
            let i = (at[0] + self.size[0] * (at[1] + self.size[1] * at[2])) as usize * from_bytes;
            std::array::from_fn(|c| if c < from_bytes { from[i + c] } else { 0 })
        };
        let numbers = |texel: [u8; 4]| match kind {
            FieldKind::Density => [parent.map().decode(texel), 0.0, 0.0, 0.0],
            _ => texel.map(f64::from),
        };
        let mut some = false;
        let brick = own.brick(BrickKey { level: 0, index: self.index })?.edited(bytes, |out| {
            for z in 0..valid[2] {
                for y in 0..valid[1] {
                    for x in 0..valid[0] {
                        let p = place(of, [origin[0] + x, origin[1] + y, origin[2] + z]);
                        let share = outside(of, p);
                        if share == 0.0 {
                            continue;
                        }
                        let to = (x + BRICK * (y + BRICK * z)) as usize * bytes;
                        let at = |a: usize, up: bool| {
                            (p[a].floor() as u32 + u32::from(up) - self.lo[a]).min(self.size[a] - 1)
                        };
                        if kind == FieldKind::Labels {
                            let near = std::array::from_fn(|a| at(a, p[a] - p[a].floor() >= 0.5));
                            let (was, is) = (texel(&self.before, near), texel(&now, near));
                            if was != is {
                                some = true;
                                out[to..to + bytes].copy_from_slice(&is[..bytes]);
                            }
                            continue;
                        }
                        let mut added = [0.0; 4];
                        for corner in 0..8 {
                            let mut weight = share;
                            let tap = std::array::from_fn(|a| {
                                let (up, t) = (corner >> a & 1 == 1, p[a] - p[a].floor());
                                weight *= if up { t } else { 1.0 - t };
                                at(a, up)
                            });
                            let (was, is) = (texel(&self.before, tap), texel(&now, tap));
                            if weight > 0.0 && was != is {
                                let (was, is) = (numbers(was), numbers(is));
                                (0..4).for_each(|c| added[c] += weight * (is[c] - was[c]));
                            }
                        }
                        if added == [0.0; 4] {
                            continue;
                        }
                        some = true;
                        let old: [u8; 4] = std::array::from_fn(|c| if c < bytes { out[to + c] } else { 0 });
                        let new = match kind {
                            FieldKind::Density => own.map().encode(own.map().decode(old) + added[0]),
                            _ => {
                                std::array::from_fn(|c| (f64::from(old[c]) + added[c]).round().clamp(0.0, 255.0) as u8)
                            }
                        };
                        out[to..to + bytes].copy_from_slice(&new[..bytes]);
                    }
                }
            }
        });
        Ok(some.then_some((self.index, brick)))
    }
}
