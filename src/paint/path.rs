//! From samples to dabs at fixed arc length.
//!
//! A stroke is a path of its samples, in one piece or several: where a sample breaks the path, a piece ends and another begins.
//! The n-th dab of a piece lies n·step along the polyline of its samples, whatever number of samples an event brings and however
//! long a frame takes; one more lies at its last sample, so that a stroke covers it. While the radius is under half the voxel's
//! diagonal, voxels that the path passes between two dabs get one of their own. Owns where the stroke has got to; of voxels it
//! knows where they lie, nothing of what they hold.

use crate::math::{DAffine3, DVec3};
use crate::paint::brush::{Brush, Pressure, Sample, Tip};
use crate::paint::dab::{Dab, half_diagonal_mm};
use crate::paint::error::PaintError;
use crate::paint::passed::{cell_of, left};
use crate::volume::Grid;
use std::collections::HashSet;

/// The most dabs that one call may give; more is a slip of a script, not a stroke.
pub const MAX_DABS: u64 = 1 << 20;

/// The most voxels in a radius; beyond it the kernel's 32-bit arithmetic no longer tells voxels apart.
const MAX_RADIUS_VOXELS: f64 = 65_536.0;

/// Dabs lie no nearer to each other than this share of the thinnest layer of voxels: nearer ones reach nothing new.
const LEAST_STEP: f64 = 1.0 / 64.0;

/// A last dab this share of a step or less behind another is that one.
const SAME: f64 = 1e-9;

/// A stroke's way so far.
#[derive(Clone, Debug)]
pub struct StrokePath {
    radius_mm: f64,
    step_mm: f64,
    builds_up: bool,
    pressure: Pressure,
    /// `index_from_world` and its inverse, if every voxel on the way is painted.
    thin: Option<[DAffine3; 2]>,
    last: Option<Sample>,
    /// Length of the pieces before, mm.
    before_mm: f64,
    /// Length of the piece's way to `last`, mm.
    arc_mm: f64,
    /// Number of the piece's next dab.
    next: u64,
    /// The voxel that holds `last`, and whether a dab lies in it.
    cell: ([i64; 3], bool),
}

impl StrokePath {
    /// A stroke of this brush that has not begun.
    ///
    /// # Errors
    /// If the brush is not valid, or its radius is more than 65,536 voxels of this grid.
    pub fn new(brush: &Brush, grid: &Grid) -> Result<Self, PaintError> {
        Self::apart_by(step_mm(brush, [grid]), brush, grid)
    }

    /// The way of a stroke on one of several volumes that it paints at once: its dabs are `step_mm` apart, the [`step_mm`] of all of
    /// them. So the same dabs lie on each, but for those that a thin brush gives to single voxels.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn apart_by(step_mm: f64, brush: &Brush, grid: &Grid) -> Result<Self, PaintError> {
        brush.check()?;
        if brush.radius_mm > MAX_RADIUS_VOXELS * grid.voxel_mm() {
            return Err(PaintError::Brush {
                field: "radius_mm",
                found: brush.radius_mm.to_string(),
                expected: "at most 65,536 voxels of the volume",
            });
        }
        let thin = (brush.radius_mm < half_diagonal_mm(grid)).then(|| [grid.index_from_world(), grid.world_from_index]);
        Ok(Self {
            radius_mm: brush.radius_mm,
            step_mm,
            builds_up: brush.tip == Tip::BuildUp,
            pressure: brush.pressure,
            thin,
            last: None,
            before_mm: 0.0,
            arc_mm: 0.0,
            next: 0,
            cell: ([0; 3], false),
        })
    }

    /// Distance between dabs along the way, mm.
    pub fn step_mm(&self) -> f64 {
        self.step_mm
    }

    /// Length of the way so far, mm, without what lies between its pieces.
    pub fn length_mm(&self) -> f64 {
        self.before_mm + self.arc_mm
    }

    /// The dabs that further samples give, in order. The first sample of a piece gives one where it is, and ends the piece before
    /// it as [`end`](Self::end) does.
    ///
    /// # Errors
    /// If a sample is not finite, its pressure is outside 0..1, or the way to it takes more than [`MAX_DABS`]; the path is then
    /// as it was.
    pub fn extend(&mut self, samples: &[Sample]) -> Result<Vec<Dab>, PaintError> {
        let mut path = self.clone();
        let mut dabs = Vec::new();
        for (index, sample) in samples.iter().enumerate() {
            check(index, sample)?;
            path.to(index, sample, &mut dabs)?;
        }
        *self = path;
        Ok(dabs)
    }

    /// Ends the piece: the dab at its last sample, if none lies there yet. Where dabs add up it counts by the share of a step that
    /// lies behind it, but wholly if the path passes its voxel and has no other dab in it. A further sample begins another piece.
    pub fn end(&mut self) -> Option<Dab> {
        let last = self.last.take()?;
        let share = self.arc_mm / self.step_mm - (self.next - 1) as f64;
        self.before_mm += self.arc_mm;
        self.arc_mm = 0.0;
        let uncovered = self.thin.is_some() && !self.cell.1;
        (share > SAME || uncovered).then(|| {
            let share = if self.builds_up && !uncovered { share.clamp(0.0, 1.0) as f32 } else { 1.0 };
            let dab = self.dab(last.position, last.pressure, last.normal);
            Dab { pressure: dab.pressure * share, ..dab }
        })
    }

    fn to(&mut self, index: usize, sample: &Sample, dabs: &mut Vec<Dab>) -> Result<(), PaintError> {
        if sample.breaks {
            dabs.extend(self.end());
        }
        let Some(last) = self.last.replace(*sample) else {
            dabs.push(self.dab(sample.position, sample.pressure, sample.normal));
            self.next = 1;
            self.cell = self
                .thin
                .map_or(([0; 3], false), |[inverse, _]| (cell_of(inverse.transform_point3(sample.position)), true));
            return Ok(());
        };
        let length = last.position.distance(sample.position);
        let end = self.arc_mm + length;
        let count = ((end / self.step_mm).floor() - self.next as f64 + 1.0).max(0.0) as u64;
        let count = count.saturating_add(dabs.len() as u64);
        if count > MAX_DABS {
            return Err(PaintError::TooLong {
                index,
                length_mm: length,
                dabs: count,
                step_mm: self.step_mm,
                most: MAX_DABS,
            });
        }
        // From the number and not by adding up, so that rounding does not depend on how many samples there were.
        let mut way: Vec<(f64, Dab)> = Vec::new();
        while self.next as f64 * self.step_mm <= end {
            let t = ((self.next as f64 * self.step_mm - self.arc_mm) / length).clamp(0.0, 1.0);
            let (centre, pressure) = between(&last, sample, t);
            way.push((t, self.dab(centre, pressure, sample.normal)));
            self.next += 1;
        }
        self.arc_mm = end;
        if let Some([index_from_world, world_from_index]) = self.thin {
            self.fill(&last, sample, &mut way, &index_from_world, &world_from_index);
        }
        dabs.extend(way.into_iter().map(|(_, dab)| dab));
        Ok(())
    }

    /// Gives a dab of radius 0 to each voxel that the way to a sample leaves without one.
    fn fill(
        &mut self,
        last: &Sample,
        sample: &Sample,
        way: &mut Vec<(f64, Dab)>,
        index_from_world: &DAffine3,
        world_from_index: &DAffine3,
    ) {
        let [a, b] = [last, sample].map(|s| index_from_world.transform_point3(s.position));
        let mut held: HashSet<_> =
            way.iter().map(|(_, d)| cell_of(index_from_world.transform_point3(d.centre))).collect();
        held.extend(self.cell.1.then_some(self.cell.0));
        for (cell, t) in left(a, b) {
            if !held.contains(&cell) {
                let centre = world_from_index.transform_point3(DVec3::from_array(cell.map(|c| c as f64)));
                let pressure = between(last, sample, t).1;
                way.push((t, Dab { centre, radius_mm: 0.0, pressure, normal: sample.normal }));
            }
        }
        way.sort_by(|x, y| x.0.total_cmp(&y.0));
        let cell = cell_of(b);
        self.cell = (cell, held.contains(&cell));
    }

    fn dab(&self, centre: DVec3, pressure: f32, normal: DVec3) -> Dab {
        let share = if self.pressure.radius { f64::from(pressure).max(Pressure::LEAST) } else { 1.0 };
        // No pressure at all paints nothing, whatever it scales.
        let pressure = if self.pressure.strength || pressure == 0.0 { pressure } else { 1.0 };
        Dab { centre, radius_mm: self.radius_mm * share, pressure, normal }
    }
}

/// Distance between dabs along the way, mm, of a stroke that paints volumes of these lattices at once: decided once, by the thinnest
/// layer of voxels in any of them, so that what a place of the world gets does not depend on which volume it is asked of.
pub fn step_mm<'a>(brush: &Brush, grids: impl IntoIterator<Item = &'a Grid>) -> f64 {
    let thinnest = |grid: &Grid| {
        let rows = grid.index_from_world().matrix3.transpose();
        1.0 / rows.x_axis.length().max(rows.y_axis.length()).max(rows.z_axis.length())
    };
    let thinnest = grids.into_iter().map(thinnest).fold(f64::INFINITY, f64::min);
    // The lightest touch still leaves no gaps.
    let least = if brush.pressure.radius { Pressure::LEAST } else { 1.0 };
    match brush.radius_mm > 0.0 {
        true => (brush.spacing * brush.radius_mm * least).max(thinnest * LEAST_STEP),
        false => thinnest * 0.25,
    }
}

/// Place and pressure between two samples.
fn between(last: &Sample, sample: &Sample, t: f64) -> (DVec3, f32) {
    (last.position.lerp(sample.position, t), last.pressure + (sample.pressure - last.pressure) * t as f32)
}

fn check(index: usize, sample: &Sample) -> Result<(), PaintError> {
    let wrong = |field, found: String, expected| Err(PaintError::Sample { index, field, found, expected });
    // Squares of larger numbers overflow.
    if !sample.position.is_finite() || sample.position.abs().max_element() > 1e100 {
        return wrong("position", sample.position.to_string(), "three finite numbers in mm");
    }
    if !sample.normal.is_finite() {
        return wrong("normal", sample.normal.to_string(), "three finite numbers");
    }
    if !(0.0..=1.0).contains(&sample.pressure) {
        return wrong("pressure", sample.pressure.to_string(), "0 to 1");
    }
    Ok(())
}
