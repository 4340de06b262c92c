//! How much of a stroke can pile up on one voxel: a bound for what building up adds, known before the GPU has painted it.
//!
//! Owns a sparse lattice of cells as large as a dab reaches: a voxel's dabs lie in its own cell and those beside it. Knows
//! dabs, no voxels. The bound is that of hard dabs, up to twice or thrice what piles up really.

use crate::paint::brush::{Brush, Shape};
use crate::paint::dab::Dab;
use crate::volume::Grid;
use std::collections::HashMap;

/// The most that the stroke so far can add to any voxel, in the field's units.
#[derive(Clone, Debug)]
pub struct BuildUpBound {
    edge_mm: f64,
    strength: f64,
    /// By cell: the strengths of the dabs in it and beside it.
    sums: HashMap<[i64; 3], f64>,
    most: f64,
}

impl BuildUpBound {
    /// Nothing yet of this brush's stroke.
    pub fn new(brush: &Brush, grid: &Grid) -> Self {
        let steps = grid.world_from_index.matrix3;
        let steps = [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| step.length());
        let edge_mm = match brush.shape {
            _ if brush.radius_mm == 0.0 => steps.iter().sum(),
            Shape::Sphere => brush.radius_mm,
            Shape::Ellipsoid => brush.radius_mm * brush.ratio.max(1.0),
            // It is lifted to the nearest layer of voxels: half the distance of two at most.
            Shape::Disc => brush.radius_mm.hypot(steps.into_iter().fold(0.0, f64::max) * 0.5),
        };
        Self { edge_mm, strength: f64::from(brush.strength), sums: HashMap::new(), most: 0.0 }
    }

    /// The bound for a straight stroke however long, of dabs this far apart, mm: three cells of them.
    pub fn of_a_line(&self, apart_mm: f64) -> f64 {
        3.0 * self.edge_mm / apart_mm * self.strength
    }

    /// Adds dabs; answers the most coverage, Σ G, that any voxel can have by now.
    pub fn add(&mut self, dabs: &[Dab]) -> f64 {
        for dab in dabs {
            let cell = (dab.centre / self.edge_mm).floor().to_array().map(|c| c as i64);
            for i in 0..27 {
                let step = [i % 3, i / 3 % 3, i / 9];
                let beside = std::array::from_fn(|axis| cell[axis].saturating_add(step[axis] - 1));
                let sum = self.sums.entry(beside).or_default();
                *sum += self.strength * f64::from(dab.pressure);
                self.most = self.most.max(*sum);
            }
        }
        self.most
    }
}
