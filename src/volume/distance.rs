//! Exact Euclidean distances on a box of voxels, along the voxel axes at their spacings: a sheared lattice counts as a straight one.
//!
//! One lower envelope of parabolas along each axis in turn (Felzenszwalb and Huttenlocher 2012), so that the cost is that of the box and
//! not of what is in it. Knows no volume.

use crate::math::DVec3;

/// Squared distance in mm² of every voxel of a box (x fastest) to the nearest one for which `goal` is true; infinite if there is none.
/// `goal` gets the voxel's place in that order, `spacing` is in mm.
pub fn squared_distances(size: [usize; 3], spacing: DVec3, goal: impl Fn(usize) -> bool) -> Vec<f64> {
    let count = size.iter().product();
    let mut d: Vec<f64> = (0..count).map(|i| if goal(i) { 0.0 } else { f64::INFINITY }).collect();
    let strides = [1, size[0], size[0] * size[1]];
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut line = vec![0.0; size[axis]];
        let mut envelope = Envelope::default();
        for j in 0..size[v] {
            for i in 0..size[u] {
                let start = i * strides[u] + j * strides[v];
                for (k, value) in line.iter_mut().enumerate() {
                    *value = d[start + k * strides[axis]];
                }
                envelope.lower(&mut line, spacing[axis]);
                for (k, value) in line.iter().enumerate() {
                    d[start + k * strides[axis]] = *value;
                }
            }
        }
    }
    d
}

/// Parabolas of a line, as (position, height, where it begins to be lowest).
#[derive(Default)]
struct Envelope(Vec<(f64, f64, f64)>);

impl Envelope {
    /// Replaces f(k) by the least of f(q) + (spacing·(k − q))² over all q.
    fn lower(&mut self, line: &mut [f64], spacing: f64) {
        self.0.clear();
        for (k, &height) in line.iter().enumerate().filter(|(_, h)| h.is_finite()) {
            let at = k as f64 * spacing;
            let mut begin = f64::NEG_INFINITY;
            while let Some(&(q, h, from)) = self.0.last() {
                begin = ((height + at * at) - (h + q * q)) / (2.0 * (at - q));
                if begin > from {
                    break;
                }
                self.0.pop();
                begin = f64::NEG_INFINITY;
            }
            self.0.push((at, height, begin));
        }
        if self.0.is_empty() {
            return;
        }
        let mut current = 0;
        for (k, value) in line.iter_mut().enumerate() {
            let at = k as f64 * spacing;
            while self.0.get(current + 1).is_some_and(|next| next.2 <= at) {
                current += 1;
            }
            let (q, h, _) = self.0[current];
            *value = h + (at - q) * (at - q);
        }
    }
}
