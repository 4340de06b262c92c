use super::*;
use burin::volume::{BRICK, BrickIndex};
use rand::{Rng, SeedableRng, rngs::StdRng};

/// Equation 2, from the voxel's and the dab's places in the world. The disc: one layer of voxels across the voxel axis whose
/// layers face the normal best, distances within the layer.
fn equation_2(grid: &Grid, brush: &Brush, dab: &Dab, v: [u32; 3]) -> f64 {
    let index = grid.index_from_world().transform_point3(dab.centre);
    if brush.radius_mm == 0.0 {
        let holds = (0..3).all(|a| (index[a] - f64::from(v[a])).abs() <= 0.5);
        return if holds { f64::from(brush.strength * dab.pressure) } else { 0.0 };
    }
    let m = grid.world_from_index.matrix3;
    let mut offset = centre_of(grid, v) - dab.centre;
    if brush.shape == Shape::Disc {
        // Normals of the three layers, from the edges that span them.
        let normals = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
        let lean = |a: usize| (normals[a].normalize().dot(dab.normal)).abs();
        let axis = (0..3).max_by(|&a, &b| lean(a).total_cmp(&lean(b))).unwrap();
        if (index[axis] - f64::from(v[axis])).abs() > 0.5 {
            return 0.0;
        }
        let n = normals[axis].normalize();
        offset -= n * offset.dot(n);
    }
    let d = offset.length();
    if d > brush.radius_mm {
        return 0.0;
    }
    let x = d / brush.radius_mm;
    let f = match brush.falloff {
        Falloff::Hard => 1.0,
        Falloff::Linear => 1.0 - x,
        Falloff::Smooth => (1.0 - x.powi(2)).powi(2),
        Falloff::Gaussian => ((-4.5 * x * x).exp() - (-4.5_f64).exp()) / (1.0 - (-4.5_f64).exp()),
        Falloff::Curve(_) => drawn(x),
    };
    f64::from(brush.strength * dab.pressure) * f
}

#[test]
fn coverage_is_equation_2_on_every_grid() {
    let mut rng = StdRng::seed_from_u64(7);
    for (name, grid) in grids() {
        for shape in [Shape::Sphere, Shape::Disc] {
            for falloff in falloffs() {
                let brush =
                    Brush { shape, falloff, strength: 0.6, radius_mm: rng.random_range(1.5..9.0), ..Brush::default() };
                let at =
                    DVec3::from_array(std::array::from_fn(|a| rng.random_range(-2.0..f64::from(grid.dims[a]) + 1.0)));
                let normal = DVec3::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), 1.0).normalize();
                let dab = Dab {
                    centre: grid.world_from_index.transform_point3(at),
                    radius_mm: brush.radius_mm,
                    pressure: 0.75,
                    normal,
                };
                let footprint = dab.footprint(&brush, &grid);
                for v in voxels(grid.dims) {
                    let expected = equation_2(&grid, &brush, &dab, v);
                    let found = footprint.as_ref().map_or(0.0, |f| f.coverage(v));
                    // Both in f64; 1e-9 is far above its rounding and far below a step of any storage.
                    assert!((found - expected).abs() < 1e-9, "{name} {shape:?} {falloff:?} {v:?}: {found} {expected}");
                    if expected > 0.0 {
                        let b = footprint.as_ref().unwrap().bounds;
                        assert!(
                            (0..3).all(|a| b.lo[a] <= v[a] && v[a] < b.end[a]),
                            "{name} {shape:?}: {b:?} lacks {v:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_hard_ball_has_the_volume_of_a_ball() {
    for (name, grid) in grids() {
        let radius = 11.0;
        let middle = grid.world_from_index.transform_point3(DVec3::new(19.3, 17.6, 16.1));
        let Some(f) = dab(middle, radius).footprint(&hard(Shape::Sphere, radius), &grid) else { panic!("{name}") };
        let inside = voxels(grid.dims).filter(|&v| f.coverage(v) == 1.0).count() as f64;
        let voxel = grid.world_from_index.matrix3.determinant().abs();
        // Only where the volume holds the whole ball.
        let whole = (0..3).all(|a| f.bounds.lo[a] > 0 && f.bounds.end[a] < grid.dims[a]);
        let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        // A lattice of cells of diameter D miscounts at most the shell of half that thickness on either side; in the mean it
        // does far better, and a tenth of the bound is already 5 sigma for cells that fall on either side by chance.
        let spacing = grid.spacing();
        let shell = 4.0 * std::f64::consts::PI * radius.powi(2) * spacing.length();
        if whole {
            assert!((inside * voxel - ball).abs() < 0.1 * shell, "{name}: {} {ball}", inside * voxel);
        }
        assert!(whole || name != "cubes");
    }
}

#[test]
fn a_hard_disc_has_the_area_of_a_disc_and_one_layer() {
    for (name, grid) in grids() {
        let m = grid.world_from_index.matrix3;
        let normal = m.x_axis.cross(m.y_axis).normalize();
        let radius = 9.0;
        let centre = grid.world_from_index.transform_point3(DVec3::new(19.3, 17.6, 16.4));
        let dab = Dab { normal, ..dab(centre, radius) };
        let f = dab.footprint(&hard(Shape::Disc, radius), &grid).unwrap();
        let inside: Vec<_> = voxels(grid.dims).filter(|&v| f.coverage(v) > 0.0).collect();
        assert!(inside.iter().all(|v| v[2] == 16), "{name}");
        assert_eq!((f.bounds.lo[2], f.bounds.end[2]), (16, 17));
        let cell = m.x_axis.cross(m.y_axis).length();
        let area = std::f64::consts::PI * radius * radius;
        let rim = 2.0 * std::f64::consts::PI * radius * (m.x_axis.length() + m.y_axis.length());
        assert!((inside.len() as f64 * cell - area).abs() < 0.1 * rim, "{name}: {} {area}", inside.len() as f64 * cell);
    }
}

#[test]
fn a_hard_ball_holds_the_voxel_at_exactly_its_radius() {
    // 0.1-mm voxels have no exact f64; 3-4-5 triangles lie on the sphere.
    let grid = Grid::aligned([16; 3], DVec3::splat(0.1), DVec3::ZERO);
    let f = dab(centre_of(&grid, [8, 8, 8]), 0.5).footprint(&hard(Shape::Sphere, 0.5), &grid).unwrap();
    for v in [[13, 8, 8], [8, 3, 8], [11, 12, 8], [8, 5, 4], [4, 8, 11]] {
        assert_eq!(f.coverage(v), 1.0, "{v:?}");
    }
    assert_eq!(f.coverage([13, 9, 8]), 0.0);
    assert_eq!(f.bounds, IndexBox { lo: [3; 3], end: [14; 3] });
}

#[test]
fn radius_zero_is_one_voxel_and_outside_is_none() {
    for (name, grid) in grids() {
        for shape in [Shape::Sphere, Shape::Disc] {
            let at = grid.world_from_index.transform_point3(DVec3::new(31.4, 31.6, 0.3));
            let f = dab(at, 0.0).footprint(&hard(shape, 0.0), &grid).unwrap();
            assert_eq!(f.bounds, IndexBox { lo: [31, 32, 0], end: [32, 33, 1] }, "{name}");
            assert_eq!(f.coverage([31, 32, 0]), 1.0);
            assert_eq!(f.coverage([32, 32, 0]), 0.0);
            let out = grid.world_from_index.transform_point3(DVec3::new(31.4, 31.6, -0.6));
            assert_eq!(dab(out, 0.0).footprint(&hard(shape, 0.0), &grid), None, "{name}");
        }
    }
    let grid = Grid::aligned([8; 3], DVec3::ONE, DVec3::ZERO);
    assert_eq!(dab(DVec3::splat(-40.0), 3.0).footprint(&hard(Shape::Sphere, 3.0), &grid), None);
    assert_eq!(dab(DVec3::splat(f64::NAN), 3.0).footprint(&hard(Shape::Sphere, 3.0), &grid), None);
}

#[test]
fn bricks_hold_the_box_and_slots_see_it() {
    let dims = [70, 64, 100];
    for (lo, end) in [
        ([0, 0, 0], [1, 1, 1]),
        ([31, 32, 33], [32, 33, 34]),
        ([69, 63, 99], [70, 64, 100]),
        ([20, 0, 30], [65, 64, 97]),
    ] {
        let b = IndexBox { lo, end };
        let inside = |v: [u32; 3]| (0..3).all(|a| lo[a] <= v[a] && v[a] < end[a]);
        let all = |grow: i64| -> Vec<BrickIndex> {
            let count = dims.map(|d: u32| d.div_ceil(BRICK));
            voxels(count)
                .map(BrickIndex)
                .filter(|i| {
                    // Every texel of the brick (or slot), taken back into the volume.
                    voxels([BRICK + 2 * grow as u32; 3]).any(|t| {
                        let v: [i64; 3] = std::array::from_fn(|a| i64::from(i.0[a] * BRICK + t[a]) - grow);
                        let clamped = std::array::from_fn(|a| v[a].clamp(0, i64::from(dims[a]) - 1) as u32);
                        inside(clamped)
                    })
                })
                .collect()
        };
        assert_eq!(b.bricks().collect::<Vec<_>>(), all(0), "{lo:?}");
        assert_eq!(b.slots(dims).collect::<Vec<_>>(), all(1), "{lo:?}");
    }
}
