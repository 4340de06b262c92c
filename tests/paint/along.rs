//! Dabs that lie along a surface: ellipsoids, and what is moved along the normal.

use super::*;
use rand::{Rng, SeedableRng, rngs::StdRng};

/// The ellipsoid |across|² + (along / ratio)² ≤ r², or the ball about each point of a way of `half` up and down the normal.
fn form(brush: &Brush, normal: DVec3, half: f64, offset: DVec3) -> f64 {
    let along = offset.dot(normal);
    let across = (offset - normal * along).length();
    let beyond = (along.abs() - half).max(0.0);
    let ratio = if brush.shape == Shape::Ellipsoid { brush.ratio } else { 1.0 };
    let x = (across.powi(2) + (beyond / ratio).powi(2)).sqrt() / brush.radius_mm;
    if x > 1.0 { 0.0 } else { f64::from(brush.strength) * (1.0 - x * x).powi(2) }
}

#[test]
fn a_dab_along_a_surface_has_its_form_on_every_grid_and_lies_in_its_box() {
    let mut rng = StdRng::seed_from_u64(11);
    for (name, grid) in grids() {
        for (shape, operation, ratio, height) in [
            (Shape::Ellipsoid, Operation::Replace, 0.3, 5.0),
            (Shape::Ellipsoid, Operation::Add, 2.0, 5.0),
            (Shape::Sphere, Operation::Raise, 0.5, 2.5),
            (Shape::Sphere, Operation::Push, 0.5, 0.0),
            (Shape::Ellipsoid, Operation::Pull, 0.4, 3.0),
        ] {
            let brush = Brush {
                shape,
                operation,
                ratio,
                height_mm: Some(height),
                radius_mm: 6.5,
                strength: 0.7,
                target: Target::Density(1.0),
                ..Brush::default()
            };
            brush.check().unwrap();
            let normal = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0))).normalize();
            let at = DVec3::from_array(std::array::from_fn(|a| rng.random_range(0.0..f64::from(grid.dims[a]))));
            let centre = grid.world_from_index.transform_point3(at);
            let dab = Dab { normal, ..dab(centre, brush.radius_mm) };
            let footprint = dab.footprint(&brush, &grid).unwrap();
            let half = if operation.displaces() { height } else { 0.0 };
            for v in voxels(grid.dims) {
                let expected = form(&brush, normal, half, centre_of(&grid, v) - centre);
                let found = footprint.coverage(v);
                assert!((found - expected).abs() < 1e-7, "{name} {shape:?} {operation:?} {v:?}: {found} {expected}");
                let b = footprint.bounds;
                let inside = (0..3).all(|a| b.lo[a] <= v[a] && v[a] < b.end[a]);
                assert!(inside || expected == 0.0, "{name} {shape:?} {operation:?}: {b:?} lacks {v:?}");
            }
        }
    }
}

#[test]
fn a_flat_ball_has_the_volume_of_an_ellipsoid() {
    let grid = Grid::aligned([64; 3], DVec3::ONE, DVec3::ZERO);
    for ratio in [0.25, 0.5, 1.0, 1.5] {
        let brush = Brush { ratio, ..hard(Shape::Ellipsoid, 16.0) };
        let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
        let dab = Dab { normal, ..dab(DVec3::new(31.3, 31.8, 31.1), 16.0) };
        let footprint = dab.footprint(&brush, &grid).unwrap();
        let inside = voxels(grid.dims).filter(|v| footprint.coverage(*v) > 0.0).count() as f64;
        let expected = 4.0 / 3.0 * std::f64::consts::PI * 16.0_f64.powi(3) * ratio;
        assert!((inside / expected - 1.0).abs() < 0.01, "{ratio}: {inside} for {expected}");
    }
}
