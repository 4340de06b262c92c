//! Where the voxels of one volume fall in another: what an import covers, and what it leaves out.
//!
//! A voxel lies in another volume if its centre is in that one's box, faces half a voxel outside the outermost centres. Knows
//! grids and counts, no file and no field.

use crate::document::error::DocumentError;
use crate::math::{Aabb, DAffine3, DVec3};
use crate::volume::{BrickSource, Grid, Voxels};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What rounding of affines may move a voxel's centre, in voxels.
pub(crate) const ROUNDING: f64 = 1e-6;

/// Voxels read at once.
pub(crate) const AT_ONCE: u64 = 1 << 21;

/// All of a volume once, in whole rows, on all cores: `add` gets a box's voxels, its first voxel and its size.
///
/// # Errors
/// If the source fails, `add` or `join` does, or `progress` said no.
pub(crate) fn scan<A: Default + Send>(
    source: &dyn BrickSource,
    add: impl Fn(&mut A, &Voxels, [u32; 3], [u32; 3]) -> Result<(), DocumentError> + Sync,
    join: impl Fn(A, A) -> Result<A, DocumentError> + Sync + Send,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<A, DocumentError> {
    let [nx, ny, nz] = source.grid().dims;
    let thick = (AT_ONCE / (u64::from(nx) * u64::from(ny))).clamp(1, u64::from(nz)) as u32;
    // A plane may be too large to be read whole.
    let tall = (AT_ONCE / u64::from(nx)).clamp(1, u64::from(ny)) as u32;
    let slabs: Vec<u32> = (0..nz).step_by(thick as usize).collect();
    let begun = AtomicUsize::new(0);
    slabs
        .par_iter()
        .map(|&z| {
            if !progress(begun.fetch_add(1, Ordering::Relaxed) as f32 / slabs.len() as f32) {
                return Err(DocumentError::Stopped);
            }
            let mut all = A::default();
            for y in (0..ny).step_by(tall as usize) {
                let (lo, size) = ([0, y, z], [nx, tall.min(ny - y), thick.min(nz - z)]);
                add(&mut all, &source.read(lo, size)?, lo, size)?;
            }
            Ok(all)
        })
        .try_reduce(A::default, join)
}

/// Rows of one grid, cut to the box of another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    other_from_index: DAffine3,
    length: u32,
    dims: DVec3,
}

impl Rows {
    /// The rows of `ours` in `other`.
    pub(crate) fn new(ours: &Grid, other: &Grid) -> Self {
        let other_from_index = other.index_from_world() * ours.world_from_index;
        Self { other_from_index, length: ours.dims[0], dims: other.dims_f64() }
    }

    /// The voxels of the row at (j, k) that lie in the other grid.
    pub(crate) fn inside(&self, j: u32, k: u32) -> Range<u32> {
        let start = self.other_from_index.transform_point3(DVec3::new(0.0, f64::from(j), f64::from(k)));
        let step = self.other_from_index.matrix3.x_axis;
        let (mut from, mut to) = (0.0, f64::from(self.length) - 1.0);
        for a in 0..3 {
            let (lo, hi) = (-0.5 - ROUNDING, self.dims[a] - 0.5 + ROUNDING);
            // Along this axis the row stands still: rounding of the affine must not turn it into a slope.
            if step[a].abs() * f64::from(self.length) < ROUNDING {
                if !(lo..=hi).contains(&start[a]) {
                    return 0..0;
                }
                continue;
            }
            let (t, u) = ((lo - start[a]) / step[a], (hi - start[a]) / step[a]);
            from = t.min(u).max(from);
            to = t.max(u).min(to);
        }
        if from > to {
            return 0..0;
        }
        from.ceil() as u32..to.floor() as u32 + 1
    }
}

/// The share of a grid's voxels that lie in another grid, 0 to 1.
pub(crate) fn covered(ours: &Grid, other: &Grid) -> f64 {
    let rows = Rows::new(ours, other);
    let [nx, ny, nz] = ours.dims;
    let rows = (0..nz).flat_map(|k| (0..ny).map(move |j| rows.inside(j, k).len() as u64));
    rows.sum::<u64>() as f64 / (f64::from(nx) * f64::from(ny) * f64::from(nz))
}

/// Some voxels of a volume that is brought in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Spread {
    /// How many.
    pub voxels: u64,
    /// How many of them lie in our volume.
    pub inside: u64,
    /// The box around them, first and last voxel; of no meaning for none.
    pub first: [u32; 3],
    /// See `first`.
    pub last: [u32; 3],
}

impl Spread {
    /// One more.
    pub(crate) fn add(&mut self, voxel: [u32; 3], inside: bool) {
        self.join(Self { voxels: 1, inside: inside.into(), first: voxel, last: voxel });
    }

    /// Those of both.
    pub(crate) fn join(&mut self, other: Self) {
        if self.voxels == 0 || other.voxels == 0 {
            *self = if self.voxels == 0 { other } else { *self };
            return;
        }
        self.voxels += other.voxels;
        self.inside += other.inside;
        for a in 0..3 {
            self.first[a] = self.first[a].min(other.first[a]);
            self.last[a] = self.last[a].max(other.last[a]);
        }
    }

    /// The box around them in world mm.
    fn world_bounds(&self, grid: &Grid) -> Aabb {
        let corner = |v: [u32; 3], d: f64| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])) + d;
        let bounds = Aabb { min: corner(self.first, -0.5), max: corner(self.last, 0.5) };
        let corners = bounds.corners().map(|c| grid.world_from_index.transform_point3(c));
        Aabb::around(corners).unwrap_or(bounds)
    }

    /// What is left out of an import of `what`, as warnings; answers the share of our volume that the file covers.
    ///
    /// # Errors
    /// If there is something and none of it lies in our volume.
    pub(crate) fn check(
        &self,
        file: &str,
        what: &str,
        ours: &Grid,
        other: &Grid,
        warnings: &mut Vec<String>,
    ) -> Result<f64, DocumentError> {
        let covered = covered(ours, other);
        if self.inside == 0 && (self.voxels > 0 || covered == 0.0) {
            let (lies, of) = match self.voxels {
                0 => (other.world_bounds(), "a volume".to_owned()),
                n => (self.world_bounds(other), format!("{n} voxels of {what}")),
            };
            return Err(DocumentError::Elsewhere {
                file: file.into(),
                found: format!("{of} at {}", millimetres(&lies)),
                expected: millimetres(&ours.world_bounds()),
            });
        }
        if self.voxels == 0 {
            warnings.push(format!("{file} holds no {what}"));
        }
        let left_out = self.voxels - self.inside;
        if left_out > 0 {
            warnings.push(format!(
                "{} of the file's voxels of {what} lie outside the volume and are left out: they lie at {}, the volume at {}",
                percent(left_out as f64 / self.voxels as f64),
                millimetres(&self.world_bounds(other)),
                millimetres(&ours.world_bounds()),
            ));
        }
        if covered < 1.0 {
            warnings.push(format!(
                "the file covers {} of the volume: it lies at {}, the volume at {}",
                percent(covered),
                millimetres(&other.world_bounds()),
                millimetres(&ours.world_bounds()),
            ));
        }
        Ok(covered)
    }
}

/// A box as a person reads it.
fn millimetres(bounds: &Aabb) -> String {
    let side = |a: usize, name: &str| format!("{name} {} to {}", short(bounds.min[a]), short(bounds.max[a]));
    format!("{}, {}, {} mm", side(0, "x"), side(1, "y"), side(2, "z"))
}

/// A tenth of a millimetre is enough for what is centimetres away; small grids keep four digits.
fn short(mm: f64) -> String {
    let digits = if mm.abs() >= 10.0 || mm == 0.0 { 1.0 } else { (3.0 - mm.abs().log10().floor()).min(9.0) };
    format!("{:.*}", digits as usize, mm + 0.0)
}

/// Never 0 or 100 for what is neither.
fn percent(share: f64) -> String {
    match share * 100.0 {
        p if p < 0.1 => "less than 0.1 %".into(),
        p if p > 99.9 && p < 100.0 => "more than 99.9 %".into(),
        p => format!("{p:.1} %"),
    }
}
