//! Values of a box of voxels and what neighbourhoods make of them: Gaussian means, medians, slopes, values between voxels.
//!
//! Lengths are mm along the voxel axes, on any grid. Numbers are those that texels hold, in steps of the storage; what is not a number takes
//! no part. Beyond the volume's border its outermost voxels go on. Every number is reckoned from its own neighbourhood in one order, whatever
//! box it is asked in, so that bricks agree where they repeat each other's voxels. Knows no brushes.

use crate::math::DVec3;
use crate::volume::{Field, SourceError, TexelFormat};

/// A Gaussian ends at so many σ.
const ENDS: f64 = 3.0;

/// Values of a box, x fastest; `lo` may lie outside the volume.
#[derive(Clone, Debug)]
pub struct Block {
    /// The voxel of the first value.
    pub lo: [i64; 3],
    /// Values along each axis.
    pub size: [usize; 3],
    /// NaN where there is none.
    pub values: Vec<f32>,
    /// Whether there may be none.
    pub gaps: bool,
}

/// How far a Gaussian reaches along each axis, voxels.
pub(super) fn reach(sigma_mm: f64, spacing: DVec3) -> [usize; 3] {
    spacing.to_array().map(|h| (ENDS * sigma_mm / h * (1.0 + 1e-9)).floor() as usize)
}

impl Block {
    /// Of a field at its finest level.
    ///
    /// # Errors
    /// If the source fails.
    pub fn read(field: &Field, lo: [i64; 3], size: [usize; 3]) -> Result<Self, SourceError> {
        Self::read_at(field, 0, lo, size)
    }

    /// Of a field at a level.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn read_at(field: &Field, level: u8, lo: [i64; 3], size: [usize; 3]) -> Result<Self, SourceError> {
        let bytes = field.read(level, lo, size.map(|s| s as u32))?;
        let values = match field.format() {
            TexelFormat::R8Unorm => bytes.iter().map(|&code| f32::from(code)).collect(),
            TexelFormat::R16Unorm | TexelFormat::R16Uint => {
                bytes.chunks_exact(2).map(|t| f32::from(u16::from_le_bytes([t[0], t[1]]))).collect()
            }
            TexelFormat::R32Float => {
                let value = |t: &[u8]| f32::from_le_bytes([t[0], t[1], t[2], t[3]]);
                bytes.chunks_exact(4).map(value).map(|v| if v.is_finite() { v } else { f32::NAN }).collect()
            }
            TexelFormat::Rgba8Unorm => vec![f32::NAN; bytes.len() / 4],
        };
        Ok(Self { lo, size, values, gaps: field.format() == TexelFormat::R32Float })
    }

    /// The value of a voxel within the box.
    pub fn at(&self, voxel: [i64; 3]) -> f32 {
        let [x, y, z] = std::array::from_fn(|a| (voxel[a] - self.lo[a]).clamp(0, self.size[a] as i64 - 1) as usize);
        self.values[x + self.size[0] * (y + self.size[1] * z)]
    }

    /// The mean of every voxel's neighbourhood, weighted by e^(−d²/2σ²) out to 3 σ along each axis; smaller by that reach on every side.
    pub fn gaussian(&self, sigma_mm: f64, spacing: DVec3) -> Self {
        let mut sum = self.clone();
        let mut weight = self.clone();
        if self.gaps {
            weight.values = self.values.iter().map(|v| if v.is_nan() { 0.0 } else { 1.0 }).collect();
            sum.values.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
        }
        for axis in 0..3 {
            let taps = taps(sigma_mm, spacing[axis]);
            sum = sum.convolved(axis, &taps);
            if self.gaps {
                weight = weight.convolved(axis, &taps);
            }
        }
        if self.gaps {
            let mean = |(sum, weight): (&f32, &f32)| if *weight > 0.0 { sum / weight } else { f32::NAN };
            sum.values = sum.values.iter().zip(&weight.values).map(mean).collect();
        }
        sum
    }

    /// Weighted along an axis; smaller by the taps' reach on both sides.
    fn convolved(&self, axis: usize, taps: &[f32]) -> Self {
        let reach = taps.len() / 2;
        let (mut lo, mut size) = (self.lo, self.size);
        lo[axis] += reach as i64;
        size[axis] -= 2 * reach;
        let stride = [1, self.size[0], self.size[0] * self.size[1]][axis];
        let mut values = vec![0.0; size.iter().product()];
        for z in 0..size[2] {
            for y in 0..size[1] {
                let row = &mut values[size[0] * (y + size[1] * z)..][..size[0]];
                let from = self.size[0] * (y + self.size[1] * z);
                for (n, tap) in taps.iter().enumerate() {
                    let source = &self.values[from + n * stride..][..size[0]];
                    row.iter_mut().zip(source).for_each(|(sum, value)| *sum += tap * value);
                }
            }
        }
        Self { lo, size, values, gaps: self.gaps }
    }

    /// The median of the values whose voxels lie within a radius of a voxel, the mean of both middle ones where they are even in number.
    pub fn median(&self, voxel: [i64; 3], offsets: &[[i64; 3]], gathered: &mut Vec<f32>) -> f32 {
        gathered.clear();
        let near = offsets.iter().map(|o| self.at(std::array::from_fn(|a| voxel[a] + o[a])));
        gathered.extend(near.filter(|v| !v.is_nan()));
        let middle = gathered.len() / 2;
        if gathered.is_empty() {
            return f32::NAN;
        }
        let even = gathered.len().is_multiple_of(2);
        let (below, upper, _) = gathered.select_nth_unstable_by(middle, f32::total_cmp);
        let lower = below.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        if even { (lower + *upper) * 0.5 } else { *upper }
    }

    /// Central differences by index, in numbers per voxel; 0 where a neighbour has none.
    pub fn slope(&self, voxel: [i64; 3]) -> DVec3 {
        let beside = |axis: usize, step: i64| {
            let mut at = voxel;
            at[axis] += step;
            f64::from(self.at(at))
        };
        let slope = DVec3::from_array([0, 1, 2].map(|axis| (beside(axis, 1) - beside(axis, -1)) * 0.5));
        if slope.is_finite() { slope } else { DVec3::ZERO }
    }

    /// The slope at a continuous index, between those of the eight voxels around it.
    pub fn slope_between(&self, at: DVec3) -> DVec3 {
        let base = at.floor();
        let part = at - base;
        let corner = |n: i64| {
            let step = [n & 1, n >> 1 & 1, n >> 2];
            let share: f64 = (0..3).map(|a| if step[a] == 1 { part[a] } else { 1.0 - part[a] }).product();
            self.slope(std::array::from_fn(|a| base[a] as i64 + step[a])) * share
        };
        (0..8).map(corner).sum()
    }

    /// The value at a continuous index by Catmull-Rom splines, never beyond the eight values around it; where one of those is missing, by
    /// the mean of the rest, weighted as between them.
    pub fn between(&self, at: DVec3) -> f32 {
        let base = at.floor();
        let part = at - base;
        let base: [i64; 3] = base.to_array().map(|v| v as i64);
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        let (mut sum, mut weight) = (0.0, 0.0);
        for corner in 0..8_i64 {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let value = self.at(std::array::from_fn(|a| base[a] + step[a]));
            let share: f64 = (0..3).map(|a| if step[a] == 1 { part[a] } else { 1.0 - part[a] }).product();
            if !value.is_nan() {
                (low, high) = (low.min(value), high.max(value));
                sum += share * f64::from(value);
                weight += share;
            }
        }
        if low == high || weight <= 0.0 {
            return if weight > 0.0 { low } else { f32::NAN };
        }
        if weight < 1.0 - 1e-9 {
            return (sum / weight) as f32;
        }
        let [wx, wy, wz] = part.to_array().map(catmull_rom);
        let mut total = 0.0;
        for (k, wz) in wz.iter().enumerate() {
            for (j, wy) in wy.iter().enumerate() {
                let mut row = 0.0;
                for (i, wx) in wx.iter().enumerate() {
                    let voxel = [base[0] + i as i64 - 1, base[1] + j as i64 - 1, base[2] + k as i64 - 1];
                    row += wx * f64::from(self.at(voxel));
                }
                total += wy * wz * row;
            }
        }
        if total.is_nan() { (sum / weight) as f32 } else { (total as f32).clamp(low, high) }
    }
}

/// Weights of a Gaussian along an axis; they add up to 1.
fn taps(sigma_mm: f64, spacing: f64) -> Vec<f32> {
    let reach = reach(sigma_mm, DVec3::splat(spacing))[0] as i64;
    let weight = |k: i64| {
        let x = k as f64 * spacing / sigma_mm;
        if k == 0 { 1.0 } else { (-0.5 * x * x).exp() }
    };
    let sum: f64 = (-reach..=reach).map(weight).sum();
    (-reach..=reach).map(|k| (weight(k) / sum) as f32).collect()
}

/// Weights of the four values about a place, `t` from the second to the third.
fn catmull_rom(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [(-t3 + 2.0 * t2 - t) * 0.5, (3.0 * t3 - 5.0 * t2 + 2.0) * 0.5, (-3.0 * t3 + 4.0 * t2 + t) * 0.5, (t3 - t2) * 0.5]
}

/// Voxels whose centres lie within a radius of a voxel's, mm along the voxel axes.
pub(super) fn ball(radius_mm: f64, spacing: DVec3) -> Vec<[i64; 3]> {
    let most = spacing.to_array().map(|h| (radius_mm / h * (1.0 + 1e-9)).floor() as i64);
    let limit = radius_mm * radius_mm * (1.0 + 1e-9);
    let mut offsets = Vec::new();
    for z in -most[2]..=most[2] {
        for y in -most[1]..=most[1] {
            for x in -most[0]..=most[0] {
                if (DVec3::new(x as f64, y as f64, z as f64) * spacing).length_squared() <= limit {
                    offsets.push([x, y, z]);
                }
            }
        }
    }
    offsets
}
