//! Between which values painting moves, and what follows from that where density is in 32-bit floats.
//!
//! Floats have no step of their own by which a weak brush could arrive at its end: 0.9^100 of a way is left of it after a hundred
//! erasures of a tenth. The step is that of 16 bits over the values that are the volume's or were ever painted; a hundred times a
//! tenth then always arrive. What stands for nothing measured takes no part, or one voxel of −3.4e38 would make the step as large as
//! all others together. Knows fields, neither documents nor the GPU.

use crate::paint::brush::{Brush, Operation, Target};
use crate::volume::{DensityMap, Field, SourceError, TexelFormat, VoxelType};

/// Values from the least to the greatest that are measurements or were painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach(pub [f64; 2]);

impl Reach {
    /// Of the source's values from `least` to `greatest`, and of all that is painted in `density`.
    ///
    /// # Errors
    /// If the source fails.
    pub fn new([least, greatest]: [f64; 2], density: &Field) -> Result<Self, SourceError> {
        let mut reach = Self([least, greatest].map(|end| if end.is_finite() { end } else { 0.0 }));
        for (index, _) in density.edits() {
            for (_, value) in density.values(index.origin(), density.valid(0, index))?.painted {
                reach.widen([value, value]);
            }
        }
        Ok(reach)
    }

    /// The same once a brush has painted on these values, up to `coverage` of it adding up.
    #[must_use]
    pub fn after(self, brush: &Brush, density: &Field, coverage: f64) -> Self {
        let mut wider = self;
        wider.widen(brush.made(self.0, density, coverage));
        wider
    }

    /// What of the reach was reached: a brush that adds up seldom goes all the way, and density has no values beyond its own.
    #[must_use]
    pub fn within(self, before: Self, density: &Field) -> Self {
        let [lo, hi] = density.extremes().map(f64::from);
        let mut reached = before;
        reached.widen([self.0[0].max(lo), self.0[1].min(hi)]);
        reached
    }

    /// The largest of them without its sign.
    pub fn largest(&self) -> f64 {
        self.0[0].abs().max(self.0[1].abs())
    }

    /// The step by which a weak brush arrives at its end.
    pub fn step(&self) -> f64 {
        (self.0[1] - self.0[0]).min(f64::MAX) / 65_535.0
    }

    fn widen(&mut self, [lo, hi]: [f64; 2]) {
        let [least, greatest] = &mut self.0;
        // Of NaN the other is taken, and infinity is reached by nothing.
        *least = if lo.is_finite() { least.min(lo) } else { *least };
        *greatest = if hi.is_finite() { greatest.max(hi) } else { *greatest };
    }
}

impl Brush {
    /// The floats that density needs where this brush makes values beyond all 32-bit ones of data that hold such: by a power of
    /// two smaller. `map` is the one that it has or gets otherwise, `reach` what the brush makes.
    pub fn floats_for(&self, map: &DensityMap, density: &Field, reach: Reach) -> Option<DensityMap> {
        let doubles = density.source().is_some_and(|s| s.voxel_type() == VoxelType::F64);
        let paints = matches!(self.effective_target(), Target::Density(_)) && self.effective() != Operation::Restore;
        let largest = reach.largest();
        let beyond = largest * map.codes_per_unit > f64::from(f32::MAX);
        (map.format == TexelFormat::R32Float && doubles && paints && beyond).then(|| DensityMap::floats(largest))
    }
}
