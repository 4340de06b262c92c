//! What is nearest: bodies off the camera's axis, entered within one step of one another, equally dense, in any order.

use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use super::reference::{Dense, picture};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Image};
use burin::math::{Aabb, Camera, DQuat, DVec2, DVec3, Plane, Pose, Projection, Ray};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn any(rng: &mut ChaCha8Rng, s: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)))
}

/// Where a ray enters and leaves a box; nothing before the ray's origin.
fn crossing(bounds: &Aabb, ray: &Ray) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for a in 0..3 {
        let ends = [bounds.min[a], bounds.max[a]].map(|x| (x - ray.origin[a]) / ray.dir[a]);
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    (enter < leave).then_some([enter, leave])
}

fn rays(frame: &Frame) -> Vec<Ray> {
    let [w, h] = frame.size;
    let px = |i: u32| DVec2::new(f64::from(i % w) + 0.5, f64::from(i / w) + 0.5);
    (0..w * h).map(|i| frame.camera.ray(px(i), frame.size)).collect()
}

/// Share of pixels whose depth is further than `slack` from the expected one, or that show where nothing is, or nothing.
fn misplaced(image: &Image, expected: &[f64], slack: f64) -> f64 {
    let far = |(&a, &b): (&f32, &f64)| {
        f64::from(a) != b && (f64::from(a) - b).abs().partial_cmp(&slack).is_none_or(|o| o.is_gt())
    };
    image.depth_mm.iter().zip(expected).filter(|&pair| far(pair)).count() as f64 / expected.len() as f64
}

/// A dense cube of 40 mm, its first voxel at the origin.
fn cube() -> Option<(Stage, Aabb)> {
    let gpu = gpu()?;
    let grid = unit_grid([40; 3]);
    let bounds = grid.world_bounds();
    Some((Stage::new(gpu, grid, density_u16(grid, |_| 40_000)), bounds))
}

/// Every voxel is opaque.
fn solid() -> TransferFunction {
    TransferFunction { colour: vec![(0.0, [0.8, 0.4, 0.2])], opacity: vec![(0.0, 1.0)], unit_mm: 1.0 }
}

#[test]
fn an_orthographic_view_off_the_axis_begins_with_the_nearest_matter() {
    let Some((mut stage, _)) = cube() else { return };
    // Along the diagonal of two faces; the edge between them lies beside the picture's middle, 71.0 mm before the image plane.
    let forward = DVec3::new(1.0, 1.0, 0.0).normalize();
    let side = DVec3::new(1.0, -1.0, 0.0).normalize();
    let edge = DVec3::new(-0.5, -0.5, 19.5);
    let eye = edge - forward * 71.0 + side * 40.0;
    let camera = Camera {
        eye,
        target: eye + forward * 100.0,
        up: DVec3::Z,
        projection: Projection::Orthographic { height_mm: 110.0 },
    };
    let view = Frame { camera, ..frame(&stage.grid, solid(), DVec3::X, [96, 96]) };
    for mode in [Mode::Dvr, Mode::Iso(20_000.0), Mode::Mip] {
        let image = stage.image(&Frame { mode, ..view.clone() });
        let nearest = image.depth_mm.iter().copied().fold(f32::INFINITY, f32::min);
        // A pixel's ray passes the edge half a pixel beside it at most, and samples lie 1 mm apart.
        let slack = if let Mode::Iso(_) = mode { 0.6 } else { 1.6 };
        assert!((71.0..71.0 + slack).contains(&nearest), "{mode:?} {nearest}");
    }
}

#[test]
fn wherever_it_lies_in_the_picture_a_box_is_met_where_its_faces_are() {
    let Some((mut stage, bounds)) = cube() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut seen = 0;
    for n in 0..24 {
        let forward = any(&mut rng, 1.0).normalize();
        let (right, up) = forward.any_orthonormal_pair();
        let aside = right * rng.random_range(-70.0..70.0) + up * rng.random_range(-70.0..70.0);
        // Also with the eye, or the image plane, among the matter.
        let eye = bounds.centre() + aside - forward * rng.random_range(-10.0..90.0);
        let projection = match n % 2 {
            0 => Projection::Orthographic { height_mm: 150.0 },
            _ => Projection::Perspective { fov_y_deg: 110.0 },
        };
        let camera = Camera { eye, target: eye + forward * 50.0, up, projection };
        let view = Frame { camera, ..frame(&stage.grid, solid(), DVec3::X, [32, 24]) };
        let entries: Vec<_> =
            rays(&view).iter().map(|ray| crossing(&bounds, ray).map_or(f64::INFINITY, |t| t[0])).collect();
        // One pass, and steps so short that a ray takes several.
        for step_mm in if n < 4 { vec![1.0, 0.004] } else { vec![1.0] } {
            for mode in [Mode::Dvr, Mode::Iso(20_000.0), Mode::Mip] {
                let image = stage.image(&Frame { mode, step_mm, ..view.clone() });
                let far = misplaced(&image, &entries, step_mm + 1e-3);
                // Rays along an edge go either way, and may cross less than a step.
                assert!(far < 0.02, "{n} {mode:?} {step_mm}: {far}");
            }
        }
        seen += entries.iter().filter(|t| t.is_finite()).count();
    }
    assert!(seen > 1000, "{seen}");
}

/// Boxes about the middle of a volume in random poses, all over one another.
fn heap(rng: &mut ChaCha8Rng, middle: DVec3, count: u32) -> Vec<(Body, Aabb)> {
    (0..count)
        .map(|id| {
            let half = any(rng, 5.0).abs() + 6.0;
            let bounds = Aabb { min: middle - half, max: middle + half };
            let pose = Pose::about(middle, DQuat::from_scaled_axis(any(rng, 2.0)), any(rng, 6.0));
            let tint = Some(std::array::from_fn(|_| rng.random_range(0.2..1.0)));
            (Body { pose, region: bounds.planes().to_vec(), tint, ..Body::whole(id + 3) }, bounds)
        })
        .collect()
}

#[test]
fn of_parts_entered_within_one_step_the_nearest_is_the_surface() {
    let Some((mut stage, bounds)) = cube() else { return };
    for seed in 0..6 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let boxes = heap(&mut rng, bounds.centre(), 9);
        let mut view = frame(&stage.grid, solid(), any(&mut rng, 1.0), [48, 40]);
        view.camera = view.camera.zoomed(0.6);
        view.mode = Mode::Iso(20_000.0);
        view.bodies = boxes.iter().map(|(body, _)| body.clone()).collect();
        for view in projections(&view) {
            // All that shows are cut faces, wherever samples lie.
            let met = |ray: &Ray| {
                let entry = |(body, bounds): &(Body, Aabb)| {
                    crossing(bounds, &body.pose.unapply_ray(ray)).map(|t| (t[0], body.id + 1))
                };
                boxes.iter().filter_map(entry).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
            };
            let expected: Vec<_> = rays(&view).iter().map(met).collect();
            let depths: Vec<_> = expected.iter().map(|e| e.0).collect();
            let shown = depths.iter().filter(|t| t.is_finite()).count();
            assert!(shown > 500, "{shown}");
            for step_mm in if seed == 0 { vec![0.7, 8.0, 0.003] } else { vec![3.0, 8.0] } {
                let image = stage.image(&Frame { step_mm, ..view.clone() });
                let far = misplaced(&image, &depths, 2e-3);
                assert!(far < 0.003, "{seed} {step_mm} {:?}: {far}", view.camera.projection);
                let others =
                    image.object.iter().zip(&expected).filter(|(o, e)| o.body().map_or(0, |id| id + 1) != e.1).count();
                assert!(others < 8, "{seed} {step_mm}: {others} objects");
            }
        }
    }
}

#[test]
fn surfaces_of_overlapping_bodies_are_the_references_within_a_step() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([66, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    for seed in 0..3 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let middle = grid.world_bounds().centre();
        let mut view = frame(&grid, tissue(), any(&mut rng, 1.0), [48, 40]);
        view.mode = Mode::Iso(26_000.0);
        view.step_mm = 3.0;
        view.bodies = (0..5)
            .map(|id| {
                let pose = Pose::about(middle, DQuat::from_scaled_axis(any(&mut rng, 0.4)), any(&mut rng, 2.0));
                Body { id, pose, ..Body::whole(id) }
            })
            .collect();
        for view in projections(&view) {
            let image = stage.image(&view);
            let reference = picture(&Dense::of(&stage.fields(), &grid), &view);
            let depths: Vec<_> = reference.iter().map(|p| p.depth_mm).collect();
            let far = misplaced(&image, &depths, 0.1);
            assert!(far < 0.01, "{seed} {:?}: {far}", view.camera.projection);
        }
    }
}

/// Four plateaus of one value, and matter about them that is less.
fn plateaus(grid: Grid) -> Field {
    density_u16(grid, move |v| {
        let inside = v.iter().zip(grid.dims).all(|(x, n)| (4..12).contains(x) || (n - 14..n - 5).contains(x));
        if inside { 50_000 } else { 14_000 + (v[0] * 50 + v[1] * 70) as u16 }
    })
}

#[test]
fn of_equal_maxima_the_nearest_is_shown_with_its_depth_and_object() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([40, 36, 34]);
    let mut stage = Stage::new(gpu, grid, plateaus(grid));
    for seed in 0..3 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut view = frame(&grid, tissue(), any(&mut rng, 1.0), [48, 40]);
        view.mode = Mode::Mip;
        view.bodies = heap(&mut rng, grid.world_bounds().centre(), 4).into_iter().map(|(body, _)| body).collect();
        view.bodies.iter_mut().for_each(|b| b.region.clear());
        for view in projections(&view) {
            // The second takes several passes: what is largest in an earlier one stays with its body.
            for (step_mm, size) in [(0.9, [48, 40]), (0.006, [10, 8])] {
                let d = stage.compare(&Frame { step_mm, size, ..view.clone() });
                // What is equal but for the last bit may be either's.
                let few = 3.5 / f64::from(size[0] * size[1]);
                assert!(d.covered > 0.1 && d.beyond_one <= few && d.misplaced <= few, "{seed} {step_mm} {d:?}");
            }
        }
    }
}

#[test]
fn a_picture_does_not_depend_on_the_order_in_which_bodies_are_named() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([40, 36, 34]);
    let mut stage = Stage::new(gpu, grid, plateaus(grid));
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut view = frame(&grid, tissue(), DVec3::new(1.0, 0.4, 0.3), [40, 32]);
    view.bodies = heap(&mut rng, grid.world_bounds().centre(), 6).into_iter().map(|(body, _)| body).collect();
    for mode in [Mode::Dvr, Mode::Iso(26_000.0), Mode::Mip] {
        let mut view = Frame { mode, lighting: Some(Lighting::default()), ..view.clone() };
        let first = stage.image(&view);
        for turn in 1..4 {
            view.bodies.rotate_left(turn);
            assert!(stage.image(&view) == first, "{mode:?} {turn}");
        }
    }
}

#[test]
fn a_zoom_in_orthographic_projection_cuts_nothing_off() {
    let Some((mut stage, bounds)) = cube() else { return };
    let projection = Projection::Orthographic { height_mm: 1.0 };
    let camera = Camera::framing_in(&bounds, DVec3::new(0.3, -1.0, 0.2), DVec3::Z, projection).zoomed(0.02);
    let view = Frame { camera, mode: Mode::Iso(20_000.0), ..frame(&stage.grid, solid(), DVec3::X, [16, 16]) };
    let depths: Vec<_> = rays(&view).iter().map(|ray| crossing(&bounds, ray).unwrap()[0]).collect();
    assert!(depths.iter().all(|t| *t > 1.0), "the image plane lies before the box");
    assert_eq!(misplaced(&stage.image(&view), &depths, 1e-3), 0.0);
    // Twice as near shows what is half as far from the middle, at the same depth.
    let Projection::Orthographic { height_mm } = camera.zoomed(0.5).projection else { panic!() };
    let Projection::Orthographic { height_mm: before } = camera.projection else { panic!() };
    assert!((height_mm / before - 0.5).abs() < 1e-12);
}

#[test]
fn a_plane_cuts_rays_along_it_and_on_either_side_of_it() {
    let Some((mut stage, bounds)) = cube() else { return };
    let middle = bounds.centre();
    let camera = Camera {
        eye: middle + DVec3::Z * 60.25,
        target: middle,
        up: DVec3::Y,
        projection: Projection::Orthographic { height_mm: 40.0 },
    };
    for mode in [Mode::Dvr, Mode::Iso(20_000.0), Mode::Mip] {
        for normal in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
            let mut view = Frame { camera, mode, ..frame(&stage.grid, solid(), DVec3::X, [20, 20]) };
            // Parallel to every ray.
            let plane = Plane::through(middle, normal).unwrap();
            view.bodies[0].region = vec![plane];
            let image = stage.image(&view);
            for (ray, colour) in rays(&view).iter().zip(&image.colour) {
                assert_eq!(colour[3] > 0.0, plane.distance(ray.origin) < 0.0, "{mode:?} {normal} {}", ray.origin);
            }
        }
    }
}

#[test]
fn an_eye_among_the_matter_sees_what_lies_before_it() {
    let Some((mut stage, bounds)) = cube() else { return };
    for projection in [Projection::Orthographic { height_mm: 20.0 }, Projection::Perspective { fov_y_deg: 60.0 }] {
        let eye = bounds.centre();
        let camera = Camera { eye, target: eye + DVec3::new(0.2, 1.0, 0.1), up: DVec3::Z, projection };
        for mode in [Mode::Dvr, Mode::Iso(20_000.0), Mode::Mip] {
            let view = Frame { camera, mode, ..frame(&stage.grid, solid(), DVec3::X, [16, 12]) };
            let image = stage.image(&view);
            assert!(image.depth_mm.iter().all(|z| *z == 0.0), "{mode:?}: matter begins at the eye");
            assert!(image.object.iter().all(|o| o.body() == Some(0)), "{mode:?}");
        }
    }
}
