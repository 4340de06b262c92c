//! What neighbourhood operators lead each voxel toward: the C of equation 1, one for every voxel instead of one for all.
//!
//! Direct Volume Editing (2008), section 3.3 and figure 5, in the form P′ = P + G·(C − P) with C told from the field as it was at the
//! stroke's start, so that neither the order of bricks nor that of dabs matters. An offset along the normal moves as far as the coverage
//! says: C hangs on G, and is given at G = ¼, ½, ¾ and 1, between which it goes straight. Cost: that of the slots asked for.

use crate::math::{DMat3, DVec3};
use crate::paint::around::{Block, ball, reach};
use crate::paint::brush::{Brush, Operation};
use crate::paint::error::PaintError;
use crate::paint::fill::Filled;
use crate::volume::{BrickIndex, Field, FieldKind, Grid, SLOT, SLOT_VOXELS, SourceError};

/// Goals of a texel.
pub const GOALS: usize = 4;

/// The widest Gaussian, and the farthest offset, in voxels of the thinnest layers.
const MOST_SIGMA: f64 = 8.0;
const MOST_HEIGHT: f64 = 12.0;
/// A Gaussian for normals that is wider than so many voxels is taken on a coarser level.
const FEW_VOXELS: f64 = 1.5;
/// The most voxels of a median's radius.
const MOST_MEDIAN: f64 = 5.0;

impl Operation {
    /// Whether it leads each voxel toward something of its own, told from its neighbourhood.
    pub fn looks_around(self) -> bool {
        matches!(self, Self::Smooth | Self::Median | Self::Sharpen | Self::Fill) || self.displaces()
    }

    /// Whether it moves matter along the normal.
    pub fn displaces(self) -> bool {
        matches!(self, Self::Raise | Self::Lower | Self::Push | Self::Pull)
    }
}

impl Brush {
    /// The same with lengths that nobody said, those of a voxel of this lattice.
    #[must_use]
    pub fn with_lengths(&self, grid: &Grid) -> Self {
        let coarsest = grid.spacing().max_element();
        let reach = if self.operation == Operation::Median { coarsest } else { grid.voxel_mm() };
        Self {
            reach_mm: Some(self.reach_mm.unwrap_or(reach)),
            height_mm: Some(self.height_mm.unwrap_or(grid.voxel_mm())),
            ..*self
        }
    }

    /// # Errors
    /// If a neighbourhood operator would look or move further than it can on this lattice.
    pub fn check_around(&self, grid: &Grid) -> Result<(), PaintError> {
        let wrong = |field, found: f64, expected| Err(PaintError::Brush { field, found: found.to_string(), expected });
        let (reach, height, voxel) = (self.reach_mm.unwrap_or(0.0), self.height_mm.unwrap_or(0.0), grid.voxel_mm());
        match self.effective() {
            Operation::Smooth | Operation::Sharpen if reach > MOST_SIGMA * voxel => {
                wrong("reach_mm", reach, "at most 8 voxels of the volume")
            }
            Operation::Median if reach > MOST_MEDIAN * voxel => {
                wrong("reach_mm", reach, "at most 5 voxels of the volume for a median")
            }
            operation if operation.displaces() && height > MOST_HEIGHT * voxel => {
                wrong("height_mm", height, "at most 12 voxels of the volume")
            }
            _ => Ok(()),
        }
    }
}

/// What goals are told from.
#[derive(Clone, Copy, Debug)]
pub struct Goals<'a> {
    /// The brush, its lengths said.
    pub brush: &'a Brush,
    /// The volume's lattice.
    pub grid: &'a Grid,
    /// What is painted, as it was at the stroke's start.
    pub field: &'a Field,
    /// What was filled in.
    pub filled: &'a Filled,
}

/// A slot's texels as voxels of the volume.
struct Texels {
    origin: [u32; 3],
    dims: [u32; 3],
}

impl Texels {
    /// Texel by texel, x fastest: apron texels as the voxels that they repeat.
    fn voxels(&self) -> impl Iterator<Item = [i64; 3]> + '_ {
        (0..SLOT * SLOT * SLOT).map(|texel| {
            let [x, y, z] = [texel % SLOT, texel / SLOT % SLOT, texel / (SLOT * SLOT)];
            let voxel = |a: usize, t: u32| i64::from((self.origin[a] + t).saturating_sub(1).min(self.dims[a] - 1));
            [voxel(0, x), voxel(1, y), voxel(2, z)]
        })
    }
}

impl Goals<'_> {
    /// [`GOALS`] numbers for every texel of a slot of level 0, x fastest, in steps of the storage; a texel's own where nothing leads it
    /// elsewhere.
    ///
    /// # Errors
    /// If the source fails.
    pub fn slot(&self, index: BrickIndex) -> Result<Vec<f32>, SourceError> {
        let texels = Texels { origin: index.origin(), dims: self.grid.dims };
        let spacing = self.grid.spacing();
        let length = self.brush.reach_mm.unwrap_or(0.0).max(f64::MIN_POSITIVE);
        let mut goals = Vec::with_capacity(SLOT_VOXELS * GOALS);
        match self.brush.effective() {
            Operation::Median => {
                let offsets = ball(length, spacing);
                let most = std::array::from_fn(|a| offsets.iter().map(|o| o[a].unsigned_abs()).max().unwrap_or(0));
                let block = self.block(index, most.map(|m| m as usize))?;
                let mut gathered = Vec::new();
                goals.extend(texels.voxels().flat_map(|v| {
                    let goal = block.median(v, &offsets, &mut gathered);
                    straight(block.at(v), goal)
                }));
            }
            Operation::Fill => {
                let block = self.block(index, [0; 3])?;
                goals.extend(texels.voxels().flat_map(|v| straight(block.at(v), self.filled.at(v))));
            }
            operation if operation.displaces() => self.displaced(operation, index, &texels, &mut goals)?,
            operation => {
                let block = self.block(index, reach(length, spacing))?;
                let mean = block.gaussian(length, spacing);
                let [least, most] = self.ends();
                goals.extend(texels.voxels().flat_map(|v| {
                    let (own, mean) = (block.at(v), mean.at(v));
                    let sharper = || (2.0 * own - mean).clamp(least, most);
                    straight(own, if operation == Operation::Sharpen { sharper() } else { mean })
                }));
            }
        }
        Ok(goals)
    }

    /// The field's least and greatest number, in steps of the storage.
    fn ends(&self) -> [f32; 2] {
        match self.field.kind() {
            FieldKind::Density => {
                let map = self.field.map();
                self.field.extremes().map(|v| ((f64::from(v) - map.lo) * map.codes_per_unit) as f32)
            }
            _ => [0.0, 255.0],
        }
    }

    /// The values of a slot and so many voxels about it.
    fn block(&self, index: BrickIndex, margin: [usize; 3]) -> Result<Block, SourceError> {
        let origin = index.origin();
        let lo = std::array::from_fn(|a| i64::from(origin[a]) - 1 - margin[a] as i64);
        Block::read(self.field, lo, margin.map(|m| SLOT as usize + 2 * m))
    }

    /// Slopes of the field, smoothed by a Gaussian.
    fn slopes(&self, index: BrickIndex, sigma: f64) -> Result<Slopes, SourceError> {
        let spacing = self.grid.spacing();
        let mut level = 0;
        let coarsest = self.field.level_count().saturating_sub(1);
        while level < coarsest && sigma >= FEW_VOXELS * spacing.max_element() * f64::from(2_u32 << level) {
            level += 1;
        }
        let (scale, origin) = (i64::from(1_u32 << level), index.origin());
        let spacing = spacing * scale as f64;
        let around = reach(sigma, spacing);
        // A voxel more for differences, one for what lies between voxels.
        let margin: [i64; 3] = std::array::from_fn(|a| around[a] as i64 + 2);
        let first = |a: usize| i64::from(origin[a]) - 1;
        let lo = std::array::from_fn(|a| first(a).div_euclid(scale) - margin[a]);
        let end: [i64; 3] = std::array::from_fn(|a| (first(a) + i64::from(SLOT)).div_euclid(scale) + 1 + margin[a]);
        let size = std::array::from_fn(|a| (end[a] - lo[a]) as usize);
        let block = Block::read_at(self.field, level, lo, size)?;
        Ok(Slopes { smooth: block.gaussian(sigma, spacing), level })
    }

    /// Values that lie the height, or its share, further along the normal.
    fn displaced(
        &self,
        operation: Operation,
        index: BrickIndex,
        texels: &Texels,
        goals: &mut Vec<f32>,
    ) -> Result<(), SourceError> {
        let spacing = self.grid.spacing();
        let matrix = self.grid.world_from_index.matrix3;
        let height = self.brush.height_mm.unwrap_or(0.0);
        // Matter that moves outward is taken from further inside.
        let sign = if matches!(operation, Operation::Raise | Operation::Pull) { -1.0 } else { 1.0 };
        let sigma = normal_sigma(self.brush, operation, height, spacing);
        // Index steps of an offset in any direction, and the splines' reach.
        let rows = self.grid.index_from_world().matrix3.transpose();
        let margin: [usize; 3] = std::array::from_fn(|a| (rows.col(a).length() * height).ceil() as usize + 2);
        let block = self.block(index, margin)?;
        let slopes = self.slopes(index, sigma)?;
        let to_world = DMat3::from_cols(rows.x_axis, rows.y_axis, rows.z_axis);
        let to_index = matrix.inverse();
        for v in texels.voxels() {
            let own = block.at(v);
            // The gradient by mm: each index's share along the normal of its layers.
            let normal = -(to_world * slopes.at(v));
            let Some(normal) = normal.try_normalize() else {
                goals.extend([own; GOALS]);
                continue;
            };
            let step = to_index * normal * (sign * height / GOALS as f64);
            let at = DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64);
            goals.extend((1..=GOALS).map(|n| {
                let goal = block.between(at + step * n as f64);
                if goal.is_nan() { own } else { goal }
            }));
        }
        Ok(())
    }
}

/// Slopes of a smoothed field about a slot, from a level on which the Gaussian is a few voxels wide.
struct Slopes {
    smooth: Block,
    level: u8,
}

impl Slopes {
    /// In the same unit for every axis.
    fn at(&self, voxel: [i64; 3]) -> DVec3 {
        if self.level == 0 {
            return self.smooth.slope(voxel);
        }
        let scale = f64::from(1_u32 << self.level);
        let fine = DVec3::new(voxel[0] as f64, voxel[1] as f64, voxel[2] as f64);
        self.smooth.slope_between((fine + 0.5) / scale - 0.5)
    }
}

/// How wide a Gaussian the normals are those of: wide enough to know, as far out as matter is moved, where it comes from. Pushing and
/// pulling go by the surface at large, so that what is small on it rides along.
fn normal_sigma(brush: &Brush, operation: Operation, height_mm: f64, spacing: DVec3) -> f64 {
    let own = (0.75 * height_mm).max(spacing.max_element());
    let most = MOST_SIGMA * spacing.min_element();
    match operation {
        Operation::Push | Operation::Pull => own.max(0.75 * brush.radius_mm).min(most.max(own)),
        _ => own.min(most.max(spacing.max_element())),
    }
}

/// The same goal at every coverage.
fn straight(own: f32, goal: f32) -> [f32; GOALS] {
    if goal.is_nan() {
        return [own; GOALS];
    }
    if own.is_nan() {
        return [goal; GOALS];
    }
    std::array::from_fn(|n| if n + 1 == GOALS { goal } else { own + (goal - own) * ((n + 1) as f32 / GOALS as f32) })
}
