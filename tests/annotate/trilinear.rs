//! A volume of samples at whole millimetres, as a surface.

use burin::annotate::surface::Surface;
use glam::DVec3;

pub struct Volume {
    pub size: [usize; 3],
    pub samples: Vec<f32>,
    pub iso: f64,
    /// Length of a voxel, mm; sample (i, j, k) lies at that times (i, j, k).
    pub voxel: f64,
}

impl Volume {
    pub fn of(size: [usize; 3], voxel: f64, iso: f64, field: impl Fn(DVec3) -> f64) -> Self {
        let mut samples = Vec::with_capacity(size.iter().product());
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    samples.push(field(DVec3::new(i as f64, j as f64, k as f64) * voxel) as f32);
                }
            }
        }
        Self { size, samples, iso, voxel }
    }

    fn at(&self, i: usize, j: usize, k: usize) -> f64 {
        f64::from(self.samples[(k * self.size[1] + j) * self.size[0] + i])
    }

    fn cell(&self, p: DVec3) -> Option<([usize; 3], [f64; 3])> {
        let p = (p / self.voxel).to_array();
        let mut cell = [0; 3];
        let mut share = [0.0; 3];
        for axis in 0..3 {
            if !(p[axis] >= 0.0 && p[axis] <= (self.size[axis] - 1) as f64) {
                return None;
            }
            cell[axis] = (p[axis] as usize).min(self.size[axis] - 2);
            share[axis] = p[axis] - cell[axis] as f64;
        }
        Some((cell, share))
    }

    fn central(&self, at: [usize; 3]) -> DVec3 {
        let mut g = [0.0; 3];
        for axis in 0..3 {
            let (mut low, mut high) = (at, at);
            low[axis] = low[axis].saturating_sub(1);
            high[axis] = (high[axis] + 1).min(self.size[axis] - 1);
            let gap = (high[axis] - low[axis]) as f64 * self.voxel;
            g[axis] = (self.at(high[0], high[1], high[2]) - self.at(low[0], low[1], low[2])) / gap;
        }
        DVec3::from_array(g)
    }
}

impl Surface for Volume {
    fn value(&self, p: DVec3) -> Option<f64> {
        let ([i, j, k], s) = self.cell(p)?;
        let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let line = |j, k| lerp(self.at(i, j, k), self.at(i + 1, j, k), s[0]);
        let face = |k| lerp(line(j, k), line(j + 1, k), s[1]);
        Some(lerp(face(k), face(k + 1), s[2]) - self.iso)
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        let (cell, s) = self.cell(p)?;
        let mut sum = DVec3::ZERO;
        for corner in 0..8_usize {
            let bit = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f64 = (0..3).map(|axis| if bit[axis] == 1 { s[axis] } else { 1.0 - s[axis] }).product();
            sum += self.central([cell[0] + bit[0], cell[1] + bit[1], cell[2] + bit[2]]) * weight;
        }
        Some(sum)
    }
}
