//! Which bricks are held where not all fit, against a choice made by looking at everything in every turn.

use super::pools::{blanks, budget_of, fields, noisy};
use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::FieldPools;
use burin::math::{Camera, DVec3, Projection};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use std::collections::{BTreeMap, BTreeSet};

/// Level and place.
type Key = (u32, [u32; 3]);

fn above(key: Key) -> Key {
    (key.0 + 1, key.1.map(|b| b / 2))
}

/// The level that each brick of level 0 is drawn from. Begins with the one brick of the coarsest level; in each turn one brick
/// is taken in below one that was: that with the largest difference between the voxels of the two, in pixels, of those for
/// which there is room. A brick whose last part is taken in gives up its own place.
fn greedy(bricks: [u32; 3], pixels: &[f64], room: usize) -> Vec<u32> {
    let finest: Vec<Key> = each(bricks, |b| (0, b));
    let mut matters: BTreeMap<Key, f64> = BTreeMap::new();
    let top = (0..).find(|l| bricks.iter().all(|&n| n.div_ceil(1 << l) == 1)).unwrap();
    for (key, &pixels) in finest.iter().zip(pixels) {
        let mut key = *key;
        for _ in 0..=top {
            let most = matters.entry(key).or_insert(0.0);
            *most = most.max(pixels);
            key = above(key);
        }
    }
    let mut taken = BTreeSet::from([(top, [0; 3])]);
    let mut held = taken.clone();
    loop {
        let left = |of: Key| matters.keys().filter(|k| above(**k) == of && !taken.contains(*k)).count();
        let fits = |key: &Key| held.len() + 1 - usize::from(left(above(*key)) == 1) <= room;
        let gain = |key: &Key| matters[key] * f64::from(1_u32 << (key.0 + 1));
        let ahead = matters.keys().filter(|k| !taken.contains(*k) && taken.contains(&above(**k)) && fits(k));
        let Some(&next) = ahead.max_by(|a, b| gain(a).total_cmp(&gain(b))) else { break };
        if left(above(next)) == 1 {
            held.remove(&above(next));
        }
        taken.insert(next);
        held.insert(next);
    }
    let drawn = |mut key: Key| {
        while !held.contains(&key) {
            key = above(key);
        }
        key.0
    };
    finest.into_iter().map(drawn).collect()
}

/// Matter so thin that nothing hides anything.
fn thin() -> TransferFunction {
    TransferFunction { opacity: vec![(0.0, 1e-7)], ..ramp(0.0, 4000.0) }
}

#[test]
fn the_bricks_with_most_to_gain_are_refined_first_and_every_slot_is_used() {
    let Some(gpu) = gpu() else { return };
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(21);
    for (bricks, views) in [([5, 1, 1], 12), ([1, 4, 3], 6), ([3, 2, 3], 4)] {
        let grid = unit_grid(bricks.map(|b| b * 32 - 5));
        let density = noisy(grid);
        let none = blanks(&grid);
        let count = bricks.iter().product::<u32>() as usize;
        let middles = each(bricks, |b| b.map(|b| b as f32 * 32.0 + 12.0));
        let mut drawn = BTreeSet::new();
        for view in 0..views {
            let mut view_of = frame(&grid, thin(), DVec3::X, [64, 64]);
            let direction = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            // Every other one from the middle of a side, so that one end is much nearer.
            let direction =
                if view % 2 == 0 { direction } else { direction * 0.2 + DVec3::from_array(bricks.map(f64::from)) };
            let bounds = grid.world_bounds();
            view_of.camera =
                Camera::framing_in(&bounds, direction, DVec3::Z, Projection::Perspective { fov_y_deg: 80.0 });
            let camera = view_of.camera;
            let ahead = (camera.target - camera.eye).normalize();
            // Pixels along a voxel's edge at the brick's nearest corner, a voxel of its neighbours included.
            let pixels: Vec<f64> = each(bricks, |b| {
                let lo = DVec3::from_array(b.map(|b| f64::from(b) * 32.0 - 1.0));
                let corner = |i: u32| lo + 33.0 * DVec3::from_array(std::array::from_fn(|a| f64::from(i >> a & 1)));
                let nearest = (0..8).map(|i| (corner(i) - camera.eye).dot(ahead)).fold(f64::INFINITY, f64::min);
                64.0 / (2.0 * 40.0_f64.to_radians().tan() * nearest.max(1e-3))
            });
            for room in 1..count {
                let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(room)).unwrap();
                let most = pools.room(FieldKind::Density).1;
                pools.make_resident(&gpu, &fields(&density, &none), &view_of).unwrap();
                assert_eq!(pools.room(FieldKind::Density), (most, most), "{bricks:?}: no slot is wasted");
                let levels: Vec<u32> = sample(&gpu, &pools, &middles).iter().map(|s| s.level).collect();
                assert_eq!(
                    levels,
                    greedy(bricks, &pixels, most),
                    "{bricks:?} {room} slots of {most}, {camera:?} {pixels:?}"
                );
                drawn.insert(levels);
            }
        }
        assert!(drawn.len() > count - 1, "the view decides too: {drawn:?}");
    }
}
