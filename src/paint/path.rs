//! From samples to dabs at fixed arc length.
//!
//! The n-th dab of a stroke lies n·step along the polyline of its samples, whatever number of samples an event brings and
//! however long a frame takes. Owns where the stroke has got to; knows nothing of voxels but their size.

use super::{Brush, Dab, PaintError, Sample};
use crate::math::DVec3;
use crate::volume::Grid;

/// The most dabs that one call may give; more is a slip of a script, not a stroke.
pub const MAX_DABS: u64 = 1 << 20;

/// The most voxels in a radius; beyond it the kernel's 32-bit arithmetic no longer tells voxels apart.
const MAX_RADIUS_VOXELS: f64 = 65_536.0;

/// A stroke's way so far.
#[derive(Clone, Debug)]
pub struct StrokePath {
    radius_mm: f64,
    step_mm: f64,
    last: Option<Sample>,
    /// Length of the way to `last`, mm.
    arc_mm: f64,
    /// Number of the next dab.
    next: u64,
}

impl StrokePath {
    /// A stroke of this brush that has not begun.
    ///
    /// # Errors
    /// If the brush is not valid, or its radius is more than 65,536 voxels of this grid.
    pub fn new(brush: &Brush, grid: &Grid) -> Result<Self, PaintError> {
        brush.check()?;
        if brush.radius_mm > MAX_RADIUS_VOXELS * grid.voxel_mm() {
            return Err(PaintError::Brush {
                field: "radius_mm",
                found: brush.radius_mm.to_string(),
                expected: "at most 65,536 voxels of the volume",
            });
        }
        let step_mm = if brush.radius_mm > 0.0 {
            brush.spacing * brush.radius_mm
        } else {
            // A quarter of the thinnest layer, so that the voxels along the way touch each other.
            let rows = grid.index_from_world().matrix3.transpose();
            0.25 / rows.x_axis.length().max(rows.y_axis.length()).max(rows.z_axis.length())
        };
        Ok(Self { radius_mm: brush.radius_mm, step_mm, last: None, arc_mm: 0.0, next: 0 })
    }

    /// Distance between dabs along the way, mm.
    pub fn step_mm(&self) -> f64 {
        self.step_mm
    }

    /// Length of the way so far, mm.
    pub fn length_mm(&self) -> f64 {
        self.arc_mm
    }

    /// The dabs that further samples give, in order. The first sample gives one where it is.
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

    fn to(&mut self, index: usize, sample: &Sample, dabs: &mut Vec<Dab>) -> Result<(), PaintError> {
        let Some(last) = self.last.replace(*sample) else {
            dabs.push(self.dab(sample.position, sample.pressure, sample.normal));
            self.next = 1;
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
        while self.next as f64 * self.step_mm <= end {
            let t = ((self.next as f64 * self.step_mm - self.arc_mm) / length).clamp(0.0, 1.0);
            let pressure = last.pressure + (sample.pressure - last.pressure) * t as f32;
            dabs.push(self.dab(last.position.lerp(sample.position, t), pressure, sample.normal));
            self.next += 1;
        }
        self.arc_mm = end;
        Ok(())
    }

    fn dab(&self, centre: DVec3, pressure: f32, normal: DVec3) -> Dab {
        Dab { centre, radius_mm: self.radius_mm, pressure, normal }
    }
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
