use super::*;
use rand::{Rng, SeedableRng, rngs::StdRng};

fn grid() -> Grid {
    Grid::aligned([64; 3], DVec3::new(1.0, 0.8, 2.0), DVec3::ZERO)
}

fn wander(n: usize) -> Vec<Sample> {
    let mut rng = StdRng::seed_from_u64(11);
    let mut at = DVec3::splat(20.0);
    (0..n)
        .map(|_| {
            at += DVec3::new(rng.random_range(-3.0..3.5), rng.random_range(-3.0..3.5), rng.random_range(-1.0..1.5));
            Sample { pressure: rng.random_range(0.0..1.0), ..sample(at) }
        })
        .collect()
}

#[test]
fn dabs_do_not_depend_on_how_samples_arrive() {
    let samples = wander(60);
    let brush = hard(Shape::Sphere, 4.0);
    let whole = StrokePath::new(&brush, &grid()).unwrap().extend(&samples).unwrap();
    let mut rng = StdRng::seed_from_u64(3);
    for _ in 0..20 {
        let mut path = StrokePath::new(&brush, &grid()).unwrap();
        let mut parts = Vec::new();
        let mut rest = &samples[..];
        while !rest.is_empty() {
            let (now, later) = rest.split_at(rng.random_range(0..=rest.len().min(7)));
            parts.extend(path.extend(now).unwrap());
            rest = later;
        }
        assert_eq!(parts, whole);
    }
}

#[test]
fn further_samples_on_the_same_line_move_no_dab() {
    let ends = [sample(DVec3::ZERO), Sample { pressure: 0.2, ..sample(DVec3::new(30.0, 12.0, -7.0)) }];
    let brush = hard(Shape::Sphere, 3.0);
    let plain = StrokePath::new(&brush, &grid()).unwrap().extend(&ends).unwrap();
    let mut path = StrokePath::new(&brush, &grid()).unwrap();
    let fine: Vec<_> = (0..=997)
        .map(|i| {
            let t = f64::from(i) / 997.0;
            Sample { pressure: 1.0 - 0.8 * t as f32, ..sample(ends[0].position.lerp(ends[1].position, t)) }
        })
        .collect();
    let split = path.extend(&fine).unwrap();
    assert_eq!(split.len(), plain.len());
    for (a, b) in split.iter().zip(&plain) {
        // 997 additions of lengths, and f32 pressure.
        assert!(a.centre.distance(b.centre) < 1e-9 && (a.pressure - b.pressure).abs() < 1e-6);
    }
}

#[test]
fn a_line_gives_its_length_over_the_step_dabs() {
    let brush = Brush { spacing: 0.2, ..hard(Shape::Sphere, 5.0) };
    let mut path = StrokePath::new(&brush, &grid()).unwrap();
    let dabs = path.extend(&[sample(DVec3::ZERO), sample(DVec3::new(10.5, 0.0, 0.0))]).unwrap();
    assert_eq!(dabs.len(), 11);
    assert_eq!((path.step_mm(), path.length_mm()), (1.0, 10.5));
    for (i, dab) in dabs.iter().enumerate() {
        assert!(dab.centre.distance(DVec3::X * i as f64) < 1e-12);
    }
}

#[test]
fn neighbouring_dabs_lie_a_step_apart_along_the_way() {
    let brush = hard(Shape::Sphere, 2.0);
    let mut path = StrokePath::new(&brush, &grid()).unwrap();
    let dabs = path.extend(&wander(200)).unwrap();
    assert_eq!(dabs.len() as u64, (path.length_mm() / path.step_mm()) as u64 + 1);
    assert!(dabs.windows(2).all(|w| w[0].centre.distance(w[1].centre) <= path.step_mm() * (1.0 + 1e-9)));
}

#[test]
fn a_click_is_one_dab_even_if_the_pointer_rests() {
    let mut path = StrokePath::new(&hard(Shape::Sphere, 4.0), &grid()).unwrap();
    let at = sample(DVec3::new(3.0, 4.0, 5.0));
    assert_eq!(path.extend(&[at]).unwrap().len(), 1);
    assert_eq!(path.extend(&[at, at]).unwrap().len(), 0);
    assert_eq!(path.extend(&[]).unwrap().len(), 0);
}

#[test]
fn pressure_runs_evenly_between_samples() {
    let brush = Brush { spacing: 0.25, ..hard(Shape::Sphere, 4.0) };
    let mut path = StrokePath::new(&brush, &grid()).unwrap();
    let dabs = path.extend(&[Sample { pressure: 0.0, ..sample(DVec3::ZERO) }, sample(DVec3::X * 8.0)]).unwrap();
    for (i, dab) in dabs.iter().enumerate() {
        assert!((dab.pressure - i as f32 / 8.0).abs() < 1e-6);
    }
}

#[test]
fn radius_zero_leaves_no_gap_between_voxels() {
    for (name, grid) in grids() {
        let brush = hard(Shape::Sphere, 0.0);
        let mut path = StrokePath::new(&brush, &grid).unwrap();
        let ends = [DVec3::new(2.2, 3.1, 1.4), DVec3::new(37.0, 20.5, 29.0)];
        let dabs = path.extend(&ends.map(|p| sample(grid.world_from_index.transform_point3(p)))).unwrap();
        let way: Vec<_> = dabs.iter().map(|d| d.footprint(&brush, &grid).unwrap().bounds.lo).collect();
        for w in way.windows(2) {
            assert!((0..3).all(|a| w[0][a].abs_diff(w[1][a]) <= 1), "{name}: {w:?}");
        }
        assert_eq!((way[0], *way.last().unwrap()), ([2, 3, 1], [37, 20, 29]), "{name}");
    }
}

#[test]
fn what_is_no_sample_is_refused_and_changes_nothing() {
    let mut path = StrokePath::new(&hard(Shape::Sphere, 4.0), &grid()).unwrap();
    path.extend(&[sample(DVec3::ZERO)]).unwrap();
    let bad = [
        Sample { position: DVec3::new(0.0, f64::NAN, 0.0), ..sample(DVec3::ZERO) },
        Sample { pressure: 1.5, ..sample(DVec3::ZERO) },
        Sample { pressure: f32::NAN, ..sample(DVec3::ZERO) },
        Sample { normal: DVec3::splat(f64::INFINITY), ..sample(DVec3::ZERO) },
        sample(DVec3::X * 1e30),
    ];
    for bad in bad {
        let before = format!("{path:?}");
        let error = path.extend(&[sample(DVec3::X), bad]).unwrap_err();
        assert!(error.to_string().contains("sample"), "{error}");
        assert_eq!(format!("{path:?}"), before);
    }
}

#[test]
fn a_stroke_covers_its_last_sample() {
    let ends = [sample(DVec3::ZERO), sample(DVec3::new(9.9, 0.0, 0.0))];
    for (tip, share) in [(Tip::Wash, 1.0), (Tip::BuildUp, 0.9)] {
        let brush = Brush { tip, ..hard(Shape::Sphere, 4.0) };
        let mut path = StrokePath::new(&brush, &grid()).unwrap();
        assert_eq!(path.extend(&ends).unwrap().len(), 10);
        let last = path.end().unwrap();
        assert_eq!(last.centre, ends[1].position);
        // 0.9 of a step of 1 mm lies behind it.
        assert!((last.pressure - share).abs() < 1e-6, "{tip:?}: {}", last.pressure);
        assert_eq!(path.end(), None, "once");
        assert!((path.length_mm() - 9.9).abs() < 1e-12);
    }
    // Where a dab of the row lies at the last sample already, it is that one; a click is one dab.
    for samples in [&[sample(DVec3::ZERO), sample(DVec3::X * 7.0)][..], &[sample(DVec3::ZERO)]] {
        let mut path = StrokePath::new(&hard(Shape::Sphere, 4.0), &grid()).unwrap();
        path.extend(samples).unwrap();
        assert_eq!(path.end(), None);
    }
}

#[test]
fn a_break_ends_a_piece_and_begins_another() {
    let brush = hard(Shape::Sphere, 4.0);
    let [a, b, c, d] = [0.0, 2.5, 20.0, 23.5].map(|x| sample(DVec3::X * x));
    let mut path = StrokePath::new(&brush, &grid()).unwrap();
    let mut dabs = path.extend(&[a, b, Sample { breaks: true, ..c }, d]).unwrap();
    dabs.extend(path.end());
    let at: Vec<f64> = dabs.iter().map(|d| d.centre.x).collect();
    assert_eq!(at, [0.0, 1.0, 2.0, 2.5, 20.0, 21.0, 22.0, 23.0, 23.5]);
    assert_eq!(path.length_mm(), 6.0, "what lies between pieces is no way");
    // However samples arrive, and a break at the very beginning is none.
    let mut path = StrokePath::new(&brush, &grid()).unwrap();
    let mut parts = Vec::new();
    for s in [Sample { breaks: true, ..a }, b, Sample { breaks: true, ..c }, d] {
        parts.extend(path.extend(&[s]).unwrap());
    }
    parts.extend(path.end());
    assert_eq!(parts, dabs);
}

/// The voxels whose cells a segment runs through, and for how much of it, found by looking at many places on it.
fn run_through(grid: &Grid, a: DVec3, b: DVec3) -> std::collections::BTreeMap<[i64; 3], u32> {
    let inverse = grid.index_from_world();
    let mut cells = std::collections::BTreeMap::new();
    for i in 0..=200_000 {
        let p = inverse.transform_point3(a.lerp(b, f64::from(i) / 200_000.0));
        *cells.entry((p + 0.5).floor().to_array().map(|v| v as i64)).or_default() += 1;
    }
    cells
}

#[test]
fn a_thin_stroke_has_a_dab_in_every_voxel_that_it_passes_and_in_no_other() {
    let mut rng = StdRng::seed_from_u64(17);
    for (name, grid) in grids() {
        let thin = half_diagonal_mm(&grid);
        for radius_mm in [0.0, 1e-4, 0.2 * thin, 0.6 * thin, 0.99 * thin] {
            let brush = hard(Shape::Sphere, radius_mm);
            let mut at = || {
                let v = std::array::from_fn(|a| rng.random_range(0.0..f64::from(grid.dims[a]) - 1.0));
                grid.world_from_index.transform_point3(DVec3::from_array(v))
            };
            let ends = [at(), at()];
            let expected = run_through(&grid, ends[0], ends[1]);
            // As one segment, and as the hundred short ones of a slow hand.
            for parts in [1, 100] {
                let samples: Vec<_> =
                    (0..=parts).map(|i| sample(ends[0].lerp(ends[1], f64::from(i) / f64::from(parts)))).collect();
                let mut path = StrokePath::new(&brush, &grid).unwrap();
                let mut dabs: Vec<_> = samples.chunks(7).flat_map(|s| path.extend(s).unwrap()).collect();
                dabs.extend(path.end());
                let held = |d: &Dab| {
                    let p = grid.index_from_world().transform_point3(d.centre);
                    (p + 0.5).floor().to_array().map(|v| v as i64)
                };
                let found: std::collections::BTreeSet<_> = dabs.iter().map(held).collect();
                for (cell, places) in &expected {
                    // One that is passed for less than the places are apart may be missing from those that were looked at, not here.
                    assert!(found.contains(cell), "{name} {radius_mm}: {cell:?}, passed at {places} places");
                }
                let touched = found.iter().filter(|c| !expected.contains_key(*c)).count();
                assert!(touched <= 1, "{name} {radius_mm}: {touched} voxels that it does not pass");
                let full: Vec<_> = dabs.iter().filter_map(|d| d.footprint(&brush, &grid)).collect();
                for cell in expected.keys() {
                    let voxel = cell.map(|c| c as u32);
                    assert!(
                        full.iter().any(|f| f.coverage(voxel) == 1.0),
                        "{name} {radius_mm}: {voxel:?} is not covered"
                    );
                }
            }
        }
    }
}

#[test]
fn a_thin_stroke_that_builds_up_gives_its_last_voxel_all_of_the_strength() {
    let grid = Grid::aligned([12; 3], DVec3::ONE, DVec3::ZERO);
    for radius_mm in [0.0, 0.4] {
        let brush = Brush { tip: Tip::BuildUp, spacing: 0.25, ..hard(Shape::Sphere, radius_mm) };
        let mut path = StrokePath::new(&brush, &grid).unwrap();
        // It ends a hair beyond the border of a voxel, and a hair behind its last dab.
        let step = path.step_mm();
        let ends = [3.5 - 5.0 * step - 0.4 * step, 3.5 + 0.01 * step].map(|x| sample(DVec3::new(x, 4.0, 4.0)));
        let mut dabs = path.extend(&ends).unwrap();
        let of = |dabs: &[Dab]| -> f64 {
            let footprints = dabs.iter().filter_map(|d| d.footprint(&brush, &grid));
            footprints.map(|f| f.coverage([4; 3])).fold(0.0, f64::max)
        };
        assert_eq!(of(&dabs), 0.0, "radius {radius_mm}: no dab of the row reaches it");
        dabs.extend(path.end());
        assert_eq!(of(&dabs), 1.0, "radius {radius_mm}");
    }
}

#[test]
fn a_thin_stroke_exactly_through_corners_paints_no_voxel_beside_it() {
    let grid = Grid::aligned([12; 3], DVec3::ONE, DVec3::ZERO);
    let brush = hard(Shape::Sphere, 0.3);
    let mut path = StrokePath::new(&brush, &grid).unwrap();
    let mut dabs = path.extend(&[sample(DVec3::ONE), sample(DVec3::splat(9.0))]).unwrap();
    dabs.extend(path.end());
    let covered: std::collections::BTreeSet<_> = dabs
        .iter()
        .filter_map(|d| d.footprint(&brush, &grid))
        .flat_map(|f| voxels([12; 3]).filter(move |&v| f.coverage(v) > 0.0))
        .collect();
    assert_eq!(covered, (1..=9).map(|i| [i; 3]).collect());
}

#[test]
fn from_half_the_diagonal_on_equation_2_stands_alone() {
    let grid = Grid::aligned([9; 3], DVec3::ONE, DVec3::ZERO);
    let half = half_diagonal_mm(&grid);
    assert!((half - 0.75_f64.sqrt()).abs() < 1e-12);
    // At the corner between eight voxels.
    let corner = dab(DVec3::splat(4.4999), half * 0.999);
    let linear = Brush { falloff: Falloff::Linear, ..hard(Shape::Sphere, half * 0.999) };
    assert_eq!(corner.footprint(&linear, &grid).unwrap().coverage([4; 3]), 1.0);
    let linear = Brush { radius_mm: half, ..linear };
    let wide = dab(DVec3::splat(4.4999), half).footprint(&linear, &grid).unwrap();
    assert!(wide.coverage([4; 3]) < 0.001);
}

#[test]
fn pressure_scales_strength_or_radius_or_both_and_leaves_no_gaps() {
    let grid = Grid::aligned([64; 3], DVec3::ONE, DVec3::ZERO);
    for (strength, radius) in [(true, false), (false, true), (true, true), (false, false)] {
        let brush = Brush { radius_mm: 8.0, pressure: Pressure { strength, radius }, ..Brush::default() };
        let at = |x: f64, pressure: f32| Sample { pressure, ..sample(DVec3::new(x, 30.0, 30.0)) };
        let mut path = StrokePath::new(&brush, &grid).unwrap();
        let mut dabs = path.extend(&[at(5.0, 1.0), at(35.0, 0.1), at(50.0, 0.1)]).unwrap();
        dabs.extend(path.end());
        for dab in &dabs {
            // Pressure falls evenly to a tenth at 35 mm.
            let pressed = (1.0 - (dab.centre.x - 5.0) / 30.0 * 0.9).max(0.1);
            let expected = if radius { 8.0 * pressed.max(0.25) } else { 8.0 };
            assert!((dab.radius_mm - expected).abs() < 1e-5, "{} at {}", dab.radius_mm, dab.centre.x);
            let gain = if strength { pressed } else { 1.0 };
            assert!((f64::from(dab.pressure) - gain).abs() < 1e-6, "{} at {}", dab.pressure, dab.centre.x);
        }
        for pair in dabs.windows(2) {
            assert!(pair[0].centre.distance(pair[1].centre) <= 0.25 * pair[1].radius_mm + 1e-9);
        }
    }
}
