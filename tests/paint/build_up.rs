use super::*;
use rand::{Rng, SeedableRng, rngs::StdRng};

#[test]
fn no_voxel_gets_more_than_the_bound_and_the_bound_is_near() {
    let mut rng = StdRng::seed_from_u64(5);
    for (name, grid) in grids() {
        for radius_mm in [0.0, 0.6, 4.0, 11.0] {
            let brush = Brush { strength: 0.7, ..hard(Shape::Sphere, radius_mm) };
            let mut at = || centre_of(&grid, grid.dims.map(|n| rng.random_range(0..n)));
            let samples = [sample(at()), Sample { pressure: 0.5, ..sample(at()) }, sample(at())];
            let dabs = StrokePath::new(&brush, &grid).unwrap().extend(&samples).unwrap();
            let mut bound = BuildUpBound::new(&brush, &grid);
            // However it comes, it adds up to the same.
            bound.add(&dabs[..dabs.len() / 2]);
            let bound = bound.add(&dabs[dabs.len() / 2..]);
            let sum = |v: [u32; 3]| {
                let centre = centre_of(&grid, v);
                let holds = |d: &Dab| {
                    let index = grid.index_from_world().transform_point3(d.centre).round();
                    index.to_array() == v.map(f64::from)
                };
                let near = |d: &&Dab| if radius_mm > 0.0 { d.centre.distance(centre) <= radius_mm } else { holds(d) };
                dabs.iter().filter(near).map(|d| 0.7 * f64::from(d.pressure)).sum::<f64>()
            };
            // The fullest voxel is one that a dab's centre is in, or beside it.
            let home = |d: &Dab| grid.index_from_world().transform_point3(d.centre).round().as_u64vec3();
            let mut fullest: Vec<_> = dabs.iter().map(home).collect();
            fullest.dedup();
            let most = fullest.into_iter().map(|v| sum(v.to_array().map(|c| c as u32))).fold(0.0, f64::max);
            assert!(bound >= most - 1e-9, "{name} {radius_mm}: {bound} is less than {most}");
            assert!(radius_mm < 4.0 || bound < 4.0 * most, "{name} {radius_mm}: {bound} is far above {most}");
        }
    }
}

#[test]
fn dabs_at_the_end_of_numbers_are_no_reason_to_panic() {
    let brush = hard(Shape::Sphere, 1e-3);
    let grid = Grid::aligned([4; 3], DVec3::ONE, DVec3::ZERO);
    let far = [dab(DVec3::splat(1e100), 1e-3), dab(DVec3::splat(-1e100), 1e-3)];
    let mut bound = BuildUpBound::new(&brush, &grid);
    let one = bound.add(&far[..1]);
    let both = bound.add(&far[1..]);
    // Cells at the end of numbers are their own neighbours: still a bound, and still of these two dabs.
    assert!((1.0..=27.0).contains(&one) && both >= one && both <= 54.0, "{one} {both}");
    assert_eq!(BuildUpBound::new(&brush, &grid).add(&[dab(DVec3::ZERO, 1e-3)]), 1.0);
    assert_eq!(bound.add(&[dab(DVec3::ZERO, 1e-3)]), both, "what lies elsewhere adds nothing");
}

#[test]
fn a_disc_that_is_lifted_to_its_layer_is_within_the_bound() {
    // Slices far thicker than the disc: dabs of all heights in a slice end in its one layer of voxels.
    let grid = Grid::aligned([8, 8, 4], DVec3::new(1.0, 1.0, 6.0), DVec3::ZERO);
    for radius_mm in [0.5, 1.0, 4.0, 20.0] {
        let brush = Brush { strength: 0.5, ..hard(Shape::Disc, radius_mm) };
        let dabs: Vec<_> = (-29..30).map(|i| dab(DVec3::new(4.0, 4.0, 6.0 + f64::from(i) * 0.1), radius_mm)).collect();
        let bound = BuildUpBound::new(&brush, &grid).add(&dabs);
        // All of them are about voxel [4, 4, 1].
        assert!(bound >= 0.5 * dabs.len() as f64 - 1e-9, "{radius_mm}: {bound}");
        // Along an axis a stroke of any length stays within what is said of lines.
        let line: Vec<_> = (0..4000).map(|i| dab(DVec3::new(f64::from(i) * 0.1, 4.0, 6.0), radius_mm)).collect();
        let bound = BuildUpBound::new(&brush, &grid);
        let (said, found) = (bound.of_a_line(0.1), bound.clone().add(&line));
        assert!(found <= said + 0.5 && found > said * 0.5, "{radius_mm}: {found} of {said}");
    }
}
