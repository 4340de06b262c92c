//! Each force against its equation, its closed forms, and the printed equations that fail.

use super::{cube, oblique, octants, unit};
use burin::explode::forces::*;
use burin::explode::*;
use burin::math::{Camera, DVec3, Plane, Projection};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn close(a: DVec3, b: DVec3, tolerance: f64) {
    assert!(a.distance(b) <= tolerance, "{a} and {b} are {} apart", a.distance(b));
}

#[test]
fn the_return_force_is_a_logarithmic_spring_that_starts_at_zero() {
    let (c, l) = (0.25, 0.1);
    assert_eq!(return_force(DVec3::ZERO, c, l), DVec3::ZERO);
    // ln(1 + r/l) = 1 where r = (e - 1) l.
    let r = (std::f64::consts::E - 1.0) * l;
    close(return_force(DVec3::Y * r, c, l), DVec3::Y * c, 1e-15);
    // Hooke's law with c/l near rest.
    close(return_force(DVec3::X * 1e-8, c, l), DVec3::X * (1e-8 * c / l), 1e-14);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..200 {
        let (way, r) = (unit(&mut rng), rng.random_range(0.0..5.0));
        close(return_force(way * r, c, l), way * (c * (1.0_f64 + r / l).ln()), 1e-14);
    }
}

/// The nearest point of an intersection of half-spaces, by Dykstra's alternating projections: knows no faces and corners.
fn nearest(planes: &[Plane], p: DVec3) -> DVec3 {
    let mut x = p;
    let mut corrections = vec![DVec3::ZERO; planes.len()];
    for _ in 0..4000 {
        for (plane, correction) in planes.iter().zip(&mut corrections) {
            let y = x + *correction;
            x = y - plane.normal * plane.distance(y).max(0.0);
            *correction = y - x;
        }
    }
    x
}

/// Faces of a part about its centre in half-diagonals.
fn planes(part: &Part, unit_mm: f64) -> Vec<Plane> {
    let local = |f: &Face| Plane { offset: -f.plane.distance(part.centre()) / unit_mm, ..f.plane };
    part.faces.iter().map(local).collect()
}

/// A few parts with many faces, slivers among them.
fn shapes() -> (Vec<Part>, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut explosion = Explosion::whole(&oblique());
    while explosion.parts.len() < 24 {
        let i = rng.random_range(0..explosion.parts.len());
        let (id, at) = (explosion.parts[i].id, explosion.parts[i].centre() + unit(&mut rng) * 2.0);
        explosion.split_at_rest(id, &Plane::through(at, unit(&mut rng)).unwrap()).unwrap();
    }
    let unit_mm = explosion.diagonal_mm() * 0.5;
    (explosion.parts, unit_mm)
}

#[test]
fn outside_the_explosion_force_fades_from_the_nearest_point() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (parts, unit_mm) = shapes();
    let (c, length) = (0.5, 0.2);
    for part in &parts {
        let (solid, planes) = (PartShape::of(part, unit_mm).unwrap(), planes(part, unit_mm));
        let mut tried = 0;
        while tried < 6 {
            let p = unit(&mut rng) * rng.random_range(0.05..1.5);
            if planes.iter().all(|f| f.distance(p) < 1e-3) {
                continue;
            }
            tried += 1;
            let expected = nearest(&planes, p);
            let push = explosion_force(&solid, p, c, length).unwrap();
            // Alternating projections converge linearly; slivers are the slowest.
            close(push.at, expected, 2e-4);
            // So the distance, which depends on the foot in second order only, is the sharper check.
            let r = p.distance(expected);
            assert!(p.distance(push.at) <= r + 1e-9, "a nearer point exists");
            let r = p.distance(push.at);
            close(push.force, (push.at - p) / r * (c * (-r / length).exp()), 1e-14);
            assert!(planes.iter().all(|f| f.distance(push.at) < 1e-9), "the foot is on the part");
        }
    }
}

#[test]
fn the_nearest_point_of_a_box_is_the_clamped_point() {
    let explosion = Explosion::whole(&cube(20));
    let solid = PartShape::of(&explosion.parts[0], explosion.diagonal_mm() * 0.5).unwrap();
    let half = DVec3::splat(1.0 / 3.0_f64.sqrt());
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..500 {
        let p = unit(&mut rng) * rng.random_range(0.0..3.0);
        match solid.nearest(p) {
            Nearest::Outside(q) => close(q, p.clamp(-half, half), 1e-12),
            Nearest::Inside(way) => {
                assert!(p.abs().cmplt(half).all());
                assert_eq!(way, None, "a part without cut faces has no way out");
                assert_eq!(explosion_force(&solid, p, 1.0, 0.2), None);
            }
        }
    }
}

#[test]
fn inside_the_part_leaves_by_its_cut_faces() {
    let explosion = octants(&cube(20));
    let unit_mm = explosion.diagonal_mm() * 0.5;
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for part in &explosion.parts {
        let solid = PartShape::of(part, unit_mm).unwrap();
        for _ in 0..50 {
            let at = DVec3::new(rng.random(), rng.random(), rng.random()) * 0.56 - 0.28;
            let mut sum = DVec3::ZERO;
            for face in part.faces.iter().filter(|f| f.cut) {
                let depth = -(face.plane.distance(part.centre() + at * unit_mm)) / unit_mm;
                assert!(depth > 0.0);
                sum -= face.plane.normal * (-depth / 0.05).exp();
            }
            let push = explosion_force(&solid, at, 0.5, 0.2).unwrap();
            assert_eq!(push.at, at);
            close(push.force, sum.normalize() * 0.5, 1e-9);
        }
    }
}

#[test]
fn the_explosion_force_is_continuous_through_a_cut_face() {
    let mut explosion = Explosion::whole(&cube(20));
    explosion.split_at_rest(PartId(1), &Plane { normal: DVec3::X, offset: 0.0 }).unwrap();
    let unit_mm = explosion.diagonal_mm() * 0.5;
    let part = &explosion.parts[0];
    let solid = PartShape::of(part, unit_mm).unwrap();
    for (y, z) in [(0.0, 0.0), (3.0, -8.0), (-9.9, 9.9)] {
        let local = |x: f64| (DVec3::new(x, y, z) - part.centre()) / unit_mm;
        let inside = explosion_force(&solid, local(-1e-7), 0.5, 0.2).unwrap();
        let outside = explosion_force(&solid, local(1e-7), 0.5, 0.2).unwrap();
        close(inside.force, outside.force, 1e-6);
        close(inside.at, outside.at, 1e-6);
        close(outside.force, DVec3::NEG_X * 0.5, 1e-6);
    }
}

#[test]
fn viewing_and_spacing_follow_their_equations_and_stay_finite_at_zero() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let eps = 0.05;
    for _ in 0..200 {
        let (way, r) = (unit(&mut rng), rng.random_range(1e-6..3.0));
        close(viewing_force(way * r, 0.3, eps, DVec3::Z), way * (0.3 / (r + eps)), 1e-12);
        close(spacing_force(way * r, 0.3, eps, DVec3::Z), way * (0.3 / (r * r + eps * eps)), 1e-10);
    }
    close(viewing_force(DVec3::ZERO, 0.3, eps, DVec3::Y), DVec3::Y * 6.0, 1e-12);
    close(spacing_force(DVec3::ZERO, 0.3, eps, DVec3::Y), DVec3::Y * 120.0, 1e-10);
}

#[test]
fn the_viewing_ray_starts_at_the_eye_and_runs_through_the_point() {
    let camera = Camera {
        eye: DVec3::new(0.0, -10.0, 0.0),
        target: DVec3::ZERO,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y_deg: 40.0 },
    };
    // Through (1, 0, 0) the ray's direction is (1, 10, 0); beside it at the eye's own height lies (0, 0, 2).
    let dir = DVec3::new(1.0, 10.0, 0.0).normalize();
    let centre = DVec3::new(0.0, 0.0, 2.0);
    let foot = camera.eye + dir * dir.dot(centre - camera.eye);
    close(from_ray(&viewing_ray(&camera, DVec3::X), centre), centre - foot, 1e-12);
    // Behind the eye the nearest point is the eye.
    let behind = DVec3::new(0.0, -13.0, 4.0);
    close(from_ray(&viewing_ray(&camera, DVec3::X), behind), behind - camera.eye, 1e-12);
    let flat = Camera { projection: Projection::Orthographic { height_mm: 5.0 }, ..camera };
    close(from_ray(&viewing_ray(&flat, DVec3::X), centre), DVec3::new(-1.0, 0.0, 2.0), 1e-12);
}

/// What is built beside what is printed, where the print has no value, or the wrong sign.
#[test]
fn the_printed_forms_fail_where_these_hold() {
    // Equation 1, c ln r: −∞ where a part rests, and away from its rest within distance 1.
    let printed_return = |r: f64| 0.25 * r.ln();
    for r in [1e-9, 0.1, 0.5, 0.99] {
        let built = return_force(DVec3::X * r, 0.25, 0.1);
        assert!(built.x > 0.0 && built.y == 0.0 && printed_return(r) < 0.0, "{r}: {built}");
    }
    assert_eq!(return_force(DVec3::ZERO, 0.25, 0.1), DVec3::ZERO);
    // Equations 3 and 4, c/r and c/r²: poles at 0.
    for r in [0.0, 1e-12, 1e-6] {
        let viewing = viewing_force(DVec3::X * r, 0.3, 0.05, DVec3::X);
        let spacing = spacing_force(DVec3::X * r, 0.3, 0.05, DVec3::X);
        assert!(viewing.length() <= 6.0 + 1e-9 && 0.3 / r > 1e5, "{r}: {viewing}");
        assert!(spacing.length() <= 120.0 + 1e-9 && 0.3 / (r * r) > 1e10, "{r}: {spacing}");
    }
    // Equation 2's direction r/|r| for a point inside, whose nearest point is itself.
    let explosion = octants(&cube(20));
    let solid = PartShape::of(&explosion.parts[0], explosion.diagonal_mm() * 0.5).unwrap();
    let built = explosion_force(&solid, DVec3::ZERO, 0.5, 0.2).unwrap().force;
    assert!((built.length() - 0.5).abs() < 1e-12 && DVec3::ZERO.try_normalize().is_none(), "{built}");
}
