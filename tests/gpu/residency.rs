//! Which bricks are held where not all fit, against a choice made by looking at everything in every turn.

use super::pools::{NOISE, blanks, budget_of, fields, noisy};
use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{Body, FieldPools, Frame, Mask, SliceCut};
use burin::math::{Camera, DVec3, Plane, Pose, Projection};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
        // Of equal ones the first, x before y before z.
        let Some(&next) = ahead.max_by(|a, b| gain(a).total_cmp(&gain(b)).then(b.cmp(a))) else { break };
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

/// Matter so thin that nothing hides anything, to the last bit.
fn thin() -> TransferFunction {
    TransferFunction { opacity: vec![(0.0, 1e-12)], ..ramp(0.0, 4000.0) }
}

/// Pixels of a picture 64 high along a voxel's edge at the nearest corner of each brick, a voxel of its neighbours included.
fn pixels(camera: &Camera, bricks: [u32; 3]) -> Vec<f64> {
    let ahead = (camera.target - camera.eye).normalize();
    each(bricks, |b| {
        let lo = DVec3::from_array(b.map(|b| f64::from(b) * 32.0 - 1.0));
        let corner = |i: u32| lo + 33.0 * DVec3::from_array(std::array::from_fn(|a| f64::from(i >> a & 1)));
        let nearest = (0..8).map(|i| (corner(i) - camera.eye).dot(ahead)).fold(f64::INFINITY, f64::min);
        match camera.projection {
            Projection::Orthographic { height_mm } => 64.0 / height_mm,
            Projection::Perspective { fov_y_deg } => 64.0 / (2.0 * (fov_y_deg.to_radians() / 2.0).tan() * nearest),
        }
    })
}

#[test]
fn the_bricks_with_most_to_gain_are_refined_first_and_every_slot_is_used() {
    let Some(gpu) = gpu() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    for (bricks, views) in [([5, 1, 1], 12), ([1, 4, 3], 6), ([3, 2, 3], 4)] {
        let grid = unit_grid(bricks.map(|b| b * 32 - 5));
        let density = noisy(grid);
        let none = blanks(&grid);
        let count = bricks.iter().product::<u32>() as usize;
        let middles = each(bricks, |b| b.map(|b| b as f32 * 32.0 + 12.0));
        let mut drawn = BTreeSet::new();
        for view in 0..views {
            let mut picture = frame(&grid, thin(), DVec3::X, [64, 64]);
            let direction = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            // Every other one from the middle of a side, so that one end is much nearer.
            let aside = view % 2 == 0;
            let direction = if aside { direction } else { direction * 0.2 + DVec3::from_array(bricks.map(f64::from)) };
            let projection = match view {
                0 => Projection::Orthographic { height_mm: 1.0 },
                _ => Projection::Perspective { fov_y_deg: 80.0 },
            };
            let camera = Camera::framing_in(&grid.world_bounds(), direction, DVec3::Z, projection);
            picture.camera = camera;
            let pixels = pixels(&camera, bricks);
            for room in 1..count {
                let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(room)).unwrap();
                let most = pools.room(FieldKind::Density).1;
                pools.make_resident(&gpu, &fields(&density, &none), &picture).unwrap();
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

#[test]
fn what_is_hidden_or_outside_the_picture_waits() {
    let Some(gpu) = gpu() else { return };
    let bricks = [5, 1, 1];
    let grid = unit_grid([155, 27, 27]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let middles = each(bricks, |b| b.map(|b| b as f32 * 32.0 + 12.0));
    let opaque = TransferFunction { opacity: vec![(0.0, 1.0)], ..ramp(0.0, 4000.0) };
    let seen_from = |direction: DVec3, at: f64, height_mm: f64| {
        let target = DVec3::new(at, 13.0, 13.0);
        let projection = Projection::Orthographic { height_mm };
        Camera { eye: target + direction * 300.0, target, up: DVec3::Z, projection }
    };
    // Behind others a brick counts for a twentieth, beside the picture for a fiftieth.
    let cases = [
        (opaque.clone(), seen_from(DVec3::NEG_X, 77.0, 200.0), [1.0, 0.05, 0.05, 0.05, 0.05]),
        (opaque.clone(), seen_from(DVec3::X, 77.0, 200.0), [0.05, 0.05, 0.05, 0.05, 1.0]),
        (opaque.clone(), seen_from(DVec3::Y, 77.0, 200.0), [1.0; 5]),
        (thin(), seen_from(DVec3::X, 77.0, 200.0), [1.0; 5]),
        (thin(), seen_from(DVec3::NEG_Y, 80.0, 20.0), [0.02, 0.02, 1.0, 0.02, 0.02]),
        (thin(), seen_from(DVec3::Z, 112.0, 20.0), [0.02, 0.02, 0.02, 1.0, 0.02]),
        (opaque, seen_from(DVec3::NEG_Y, 112.0, 20.0), [0.02, 0.02, 0.02, 1.0, 0.02]),
    ];
    for (transfer, camera, weights) in cases {
        let picture = Frame { camera, ..frame(&grid, transfer, DVec3::X, [64, 64]) };
        for room in 1..5 {
            let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(room)).unwrap();
            let most = pools.room(FieldKind::Density).1;
            pools.make_resident(&gpu, &fields(&density, &none), &picture).unwrap();
            let levels: Vec<u32> = sample(&gpu, &pools, &middles).iter().map(|s| s.level).collect();
            assert_eq!(levels, greedy(bricks, &weights, most), "{camera:?} {room} slots of {most}");
        }
    }
}

fn any(rng: &mut ChaCha8Rng, s: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)))
}

/// One to three parts of the volume, of whatever mask, moved or not.
fn parts(rng: &mut ChaCha8Rng, middle: DVec3) -> Vec<Body> {
    let masks = [Mask::None, Mask::Selection, Mask::Background];
    (0..rng.random_range(1..4))
        .map(|id| Body {
            pose: Pose { translation: any(rng, 60.0), ..Pose::IDENTITY },
            region: Plane::through(middle + any(rng, 30.0), any(rng, 1.0)).into_iter().collect(),
            mask: masks[rng.random_range(0..3)],
            ..Body::whole(id)
        })
        .collect()
}

#[test]
fn what_is_held_is_what_is_asked_for_whatever_was_before() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([150, 90, 60]);
    let bricks = [5, 3, 2];
    let middle = grid.world_bounds().centre();
    let points = each(bricks.map(|b| b * 4), |v| v.map(|v| v as f32 * 8.0 + 3.0).map(|x| x.min(140.0)));
    let points: Vec<[f32; 3]> =
        points.into_iter().filter(|p| (0..3).all(|a| p[a] < grid.dims[a] as f32 - 1.0)).collect();
    for (slots, seed) in [(64, 1), (9, 2), (17, 3)] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut density = noisy(grid);
        let mut rest = blanks(&grid);
        let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
        let mut picture = frame(&grid, ramp(0.0, 4000.0), DVec3::X, [64, 64]);
        picture.camera = picture.camera.zoomed(0.5);
        let mut slices: [Option<u32>; 3] = [None; 3];
        for turn in 0..26 {
            let index = BrickIndex(bricks.map(|n| rng.random_range(0..n)));
            let edit = |value: u8, bytes: usize| {
                // Codes from 1024 on, or shares of the selection.
                let texel = |value: u8| if bytes == 2 { vec![value, 4] } else { vec![value] };
                let texels = (0..BRICK_VOXELS)
                    .flat_map(|i| texel(if (i / 977).is_multiple_of(3) { value } else { 3 }))
                    .collect();
                let uniform = Brick::Uniform([value, if bytes == 2 { 4 } else { 0 }, 0, 0]);
                vec![(index, Some(if value.is_multiple_of(2) { uniform } else { Brick::from_texels(texels, bytes) }))]
            };
            let value: u8 = rng.random_range(0..=255);
            match turn % 9 {
                0 => picture.camera.eye = middle + any(&mut rng, 260.0),
                1 => picture.size = [[64, 64], [200, 50], [50, 200]][rng.random_range(0..3)],
                2 => picture.bodies = parts(&mut rng, middle),
                6 => {
                    // All but the last stay as they are.
                    picture.bodies.push(Body::whole(7));
                    let last = parts(&mut rng, middle).remove(0);
                    *picture.bodies.last_mut().unwrap() = Body { mask: Mask::None, ..last };
                    pools.make_resident(&gpu, &fields(&density, &rest), &picture).unwrap();
                    picture.bodies.last_mut().unwrap().region = parts(&mut rng, middle).remove(0).region;
                }
                3 => picture.mode = [Mode::Dvr, Mode::Mip, Mode::Iso(2500.0)][rng.random_range(0..3)],
                4 => picture.transfer = ramp(rng.random_range(-100.0..3900.0), 4000.0),
                5 => {
                    let axis = rng.random_range(0..3);
                    slices[axis] = Some(rng.random_range(0..grid.dims[axis]));
                    pools
                        .make_slice_resident(
                            &gpu,
                            &fields(&density, &rest),
                            VolumeId::FIRST,
                            SliceCut::Row { axis, index: slices[axis].unwrap() },
                        )
                        .unwrap();
                }
                7 => {
                    let (_, refresh) = density.swap(edit(value, 2)).unwrap();
                    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
                }
                _ => {
                    let (_, refresh) = rest[1].swap(edit(value, 1)).unwrap();
                    pools.refresh(&gpu, FieldKind::Selection, &rest[1], &refresh).unwrap();
                }
            }
            if rng.random_bool(0.3) {
                pools.bound_uploads(Some(1));
                pools.make_resident(&gpu, &fields(&density, &rest), &picture).unwrap();
                pools.bound_uploads(None);
            }
            pools.make_resident(&gpu, &fields(&density, &rest), &picture).unwrap();
            let mut fresh = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
            for (axis, at) in slices.iter().enumerate().filter_map(|(axis, at)| Some((axis, (*at)?))) {
                fresh
                    .make_slice_resident(
                        &gpu,
                        &fields(&density, &rest),
                        VolumeId::FIRST,
                        SliceCut::Row { axis, index: at },
                    )
                    .unwrap();
            }
            fresh.make_resident(&gpu, &fields(&density, &rest), &picture).unwrap();
            let (was, is) = (sample(&gpu, &fresh, &points), sample(&gpu, &pools, &points));
            for (p, (a, b)) in points.iter().zip(was.iter().zip(&is)) {
                assert_eq!((a.level, a.skip), (b.level, b.skip), "{slots} slots, turn {turn}, {p:?}");
                let near =
                    f64::from((a.density - b.density).abs()) <= NOISE && (a.selection - b.selection).abs() < 0.01;
                assert!(near, "{slots} slots, turn {turn}, {p:?}: {a:?} {b:?}");
            }
        }
    }
}
