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
