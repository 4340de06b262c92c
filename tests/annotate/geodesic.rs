//! Rulers: lengths against the great circle, the helix and an integrated geodesic of the torus; ticks and strips on the surface.

use super::voxels::{Voxels, cylinder, sphere, torus, unit};
use burin::annotate::path::geodesic::{GeodesicError, RULER_VERTICES, geodesic};
use burin::annotate::path::strip::Tracing;
use burin::annotate::path::surface_path::SurfacePath;
use burin::annotate::surface::{Surface, project};
use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

fn voxel() -> Tracing {
    Tracing::of_voxel(1.0)
}

fn on(volume: &Voxels, path: &SurfacePath) {
    for (&p, &n) in path.points().iter().zip(path.normals()) {
        let g = volume.gradient(p).unwrap();
        assert!(volume.value(p).unwrap().abs() <= 1.01e-3 * g.length(), "{p} is off by {}", volume.value(p).unwrap());
        assert!((n + g.normalize()).length() < 1e-12);
    }
}

#[test]
fn a_ruler_on_a_sphere_is_the_great_circle() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut worst = 0.0f64;
    let mut slowest = 0.0f64;
    let mut rng_times = Vec::new();
    for radius in [20.0, 40.0, 60.0] {
        let volume = sphere(radius);
        for angle in [0.05, 0.3, 1.0, 1.0, 1.0, 1.0, 2.0, 2.9] {
            let a = unit(&mut rng);
            let side = a.cross(unit(&mut rng)).normalize();
            let b = a * f64::cos(angle) + side * f64::sin(angle);
            let begin = Instant::now();
            let path = geodesic(&volume, a * radius, b * radius, RULER_VERTICES, &voxel()).unwrap();
            let took = begin.elapsed().as_secs_f64() * 1e3;
            rng_times.push(took);
            slowest = slowest.max(took);
            on(&volume, &path);
            let off = path.length_mm() / (radius * angle) - 1.0;
            worst = worst.max(off.abs());
            assert!(off.abs() < 0.003, "radius {radius}, {angle} rad: {:.4} % off", off * 100.0);
            let plane = a.cross(b).normalize();
            let aside = path.points().iter().map(|p| p.dot(plane).abs()).fold(0.0, f64::max);
            assert!(aside < 0.02 * radius, "{aside} mm off the plane of the great circle, {radius}, {angle}");
        }
    }
    println!("sphere: worst {:.4} %, slowest {slowest:.1} ms, {rng_times:.1?}", worst * 100.0);
}

#[test]
fn a_ruler_on_a_cylinder_is_a_helix() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut worst = 0.0f64;
    let volume = cylinder(25.0, 60.0);
    for _ in 0..12 {
        let (turn, rise, from) = (rng.random_range(0.2..2.8), rng.random_range(0.0..50.0), rng.random_range(0.0..6.0));
        let at = |t: f64, z: f64| DVec3::new(25.0 * f64::cos(t), 25.0 * f64::sin(t), z);
        let path = geodesic(&volume, at(from, -20.0), at(from + turn, rise - 20.0), RULER_VERTICES, &voxel()).unwrap();
        on(&volume, &path);
        let off = path.length_mm() / f64::hypot(25.0 * turn, rise) - 1.0;
        worst = worst.max(off.abs());
        assert!(off.abs() < 0.003, "turn {turn}, rise {rise}: {:.4} % off", off * 100.0);
    }
    println!("cylinder: worst {:.4} %", worst * 100.0);
}

/// A geodesic of the torus by its equations in the angles (θ along the ring, φ around the tube), fourth-order Runge-Kutta:
/// θ'' = 2 r sin φ / (R + r cos φ) θ' φ', φ'' = −(R + r cos φ) sin φ / r θ'².
fn shot(ring: f64, tube: f64, phi: f64, heading: f64, length: f64) -> [DVec3; 2] {
    let place = |[t, p, ..]: [f64; 4]| {
        let w = ring + tube * f64::cos(p);
        DVec3::new(w * f64::cos(t), w * f64::sin(t), tube * f64::sin(p))
    };
    let slope = |[_, p, dt, dp]: [f64; 4]| {
        let w = ring + tube * f64::cos(p);
        [dt, dp, 2.0 * tube * f64::sin(p) / w * dt * dp, -w * f64::sin(p) / tube * dt * dt]
    };
    let mut s = [0.0, phi, f64::cos(heading) / (ring + tube * f64::cos(phi)), f64::sin(heading) / tube];
    let first = place(s);
    let h = length / 2000.0;
    let plus = |s: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| s[i] + h * k[i]);
    for _ in 0..2000 {
        let k1 = slope(s);
        let k2 = slope(plus(s, k1, h / 2.0));
        let k3 = slope(plus(s, k2, h / 2.0));
        let k4 = slope(plus(s, k3, h));
        s = std::array::from_fn(|i| s[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    [first, place(s)]
}

#[test]
fn a_ruler_on_a_torus_is_as_long_as_the_geodesic_that_was_shot() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut worst = 0.0f64;
    let mut slowest = 0.0f64;
    let (ring, tube) = (45.0, 20.0);
    let volume = torus(ring, tube);
    for round in 0..24 {
        // Half of them on the inside, where the surface is a saddle.
        let phi = if round % 2 == 0 {
            std::f64::consts::PI + rng.random_range(-1.0..1.0)
        } else {
            rng.random_range(-1.5..1.5)
        };
        let length = rng.random_range(5.0..30.0);
        let [a, b] = shot(ring, tube, phi, rng.random_range(0.0..std::f64::consts::TAU), length);
        let begin = Instant::now();
        let path = geodesic(&volume, a, b, RULER_VERTICES, &voxel()).unwrap();
        slowest = slowest.max(begin.elapsed().as_secs_f64() * 1e3);
        on(&volume, &path);
        let off = path.length_mm() / length - 1.0;
        worst = worst.max(off.abs());
        assert!(off.abs() < 0.003, "phi {phi}, length {length}: {:.4} % off", off * 100.0);
    }
    println!("torus: worst {:.4} %, slowest {slowest:.1} ms", worst * 100.0);
}

#[test]
fn vertices_and_ticks_are_even_and_on_the_surface() {
    let volume = sphere(40.0);
    let path = geodesic(&volume, DVec3::X * 40.0, DVec3::new(1.0, 2.0, 0.5).normalize() * 40.0, 65, &voxel()).unwrap();
    assert_eq!(path.points().len(), 65);
    let mean = path.length_mm() / 64.0;
    assert!(path.points().windows(2).all(|p| (p[0].distance(p[1]) / mean - 1.0).abs() < 0.02));
    let ticks = path.ticks(&volume, 2.5, &voxel());
    assert_eq!(ticks.len(), (path.length_mm() / 2.5).floor() as usize + 1);
    for (k, tick) in ticks.iter().enumerate() {
        assert_eq!(tick.along_mm, 2.5 * k as f64);
        assert!(volume.value(tick.at).unwrap().abs() < 1.01e-3);
        assert!(tick.tangent.dot(tick.normal).abs() < 1e-12 && (tick.tangent.length() - 1.0).abs() < 1e-12);
        let angle = tick.at.angle_between(ticks[0].at);
        assert!((angle * 40.0 - tick.along_mm).abs() < 0.05, "{} against {}", angle * 40.0, tick.along_mm);
    }
    assert!(path.ticks(&volume, 0.0, &voxel()).is_empty() && path.ticks(&volume, f64::NAN, &voxel()).is_empty());
}

#[test]
fn a_strip_has_its_width_and_left_is_left() {
    let volume = sphere(40.0);
    let path = geodesic(&volume, DVec3::X * 40.0, DVec3::Y * 40.0, 65, &voxel()).unwrap();
    let strip = path.strip(&volume, -4.0, 8.0, 13, &voxel());
    assert_eq!((strip.columns, strip.rows, strip.trimmed(), strip.quads().len()), (65, 13, 0, 64 * 12));
    for column in 0..65 {
        for row in 0..13 {
            let p = strip.point(column, row).unwrap();
            assert!(volume.value(p).unwrap().abs() < 1.01e-3);
            // Along the equator toward y, left seen from outside is +z.
            let latitude = (p.z / p.length()).asin() * 40.0;
            assert!((latitude - strip.across_mm[row]).abs() < 0.03, "{latitude} for {}", strip.across_mm[row]);
        }
    }
    for [a, b, c, d] in strip.quads() {
        let [a, b, c, d] = [a, b, c, d].map(|i| strip.points[i as usize].unwrap());
        assert!((b - a).cross(c - a).dot(a) > 0.0 && (c - a).cross(d - a).dot(a) > 0.0);
    }
    assert_eq!(strip.uv(0, 0), glam::DVec2::ZERO);
    assert_eq!(strip.uv(64, 12), glam::DVec2::ONE);
    assert!((strip.uv(32, 4).x - 0.5).abs() < 0.01 && (strip.uv(32, 4).y - 4.0 / 12.0).abs() < 1e-12);
}

#[test]
fn a_strip_is_trimmed_where_the_volume_ends() {
    let volume = cylinder(20.0, 10.0);
    let at = |t: f64| DVec3::new(20.0 * t.cos(), 20.0 * t.sin(), 4.0);
    let path = geodesic(&volume, at(0.1), at(1.0), 33, &voxel()).unwrap();
    let strip = path.strip(&volume, -8.0, 8.0, 17, &voxel());
    for row in 0..17 {
        let there = (0..33).filter(|&c| strip.point(c, row).is_some()).count();
        let expected = if 4.0 + strip.across_mm[row] < 9.9 { 33 } else { 0 };
        assert!(there == expected || (strip.across_mm[row] - 6.0).abs() < 0.1, "row {row}: {there}");
    }
}

#[test]
fn a_baseline_follows_the_points_that_were_picked() {
    let volume = sphere(30.0);
    let picked: Vec<DVec3> = (0..9)
        .map(|k| DVec3::new(1.0, 0.1 * k as f64, 0.2 * (0.8 * k as f64).sin()).normalize() * 30.0)
        .map(|p| project(&volume, p, p.normalize(), 1e-3).unwrap())
        .collect();
    let path = SurfacePath::through(&volume, &picked, &voxel()).unwrap();
    on(&volume, &path);
    for p in picked {
        let near = path.points().iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
        assert!(near < 0.6, "{near}");
    }
    assert!(path.points().windows(2).all(|p| p[0].distance(p[1]) < 1.1));
    assert!(SurfacePath::through(&volume, &[], &voxel()).is_none());
}

#[test]
fn pieces_that_are_not_connected_are_told() {
    let two = Voxels::of(DVec3::splat(-30.0), DVec3::splat(30.0), 1.0, |p| {
        (8.0 - p.distance(DVec3::X * 15.0)).max(8.0 - p.distance(DVec3::X * -15.0))
    });
    let found = geodesic(&two, DVec3::X * 7.0, DVec3::X * -7.0, 129, &voxel());
    assert!(matches!(found, Err(GeodesicError::NotConnected { .. })), "{found:?}");
    let found = geodesic(&two, DVec3::X * 23.0, DVec3::X * -23.0, 129, &voxel());
    assert!(matches!(found, Err(GeodesicError::NotConnected { .. })), "{found:?}");
    let found = geodesic(&two, DVec3::X * 7.0, DVec3::X * 7.0, 129, &voxel());
    assert!(matches!(found, Err(GeodesicError::Same { .. })), "{found:?}");
    let found = geodesic(&two, DVec3::X * 7.0, DVec3::X * 1e3, 129, &voxel());
    assert!(matches!(found, Err(GeodesicError::NoSurface { end: "second", .. })), "{found:?}");
}

#[test]
fn a_horseshoe_is_measured_around_its_bend() {
    // A bent rod: half a torus closed by balls; straight at the goal ends in the gap.
    let (ring, tube) = (20.0, 6.0);
    let volume = Voxels::of(DVec3::new(-30.0, -30.0, -10.0), DVec3::new(30.0, 30.0, 10.0), 1.0, |p| {
        let rod = if p.y > -10.0 { tube - (p.truncate().length() - ring).hypot(p.z) } else { -1e3 };
        let ends = [-1.0, 1.0].map(|s| tube - p.distance(DVec3::new(s * 300f64.sqrt(), -10.0, 0.0)));
        rod.max(ends[0]).max(ends[1])
    });
    let top = |x: f64| DVec3::new(x * 300f64.sqrt(), -10.0, tube);
    let begin = Instant::now();
    let path = geodesic(&volume, top(-1.0), top(1.0), 129, &voxel()).unwrap();
    println!("horseshoe: {:.2} mm in {:.1} ms", path.length_mm(), begin.elapsed().as_secs_f64() * 1e3);
    on(&volume, &path);
    // Through the inner side at least along the inner ring's arc, at most along the ring's own.
    let arc = 4.0 / 3.0 * std::f64::consts::PI;
    assert!(path.length_mm() > arc * (ring - tube) && path.length_mm() < arc * ring, "{}", path.length_mm());
}

#[test]
fn a_ruler_is_the_same_every_time_and_both_ways() {
    let volume = torus(30.0, 12.0);
    let [a, b] = [DVec3::new(42.0, 0.0, 0.0), DVec3::new(10.0, 28.0, 11.0)];
    let one = geodesic(&volume, a, b, 129, &voxel()).unwrap();
    assert_eq!(one, geodesic(&volume, a, b, 129, &voxel()).unwrap());
    let back = geodesic(&volume, b, a, 129, &voxel()).unwrap();
    assert!((one.length_mm() / back.length_mm() - 1.0).abs() < 1e-3);
}

#[test]
fn a_ruler_on_rough_ground_finds_its_way() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut volume = sphere(40.0);
    volume.values.iter_mut().for_each(|v| *v += rng.random_range(-0.8..0.8));
    for _ in 0..12 {
        let [a, b] = std::array::from_fn(|_| unit(&mut rng));
        let ends = [a, b].map(|n| project(&volume, n * 40.0, n, 1e-3).unwrap());
        let path = geodesic(&volume, ends[0], ends[1], RULER_VERTICES, &voxel()).unwrap();
        on(&volume, &path);
        let ratio = path.length_mm() / (40.0 * a.angle_between(b));
        // Uphill and down again, but no layer left: neighbours stay neighbours.
        assert!((0.99..1.15).contains(&ratio), "{ratio}");
        let longest = path.points().windows(2).map(|p| p[0].distance(p[1])).fold(0.0, f64::max);
        assert!(longest < 4.0 * path.length_mm() / 128.0, "{longest}");
        assert!((path.points()[0].distance(ends[0])).max(path.points().last().unwrap().distance(ends[1])) < 2e-3);
    }
}

/// Counts how often a field is asked for its value.
struct Counted(Voxels, AtomicUsize);

impl Surface for Counted {
    fn value(&self, p: DVec3) -> Option<f64> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.value(p)
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        self.0.gradient(p)
    }
}

#[test]
fn a_ruler_takes_few_looks_at_the_field() {
    let volume = Counted(cylinder(25.0, 60.0), AtomicUsize::new(0));
    let at = |t: f64, z: f64| DVec3::new(25.0 * f64::cos(t), 25.0 * f64::sin(t), z);
    geodesic(&volume, at(0.0, -20.0), at(2.0, 25.0), RULER_VERTICES, &voxel()).unwrap();
    let looks = volume.1.load(Ordering::Relaxed);
    println!("{looks} values");
    assert!(looks < 8_000, "{looks}");
}

#[test]
fn a_ruler_in_a_groove_does_not_overshoot() {
    // The inner side of a thin ring is a saddle so strong that undamped steps grow from round to round.
    let (ring, tube) = (24.0, 4.0);
    let box_ = DVec3::new(30.0, 30.0, 6.0);
    let volume = Voxels::of(-box_, box_, 0.5, |p| tube - (p.truncate().length() - ring).hypot(p.z));
    for heading in [0.001, 0.002, 0.003] {
        let [a, b] = shot(ring, tube, std::f64::consts::PI, heading, 50.0);
        let path = geodesic(&volume, a, b, RULER_VERTICES, &Tracing::of_voxel(0.5)).unwrap();
        let off = path.length_mm() / 50.0 - 1.0;
        println!("groove, end {:.2} mm up: {:.4} %", b.z, off * 100.0);
        assert!(off.abs() < 0.003, "{off}");
    }
}

#[test]
fn a_strip_has_its_width_at_coarse_steps_too() {
    let volume = sphere(20.0);
    let path = geodesic(&volume, DVec3::X * 20.0, DVec3::Y * 20.0, 33, &voxel()).unwrap();
    let coarse = Tracing { step_mm: 6.0, tolerance_mm: 1e-3 };
    let strip = path.strip(&volume, 0.0, 18.0, 4, &coarse);
    for column in 0..33 {
        let p = strip.point(column, 3).unwrap();
        let latitude = (p.z / p.length()).asin() * 20.0;
        assert!((latitude / 18.0 - 1.0).abs() < 0.008, "{latitude}");
    }
}

#[test]
fn neighbours_on_two_pieces_are_not_joined() {
    // Two plates back to back, a voxel and a half apart at the nearest: straight at the goal is a step across the gap.
    let gap = Voxels::of(DVec3::splat(-20.0), DVec3::splat(20.0), 1.0, |p| (p.x.abs() - 1.6).min(12.0 - p.length()));
    let at = |x: f64| DVec3::new(x, 3.0, 2.0);
    let found = geodesic(&gap, at(-1.6), at(1.6), 9, &Tracing { step_mm: 4.0, tolerance_mm: 1e-3 });
    assert!(matches!(found, Err(GeodesicError::NotConnected { .. })), "{found:?}");
}

#[test]
fn the_last_stretch_does_not_leap_a_slit() {
    // A slab cut in two by a slit narrower than a step; the goal lies just beyond it.
    let slab = Voxels::of(DVec3::splat(-20.0), DVec3::splat(20.0), 1.0, |p| (0.3 - p.z).min(p.x.abs() - 0.9));
    let at = |x: f64| DVec3::new(x, 0.2, 0.3);
    let coarse = Tracing { step_mm: 2.0, tolerance_mm: 1e-3 };
    for to in [1.6, 1.8, 2.0] {
        let found = geodesic(&slab, at(-15.0), at(to), 129, &coarse);
        assert!(matches!(found, Err(GeodesicError::NotConnected { .. })), "{to}: {:?}", found.map(|p| p.length_mm()));
        assert!(geodesic(&slab, at(-15.0), at(-to), 129, &coarse).is_ok());
    }
}
