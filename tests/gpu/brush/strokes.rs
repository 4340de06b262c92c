//! Every target, operation, tip, falloff and shape on anisotropic, turned and sheared grids, against the oracle.

use super::reference::{check, mismatches};
use super::*;

const OPERATIONS: [Operation; 5] =
    [Operation::Replace, Operation::Add, Operation::Subtract, Operation::Blend, Operation::Restore];

/// Dabs that overlap, lie on brick borders, in a corner of the volume, half outside.
fn dabs(grid: &Grid, radius_mm: f64, rng: &mut StdRng) -> Vec<Dab> {
    let size = grid.dims_f64();
    let border = DVec3::from_array(size.to_array().map(|d| if d > 32.0 { 31.4 } else { d / 2.0 + 0.1 }));
    let mut at = vec![
        border,
        border + DVec3::new(-0.4, -3.0, 0.6),
        DVec3::new(-0.5, -0.4, 0.2),
        size - DVec3::new(0.6, 0.0, 0.7),
    ];
    at.extend((0..2).map(|_| DVec3::from_array(std::array::from_fn(|a| rng.random_range(0.0..size[a])))));
    at.into_iter().map(|i| Dab { pressure: rng.random_range(0.3..1.0), ..dab_at(grid, i, radius_mm) }).collect()
}

/// All brushes of a target, on one grid or another.
fn every_brush(canvases: &mut [Canvas], target: Target, range: [f64; 2]) {
    let mut rng = StdRng::seed_from_u64(5);
    let mut n = 0;
    for operation in OPERATIONS {
        for tip in [Tip::Wash, Tip::BuildUp] {
            for falloff in falloffs() {
                for shape in [Shape::Sphere, Shape::Disc, Shape::Ellipsoid] {
                    n += 1;
                    let count = canvases.len();
                    let canvas = &mut canvases[rng.random_range(0..count)];
                    let brush = Brush {
                        shape,
                        radius_mm: [rng.random_range(2.0..8.0), 3.0][n % 2],
                        falloff,
                        strength: [0.8, 1.0, 0.3][n / 3 % 3],
                        operation,
                        tip,
                        target,
                        ratio: [0.4, 1.7][n % 2],
                        spacing: 0.25,
                        range: (n % 5 == 0).then_some(range.map(Number::Real)),
                        erase: n % 13 == 0,
                        pressure: Pressure { strength: true, radius: n % 3 == 0 },
                        ..Brush::default()
                    };
                    let mut dabs = dabs(&canvas.grid, brush.radius_mm, &mut rng);
                    if brush.pressure.radius {
                        // A lighter touch is smaller, but not thinner than a voxel.
                        dabs.iter_mut().for_each(|dab| dab.radius_mm *= rng.random_range(0.8..1.0));
                    }
                    let found = canvas.paint(&brush, &dabs);
                    check(&format!("{brush:?}"), canvas, &brush, &dabs, &found);
                }
            }
        }
    }
}

#[test]
fn selection_is_painted_as_the_equations_say() {
    let Some(gpu) = gpu() else { return };
    every_brush(&mut oracle_grids().map(|g| Canvas::codes(&gpu, g)), Target::Selection(0.9), [10_000.0, 40_000.0]);
}

#[test]
fn colour_is_painted_as_the_equations_say() {
    let Some(gpu) = gpu() else { return };
    let target = Target::Colour([0.9, 0.25, 0.6, 0.7]);
    every_brush(&mut oracle_grids().map(|g| Canvas::codes(&gpu, g)), target, [10_000.0, 40_000.0]);
}

#[test]
fn labels_are_painted_as_the_equations_say() {
    let Some(gpu) = gpu() else { return };
    every_brush(&mut oracle_grids().map(|g| Canvas::floats(&gpu, g)), Target::Label(255), [-20.0, 60.0]);
}

#[test]
fn density_codes_are_painted_as_the_equations_say() {
    let Some(gpu) = gpu() else { return };
    // A map with codes to spare on both sides, so that no offset leaves it, and edits to restore.
    let mut canvases = oracle_grids().map(|grid| {
        let voxels = Voxels::I16(each(grid.dims, |v| (noise(v, 0) % 4000) as i16 - 1000));
        let source = MemorySource::new("synthetic", grid, voxels, (1.0, 0.0)).unwrap();
        let map = DensityMap::codes(-2000.0, 4000.0, Some(1.0));
        let field = Field::from_source(std::sync::Arc::new(source), map, &|_| true).unwrap().unwrap();
        let mut canvas = Canvas::new(&gpu, grid, field);
        edit(&mut canvas);
        canvas
    });
    every_brush(&mut canvases, Target::Density(612.5), [-100.0, 900.5]);
}

#[test]
fn density_floats_are_painted_as_the_equations_say() {
    let Some(gpu) = gpu() else { return };
    let mut canvases = oracle_grids().map(|grid| {
        let mut canvas = Canvas::floats(&gpu, grid);
        edit(&mut canvas);
        canvas
    });
    every_brush(&mut canvases, Target::Density(33.25), [-20.0, 60.0]);
}

/// An earlier edit in one brick, for strokes that restore.
fn edit(canvas: &mut Canvas) {
    let texel = canvas.density.map().encode(50.0);
    canvas.density.swap(vec![(BrickIndex([0; 3]), Some(Brick::Uniform(texel)))]).unwrap();
    let gpu = gpu().unwrap();
    canvas.pools = FieldPools::new(&gpu, &canvas.grid, &canvas.density, 64 << 20).unwrap();
}

#[test]
fn the_printed_form_of_equation_1_is_not_what_is_painted() {
    let Some(gpu) = gpu() else { return };
    let mut canvas = Canvas::codes(&gpu, grids()[0]);
    let brush = Brush { radius_mm: 6.0, ..Brush::default() };
    let dabs = [dab_at(&canvas.grid, DVec3::new(20.0, 18.0, 15.0), 6.0)];
    let found = canvas.paint(&brush, &dabs);
    assert!(mismatches(&canvas, &brush, &dabs, &found, false).is_empty());
    // It paints everything outside of the brush.
    assert!(mismatches(&canvas, &brush, &dabs, &found, true).len() > 40_000);
}

#[test]
fn a_hard_ball_has_the_volume_of_a_ball() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([80; 3]);
    let mut canvas = Canvas::blank(&gpu, grid);
    let radius = 30.0;
    let brush = Brush { radius_mm: radius, falloff: Falloff::Hard, target: Target::Label(9), ..Brush::default() };
    let found = canvas.paint(&brush, &[dab_at(&grid, DVec3::new(40.2, 39.7, 40.4), radius)]);
    let inside = found.chunks_exact(2).filter(|t| **t == [9, 0]).count() as f64;
    let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    // The lattice points of a ball fluctuate about its volume by less than r^1.5 for such radii; a shell of one voxel is 60 times that.
    assert!((inside - ball).abs() < radius.powf(1.5), "{inside} {ball}");
}

#[test]
fn a_voxel_at_exactly_the_radius_is_painted() {
    let Some(gpu) = gpu() else { return };
    // 0.1 has no exact f64 or f32; 3-4-5 triangles lie on the rim.
    let grid = Grid::aligned([40; 3], DVec3::splat(0.1), DVec3::splat(-7.3));
    let mut canvas = Canvas::blank(&gpu, grid);
    let brush = Brush { radius_mm: 0.5, falloff: Falloff::Hard, ..Brush::default() };
    let found = canvas.paint(&brush, &[dab_at(&grid, DVec3::splat(31.0), 0.5)]);
    let at = |v: [usize; 3]| found[v[0] + 40 * (v[1] + 40 * v[2])];
    for v in [[36, 31, 31], [31, 26, 31], [34, 35, 31], [31, 28, 27], [27, 31, 34]] {
        assert_eq!(at(v), 255, "{v:?}");
    }
    assert_eq!(at([36, 32, 31]), 0);
    // Lattice points at most 5 from the centre.
    assert_eq!(found.iter().filter(|&&t| t != 0).count(), 515);
}

#[test]
fn radius_zero_paints_one_voxel_a_dab() {
    let Some(gpu) = gpu() else { return };
    for grid in grids() {
        let mut canvas = Canvas::codes(&gpu, grid);
        for shape in [Shape::Sphere, Shape::Disc] {
            let brush = Brush { shape, radius_mm: 0.0, target: Target::Selection(0.5), ..Brush::default() };
            let ends = [DVec3::new(2.2, 3.1, 1.4), DVec3::new(37.0, 33.5, 32.4)];
            let mut path = StrokePath::new(&brush, &grid).unwrap();
            let normal = dab_at(&grid, DVec3::ZERO, 0.0).normal;
            let samples = ends.map(|p| Sample {
                position: grid.world_from_index.transform_point3(p),
                normal,
                pressure: 1.0,
                breaks: false,
            });
            let dabs = path.extend(&samples).unwrap();
            let found = canvas.paint(&brush, &dabs);
            check("radius 0", &canvas, &brush, &dabs, &found);
            assert_eq!(found[2 + 40 * (3 + 36)], 128);
        }
    }
}

#[test]
fn weak_strokes_do_not_stall() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([12; 3]);
    let map = |from: &Voxels| {
        let source = MemorySource::new("flat", grid, from.clone(), (1.0, 0.0)).unwrap();
        let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
        Field::from_source(std::sync::Arc::new(source), map, &|_| true).unwrap().unwrap()
    };
    let density = map(&Voxels::U16(each(grid.dims, |v| if v[0] < 5 { 0 } else { 65_535 })));
    let at = DVec3::splat(5.0);
    let dabs = vec![dab_at(&grid, at, 2.0); 12_000];
    for (target, operation) in [
        (Target::Density(65_535.0), Operation::Replace),
        (Target::Density(0.0), Operation::Blend),
        (Target::Density(0.0), Operation::Restore),
        (Target::Selection(1.0), Operation::Replace),
        (Target::Colour([1.0, 0.5, 0.0, 1.0]), Operation::Blend),
        (Target::Colour([0.0; 4]), Operation::Restore),
    ] {
        let mut canvas = Canvas::new(&gpu, grid, density.clone());
        if operation == Operation::Restore {
            // 40,000 everywhere in the brick, over the source's ends.
            canvas.density.swap(vec![(BrickIndex([0; 3]), Some(Brick::Uniform([0x40, 0x9c, 0, 0])))]).unwrap();
            canvas.pools = FieldPools::new(&gpu, &grid, &canvas.density, 64 << 20).unwrap();
        }
        for tip in [Tip::BuildUp, Tip::Wash] {
            let brush = Brush {
                radius_mm: 2.0,
                falloff: Falloff::Hard,
                strength: 0.001,
                operation,
                tip,
                target,
                ..Brush::default()
            };
            let found = canvas.paint(&brush, &dabs);
            check(&format!("{brush:?}"), &canvas, &brush, &dabs, &found);
            if tip == Tip::BuildUp {
                // 1 − 0.999^12000 = 1 − 6e-6: the end itself, within half a step of 16 bits.
                let i = 5 + 12 * (5 + 12 * 5);
                match target {
                    Target::Density(c) if operation != Operation::Restore => {
                        assert_eq!(found[2 * i..2 * i + 2], (c as u16).to_le_bytes());
                    }
                    Target::Density(_) => assert_eq!(found[2 * i..2 * i + 2], [255; 2]),
                    Target::Selection(_) => assert_eq!(found[i], 255),
                    _ => assert_eq!(found[4 * i + 3], if operation == Operation::Restore { 0 } else { 255 }),
                }
            }
        }
    }
}

#[test]
fn a_weak_sum_adds_every_dab() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid(DIMS);
    let source = MemorySource::new("flat", grid, Voxels::U16(vec![1000; 40 * 36 * 34]), (1.0, 0.0)).unwrap();
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let field = Field::from_source(std::sync::Arc::new(source), map, &|_| true).unwrap().unwrap();
    let mut canvas = Canvas::new(&gpu, grid, field);
    let n = 3000;
    let dabs = vec![dab_at(&grid, DVec3::splat(16.0), 1.0); n];
    let brush = Brush {
        radius_mm: 1.0,
        falloff: Falloff::Hard,
        strength: 0.001,
        operation: Operation::Add,
        tip: Tip::BuildUp,
        target: Target::Density(10_000.0),
        ..Brush::default()
    };
    let found = canvas.paint(&brush, &dabs);
    let i = 16 + 40 * (16 + 36 * 16);
    let code = u16::from_le_bytes([found[2 * i], found[2 * i + 1]]);
    // n additions in f32 to a sum below 4, each rounded by at most 2^-23·2: n · 2.4e-7 · 10,000 codes.
    let bound = 1.0 + n as f64 * 2.4e-7 * 10_000.0;
    assert!((f64::from(code) - 31_000.0).abs() <= bound, "{code}");
}

#[test]
fn a_weak_stroke_on_integers_beyond_all_32_bit_floats_takes_its_share_and_no_more() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([12; 3]);
    let slope = 1e36;
    let source = MemorySource::new("large", grid, Voxels::U16(each(grid.dims, |_| 60_000)), (slope, 0.0)).unwrap();
    let map = DensityMap::floats(60_000.0 * slope);
    assert!(map.codes_per_unit < 1.0, "smaller by a power of two");
    let density = Field::from_source(std::sync::Arc::new(source), map, &|_| true).unwrap().unwrap();
    let brush = Brush {
        radius_mm: 2.0,
        falloff: Falloff::Hard,
        strength: 0.1,
        target: Target::Density(0.0),
        ..Brush::default()
    };
    let mut canvas = Canvas::new(&gpu, grid, density);
    let found = canvas.paint(&brush, &[dab_at(&grid, DVec3::splat(5.0), 2.0)]);
    let i = 5 + 12 * (5 + 12 * 5);
    let value = map.decode(std::array::from_fn(|b| found[4 * i + b]));
    // P + G·(C − P)
    let expected = 60_000.0 * slope * 0.9;
    assert!((value / expected - 1.0).abs() < 1e-6, "{value:e} for {expected:e}");
}

/// P + G (E − P), but no less than a whole step where fewer than five are left and that would be under half of one, and E from
/// within a step. The step is that of the reach, or of the end's own size where it lies outside.
#[test]
fn near_its_end_a_weak_stroke_in_floats_goes_by_whole_steps() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([36, 10, 8]);
    let cases = [
        (0.0_f64, [0.0, 16_383.75], 0.25_f64),
        (700.0, [0.0, 16_383.75], 0.25),
        (1e6, [0.0, 16_383.75], 1e6 / 65_535.0),
        (-1e6, [0.0, 16_383.75], 1e6 / 65_535.0),
        (0.0, [100.0, 16_483.75], 0.0),
    ];
    for (end, reach, step) in cases {
        let before = move |v| (end + (f64::from(noise(v, 9) % 4000) / 250.0 - 8.0) * step.max(0.25)) as f32;
        let mut canvas = Canvas::new(&gpu, grid, density_f32(grid, |_| end as f32));
        let bricks = canvas.density.brick_indices(0).into_iter().map(|index| {
            let o = index.origin();
            let texels = each([BRICK; 3], |v| before([0, 1, 2].map(|a| o[a] + v[a])).to_le_bytes());
            (index, Some(Brick::from_texels(texels.concat(), 4)))
        });
        let bricks = bricks.collect();
        canvas.density.swap(bricks).unwrap();
        canvas.pools = FieldPools::new(&gpu, &grid, &canvas.density, 64 << 20).unwrap();
        canvas.reach = Reach(reach);
        for (n, strength) in [0.012_f32, 0.06, 0.1, 0.13, 0.4, 0.9].into_iter().enumerate() {
            let operation = if end == 0.0 && n % 2 == 0 { Operation::Replace } else { Operation::Restore };
            let brush = Brush {
                radius_mm: 100.0,
                falloff: Falloff::Hard,
                strength,
                operation,
                tip: Tip::Wash,
                target: Target::Density(0.0),
                ..Brush::default()
            };
            let found = canvas.paint(&brush, &[dab_at(&grid, DVec3::new(18.0, 5.0, 4.0), 100.0)]);
            let mut stepped = [0; 3];
            for (v, found) in each(grid.dims, |v| v).into_iter().zip(found.chunks_exact(4)) {
                let (p, found) = (f64::from(before(v)), f64::from(f32::from_le_bytes(found.try_into().unwrap())));
                let mixed = p + f64::from(strength) * (end - p);
                let (way, moved) = ((end - p).abs(), (mixed - p).abs());
                // Where rounding decides.
                let edge = |a: f64, b: f64| b > 0.0 && (a - b).abs() < 0.01 * step;
                if edge(moved, 0.5 * step) || edge(way, 5.0 * step) || edge(way, step) {
                    continue;
                }
                let weak = way <= 5.0 * step && moved < 0.5 * step;
                let by_step = if way <= step { end } else { p + step * (end - p).signum() };
                stepped[usize::from(weak) + usize::from(weak && way <= step)] += 1;
                let expected = if weak { by_step } else { mixed };
                let off = (found - expected).abs();
                assert!(off <= 3e-7 * end.abs() + 1e-5, "{end} {strength}: {found} for {expected} from {p}");
            }
            assert!(stepped[0] > 100 && (step == 0.0 || strength > 0.4 || stepped[2] > 50), "{stepped:?}");
        }
    }
}

/// What adds up ends where the source's type does, or where one application does if that is further.
#[test]
fn sums_in_floats_end_as_those_of_the_type_do() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([36, 6, 5]);
    let value = |v: [u32; 3]| if v[0] == 0 { 3 } else { 3 + (noise(v, 4) % 250) as u8 };
    let source = MemorySource::new("bytes", grid, Voxels::U8(each(grid.dims, value)), (1.0, 0.0)).unwrap();
    let field = Field::from_source(std::sync::Arc::new(source), DensityMap::FLOAT, &|_| true).unwrap().unwrap();
    let [least, greatest] = field.extremes().map(f64::from);
    let mut canvas = Canvas::new(&gpu, grid, field);
    for (amount, operation, end) in [
        (2.0, Operation::Add, 255.0),
        (100.0, Operation::Add, greatest + 100.0),
        (2.0, Operation::Subtract, 0.0),
        (90.0, Operation::Subtract, least - 90.0),
    ] {
        let target = Target::Density(amount);
        let brush =
            Brush { radius_mm: 90.0, falloff: Falloff::Hard, operation, tip: Tip::BuildUp, target, ..Brush::default() };
        let brush = Brush { strength: 1.0, ..brush };
        let count = 7;
        let found = canvas.paint(&brush, &vec![dab_at(&grid, DVec3::splat(3.0), 90.0); count]);
        let mut ended = 0;
        for (v, found) in each(grid.dims, |v| v).into_iter().zip(found.chunks_exact(4)) {
            let found = f64::from(f32::from_le_bytes(found.try_into().unwrap()));
            let sum = amount * count as f64;
            let expected = match operation {
                Operation::Add => (f64::from(value(v)) + sum).min(end),
                _ => (f64::from(value(v)) - sum).max(end),
            };
            ended += u32::from(expected == end);
            assert!((found - expected).abs() < 1e-3, "{operation:?} {amount}: {found} for {expected}");
        }
        assert!(ended > 20, "{ended}");
    }
}
