//! Rays, planes, boxes, poses and cameras against closed forms and brute force.

use burin::math::{Aabb, Camera, DQuat, DVec2, DVec3, Plane, Pose, Projection, Ray};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn any(rng: &mut ChaCha8Rng, s: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)))
}

fn pose(rng: &mut ChaCha8Rng) -> Pose {
    Pose { rotation: DQuat::from_scaled_axis(any(rng, 2.0)), translation: any(rng, 30.0) }
}

fn camera(rng: &mut ChaCha8Rng) -> Camera {
    let projection = if rng.random_bool(0.5) {
        Projection::Perspective { fov_y_deg: rng.random_range(10.0..100.0) }
    } else {
        Projection::Orthographic { height_mm: rng.random_range(5.0..300.0) }
    };
    Camera { eye: any(rng, 200.0), target: any(rng, 50.0), up: any(rng, 1.0), projection }
}

#[test]
fn a_ray_is_clipped_to_what_lies_inside_all_planes() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut parallel = [0; 2];
    for n in 0..2000 {
        let ray = Ray { origin: any(&mut rng, 4.0), dir: any(&mut rng, 1.0).normalize() };
        let ray = if n % 2 == 0 { Ray { dir: DVec3::Z, ..ray } } else { ray };
        let mut planes: Vec<Plane> =
            (0..2).filter_map(|_| Plane::through(any(&mut rng, 3.0), any(&mut rng, 1.0))).collect();
        if n % 2 == 0 {
            let along = Plane { normal: DVec3::X, offset: ray.origin.x + rng.random_range(-1.5..1.5) };
            parallel[usize::from(along.distance(ray.origin) <= 0.0)] += 1;
            planes.push(along);
        }
        let clipped = ray.clip(&planes, -5.0, 9.0);
        for i in 0..=1400 {
            let t = -5.0 + f64::from(i) * 0.01;
            let depth = planes.iter().map(|p| p.distance(ray.at(t))).fold(f64::NEG_INFINITY, f64::max);
            let inside = clipped.is_some_and(|(t0, t1)| t0 <= t && t <= t1);
            assert!(depth.abs() < 1e-9 || inside == (depth < 0.0), "{ray:?} {planes:?} {clipped:?} at {t}");
        }
        assert!(clipped.is_none_or(|(t0, t1)| -5.0 <= t0 && t0 < t1 && t1 <= 9.0));
    }
    assert!(parallel.iter().all(|&n| n > 100), "{parallel:?}");
}

#[test]
fn a_box_is_its_corners_and_its_planes() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..50 {
        let points: Vec<DVec3> = (0..5).map(|_| any(&mut rng, 10.0)).collect();
        let bounds = Aabb::around(points.iter().copied()).unwrap();
        for a in 0..3 {
            assert_eq!(bounds.min[a], points.iter().map(|p| p[a]).fold(f64::INFINITY, f64::min));
            assert_eq!(bounds.max[a], points.iter().map(|p| p[a]).fold(f64::NEG_INFINITY, f64::max));
        }
        for (i, corner) in bounds.corners().into_iter().enumerate() {
            let bit = |a: usize| if i >> a & 1 == 1 { bounds.max[a] } else { bounds.min[a] };
            assert_eq!(corner, DVec3::new(bit(0), bit(1), bit(2)));
            assert!((corner.distance(bounds.centre()) - bounds.half_diagonal()).abs() < 1e-12);
        }
        let p = any(&mut rng, 12.0);
        let inside = (0..3).all(|a| bounds.min[a] <= p[a] && p[a] <= bounds.max[a]);
        assert_eq!(bounds.planes().iter().all(|plane| plane.distance(p) <= 0.0), inside);
        assert!(bounds.planes().iter().all(|plane| plane.flipped().distance(p) == -plane.distance(p)));
    }
    assert_eq!(Aabb::around([]), None);
}

#[test]
fn a_pose_and_its_inverse_move_points_planes_and_rays_alike() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..200 {
        let (pose, p, centre) = (pose(&mut rng), any(&mut rng, 40.0), any(&mut rng, 20.0));
        assert!(pose.unapply(pose.apply(p)).distance(p) < 1e-12);
        assert!(pose.world_from_rest().transform_point3(p).distance(pose.apply(p)) < 1e-12);
        let plane = Plane::through(any(&mut rng, 20.0), any(&mut rng, 1.0)).unwrap();
        assert!((pose.apply_plane(&plane).distance(pose.apply(p)) - plane.distance(p)).abs() < 1e-12);
        assert!((pose.unapply_plane(&plane).distance(p) - plane.distance(pose.apply(p))).abs() < 1e-12);
        let ray = Ray { origin: any(&mut rng, 20.0), dir: any(&mut rng, 1.0).normalize() };
        assert!(pose.unapply_ray(&ray).at(7.0).distance(pose.unapply(ray.at(7.0))) < 1e-12);
        // Shares of the way: none, all, and two halves of the turn one after the other.
        assert!(pose.share(0.0, centre).apply(p).distance(p) < 1e-12);
        assert!(pose.share(1.0, centre).apply(p).distance(pose.apply(p)) < 1e-11);
        let half = pose.share(0.5, centre);
        assert!(half.apply(centre).distance((centre + pose.apply(centre)) * 0.5) < 1e-11);
        assert!((half.rotation * half.rotation).angle_between(pose.rotation) < 1e-7);
        let about = Pose::about(centre, pose.rotation, DVec3::X);
        assert!(about.apply(centre).distance(centre + DVec3::X) < 1e-12);
    }
}

#[test]
fn a_pixel_s_ray_goes_through_what_that_pixel_shows() {
    // By hand: 200 × 100 pixels, up is z, looking along y.
    let eye = DVec3::new(0.0, -10.0, 0.0);
    let flat =
        Camera { eye, target: DVec3::ZERO, up: DVec3::Z, projection: Projection::Orthographic { height_mm: 50.0 } };
    let corner = flat.ray(DVec2::ZERO, [200, 100]);
    assert!(corner.origin.distance(DVec3::new(-50.0, -10.0, 25.0)) < 1e-12 && corner.dir.distance(DVec3::Y) < 1e-12);
    let near = Camera { projection: Projection::Perspective { fov_y_deg: 90.0 }, ..flat };
    let corner = near.ray(DVec2::ZERO, [200, 100]);
    assert!(corner.origin == eye && corner.dir.distance(DVec3::new(-2.0, 1.0, 1.0).normalize()) < 1e-12);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..300 {
        let camera = camera(&mut rng);
        let size = [rng.random_range(1..900), rng.random_range(1..900)];
        let px = DVec2::new(rng.random_range(-20.0..900.0), rng.random_range(-20.0..900.0));
        let ray = camera.ray(px, size);
        let point = ray.at(rng.random_range(1.0..500.0));
        let (found, depth) = camera.project(point, size).unwrap();
        assert!(found.distance(px) < 1e-6, "{camera:?} {px} {found}");
        assert!((depth - (point - camera.eye).dot(camera.forward())).abs() < 1e-9);
        assert!((ray.dir.length() - 1.0).abs() < 1e-12);
        // A pixel further: as far beside it as a pixel is wide there.
        let beside = camera.ray(px + DVec2::X, size);
        let at = |ray: &Ray| ray.at(depth / ray.dir.dot(camera.forward()));
        let wide = at(&ray).distance(at(&beside));
        assert!((wide / camera.mm_per_pixel(depth, size[1]) - 1.0).abs() < 1e-6);
        let behind = camera.eye - camera.forward() * 3.0;
        assert_eq!(camera.project(behind, size).is_none(), matches!(camera.projection, Projection::Perspective { .. }));
    }
}

#[test]
fn an_orbit_goes_round_the_target_and_stops_short_of_the_poles() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..300 {
        let camera = camera(&mut rng);
        let (azimuth, elevation) = (rng.random_range(-400.0..400.0_f64), rng.random_range(-90.0..90.0_f64));
        let turned = camera.orbited(azimuth, elevation);
        let (before, after) = (camera.eye - camera.target, turned.eye - turned.target);
        assert!((before.length() - after.length()).abs() < 1e-9 && turned.target == camera.target);
        let height = |v: DVec3| (v.z / v.length()).asin().to_degrees();
        assert!((height(after) - (height(before) + elevation).clamp(-89.5, 89.5)).abs() < 1e-6);
        let round = |v: DVec3| v.y.atan2(v.x).to_degrees();
        let off = (round(after) - round(before) - azimuth).rem_euclid(360.0);
        assert!(off.min(360.0 - off) < 1e-6, "{off}");
        assert_eq!((turned.up, turned.projection), (DVec3::Z, camera.projection));
    }
}

#[test]
fn pan_and_zoom_move_what_is_seen_as_the_hand_does() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for _ in 0..300 {
        let camera = camera(&mut rng);
        let size = [640, 480];
        let delta = DVec2::new(rng.random_range(-90.0..90.0), rng.random_range(-90.0..90.0));
        let (before, _) = camera.project(camera.target, size).unwrap();
        let (after, _) = camera.panned(delta, size[1]).project(camera.target, size).unwrap();
        assert!(after.distance(before + delta) < 1e-6, "{before} {after} {delta}");
        let factor = rng.random_range(0.2..3.0);
        let zoomed = camera.zoomed(factor);
        let mm = |c: &Camera| c.mm_per_pixel((c.target - c.eye).length(), size[1]);
        assert!((mm(&zoomed) / mm(&camera) - factor).abs() < 1e-9);
        assert!(zoomed.forward().distance(camera.forward()) < 1e-9 && zoomed.target == camera.target);
    }
}

#[test]
fn a_framed_box_fills_the_picture_and_no_more() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..100 {
        let bounds = Aabb::around([any(&mut rng, 50.0), any(&mut rng, 50.0)]).unwrap();
        let direction = any(&mut rng, 1.0);
        for projection in [Projection::Perspective { fov_y_deg: 40.0 }, Projection::Orthographic { height_mm: 1.0 }] {
            let camera = Camera::framing_in(&bounds, direction, DVec3::Z, projection);
            assert!(camera.forward().distance(-direction.normalize()) < 1e-9);
            let inside = |p: DVec2| p.cmpge(DVec2::splat(-1e-6)).all() && p.cmple(DVec2::splat(100.0 + 1e-6)).all();
            let shown = |p: DVec3| inside(camera.project(p, [100, 100]).unwrap().0);
            assert!(bounds.corners().into_iter().all(shown), "{camera:?}");
            // The sphere about the box touches the picture's upper side.
            let ray = camera.ray(DVec2::new(50.0, 0.0), [100, 100]);
            let beside = (bounds.centre() - ray.origin).cross(ray.dir).length();
            assert!((beside / bounds.half_diagonal() - 1.0).abs() < 1e-9, "{beside}");
        }
    }
}
