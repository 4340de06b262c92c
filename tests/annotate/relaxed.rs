//! Annotation grids on surfaces: measures, back-tracing and relaxation against formulas and a plain minimiser.

use super::traced_grid::plain_grid;
use super::trilinear::Volume;
use burin::annotate::grid::SurfaceGrid;
use burin::annotate::relaxing::relax::relax;
use burin::annotate::surface::{Surface, normal, project};
use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const MIDDLE: DVec3 = DVec3::splat(31.5);

fn ball(radius: f64) -> Volume {
    Volume::of([64; 3], 1.0, 0.0, |p| radius - p.distance(MIDDLE))
}

fn never() -> bool {
    false
}

/// Distance to the trilinear iso-surface, in voxels: the value over the field's own slope.
fn farthest_off(grid: &SurfaceGrid, surface: &Volume) -> f64 {
    let slope = |p: DVec3| {
        let ahead = |axis: DVec3| {
            surface.value(p + axis * 1e-5).unwrap_or(f64::NAN) - surface.value(p - axis * 1e-5).unwrap_or(f64::NAN)
        };
        DVec3::new(ahead(DVec3::X), ahead(DVec3::Y), ahead(DVec3::Z)).length() / 2e-5
    };
    grid.points
        .iter()
        .flatten()
        .map(|&p| surface.value(p).expect("inside").abs() / slope(p) / surface.voxel)
        .fold(0.0, f64::max)
}

/// Like gyri: a ball with seeded waves on it.
fn bumpy(seed: u64, height: f64) -> Volume {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let waves: Vec<(DVec3, f64)> = (0..12)
        .map(|_| {
            let k = DVec3::new(
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
            );
            (k.normalize() * random.random_range(0.3..0.6), random.random_range(0.0..std::f64::consts::TAU))
        })
        .collect();
    Volume::of([64; 3], 1.0, 0.0, move |p| {
        let on = (p - MIDDLE).normalize_or_zero() * 24.0;
        24.0 + height * waves.iter().map(|(k, phase)| (k.dot(on) + phase).sin()).sum::<f64>() / 12.0_f64.sqrt()
            - p.distance(MIDDLE)
    })
}

fn check(name: &str, surface: &Volume, grid: &SurfaceGrid) {
    let excess = grid.distortion().excess;
    let least = super::relaxed_oracle::least_excess(grid, 400);
    println!(
        "{name}: excess {excess:.5}, least {least:.5}, trimmed {}, off {:.4}",
        grid.trimmed(),
        farthest_off(grid, surface)
    );
    assert_eq!(grid.turned_over(surface), 0, "{name}");
    assert!(farthest_off(grid, surface) < 0.05, "{name}");
    assert!(excess <= 1.25 * least + 0.01, "{name}: {excess} over {least}");
    // Tighter than asked: at rest the lattice is the minimiser.
    assert!(excess <= 1.05 * least + 0.001, "{name}: {excess} over {least}");
}

#[test]
fn a_plane_stays_flat() {
    let slope = DVec3::new(0.3, -0.2, 1.0).normalize();
    let plane = Volume::of([64; 3], 1.0, 0.0, |p| slope.dot(MIDDLE - p));
    let along = DVec3::new(1.0, 0.5, 0.3);
    let grid = relax(&plane, MIDDLE + slope * 2.0, along, 41, 31, 1.1, None, &never);
    let f = (along - slope * along.dot(slope)).normalize();
    let b = slope.cross(f);
    for (index, point) in grid.points.iter().enumerate() {
        let exact = MIDDLE + f * (1.1 * ((index % 41) as f64 - 20.0)) + b * (1.1 * ((index / 41) as f64 - 15.0));
        let off = point.expect("inside").distance(exact);
        assert!(off < 0.01 * 1.1, "{index}: {off}");
    }
    assert!(grid.distortion().excess < 1e-5);
    assert_eq!(grid.turned_over(&plane), 0);
}

#[test]
fn a_cylinder_unrolls() {
    let radius = 18.0;
    let pipe = Volume::of([64; 3], 1.0, 0.0, |p| radius - (p - MIDDLE).truncate().length());
    let seed = MIDDLE + DVec3::X * radius;
    let grid = relax(&pipe, seed, DVec3::new(0.0, 1.0, 0.7), 41, 41, 1.0, None, &never);
    let (along, up) = (DVec3::new(0.0, 1.0, 0.7).normalize(), DVec3::new(0.0, -0.7, 1.0).normalize());
    for (index, point) in grid.points.iter().enumerate() {
        let flat = along * ((index % 41) as f64 - 20.0) + up * ((index / 41) as f64 - 20.0);
        let turn = flat.y / radius;
        let exact = MIDDLE + DVec3::new(radius * turn.cos(), radius * turn.sin(), flat.z);
        let off = point.expect("inside").distance(exact);
        assert!(off < 0.01 * flat.length().max(5.0), "{index}: {off}");
    }
    check("cylinder", &pipe, &grid);
    assert!(grid.distortion().excess < 1e-3);
}

#[test]
fn a_sphere_and_a_torus_are_whole_and_least() {
    let torus = Volume::of([64; 3], 1.0, 0.0, |p| {
        let q = p - MIDDLE;
        8.0 - DVec3::new(q.truncate().length() - 18.0, 0.0, q.z).length()
    });
    let sphere = ball(20.0);
    let tip = MIDDLE + DVec3::new(1.0, 2.0, 2.0).normalize() * 20.0;
    for (name, surface, seed, along, step) in [
        ("sphere", &sphere, tip, DVec3::X, 0.75),
        ("torus outside", &torus, MIDDLE + DVec3::X * 26.0, DVec3::Z, 0.5),
        ("torus top", &torus, MIDDLE + DVec3::new(18.0, 0.0, 8.0), DVec3::X, 0.6),
        ("torus inside", &torus, MIDDLE + DVec3::X * 10.0, DVec3::new(0.0, 1.0, 1.0), 0.5),
    ] {
        let plain = plain_grid(surface, seed, along, 41, 41, step);
        let grid = relax(surface, seed, along, 41, 41, step, Some(&plain), &never);
        assert_eq!(grid.trimmed(), 0, "{name}");
        check(name, surface, &grid);
        let (before, after) = (plain.distortion().excess, grid.distortion().excess);
        println!("{name}: plain {before:.5}, turned {}, trimmed {}", plain.turned_over(surface), plain.trimmed());
        assert!(
            after <= before || plain.turned_over(surface) > 0 || plain.trimmed() > 0,
            "{name}: {after} over {before}"
        );
    }
}

#[test]
fn bumps_are_covered_without_folds() {
    for seed in 0..4 {
        let surface = bumpy(seed, 1.2);
        let mut random = ChaCha8Rng::seed_from_u64(100 + seed);
        let way =
            DVec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), random.random_range(-1.0..1.0))
                .normalize();
        let seed_point = project(&surface, MIDDLE + way * 24.0, way, 1e-4).expect("a surface");
        let grid = relax(&surface, seed_point, DVec3::Z, 41, 41, 0.7, None, &never);
        assert_eq!(grid.trimmed(), 0, "{seed}");
        check(&format!("bumps {seed}"), &surface, &grid);
    }
}

#[test]
fn a_finer_lattice_is_as_good() {
    let surface = bumpy(9, 1.0);
    let tip = project(&surface, MIDDLE + DVec3::X * 24.0, DVec3::X, 1e-4).expect("a surface");
    let [coarse, fine] =
        [(41, 0.8), (81, 0.4)].map(|(n, step)| relax(&surface, tip, DVec3::Y, n, n, step, None, &never));
    assert_eq!(fine.trimmed(), 0);
    assert_eq!(fine.turned_over(&surface), 0);
    let (a, b) = (coarse.distortion().excess, fine.distortion().excess);
    assert!((a - b).abs() < 0.1 * a + 0.001, "{a} and {b}");
    check("81", &surface, &fine);
}

#[test]
fn centre_and_axis_stay_and_nothing_is_mirrored() {
    let surface = bumpy(5, 1.0);
    let start = MIDDLE + DVec3::new(2.0, 1.0, -1.0).normalize() * 25.0;
    let along = DVec3::new(0.1, 1.0, 0.4);
    let grid = relax(&surface, start, along, 41, 21, 0.7, None, &never);
    let outward = normal(&surface, start).expect("a normal");
    let seed = project(&surface, start, outward, 1e-5).expect("a surface");
    let at = |right: isize, up: isize| grid.points[((10 + up) * 41 + 20 + right) as usize].expect("there");
    assert!(at(0, 0).distance(seed) < 2e-3);
    let n = normal(&surface, seed).expect("a normal");
    let f = n.cross(along.cross(n)).normalize();
    let b = n.cross(f);
    let u = at(1, 0) - at(-1, 0);
    assert!(u.dot(f) > 0.0 && (u.dot(b) / u.dot(f)).abs() < 0.02, "{}", u.dot(b) / u.dot(f));
    assert!((at(0, 1) - at(0, -1)).dot(b) > 0.0);
}

#[test]
fn a_lower_plain_grid_is_not_made_worse() {
    // A grid that is a little too small bends around less of the sphere.
    let sphere = ball(20.0);
    let seed = MIDDLE + DVec3::Z * 20.0;
    let relaxed = relax(&sphere, seed, DVec3::X, 41, 41, 1.1, None, &never);
    let smaller = relax(&sphere, seed, DVec3::X, 41, 41, 1.095, None, &never);
    let plain = SurfaceGrid { spacing_mm: 1.1, ..smaller };
    let least = plain.distortion().excess;
    assert!(least < relaxed.distortion().excess, "{least} {}", relaxed.distortion().excess);
    let grid = relax(&sphere, seed, DVec3::X, 41, 41, 1.1, Some(&plain), &never);
    assert!(grid.distortion().excess <= least);
    // One that is turned over is no measure, however low.
    let mut folded = plain.clone();
    folded.points = plain.points.chunks_exact(41).rev().flatten().copied().collect();
    let grid = relax(&sphere, seed, DVec3::X, 41, 41, 1.1, Some(&folded), &never);
    assert_eq!(grid.turned_over(&sphere), 0);
    assert_eq!(grid, relaxed);
}

/// A surface of which a ball is missing.
struct Holed(Volume, DVec3, f64);

impl Surface for Holed {
    fn value(&self, p: DVec3) -> Option<f64> {
        self.0.value(p).filter(|_| p.distance(self.1) > self.2)
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        self.0.gradient(p).filter(|_| p.distance(self.1) > self.2)
    }
}

#[test]
fn holes_and_borders_are_trimmed_and_the_rest_is_relaxed() {
    let seed = MIDDLE + DVec3::Z * 20.0;
    let hole = MIDDLE + DVec3::new(6.0, 0.0, 19.0);
    let holed = Holed(ball(20.0), hole, 2.5);
    let grid = relax(&holed, seed, DVec3::X, 41, 41, 0.6, None, &never);
    assert_eq!(grid.turned_over(&holed), 0);
    assert!((30..200).contains(&grid.trimmed()), "{}", grid.trimmed());
    assert!(grid.points.iter().flatten().all(|p| p.distance(hole) > 2.5));
    let behind = grid.points.iter().flatten().filter(|p| p.x > hole.x + 3.5 && (p.y - hole.y).abs() < 2.0).count();
    assert!(behind > 20, "{behind}");
    check("hole", &holed.0, &grid);

    // The border of the volume cuts the sphere 3 mm beside the seed.
    let cut = Volume::of([64, 64, 64], 1.0, 0.0, |p| 20.0 - p.distance(DVec3::new(3.0, 31.5, 31.5)));
    let grid = relax(&cut, DVec3::new(3.0, 31.5, 51.5), DVec3::X, 41, 41, 0.5, None, &never);
    assert_eq!(grid.turned_over(&cut), 0);
    let left = grid.points.iter().filter(|p| p.is_some()).count();
    assert!((41 * 25..41 * 29).contains(&left), "{left}");
    check("border", &cut, &grid);
}

#[test]
fn nothing_comes_of_nothing() {
    let sphere = ball(20.0);
    let seed = MIDDLE + DVec3::Z * 20.0;
    let all_trimmed = |grid: SurfaceGrid| grid.trimmed() == grid.points.len() && grid.points.len() == 41 * 21;
    assert!(all_trimmed(relax(&sphere, DVec3::splat(-9.0), DVec3::X, 41, 21, 0.5, None, &never)));
    assert!(all_trimmed(relax(&sphere, seed, DVec3::ZERO, 41, 21, 0.5, None, &never)));
    assert!(all_trimmed(relax(&sphere, seed, DVec3::X, 40, 20, 0.5, None, &|| true)));
    let [a, b] = [0, 1].map(|_| relax(&bumpy(3, 1.0), MIDDLE + DVec3::X * 24.0, DVec3::Y, 31, 41, 0.7, None, &never));
    assert_eq!(a, b);
}

#[test]
fn back_tracing_ends_at_the_change_of_sign() {
    let surface = bumpy(1, 1.0);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..500 {
        let way =
            DVec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), random.random_range(-1.0..1.0))
                .normalize();
        let from = MIDDLE + way * random.random_range(20.0..28.0);
        let found = project(&surface, from, way, 1e-4).expect("a surface");
        assert!((found - from).cross(way).length() < 1e-9);
        let [inside, outside] = [-2e-4, 2e-4].map(|by| surface.value(found + way * by).expect("inside"));
        assert!(inside > 0.0 && outside < 0.0);
    }
    // Outward of the outermost surface there is none, and leaving the volume is no arrival.
    assert!(project(&surface, MIDDLE + DVec3::X * 28.0, -DVec3::X, 1e-4).is_none());
    assert!(project(&surface, DVec3::splat(100.0), DVec3::X, 1e-4).is_none());
}

#[test]
fn measures_follow_their_formulas() {
    let plane = Volume::of([64; 3], 1.0, 0.0, |p| MIDDLE.z - p.z);
    let of = |u: DVec3, v: DVec3| {
        let points = (0..35).map(|i| Some(MIDDLE + u * ((i % 7) as f64 - 3.0) + v * ((i / 7) as f64 - 2.0))).collect();
        SurfaceGrid { columns: 7, rows: 5, spacing_mm: 2.0, points }
    };
    let (a, b): (f64, f64) = (1.3, 0.7);
    let found = of(DVec3::X * 2.0 * a, DVec3::Y * 2.0 * b).distortion();
    let excess = (a * a + b * b + 1.0 / (a * a) + 1.0 / (b * b)) / 4.0 - 1.0;
    assert!((found.excess - excess).abs() < 1e-12);
    assert!((found.most_area - a * b).abs() < 1e-12 && (found.least_area - a * b).abs() < 1e-12);
    assert!((found.most_length - a).abs() < 1e-12 && (found.least_length - b).abs() < 1e-12);
    // Three columns of quads stretched by 2 among three that are not: a mean over the area on the surface.
    let mut mixed = of(DVec3::X * 2.0, DVec3::Y * 2.0);
    for (index, point) in mixed.points.iter_mut().enumerate() {
        *point = Some(
            MIDDLE + DVec3::new([0.0, 2.0, 4.0, 6.0, 10.0, 14.0, 18.0][index % 7] - 9.0, 2.0 * (index / 7) as f64, 0.0),
        );
    }
    let mean = (1.0 * 4.0 + 2.0 * (4.0 + 0.25 + 1.0 + 1.0)) / 3.0;
    assert!((mixed.distortion().excess - (mean / 4.0 - 1.0)).abs() < 1e-12);
    // A shear by s: singular values σ, 1/σ with σ² + σ⁻² = 2 + s².
    let found = of(DVec3::X * 2.0, DVec3::new(1.0, 2.0, 0.0)).distortion();
    assert!((found.excess - 0.125).abs() < 1e-12);

    let mut grid = of(DVec3::X * 2.0, DVec3::Y * 2.0);
    assert_eq!((grid.triangles().len(), grid.turned_over(&plane), grid.trimmed()), (48, 0, 0));
    assert!(grid.normals(&plane).iter().all(|n| n.is_some_and(|n| n.distance(DVec3::Z) < 1e-9)));
    assert_eq!(of(DVec3::X * 2.0, -DVec3::Y * 2.0).turned_over(&plane), 48);
    // The centre drawn over its right neighbour: of its six triangles those two turn that lie between them.
    grid.points[17] = Some(MIDDLE + DVec3::X * 2.5);
    assert_eq!(grid.turned_over(&plane), 2);
    grid.points[17] = None;
    assert_eq!((grid.triangles().len(), grid.trimmed()), (40, 1));
}
