//! Lassos: the patch's border is the line, its inside lies on the surface, crossings are wound around, cutaways of it are closed.

use super::voxels::{Voxels, is_closed, sphere, torus};
use burin::annotate::surface::{Surface, project};
use burin::annotate::window::cutaway::Cutaway;
use burin::annotate::window::lasso::{LassoError, LassoPatch, lasso_patch};
use glam::{DVec2, DVec3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};
use std::time::Instant;

/// Points on the surface above (x, y) of a line in the plane z = 0, from `above` down.
fn draped(volume: &Voxels, line: &[DVec2], above: f64) -> Vec<DVec3> {
    line.iter().map(|p| project(volume, p.extend(above), DVec3::Z, 1e-4).unwrap()).collect()
}

fn star(rng: &mut ChaCha8Rng, radius: f64, count: usize) -> Vec<DVec2> {
    let waves: [f64; 3] = std::array::from_fn(|_| rng.random_range(0.0..0.15));
    (0..count)
        .map(|k| {
            let t = TAU * k as f64 / count as f64;
            let r =
                radius * (1.0 + waves[0] * (2.0 * t).sin() + waves[1] * (3.0 * t).cos() + waves[2] * (5.0 * t).sin());
            DVec2::new(r * t.cos(), r * t.sin())
        })
        .collect()
}

fn shoelace(line: &[DVec2]) -> f64 {
    (0..line.len()).map(|k| 0.5 * line[k].perp_dot(line[(k + 1) % line.len()])).sum()
}

/// Area of the patch's shadow in the plane z = 0, with its sign.
fn shadow(lasso: &LassoPatch) -> f64 {
    let c = |i: u32| lasso.patch.corners()[i as usize].truncate();
    lasso.patch.triangles().iter().map(|&[a, b, d]| 0.5 * (c(b) - c(a)).perp_dot(c(d) - c(a))).sum()
}

fn away(p: DVec2, line: &[DVec2]) -> f64 {
    let to_edge = |a: DVec2, b: DVec2| {
        let share = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, share))
    };
    (0..line.len()).map(|k| to_edge(line[k], line[(k + 1) % line.len()])).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_lasso_becomes_the_surface_that_it_encircles() {
    let volume = sphere(40.0);
    for seed in 0..12 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut line = star(&mut rng, 20.0, 200);
        if seed % 2 == 1 {
            line.reverse();
        }
        let edge = [1.0, 2.0, 0.7][seed as usize % 3];
        let begin = Instant::now();
        let lasso = lasso_patch(&volume, &draped(&volume, &line, 38.0), DVec3::Z, edge, 1e-3).unwrap();
        let took = begin.elapsed().as_secs_f64() * 1e3;
        let patch = &lasso.patch;
        assert_eq!((lasso.trimmed, lasso.crossings), (0, 0));
        for &p in patch.corners() {
            assert!(p.z > 10.0 && volume.value(p).unwrap().abs() <= 1.01e-3 * volume.gradient(p).unwrap().length());
        }
        let border = patch.border();
        assert_eq!(border.len(), 1);
        for &c in &border[0] {
            assert!(away(patch.corners()[c as usize].truncate(), &line) < 0.25 * edge + 1e-6);
        }
        let area = shoelace(&line).abs();
        assert!((shadow(&lasso) / area - 1.0).abs() < 0.02, "{} for {area}", shadow(&lasso));
        // Edges as long as asked for, seen along the normal; no slivers but at the border.
        let flat = |i: u32| patch.corners()[i as usize].truncate();
        let mut lengths: Vec<f64> = patch
            .triangles()
            .iter()
            .flat_map(|&[a, b, c]| [flat(a).distance(flat(b)), flat(b).distance(flat(c))])
            .collect();
        lengths.sort_by(f64::total_cmp);
        let median = lengths[lengths.len() / 2];
        assert!((median / edge - 1.0).abs() < 0.1 && lengths[lengths.len() - 1] < 2.0 * edge, "{median} for {edge}");
        let cut = Cutaway::new(patch, DVec3::Z, 6.0, 1.0).unwrap();
        is_closed(cut.corners(), cut.triangles()).unwrap();
        assert!(cut.contains(DVec3::new(0.0, 0.0, 37.0)) && !cut.contains(DVec3::new(0.0, 0.0, 33.0)));
        if seed < 3 {
            println!("edge {edge}: {} vertices in {took:.1} ms", patch.corners().len());
        }
    }
}

#[test]
fn corners_of_a_coarse_lasso_stay() {
    let volume = sphere(40.0);
    let square = [[-12.0, -12.0], [12.0, -12.0], [12.0, 12.0], [-12.0, 12.0]].map(DVec2::from_array);
    let lasso = lasso_patch(&volume, &draped(&volume, &square, 38.0), DVec3::Z, 1.0, 1e-3).unwrap();
    assert_eq!((lasso.trimmed, lasso.crossings), (0, 0));
    for c in square {
        assert!(lasso.patch.corners().iter().any(|p| p.truncate().distance(c) < 1e-6));
    }
    assert!((shadow(&lasso) / 576.0 - 1.0).abs() < 1e-6);
    assert!(lasso.patch.corners().iter().all(|&p| p.z > 30.0 && volume.value(p).unwrap().abs() < 1.1e-3));
}

#[test]
fn a_lasso_that_crosses_itself_winds_around_its_inside() {
    let volume = sphere(40.0);
    // A lying eight, whose lobes turn opposite ways: both are inside. (18 sin t, 9 sin 2t) has the area 2 · 18 · 9 · 4/3.
    let eight: Vec<DVec2> = (0..240)
        .map(|k| TAU * (k as f64 + 0.37) / 240.0)
        .map(|t| DVec2::new(18.0 * t.sin(), 9.0 * (2.0 * t).sin()))
        .collect();
    let lasso = lasso_patch(&volume, &draped(&volume, &eight, 38.0), DVec3::Z, 1.0, 1e-3).unwrap();
    assert!(lasso.crossings >= 1);
    let lobes = 2.0 * 18.0 * 9.0 * 4.0 / 3.0;
    assert!((shadow(&lasso) / lobes - 1.0).abs() < 0.03, "{} for {lobes}", shadow(&lasso));
    let cut = Cutaway::new(&lasso.patch, DVec3::Z, 3.0, 1.0).unwrap();
    is_closed(cut.corners(), cut.triangles()).unwrap();
    for x in [-10.0, 10.0] {
        assert!(cut.contains(DVec3::new(x, 0.0, (1600.0_f64 - 100.0).sqrt() - 1.0)));
    }
    // Twice round, and ends that overlap: once inside.
    let twice: Vec<DVec2> = (0..300)
        .map(|k| (k as f64, TAU * 2.2 * k as f64 / 300.0))
        .map(|(k, t)| DVec2::new((15.0 - 0.01 * k) * t.cos(), (15.0 - 0.01 * k) * t.sin()))
        .collect();
    let lasso = lasso_patch(&volume, &draped(&volume, &twice, 38.0), DVec3::Z, 1.0, 1e-3).unwrap();
    assert!(shadow(&lasso) < PI * 15.0 * 15.0 && shadow(&lasso) > PI * 12.5 * 12.5, "{}", shadow(&lasso));
    let cut = Cutaway::new(&lasso.patch, DVec3::Z, 3.0, 1.0).unwrap();
    is_closed(cut.corners(), cut.triangles()).unwrap();
}

#[test]
fn scribbles_give_closed_meshes() {
    let volume = sphere(40.0);
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(500 + seed);
        let count = rng.random_range(3..40);
        let line: Vec<DVec2> = (0..count)
            .map(|_| DVec2::new(rng.random_range(-20.0..20.0), rng.random_range(-20.0..20.0)))
            .map(|p| if seed % 3 == 0 { p.round() } else { p })
            .collect();
        match lasso_patch(&volume, &draped(&volume, &line, 38.0), DVec3::Z, 1.5, 1e-3) {
            Ok(lasso) => {
                let cut = Cutaway::new(&lasso.patch, DVec3::Z, 3.0, 1.0).unwrap();
                is_closed(cut.corners(), cut.triangles()).unwrap();
                assert!(lasso.patch.corners().iter().all(|&p| p.z > 20.0 && volume.value(p).unwrap().abs() < 1.1e-3));
                // Inside is what the line winds around: sampled at random.
                for _ in 0..200 {
                    let p = DVec2::new(rng.random_range(-22.0..22.0), rng.random_range(-22.0..22.0));
                    if away(p, &line) > 0.5 {
                        let angle: f64 = (0..count).map(|k| (line[k] - p).angle_to(line[(k + 1) % count] - p)).sum();
                        let z = (1600.0 - p.length_squared()).sqrt() - 1.0;
                        assert_eq!(cut.contains(p.extend(z)), (angle / TAU).round() != 0.0, "seed {seed}, {p}");
                    }
                }
            }
            Err(e) => assert!(count < 4, "{e}"),
        }
    }
}

#[test]
fn where_there_is_no_surface_the_patch_has_a_hole_and_keeps_to_its_layer() {
    // Around the hole of a torus, seen along its axis: the patch is trimmed there.
    let volume = torus(20.0, 8.0);
    let ring: Vec<DVec2> =
        (0..120).map(|k| TAU * k as f64 / 120.0).map(|t| DVec2::new(22.0 * t.cos(), 22.0 * t.sin())).collect();
    let lasso = lasso_patch(&volume, &draped(&volume, &ring, 8.0), DVec3::Z, 1.0, 1e-3).unwrap();
    assert!(lasso.trimmed > 100, "{}", lasso.trimmed);
    assert!(lasso.patch.corners().iter().all(|p| p.z > -0.5 && p.truncate().length() > 11.5));
    assert!(lasso.patch.border().len() >= 2);
    let cut = Cutaway::new(&lasso.patch, DVec3::Z, 3.0, 1.0).unwrap();
    is_closed(cut.corners(), cut.triangles()).unwrap();
    // A plate with a hole over another plate, three edges and more below: the hole is trimmed, not filled from below.
    let plates = Voxels::of(DVec3::new(-20.0, -20.0, -16.0), DVec3::new(20.0, 20.0, 10.0), 1.0, |p| {
        let upper = (2.0 - (p.z - 2.0).abs()).min(p.truncate().length() - 5.0);
        upper.max(2.0 - (p.z + 10.0).abs())
    });
    let square = [[-12.0, -12.0], [12.0, -12.0], [12.0, 12.0], [-12.0, 12.0]].map(DVec2::from_array);
    let lasso = lasso_patch(&plates, &draped(&plates, &square, 3.9), DVec3::Z, 1.0, 1e-3).unwrap();
    assert!(lasso.trimmed > 40 && lasso.patch.corners().iter().all(|p| p.z > 0.0), "{}", lasso.trimmed);
}

#[test]
fn what_encircles_nothing_is_refused() {
    let volume = sphere(40.0);
    let line = draped(&volume, &[[0.0, 0.0], [5.0, 0.0], [0.0, 5.0]].map(DVec2::from_array), 39.0);
    let ask = |line: &[DVec3], outward: DVec3, edge: f64| lasso_patch(&volume, line, outward, edge, 1e-3);
    assert!(ask(&line, DVec3::Z, 1.0).is_ok());
    assert!(matches!(ask(&line[..2], DVec3::Z, 1.0), Err(LassoError::TooFewPoints { points: 2 })));
    assert!(matches!(ask(&[], DVec3::Z, 1.0), Err(LassoError::TooFewPoints { points: 0 })));
    assert!(matches!(ask(&line, DVec3::ZERO, 1.0), Err(LassoError::Direction { .. })));
    assert!(matches!(ask(&line, DVec3::Z, 0.0), Err(LassoError::Edge { .. })));
    assert!(matches!(ask(&line, DVec3::Z, 1e-3), Err(LassoError::TooFine { .. })));
    assert!(matches!(ask(&[line[0], DVec3::NAN, line[2]], DVec3::Z, 1.0), Err(LassoError::NotAPlace { index: 1, .. })));
    let there_and_back = [line[0], line[1], line[1] + DVec3::X * 1e-12, line[0]];
    assert!(ask(&there_and_back, DVec3::Z, 1.0).is_err());
}

#[test]
fn the_same_lasso_gives_the_same_patch() {
    let volume = sphere(30.0);
    let line = draped(&volume, &star(&mut ChaCha8Rng::seed_from_u64(9), 12.0, 90), 29.0);
    let once = || lasso_patch(&volume, &line, DVec3::new(0.1, 0.0, 1.0), 0.8, 1e-3).unwrap();
    assert_eq!(once(), once());
}

#[test]
fn a_coarse_lasso_on_a_steep_shell_stays_on_it() {
    // A shell within a shell: chords between four points dip to the inner one, and so do level guesses at steep places.
    let box_ = DVec3::splat(44.0);
    let volume =
        Voxels::of(-box_, box_, 1.0, |p| (2.0 - (p.length() - 38.0).abs()).max(2.0 - (p.length() - 32.0).abs()));
    for (radius, edge) in [(34.0, 1.0), (34.0, 3.0), (30.0, 4.0)] {
        let square: Vec<DVec2> = (0..4).map(|k| DVec2::from_angle(0.3 + k as f64 * PI / 2.0) * radius).collect();
        let line = draped(&volume, &square, (1600.0_f64 - radius * radius).sqrt() + 0.3);
        let lasso = lasso_patch(&volume, &line, DVec3::Z, edge, 1e-3).unwrap();
        assert_eq!(lasso.trimmed, 0);
        for p in lasso.patch.corners() {
            assert!((p.length() - 40.0).abs() < 0.1, "edge {edge}: {p} has radius {}", p.length());
        }
        assert!((shadow(&lasso) / shoelace(&square) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn corners_of_a_small_lasso_stay() {
    let volume = sphere(40.0);
    let side: Vec<f64> = (0..12).map(|k| k as f64 * 0.5).collect();
    let square: Vec<DVec2> = [[0.0, 0.0, 1.0, 0.0], [6.0, 0.0, 0.0, 1.0], [6.0, 6.0, -1.0, 0.0], [0.0, 6.0, 0.0, -1.0]]
        .iter()
        .flat_map(|&[x, y, u, v]| side.iter().map(move |s| DVec2::new(x + u * s, y + v * s)))
        .collect();
    let lasso = lasso_patch(&volume, &draped(&volume, &square[3..], 39.0), DVec3::Z, 2.5, 1e-3).unwrap();
    for c in [[6.0, 0.0], [6.0, 6.0], [0.0, 6.0]].map(DVec2::from_array) {
        assert!(lasso.patch.corners().iter().any(|p| p.truncate().distance(c) < 1e-6), "{c}");
    }
}
