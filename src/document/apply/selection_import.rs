//! A selection from another volume: above a threshold, resampled by world position, with a soft border.
//!
//! The border is a ramp: s = ½ + d/soften, clamped to 0..1, where d is the signed distance in mm to the border, positive
//! inside: the exact Euclidean distance to the nearest voxel centre of the other side less half the smallest spacing. Distances
//! are measured along the voxel axes at their spacings, so a sheared grid counts as a straight one. Works block by block, each
//! with as much around it as the ramp reaches, so that memory does not grow with the volume.

use crate::document::apply::overlap::{Rows, Spread, scan};
use crate::document::error::DocumentError;
use crate::document::subject::Subject;
use crate::math::{DAffine3, DVec3};
use crate::volume::{
    BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickSource, Changes, Grid, SourceError, Voxels, squared_distances,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bricks along an edge of a block: larger blocks read less of their surroundings twice.
const BLOCK: u32 = 2;

/// What an import leads to; nothing is changed yet.
#[derive(Debug)]
pub(crate) struct Imported {
    /// All bricks of the new selection.
    pub changes: Changes,
    /// Voxels selected at all.
    pub voxels: u64,
    /// Share of the volume that the file covers.
    pub covered: f64,
    /// What was left out.
    pub warnings: Vec<String>,
}

/// The bricks of a selection of all voxels whose value in `other` is above `threshold`. Where `other` ends, nothing is selected.
///
/// # Errors
/// If `other` fails, if what it selects lies elsewhere, or `progress` said no.
pub(crate) fn import(
    subject: &Subject<'_>,
    other: &dyn BrickSource,
    threshold: f64,
    soften_mm: f64,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Imported, DocumentError> {
    let grid = *subject.grid();
    let mut spread = above(subject, other, threshold, &|x| progress(x * 0.3))?;
    let bricks = subject.selection.brick_dims(0);
    let blocks = bricks.map(|b| b.div_ceil(BLOCK));
    let other_from_index = other.grid().index_from_world() * grid.world_from_index;
    let ramp = Ramp::new(&grid, soften_mm);
    let all: Vec<[u32; 3]> = (0..blocks.iter().product::<u32>())
        .map(|i| [i % blocks[0], i / blocks[0] % blocks[1], i / blocks[0] / blocks[1]])
        .collect();
    let (count, begun) = (all.len() as f32, AtomicUsize::new(0));
    let done = all
        .into_par_iter()
        .map(|block| {
            if !progress(0.3 + 0.7 * begun.fetch_add(1, Ordering::Relaxed) as f32 / count) {
                return Err(DocumentError::Stopped);
            }
            let first = block.map(|b| b * BLOCK * BRICK);
            let size: [u32; 3] = std::array::from_fn(|a| (BLOCK * BRICK).min(grid.dims[a] - first[a]));
            let lo: [i64; 3] = std::array::from_fn(|a| i64::from(first[a]) - i64::from(ramp.reach[a]));
            let around: [usize; 3] = std::array::from_fn(|a| (size[a] + 2 * ramp.reach[a]) as usize);
            let Some(mask) = mask(other, &other_from_index, &grid, lo, around, threshold)? else {
                return Ok(Vec::new());
            };
            let selected = ramp.soften(&mask, around);
            Ok(cut(&selected, around, ramp.reach, first, size))
        })
        .collect::<Result<Vec<_>, DocumentError>>()?;
    let changes: Changes = done.into_iter().flatten().collect();
    let mut warnings = Vec::new();
    if changes.is_empty() && spread.inside > 0 {
        warnings
            .push(format!("nothing is selected: what {} has above {threshold} is finer than a voxel", other.name()));
    }
    // Between voxels the value falls off gently: a voxel beside the volume may select one in it.
    spread.inside = spread.inside.max(u64::from(!changes.is_empty()));
    let what = format!("values above {threshold}");
    let covered = spread.check(other.name(), &what, &grid, other.grid(), &mut warnings)?;
    let selected = |brick: &Option<Brick>| {
        let texels = brick.as_ref().map(|b| b.to_texels(1)).unwrap_or_default();
        texels.iter().filter(|&&t| t > 0).count() as u64
    };
    let voxels = changes.iter().map(|(_, brick)| selected(brick)).sum();
    Ok(Imported { changes, voxels, covered, warnings })
}

/// The voxels of a file above a threshold.
fn above(
    subject: &Subject<'_>,
    other: &dyn BrickSource,
    threshold: f64,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Spread, DocumentError> {
    let rows = Rows::new(other.grid(), subject.grid());
    let (slope, intercept) = other.scaling();
    let add = |spread: &mut Spread, voxels: &Voxels, lo: [u32; 3], size: [u32; 3]| {
        let width = size[0] as usize;
        for n in 0..voxels.len() / width {
            let (j, k) = (lo[1] + n as u32 % size[1], lo[2] + n as u32 / size[1]);
            let inside = rows.inside(j, k);
            for i in 0..size[0] {
                if voxels.get(n * width + i as usize) * slope + intercept > threshold {
                    spread.add([i, j, k], inside.contains(&i));
                }
            }
        }
        Ok(())
    };
    let join = |mut a: Spread, b: Spread| {
        a.join(b);
        Ok(a)
    };
    scan(other, add, join, progress)
}

/// Which side of the threshold a voxel is on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Inside,
    Outside,
    /// Not a voxel of our grid: no distance is measured to it.
    Beyond,
}

/// The sides of the voxels of a box; `None` if none is inside.
fn mask(
    other: &dyn BrickSource,
    other_from_index: &DAffine3,
    grid: &Grid,
    lo: [i64; 3],
    size: [usize; 3],
    threshold: f64,
) -> Result<Option<Vec<Side>>, SourceError> {
    let dims = other.grid().dims;
    let low = DVec3::new(lo[0] as f64, lo[1] as f64, lo[2] as f64);
    let high = low + DVec3::new(size[0] as f64, size[1] as f64, size[2] as f64) - 1.0;
    let corners = crate::math::Aabb { min: low, max: high }.corners().map(|c| other_from_index.transform_point3(c));
    let min = corners.into_iter().fold(corners[0], DVec3::min);
    let max = corners.into_iter().fold(corners[0], DVec3::max);
    let mut from = [0_u32; 3];
    let mut count = [0_u32; 3];
    for a in 0..3 {
        let last = f64::from(dims[a] - 1);
        if max[a] < -0.5 || min[a] > last + 0.5 {
            return Ok(None);
        }
        from[a] = min[a].floor().clamp(0.0, last) as u32;
        count[a] = (max[a].ceil().clamp(0.0, last) as u32).max(from[a]) - from[a] + 1;
    }
    let voxels = other.read(from, count)?;
    let (slope, intercept) = other.scaling();
    let value = |p: DVec3| interpolate(&voxels, p, from, count, dims) * slope + intercept;
    let mut any = false;
    let mut mask = Vec::with_capacity(size.iter().product());
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let at = [lo[0] + x as i64, lo[1] + y as i64, lo[2] + z as i64];
                let ours = (0..3).all(|a| (0..i64::from(grid.dims[a])).contains(&at[a]));
                let p = other_from_index.transform_point3(DVec3::new(at[0] as f64, at[1] as f64, at[2] as f64));
                // NaN is above nothing.
                let side = match ours {
                    true if value(p) > threshold => Side::Inside,
                    true => Side::Outside,
                    false => Side::Beyond,
                };
                any |= side == Side::Inside;
                mask.push(side);
            }
        }
    }
    Ok(any.then_some(mask))
}

/// Stored values between voxel centres, trilinear, NaN outside the volume's box. A point on a centre (to a thousandth of a voxel,
/// for grids that are the same but for rounding) is that voxel.
fn interpolate(voxels: &Voxels, p: DVec3, from: [u32; 3], count: [u32; 3], dims: [u32; 3]) -> f64 {
    let snapped = p.round();
    let p = DVec3::select((p - snapped).abs().cmplt(DVec3::splat(1e-3)), snapped, p);
    let mut base = [0_i64; 3];
    let mut part = [0.0; 3];
    for a in 0..3 {
        if p[a] < -0.5 || p[a] > f64::from(dims[a]) - 0.5 {
            return f64::NAN;
        }
        base[a] = p[a].floor() as i64;
        part[a] = p[a] - p[a].floor();
    }
    let mut sum = 0.0;
    for corner in 0..8_usize {
        let mut weight = 1.0;
        let mut at = 0_usize;
        for a in [2, 1, 0] {
            let step = (corner >> a & 1) as i64;
            weight *= if step == 1 { part[a] } else { 1.0 - part[a] };
            let i = (base[a] + step).clamp(0, i64::from(dims[a]) - 1) - i64::from(from[a]);
            at = at * count[a] as usize + i.clamp(0, i64::from(count[a]) - 1) as usize;
        }
        if weight > 0.0 {
            sum += weight * voxels.get(at);
        }
    }
    sum
}

/// The soft border.
struct Ramp {
    spacing: DVec3,
    soften_mm: f64,
    /// Voxels that it reaches along each axis.
    reach: [u32; 3],
}

impl Ramp {
    fn new(grid: &Grid, soften_mm: f64) -> Self {
        let spacing = grid.spacing();
        let mm = if soften_mm > 0.0 { soften_mm * 0.5 + spacing.min_element() } else { 0.0 };
        Self { spacing, soften_mm, reach: std::array::from_fn(|a| (mm / spacing[a]).ceil() as u32) }
    }

    /// Selection of a box, 0..255.
    fn soften(&self, mask: &[Side], size: [usize; 3]) -> Vec<u8> {
        if self.soften_mm <= 0.0 {
            return mask.iter().map(|&m| if m == Side::Inside { 255 } else { 0 }).collect();
        }
        let half = self.spacing.min_element() * 0.5;
        let to = |side: Side| squared_distances(size, self.spacing, |i| mask[i] == side);
        let (to_outside, to_inside) = (to(Side::Outside), to(Side::Inside));
        let one = |(&side, (out, ins)): (&Side, (&f64, &f64))| {
            let d = if side == Side::Inside { out.sqrt() - half } else { half - ins.sqrt() };
            ((0.5 + d / self.soften_mm).clamp(0.0, 1.0) * 255.0).round() as u8
        };
        mask.iter().zip(to_outside.iter().zip(&to_inside)).map(one).collect()
    }
}

/// The bricks of a block without what lies around it; empty ones are left out.
fn cut(selected: &[u8], around: [usize; 3], reach: [u32; 3], first: [u32; 3], size: [u32; 3]) -> Changes {
    let mut changes = Changes::new();
    for bz in 0..size[2].div_ceil(BRICK) {
        for by in 0..size[1].div_ceil(BRICK) {
            for bx in 0..size[0].div_ceil(BRICK) {
                let low = [bx, by, bz].map(|b| b * BRICK);
                let mut texels = vec![0_u8; BRICK_VOXELS];
                for z in 0..BRICK.min(size[2] - low[2]) {
                    for y in 0..BRICK.min(size[1] - low[1]) {
                        let n = BRICK.min(size[0] - low[0]) as usize;
                        let from = (low[0] + reach[0]) as usize
                            + around[0]
                                * ((low[1] + y + reach[1]) as usize + around[1] * (low[2] + z + reach[2]) as usize);
                        let to = (BRICK * (y + BRICK * z)) as usize;
                        texels[to..to + n].copy_from_slice(&selected[from..from + n]);
                    }
                }
                if texels.iter().any(|&t| t > 0) {
                    let index = BrickIndex(std::array::from_fn(|a| (first[a] + low[a]) / BRICK));
                    changes.push((index, Some(Brick::from_texels(texels, 1))));
                }
            }
        }
    }
    changes
}
