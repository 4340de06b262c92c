//! Filling in: what lies under a stroke goes evenly from what lies at its rim, by Laplace's equation with the values about it held.
//!
//! Σ (u(beside) − u)/h² = 0 over the six neighbours, h the spacing along the axis in mm; the volume's border and what is not a number hold
//! nothing. No value so found lies beyond those held. Solved by conjugate gradients, preconditioned by the diagonal. Cost: that of the
//! voxels filled. Knows neither strokes nor how voxels were chosen.

use crate::math::DVec3;
use crate::paint::around::Block;
use crate::paint::voxel_set::VoxelSet;
use crate::volume::{BRICK, BRICK_VOXELS, BrickIndex, Field, SourceError};
use std::collections::HashMap;

/// Steps after which it stops in any case; residuals fall by half every few.
const MOST_STEPS: usize = 4000;
/// A residual this share of the first is none.
const SOLVED: f64 = 1e-9;

/// Values that were found, by voxel.
#[derive(Clone, Debug, Default)]
pub struct Filled(HashMap<BrickIndex, Box<[f32]>>);

impl Filled {
    /// The value of a voxel, in steps of the storage; NaN where none was found.
    pub fn at(&self, voxel: [i64; 3]) -> f32 {
        let (brick, place) = place(voxel.map(|v| v as u32));
        self.0.get(&brick).map_or(f32::NAN, |values| values[place])
    }

    fn put(&mut self, voxel: [u32; 3], value: f32) {
        let (brick, place) = place(voxel);
        self.0.entry(brick).or_insert_with(|| vec![f32::NAN; BRICK_VOXELS].into())[place] = value;
    }

    /// Takes over all values of another.
    pub fn extend(&mut self, other: Self) {
        for (brick, values) in other.0 {
            match self.0.get_mut(&brick) {
                Some(own) => own.iter_mut().zip(values.iter()).filter(|(_, v)| !v.is_nan()).for_each(|(a, b)| *a = *b),
                None => drop(self.0.insert(brick, values)),
            }
        }
    }

    /// Fills in these voxels of a field.
    ///
    /// # Errors
    /// If the source fails.
    pub fn solve(field: &Field, spacing: DVec3, domain: &VoxelSet) -> Result<Self, SourceError> {
        let dims = field.dims(0);
        let voxels: Vec<[u32; 3]> = domain.voxels();
        let mut numbers: HashMap<BrickIndex, Box<[u32]>> = HashMap::new();
        for (n, voxel) in (1..).zip(&voxels) {
            let (brick, place) = place(*voxel);
            numbers.entry(brick).or_insert_with(|| vec![0; BRICK_VOXELS].into())[place] = n;
        }
        let mut blocks: HashMap<BrickIndex, Block> = HashMap::new();
        for brick in numbers.keys() {
            let lo = brick.origin().map(|o| i64::from(o) - 1);
            blocks.insert(*brick, Block::read(field, lo, [BRICK as usize + 2; 3])?);
        }
        let weights = spacing.to_array().map(|h| 1.0 / (h * h));
        let mut system = System { beside: Vec::new(), diagonal: Vec::new(), weights };
        let (mut right, mut ends) = (Vec::new(), [f64::INFINITY, f64::NEG_INFINITY]);
        for voxel in &voxels {
            let block = &blocks[&BrickIndex::of_voxel(*voxel)];
            let (mut beside, mut diagonal, mut held) = ([0; 6], 0.0, 0.0);
            for (face, beside) in beside.iter_mut().enumerate() {
                let (axis, step) = (face / 2, if face % 2 == 0 { -1 } else { 1 });
                let mut at = voxel.map(i64::from);
                at[axis] += step;
                if at[axis] < 0 || at[axis] >= i64::from(dims[axis]) {
                    continue;
                }
                let (brick, place) = place(at.map(|v| v as u32));
                *beside = numbers.get(&brick).map_or(0, |numbers| numbers[place]);
                let value = f64::from(block.at(at));
                if *beside != 0 {
                    diagonal += weights[axis];
                } else if !value.is_nan() {
                    diagonal += weights[axis];
                    held += weights[axis] * value;
                    ends = [ends[0].min(value), ends[1].max(value)];
                }
            }
            system.beside.push(beside);
            system.diagonal.push(diagonal);
            right.push(held);
        }
        let mut filled = Self::default();
        if ends[0] > ends[1] {
            return Ok(filled);
        }
        let found = system.solve(&right, 0.5 * (ends[0] + ends[1]));
        for (voxel, value) in voxels.iter().zip(found) {
            filled.put(*voxel, value.clamp(ends[0], ends[1]) as f32);
        }
        Ok(filled)
    }
}

fn place(voxel: [u32; 3]) -> (BrickIndex, usize) {
    let [x, y, z] = voxel.map(|v| v % BRICK);
    (BrickIndex::of_voxel(voxel), (x + BRICK * (y + BRICK * z)) as usize)
}

/// One equation a voxel: diagonal·u − Σ weight·u(beside) = what is held about it.
struct System {
    /// Numbers of the unknowns beside, from 1; 0 for none.
    beside: Vec<[u32; 6]>,
    diagonal: Vec<f64>,
    weights: [f64; 3],
}

impl System {
    fn apply(&self, u: &[f64], out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let mut sum = self.diagonal[i] * u[i];
            for (face, n) in self.beside[i].iter().enumerate() {
                if *n != 0 {
                    sum -= self.weights[face / 2] * u[*n as usize - 1];
                }
            }
            *out = sum;
        }
    }

    fn solve(&self, right: &[f64], first: f64) -> Vec<f64> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled = |r: &[f64]| -> Vec<f64> {
            r.iter().zip(&self.diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
        };
        let mut u = vec![first; right.len()];
        let mut applied = vec![0.0; right.len()];
        self.apply(&u, &mut applied);
        let mut residual: Vec<f64> = right.iter().zip(&applied).map(|(b, a)| b - a).collect();
        let mut ahead = scaled(&residual);
        let mut way = ahead.clone();
        let mut size = dot(&residual, &ahead);
        let small = size * SOLVED * SOLVED;
        for _ in 0..MOST_STEPS {
            if size <= small || size <= 0.0 {
                break;
            }
            self.apply(&way, &mut applied);
            let far = size / dot(&way, &applied);
            if !far.is_finite() {
                break;
            }
            u.iter_mut().zip(&way).for_each(|(u, w)| *u += far * w);
            residual.iter_mut().zip(&applied).for_each(|(r, a)| *r -= far * a);
            ahead = scaled(&residual);
            let new = dot(&residual, &ahead);
            way.iter_mut().zip(&ahead).for_each(|(w, a)| *w = a + new / size * *w);
            size = new;
        }
        u
    }
}
