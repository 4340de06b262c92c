//! The voxel that lies deepest inside a segment.
//!
//! A label's point on a segment has to lie inside it, which a centroid need not. The pole of inaccessibility does: of all voxels of
//! the segment it is the one whose centre is farthest from any voxel centre outside. Distances come from the exact separable
//! Euclidean distance transform of Felzenszwalb and Huttenlocher ("Distance Transforms of Sampled Functions", 2012): per axis the
//! lower envelope of parabolas. Owns its field of distances for the time of the call; it knows no volume, only the mask's closure.

use glam::DVec3;

/// The deepest voxel of a mask and how deep it lies.
///
/// - `mask(i, j, k)` says whether a voxel belongs to the segment; it is asked once for every voxel of the box, i fastest.
/// - `size` counts the box's voxels per axis; what lies outside the box is outside the segment.
/// - `spacing_mm` is the distance of neighbouring voxel centres per axis, mm, above 0.
///
/// Returns the voxel's index in the box and its depth in mm: the distance from its centre to the nearest centre outside. Of equally
/// deep voxels the one nearest to the segment's centroid is taken, then the first in storage order. `None` if the mask is empty, or
/// a spacing is not a number above 0.
#[must_use]
pub fn pole(
    mask: &dyn Fn(usize, usize, usize) -> bool,
    size: [usize; 3],
    spacing_mm: DVec3,
) -> Option<([usize; 3], f64)> {
    if size.contains(&0) || !spacing_mm.to_array().iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    // One layer of outside all round takes the place of everything beyond the box: nothing farther out is nearer.
    let padded = size.map(|n| n + 2);
    let strides = [1, padded[0], padded[0] * padded[1]];
    let mut squared = vec![0.0; padded[0] * padded[1] * padded[2]];
    let (mut count, mut sum) = (0_u64, DVec3::ZERO);
    for k in 0..size[2] {
        for j in 0..size[1] {
            for i in 0..size[0] {
                if mask(i, j, k) {
                    squared[(i + 1) + (j + 1) * strides[1] + (k + 1) * strides[2]] = f64::INFINITY;
                    count += 1;
                    sum += DVec3::new(i as f64, j as f64, k as f64);
                }
            }
        }
    }
    if count == 0 {
        return None;
    }
    let centroid = sum / count as f64;
    for axis in 0..3 {
        let (across, along) = ([(axis + 1) % 3, (axis + 2) % 3], padded[axis]);
        let mut line = Line::new(along, spacing_mm[axis]);
        for b in 0..padded[across[1]] {
            for a in 0..padded[across[0]] {
                line.transform(&mut squared, a * strides[across[0]] + b * strides[across[1]], strides[axis]);
            }
        }
    }
    let mut best: Option<([usize; 3], f64, f64)> = None;
    for k in 0..size[2] {
        for j in 0..size[1] {
            for i in 0..size[0] {
                let depth = squared[(i + 1) + (j + 1) * strides[1] + (k + 1) * strides[2]];
                if depth <= 0.0 {
                    continue;
                }
                let off = ((DVec3::new(i as f64, j as f64, k as f64) - centroid) * spacing_mm).length_squared();
                let better = best.is_none_or(|(_, held, held_off)| {
                    // Equal up to rounding: sums of the same squares in another order differ in their last bits.
                    let slack = 1e-9 * held.max(depth);
                    depth > held + slack || (depth >= held - slack && off < held_off - 1e-9 * held_off.max(off))
                });
                if better {
                    best = Some(([i, j, k], depth, off));
                }
            }
        }
    }
    best.map(|(voxel, depth, _)| (voxel, depth.sqrt()))
}

/// Room for the transform of one line of samples.
struct Line {
    step: f64,
    values: Vec<f64>,
    /// Samples whose parabolas make the lower envelope, and where each takes over, in mm.
    holds: Vec<usize>,
    from: Vec<f64>,
}

impl Line {
    fn new(samples: usize, step: f64) -> Self {
        Self { step, values: vec![0.0; samples], holds: Vec::with_capacity(samples), from: Vec::with_capacity(samples) }
    }

    /// Replaces f by min over q of (p − q)² + f(q) along one line of the field.
    fn transform(&mut self, field: &mut [f64], first: usize, stride: usize) {
        for (n, value) in self.values.iter_mut().enumerate() {
            *value = field[first + n * stride];
        }
        self.holds.clear();
        self.from.clear();
        for q in 0..self.values.len() {
            if self.values[q].is_infinite() {
                continue;
            }
            let at = q as f64 * self.step;
            let mut start = f64::NEG_INFINITY;
            while let (Some(&held), Some(&since)) = (self.holds.last(), self.from.last()) {
                let before = held as f64 * self.step;
                // Where the two parabolas meet.
                start = (self.values[q] - self.values[held] + at * at - before * before) / (2.0 * (at - before));
                if start > since {
                    break;
                }
                self.holds.pop();
                self.from.pop();
                start = f64::NEG_INFINITY;
            }
            self.holds.push(q);
            self.from.push(start);
        }
        let mut piece = 0;
        for p in 0..self.values.len() {
            let at = p as f64 * self.step;
            while piece + 1 < self.from.len() && self.from[piece + 1] < at {
                piece += 1;
            }
            if let Some(&held) = self.holds.get(piece) {
                let away = at - held as f64 * self.step;
                field[first + p * stride] = away * away + self.values[held];
            }
        }
    }
}
