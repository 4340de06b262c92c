//! Splitter planes and silhouettes, against rays, projections and hulls.

use super::{cube, oblique, octants, unit};
use burin::explode::*;
use burin::math::{Camera, DQuat, DVec2, DVec3, Pose, Projection};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SIZE: [u32; 2] = [400, 300];

fn cameras() -> Vec<Camera> {
    let at = |eye: DVec3, projection| Camera { eye, target: DVec3::new(3.0, -2.0, 1.0), up: DVec3::Z, projection };
    let eye = DVec3::new(120.0, -160.0, 70.0);
    vec![
        at(eye, Projection::Perspective { fov_y_deg: 30.0 }),
        at(eye, Projection::Perspective { fov_y_deg: 80.0 }),
        at(eye, Projection::Orthographic { height_mm: 90.0 }),
    ]
}

#[test]
fn the_axis_plane_is_edge_on_where_it_was_clicked() {
    for camera in cameras() {
        for px in [DVec2::new(200.0, 150.0), DVec2::new(31.0, 270.5)] {
            let ray = camera.ray(px, SIZE);
            let hit = ray.at(150.0);
            for axis in [Axis::Horizontal, Axis::Vertical] {
                let plane = axis_plane(&camera, px, SIZE, axis, hit).unwrap();
                assert!(plane.distance(hit).abs() < 1e-10);
                assert!(plane.normal.dot(ray.dir).abs() < 1e-12, "holds the ray through the click");
                // At the hit's depth the plane's trace on the screen is the row (or column) of the click.
                let (right, up) = camera.right_up();
                let along = if axis == Axis::Horizontal { right } else { up };
                let (there, _) = camera.project(hit + along * 7.0, SIZE).unwrap();
                assert!(plane.distance(hit + along * 7.0).abs() < 1e-10);
                let off = if axis == Axis::Horizontal { there.y - px.y } else { there.x - px.x };
                assert!(off.abs() < 1e-8);
            }
        }
    }
}

#[test]
fn the_depth_plane_has_one_depth_in_the_picture() {
    for camera in cameras() {
        let hit = camera.ray(DVec2::new(90.0, 80.0), SIZE).at(140.0);
        let plane = depth_plane(&camera, hit).unwrap();
        let (_, depth) = camera.project(hit, SIZE).unwrap();
        for px in [DVec2::new(0.0, 0.0), DVec2::new(390.0, 20.0), DVec2::new(200.0, 299.0)] {
            let ray = camera.ray(px, SIZE);
            let t = -plane.distance(ray.origin) / plane.normal.dot(ray.dir);
            let (_, there) = camera.project(ray.at(t), SIZE).unwrap();
            assert!((there - depth).abs() < 1e-9);
        }
        assert!(plane.distance(camera.eye) < 0.0, "the nearer side is the inner one");
    }
}

#[test]
fn the_line_plane_projects_to_the_line() {
    for camera in cameras() {
        let (from, to) = (DVec2::new(50.0, 210.0), DVec2::new(333.0, 40.0));
        let plane = line_plane(&camera, from, to, SIZE).unwrap();
        for i in 0..5 {
            let px = from.lerp(to, f64::from(i) * 0.4 - 0.3);
            let ray = camera.ray(px, SIZE);
            for t in [0.0, 50.0, 300.0] {
                assert!(plane.distance(ray.at(t)).abs() < 1e-9);
            }
        }
        assert!(plane.distance(camera.ray(DVec2::new(50.0, 50.0), SIZE).at(100.0)).abs() > 1.0);
        assert!(matches!(line_plane(&camera, from, from, SIZE), Err(ExplodeError::NoPlane { splitter: "line", .. })));
        assert!(line_plane(&camera, from, DVec2::NAN, SIZE).is_err());
    }
}

/// Whether a segment meets the hull of points: by the separating-axis theorem over the segment's and all pairs' normals,
/// which needs no hull.
fn meets_hull(points: &[DVec2], a: DVec2, b: DVec2) -> f64 {
    let mut axes = vec![b - a, (b - a).perp()];
    for (i, p) in points.iter().enumerate() {
        axes.extend(points[i + 1..].iter().map(|q| (*q - *p).perp()));
    }
    // The largest gap along any axis, negative where all overlap.
    axes.iter().filter(|n| n.length() > 1e-9).fold(f64::NEG_INFINITY, |gap, axis| {
        let n = axis.normalize();
        let span = |p: &mut dyn Iterator<Item = DVec2>| {
            p.fold((f64::INFINITY, f64::NEG_INFINITY), |s, q| (s.0.min(n.dot(q)), s.1.max(n.dot(q))))
        };
        let (lo, hi) = span(&mut points.iter().copied());
        let (s, e) = span(&mut [a, b].into_iter());
        gap.max(s - hi).max(lo - e)
    })
}

#[test]
fn the_line_meets_the_parts_whose_posed_silhouettes_it_crosses() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let explosion = octants(&cube(40));
    let mut turned =
        |part: &Part| Pose::about(part.centre(), DQuat::from_axis_angle(unit(&mut rng), 0.6), part.centre() * 0.8);
    let given: Vec<Pose> = explosion.parts.iter().map(&mut turned).collect();
    let poses = Poses::found(&explosion.parts, &given);
    let (mut met, mut missed) = (0, 0);
    for camera in cameras() {
        for _ in 0..60 {
            let px = |rng: &mut ChaCha8Rng| DVec2::new(rng.random_range(0.0..400.0), rng.random_range(0.0..300.0));
            let (from, to) = (px(&mut rng), px(&mut rng));
            let found = explosion.meeting(&poses, &camera, from, to, SIZE).unwrap();
            for (part, pose) in explosion.parts.iter().zip(&given) {
                let shadow: Vec<DVec2> =
                    part.vertices.iter().map(|&v| camera.project(pose.apply(v), SIZE).unwrap().0).collect();
                let gap = meets_hull(&shadow, from, to);
                if gap.abs() > 1e-6 {
                    assert_eq!(found.contains(&part.id), gap < 0.0, "{camera:?} {from} {to} gap {gap}");
                    if gap < 0.0 { met += 1 } else { missed += 1 }
                }
            }
        }
    }
    assert!(met > 100 && missed > 100, "{met} {missed}");
}

#[test]
fn a_line_cuts_what_it_meets_and_leaves_the_rest() {
    let grid = oblique();
    let mut explosion = Explosion::whole(&grid);
    let camera = Camera::framing(&grid.world_bounds(), DVec3::new(1.0, -1.0, 0.4), DVec3::Z);
    let whole = explosion.parts[0].volume_mm3();
    let first = split_by_line(&mut explosion, &camera, DVec2::new(0.0, 130.0), DVec2::new(400.0, 160.0));
    assert_eq!(first.len(), 1);
    for half in first[0] {
        let part = explosion.part(half).unwrap();
        let plane = line_plane(&camera, DVec2::new(0.0, 130.0), DVec2::new(400.0, 160.0), SIZE).unwrap();
        let sides: Vec<f64> = part.vertices.iter().map(|&v| plane.distance(v)).collect();
        assert!(sides.iter().all(|d| *d < 1e-7) || sides.iter().all(|d| *d > -1e-7));
    }
    // A short line in one half's silhouette only.
    let [a, b] = first[0];
    let (at, _) = camera.project(explosion.part(a).unwrap().centre(), SIZE).unwrap();
    let met = explosion.meeting(&Poses::default(), &camera, at, at + DVec2::new(1.0, 0.0), SIZE).unwrap();
    assert!(met.contains(&a) && !met.contains(&b));
    let cut = split_by_line(&mut explosion, &camera, at, at + DVec2::new(1.0, 0.0));
    assert_eq!(cut.len(), 1);
    assert!(explosion.part(b).is_ok());
    assert!((explosion.parts.iter().map(|p| p.volume_mm3()).sum::<f64>() / whole - 1.0).abs() < 1e-9);
    explosion.check().unwrap();
}

#[test]
fn hidden_parts_and_parts_behind_the_eye_are_not_cut() {
    let mut explosion = octants(&cube(40));
    let camera = Camera {
        eye: DVec3::new(0.0, -5.0, 0.0),
        target: DVec3::new(0.0, -100.0, 0.0),
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y_deg: 60.0 },
    };
    let across = (DVec2::new(10.0, 20.0), DVec2::new(390.0, 280.0));
    let found = explosion.meeting(&Poses::default(), &camera, across.0, across.1, SIZE).unwrap();
    assert!(!found.is_empty());
    for id in &found {
        assert!(explosion.part(*id).unwrap().vertices.iter().all(|v| v.y <= 0.0), "in front of the eye is y < -5");
    }
    explosion.part_mut(found[0]).unwrap().visible = false;
    assert!(!explosion.meeting(&Poses::default(), &camera, across.0, across.1, SIZE).unwrap().contains(&found[0]));
}

/// Cuts what the line splitter names.
fn split_by_line(explosion: &mut Explosion, camera: &Camera, from: DVec2, to: DVec2) -> Vec<[PartId; 2]> {
    let cuts = explosion.line_cuts(&Poses::default(), camera, from, to, SIZE).unwrap();
    explosion.cut(&cuts).unwrap()
}
