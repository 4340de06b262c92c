//! How much of a stroke can pile up on one voxel: a bound for what building up adds, known before the GPU has painted it.
//!
//! Owns a sparse lattice of cells as large as the radius: a voxel's dabs lie in its own cell and those beside it. Knows
//! dabs, no voxels. The bound is that of hard dabs, up to twice or thrice what piles up really.

use super::{Brush, Dab};
use crate::volume::Grid;
use std::collections::HashMap;

/// See the module's head.
#[derive(Clone, Debug)]
pub struct Pile {
    edge_mm: f64,
    strength: f64,
    /// By cell: the strengths of the dabs in it and beside it.
    sums: HashMap<[i64; 3], f64>,
    most: f64,
}

impl Pile {
    /// Nothing yet of this brush's stroke.
    pub fn new(brush: &Brush, grid: &Grid) -> Self {
        let steps = grid.world_from_index.matrix3;
        let voxel_mm = steps.x_axis.length() + steps.y_axis.length() + steps.z_axis.length();
        Self {
            edge_mm: if brush.radius_mm > 0.0 { brush.radius_mm } else { voxel_mm },
            strength: f64::from(brush.strength),
            sums: HashMap::new(),
            most: 0.0,
        }
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
