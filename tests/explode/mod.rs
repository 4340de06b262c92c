//! Parts, splitters, forces, rigid bodies and the measured gain.

mod forces;
mod gain;
mod octree;
mod parts;
mod picture;
mod poses;
mod simulation;
mod splitters;

use burin::explode::Explosion;
use burin::math::{DAffine3, DMat3, DQuat, DVec3};
use burin::volume::Grid;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// An anisotropic, turned and shifted grid.
pub fn oblique() -> Grid {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7));
    let matrix3 = turn * DMat3::from_diagonal(DVec3::new(0.7, 1.1, 2.5));
    Grid { dims: [90, 70, 33], world_from_index: DAffine3 { matrix3, translation: DVec3::new(-40.0, 13.0, 77.0) } }
}

/// A cube of `n` voxels of 1 mm about the origin.
pub fn cube(n: u32) -> Grid {
    Grid::aligned([n; 3], DVec3::ONE, DVec3::splat(0.5 - f64::from(n) * 0.5))
}

/// Eight octants: split by three planes through the centre.
pub fn octants(grid: &Grid) -> Explosion {
    let mut explosion = Explosion::whole(grid);
    let centre = explosion.parts[0].centre();
    for axis in DVec3::AXES {
        let plane = burin::math::Plane::through(centre, axis).unwrap();
        for id in explosion.parts.iter().map(|p| p.id).collect::<Vec<_>>() {
            assert!(explosion.split_at_rest(id, &plane).unwrap().is_some());
        }
    }
    explosion
}

pub fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
    loop {
        let v = DVec3::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}
