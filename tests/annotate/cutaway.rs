//! Closed meshes of windowed cutaways: every edge twice, inside as rays count it, rims on the surface.

use super::voxels::{distance_to_triangle, is_closed, sphere, torus, winding_by_ray};
use burin::annotate::grid::SurfaceGrid;
use burin::annotate::path::strip::{Tracing, rim_bands};
use burin::annotate::surface::{Surface, project};
use burin::annotate::window::cutaway::{CutPart, Cutaway, winding};
use burin::annotate::window::patch::{Patch, PatchError};
use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// A grid on the dome z = √(R² − x² − y²) with jitter and bumps; vertices are trimmed with the given share.
fn grid(rng: &mut ChaCha8Rng, side: usize, trimmed: f64, bumps: f64) -> SurfaceGrid {
    let middle = (side - 1) as f64 / 2.0;
    let mut points: Vec<Option<DVec3>> = (0..side * side)
        .map(|i| {
            let (x, y) = ((i % side) as f64 - middle, (i / side) as f64 - middle);
            let jitter = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.2..0.2)));
            let z = (900.0 - x * x - y * y).sqrt() - 30.0 + bumps * (x * 1.3).sin() * (y * 1.1).cos();
            Some(DVec3::new(x, y, z) + jitter)
        })
        .collect();
    points.iter_mut().for_each(|p| {
        if rng.random_bool(trimmed) {
            *p = None;
        }
    });
    SurfaceGrid { columns: side, rows: side, spacing_mm: 1.0, points }
}

fn closed(cut: &Cutaway) {
    is_closed(cut.corners(), cut.triangles()).unwrap();
}

#[test]
fn every_edge_is_twice_in_opposite_directions_however_the_grid_is_trimmed() {
    let mut pinched = 0;
    let mut holed = 0;
    for seed in 0..400 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let share = [0.0, 0.05, 0.2, 0.4, 0.55][seed as usize % 5];
        let bumps = if seed % 3 == 0 { 4.0 } else { 0.3 };
        let side = rng.random_range(3..18);
        let grid = grid(&mut rng, side, share, bumps);
        match Patch::from_grid(&grid, DVec3::Z) {
            Ok(patch) => {
                let cut = Cutaway::new(&patch, DVec3::Z, 5.0, 1.0).unwrap();
                closed(&cut);
                let loops = patch.border();
                assert_eq!(
                    loops.iter().map(Vec::len).sum::<usize>(),
                    cut.triangles().len() / 2 - patch.triangles().len()
                );
                holed += usize::from(loops.len() > 1);
                let present = grid.points.iter().flatten().count();
                pinched += usize::from(patch.corners().len() > present);
            }
            Err(e) => assert_eq!(e, PatchError::Empty),
        }
    }
    assert!(pinched > 20 && holed > 100, "{pinched} {holed}");
}

#[test]
fn triangles_without_area_are_taken_out_and_leave_neither_gap_nor_slit() {
    for seed in 0..200 {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let mut grid = grid(&mut rng, 9, 0.05, 0.0);
        // A flat grid, some of whose vertices fall together with a neighbour, and some of whose rows are in line.
        for i in 0..81 {
            if let Some(p) = &mut grid.points[i] {
                *p = DVec3::new((i % 9) as f64, (i / 9) as f64, 0.0);
            }
        }
        for _ in 0..rng.random_range(1..12) {
            let i = rng.random_range(0..80);
            if grid.points[i].is_some() && i % 9 != 8 {
                grid.points[i] = if rng.random() { grid.points[i + 1] } else { grid.points[(i + 9).min(80)] };
            }
        }
        let Ok(patch) = Patch::from_grid(&grid, DVec3::Z) else { continue };
        closed(&Cutaway::new(&patch, DVec3::Z, 2.0, 0.0).unwrap());
    }
    // An apex in the middle of an edge that another triangle has: one border loop round, no slit.
    let corners = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let patch = Patch::new(&corners, &[[0, 1, 3], [0, 2, 1], [0, 4, 2], [2, 4, 1]]).unwrap();
    assert_eq!(patch.triangles().len(), 4);
    assert_eq!(patch.border().len(), 1);
    assert_eq!(patch.border()[0].len(), 4);
    assert!((patch.area_mm2() - 2.0).abs() < 1e-12);
    closed(&Cutaway::new(&patch, DVec3::Z, 1.0, 0.5).unwrap());
}

#[test]
fn vertices_that_fall_together_leave_no_slit() {
    let mut points: Vec<Option<DVec3>> =
        (0..25).map(|i| Some(DVec3::new((i % 5) as f64, (i / 5) as f64, 0.0))).collect();
    points[12] = points[11];
    points[17] = points[18];
    let patch = Patch::from_grid(&SurfaceGrid { columns: 5, rows: 5, spacing_mm: 1.0, points }, DVec3::Z).unwrap();
    let border = patch.border();
    assert_eq!((border.len(), border[0].len()), (1, 16));
    assert!((patch.area_mm2() - 16.0).abs() < 1e-9);
    closed(&Cutaway::new(&patch, DVec3::Z, 2.0, 0.0).unwrap());
}

#[test]
fn a_patch_given_clockwise_is_turned() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let patch = Patch::new(&corners, &[[0, 2, 1]]).unwrap();
    let cut = Cutaway::new(&patch, DVec3::Z, 2.0, 1.0).unwrap();
    closed(&cut);
    assert!((cut.winding(DVec3::new(0.2, 0.2, -1.0)) - 1.0).abs() < 1e-12);
    let [low, high] = cut.bounds();
    assert_eq!((low.z, high.z), (-2.0, 1.0));
}

#[test]
fn triangles_along_the_centre_normal_are_left_out() {
    // A step: flat, a riser along z, flat; and the same with the riser at the border.
    let at = |x: f64, y: f64, z: f64| Some(DVec3::new(x, y, z));
    let step = SurfaceGrid {
        columns: 4,
        rows: 2,
        spacing_mm: 1.0,
        points: vec![
            at(0., 0., 0.),
            at(1., 0., 0.),
            at(1., 0., 1.),
            at(2., 0., 1.),
            at(0., 1., 0.),
            at(1., 1., 0.),
            at(1., 1., 1.),
            at(2., 1., 1.),
        ],
    };
    let patch = Patch::from_grid(&step, DVec3::Z).unwrap();
    let cut = Cutaway::new(&patch, DVec3::Z, 0.4, 0.1).unwrap();
    closed(&cut);
    assert!(cut.contains(DVec3::new(0.5, 0.5, -0.2)) && cut.contains(DVec3::new(1.5, 0.5, 0.8)));
    assert!(!cut.contains(DVec3::new(0.5, 0.5, 0.5)) && !cut.contains(DVec3::new(1.5, 0.5, 0.3)));
    let riser = SurfaceGrid {
        columns: 2,
        rows: 2,
        spacing_mm: 1.0,
        points: vec![step.points[1], step.points[2], step.points[5], step.points[6]],
    };
    let patch = Patch::from_grid(&riser, DVec3::X).unwrap();
    assert!(Cutaway::new(&patch, DVec3::Z, 0.4, 0.1).is_err());
}

#[test]
fn the_mesh_faces_outward_whichever_way_the_grid_runs() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut grid = grid(&mut rng, 8, 0.0, 0.0);
    for _ in 0..2 {
        let patch = Patch::from_grid(&grid, DVec3::Z).unwrap();
        let cut = Cutaway::new(&patch, DVec3::Z * 3.0, 4.0, 0.5).unwrap();
        let volume: f64 = cut
            .triangles()
            .iter()
            .map(|t| t.map(|i| cut.corners()[i as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        let shadow: f64 = patch
            .triangles()
            .iter()
            .map(|t| t.map(|i| patch.corners()[i as usize]))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).z)
            .sum();
        assert!((volume - shadow * 4.5).abs() < 1e-9 && volume > 0.0, "{volume} {shadow}");
        let count = |part| (0..cut.triangles().len()).filter(|&t| cut.part(t) == part).count();
        assert_eq!([count(CutPart::Sheet), count(CutPart::Floor)], [patch.triangles().len(); 2]);
        assert_eq!(count(CutPart::Wall), 2 * 28);
        for (t, tri) in cut.triangles().iter().enumerate() {
            let [a, b, c] = tri.map(|i| cut.corners()[i as usize]);
            let n = (b - a).cross(c - a).normalize();
            match cut.part(t) {
                CutPart::Sheet => assert!(n.z > 0.3),
                CutPart::Floor => assert!(n.z < -0.3),
                CutPart::Wall => assert!(n.z.abs() < 1e-9),
            }
        }
        // The rim is the border on the surface, counter-clockwise.
        let rim = &cut.rim()[0];
        let turn: f64 = (0..rim.len()).map(|k| rim[k].cross(rim[(k + 1) % rim.len()]).z).sum();
        assert!(cut.rim().len() == 1 && rim.len() == 28 && turn > 0.0);
        grid.points = grid.points.chunks(8).flat_map(|row| row.iter().rev().copied().collect::<Vec<_>>()).collect();
    }
}

fn agrees(cut: &Cutaway, points: usize, seed: u64) -> (usize, usize, usize) {
    let [low, high] = cut.bounds();
    let grow = 0.1 * (high - low);
    (0..points)
        .into_par_iter()
        .map(|i| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed * 1_000_003 + i as u64);
            let p = DVec3::from_array(std::array::from_fn(|k| rng.random_range((low - grow)[k]..(high + grow)[k])));
            let near =
                cut.triangles().iter().any(|t| distance_to_triangle(p, t.map(|i| cut.corners()[i as usize])) < 1e-4);
            if near {
                return (0, 0, 0);
            }
            let by_ray = winding_by_ray(cut.corners(), cut.triangles(), p, &mut rng);
            let here = cut.winding(p);
            assert!((here - f64::from(by_ray)).abs() < 1e-6, "{p}: {here}, rays say {by_ray}");
            assert_eq!(cut.contains(p), by_ray != 0, "{p}");
            (1, usize::from(by_ray != 0), usize::from(!(0..=1).contains(&by_ray)))
        })
        .reduce(|| (0, 0, 0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2))
}

#[test]
fn inside_agrees_with_rays() {
    let (mut asked, mut inside, mut folded) = (0, 0, 0);
    for seed in 0..10 {
        let mut rng = ChaCha8Rng::seed_from_u64(50 + seed);
        let (share, bumps) = [(0.0, 0.0), (0.1, 0.3), (0.3, 3.0), (0.0, 6.0), (0.2, 0.0)][seed as usize % 5];
        let grid = grid(&mut rng, 13, share, bumps);
        let patch = Patch::from_grid(&grid, DVec3::Z).unwrap();
        // An oblique centre normal makes the sheet fold over itself as it is displaced.
        let outward = if seed < 5 { DVec3::Z } else { DVec3::new(1.0, 0.4, 0.5) };
        let cut = Cutaway::new(&patch, outward, 4.0, 0.5).unwrap();
        let (a, i, f) = agrees(&cut, 10_000, seed);
        (asked, inside, folded) = (asked + a, inside + i, folded + f);
    }
    println!("{asked} points asked, {inside} inside, {folded} of them with a winding other than 1");
    assert!(asked > 99_000 && inside > 15_000 && folded > 300, "{asked} {inside} {folded}");
}

#[test]
fn overlapping_cutaways_of_opposite_sheets_do_not_cancel() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let patch = Patch::from_grid(&grid(&mut rng, 6, 0.0, 0.0), DVec3::Z).unwrap();
    let one = Cutaway::new(&patch, DVec3::Z, 3.0, 0.0).unwrap();
    let turned: Vec<[u32; 3]> = one.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
    let inside = DVec3::new(0.1, 0.2, -1.5);
    assert!((winding(one.corners(), one.triangles(), inside) - 1.0).abs() < 1e-9);
    assert!((winding(one.corners(), &turned, inside) + 1.0).abs() < 1e-9);
    assert!(one.contains(inside));
}

#[test]
fn what_cannot_be_is_refused() {
    let bad = SurfaceGrid { columns: 3, rows: 3, spacing_mm: 1.0, points: vec![None; 8] };
    assert!(matches!(Patch::from_grid(&bad, DVec3::Z), Err(PatchError::NotAGrid { .. })));
    assert!(matches!(Patch::new(&[DVec3::ZERO], &[[0, 1, 0]]), Err(PatchError::NoSuchCorner { .. })));
    assert!(matches!(Patch::new(&[DVec3::NAN], &[]), Err(PatchError::NotAPlace { .. })));
    let line = [0.0, 1.0, 2.0].map(|x| DVec3::new(x, 0.0, 0.0));
    assert_eq!(Patch::new(&line, &[[0, 1, 2]]), Err(PatchError::Empty));
    let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let patch = Patch::new(&flat, &[[0, 1, 2]]).unwrap();
    for (outward, depth, lift) in
        [(DVec3::ZERO, 1.0, 0.0), (DVec3::Z, 0.0, 0.0), (DVec3::Z, f64::NAN, 0.0), (DVec3::Z, 1.0, -0.1)]
    {
        assert!(Cutaway::new(&patch, outward, depth, lift).is_err());
    }
}

#[test]
fn rim_bands_lie_on_the_surface_at_their_width_outside_the_window() {
    let volume = sphere(30.0);
    let tracing = Tracing::of_voxel(1.0);
    // A cap of 0.4 rad about z: its border is a circle, beside it the band is a ring.
    let mut corners = vec![DVec3::new(0.0, 0.0, 30.0)];
    let place =
        |polar: f64, turn: f64| 30.0 * DVec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
    corners.extend((0..96).map(|k| place(0.4, std::f64::consts::TAU * k as f64 / 96.0)));
    let corners: Vec<DVec3> = corners.iter().map(|&c| project(&volume, c, c.normalize(), 1e-4).unwrap()).collect();
    let triangles: Vec<[u32; 3]> = (0..96).map(|k| [0, 1 + k, 1 + (k + 1) % 96]).collect();
    let patch = Patch::new(&corners, &triangles).unwrap();
    let bands = rim_bands(&volume, &patch, 1.0, 3.0, 5, &tracing);
    assert_eq!(bands.len(), 1);
    let band = &bands[0];
    assert_eq!((band.columns, band.rows, band.trimmed(), band.quads().len()), (97, 5, 0, 96 * 4));
    assert_eq!(band.across_mm, [-3.0, -2.0, -1.0, 0.0, 1.0]);
    for row in 0..5 {
        for column in 0..97 {
            let p = band.point(column, row).unwrap();
            assert!(volume.value(p).unwrap().abs() < 2e-3);
            let polar = (p.z / p.length()).acos();
            let expected = 0.4 - band.across_mm[row] / 30.0;
            assert!((polar - expected).abs() * 30.0 < 0.03, "row {row}: {} mm off", (polar - expected) * 30.0);
        }
        assert!(band.point(0, row).unwrap().distance(band.point(96, row).unwrap()) < 1e-9);
    }
    let around = 30.0 * 0.4_f64.sin() * std::f64::consts::TAU;
    assert!((band.along_mm[96] - around).abs() < 0.01 * around && band.uv(96, 4) == glam::DVec2::ONE);
    for [a, b, c, _] in band.quads() {
        let [a, b, c] = [a, b, c].map(|i| band.points[i as usize].unwrap());
        assert!((b - a).cross(c - a).dot(a) > 0.0);
    }
}

#[test]
fn rims_of_holes_have_their_band_in_the_hole() {
    let volume = torus(30.0, 15.0);
    let side = 13;
    let mut points: Vec<Option<DVec3>> = (0..side * side)
        .map(|i| {
            let (u, v) = ((i % side) as f64 - 6.0, (i / side) as f64 - 6.0);
            project(&volume, DVec3::new(30.0 + u, v, 15.0), DVec3::Z, 1e-4)
        })
        .collect();
    for v in 5..8 {
        for u in 5..8 {
            points[v * side + u] = None;
        }
    }
    let grid = SurfaceGrid { columns: side, rows: side, spacing_mm: 1.0, points };
    let patch = Patch::from_grid(&grid, DVec3::Z).unwrap();
    let bands = rim_bands(&volume, &patch, 0.0, 0.8, 2, &Tracing::of_voxel(1.0));
    assert_eq!(bands.len(), 2);
    let inner = bands.iter().min_by_key(|b| b.columns).unwrap();
    for column in 0..inner.columns {
        let (out, on) = (inner.point(column, 0).unwrap(), inner.point(column, 1).unwrap());
        let from_middle = |p: DVec3| (p - DVec3::new(30.0, 0.0, 0.0)).truncate().length();
        assert!(from_middle(out) < from_middle(on) - 0.4);
    }
}
