//! Surface particles by the book, in f64, from the voxels' own numbers.

use super::pools::blanks;
use crate::common::volumes::{density_f32, density_u16, one_volume};
use burin::gpu::{Fields, GridRequest};
use burin::math::DVec3;
use burin::volume::*;

/// A volume, and its voxels as numbers.
pub struct Stored {
    pub grid: Grid,
    pub density: Field,
    rest: [Field; 3],
    values: Vec<f64>,
}

impl Stored {
    fn made(grid: Grid, density: Field) -> Self {
        let mut values = vec![0.0; grid.voxel_count() as usize];
        density.values([0; 3], grid.dims).unwrap().each(|i, number| values[i] = number.to_f64());
        Self { grid, density, rest: blanks(&grid), values }
    }

    /// Of the value at each voxel's place in the world.
    pub fn new(grid: Grid, of: impl Fn(DVec3) -> u16) -> Self {
        let place = |v: [u32; 3]| grid.world_from_index.transform_point3(DVec3::from_array(v.map(f64::from)));
        Self::made(grid, density_u16(grid, |v| of(place(v))))
    }

    pub fn of_floats(grid: Grid, of: impl Fn(DVec3) -> f32) -> Self {
        let place = |v: [u32; 3]| grid.world_from_index.transform_point3(DVec3::from_array(v.map(f64::from)));
        Self::made(grid, density_f32(grid, |v| of(place(v))))
    }

    pub fn of(volume: &Volume) -> Self {
        Self::made(*volume.grid(), volume.density.clone())
    }

    pub fn fields(&self) -> Fields<'_> {
        let [colour, selection, labels] = &self.rest;
        one_volume(&self.grid, &self.density, colour, selection, labels)
    }

    fn voxel(&self, v: [i64; 3]) -> f64 {
        let at = |a: usize| v[a].clamp(0, i64::from(self.grid.dims[a]) - 1) as usize;
        let [nx, ny, _] = self.grid.dims.map(|d| d as usize);
        self.values[at(0) + nx * (at(1) + ny * at(2))]
    }

    /// Between eight voxels, of whatever each of them has.
    fn between(&self, index: DVec3, of: impl Fn([i64; 3]) -> DVec3) -> DVec3 {
        let lo = index.floor();
        let t = index - lo;
        let mut sum = DVec3::ZERO;
        for corner in 0..8 {
            let up = |a: usize| corner >> a & 1;
            let weight: f64 = (0..3).map(|a| if up(a) == 1 { t[a] } else { 1.0 - t[a] }).product();
            sum += weight * of(std::array::from_fn(|a| lo[a] as i64 + up(a)));
        }
        sum
    }

    /// The trilinear value at a place in the world.
    pub fn value(&self, world: DVec3) -> f64 {
        let index = self.grid.index_from_world().transform_point3(world);
        self.between(index, |v| DVec3::splat(self.voxel(v))).x
    }

    /// The paper's gradient, per mm: central differences at the centres of voxels, and what lies between.
    pub fn gradient(&self, world: DVec3) -> DVec3 {
        let to_index = self.grid.index_from_world();
        let central = |v: [i64; 3]| {
            DVec3::from_array(std::array::from_fn(|a| {
                let beside = |by: i64| {
                    let mut v = v;
                    v[a] += by;
                    self.voxel(v)
                };
                0.5 * (beside(1) - beside(-1))
            }))
        };
        to_index.matrix3.transpose() * self.between(to_index.transform_point3(world), central)
    }
}

/// How far along a line the trilinear value is `iso`, mm, by bisection of the nearest interval that it crosses it in; infinite if that is
/// further than a voxel.
pub fn distance_to_surface(stored: &Stored, iso: f64, at: DVec3, along: DVec3) -> f64 {
    let excess = |t: f64| stored.value(at + along * t) - iso;
    let start = excess(0.0);
    if start == 0.0 {
        return 0.0;
    }
    let step = 0.01 * stored.grid.voxel_mm();
    for i in 1..=100 {
        for sense in [1.0, -1.0] {
            let [mut near, mut far] = [f64::from(i - 1), f64::from(i)].map(|k| sense * step * k);
            if excess(near) * excess(far) > 0.0 {
                continue;
            }
            for _ in 0..40 {
                let middle = 0.5 * (near + far);
                if excess(near) * excess(middle) <= 0.0 { far = middle } else { near = middle }
            }
            return near.abs();
        }
    }
    f64::INFINITY
}

/// Where a particle is after 0, 1, … steps: equations 4 and 5, each place traced back along the normal of the one before to where the value
/// is the iso-value.
pub fn plain_spine(stored: &Stored, request: &GridRequest, sense: f64) -> Vec<DVec3> {
    let normal = |at: DVec3| -stored.gradient(at).normalize();
    let back = |from: DVec3, n: DVec3| {
        // Outward while the value is too high.
        let excess = |t: f64| stored.value(from + n * t) - request.iso;
        let sign = excess(0.0).signum();
        let mut far = 0.0;
        while excess(far).signum() == sign {
            far += sign * 0.02 * stored.grid.voxel_mm();
        }
        let mut near = far - sign * 0.02 * stored.grid.voxel_mm();
        for _ in 0..50 {
            let middle = 0.5 * (near + far);
            if excess(middle).signum() == sign { near = middle } else { far = middle }
        }
        from + n * near
    };
    let tangent = |o: DVec3, n: DVec3| n.cross(o.cross(n)).normalize();
    let mut at = back(request.centre, normal(request.centre));
    let mut f = tangent(request.along, normal(at));
    let mut path = vec![at];
    for _ in 0..request.steps[0] {
        let n = normal(at);
        at = back(at + sense * request.step_mm * f, n);
        f = tangent(f, normal(at));
        path.push(at);
    }
    path
}
