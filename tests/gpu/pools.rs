//! What shaders read through `burin::field` against the host's fields.

use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{Body, FieldPools, Fields, Gpu, GpuError, SliceCut};
use burin::math::{DVec3, Plane, Pose};
use burin::volume::*;

#[test]
fn samples_through_pages_equal_the_dense_field() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([70, 66, 40]);
    let density = density_u16(grid, |v| ((v[0] * 631 + v[1] * 409 + v[2] * 211 + v[0] * v[1] * 7) % 60_000) as u16);
    let selection = painted(FieldKind::Selection, &grid, |v| {
        [if v[0] > 40 { ((v[1] * 5 + v[2] * 3) % 256) as u8 } else { 255 }, 0, 0, 0]
    });
    let colour =
        painted(FieldKind::Colour, &grid, |v| [(v[0] * 3) as u8, (v[1] * 2) as u8, v[2] as u8, (v[0] + v[1]) as u8]);
    let labels = painted(FieldKind::Labels, &grid, |v| {
        let [a, b] = ((v[0] / 3 + 7 * (v[1] / 5) + 300 * (v[2] / 11)) as u16).to_le_bytes();
        [a, b, 0, 0]
    });
    let fields = one_volume(&grid, &density, &colour, &selection, &labels);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, 256 << 20).unwrap();
    let frame = frame(&grid, ramp(-1.0, 60_000.0), DVec3::new(1.0, -2.0, 0.5), [64, 64]);
    assert!(pools.make_resident(&gpu, &fields, &frame).unwrap());
    let points = places(grid.dims, 4000);
    let unorm = |t: u8| f64::from(t) / 255.0;
    for (p, s) in points.iter().zip(sample(&gpu, &pools, &points)) {
        assert_eq!(s.level, 0);
        // Samplers weigh with 8 bits: a 256th of the largest step between neighbours.
        let expected = trilinear(&density, 0, *p, |t| density.map().decode(t));
        assert!((f64::from(s.density) - expected).abs() <= 60_000.0 / 200.0, "{p:?}: {} for {expected}", s.density);
        let expected = trilinear(&selection, 0, *p, |t| unorm(t[0]));
        assert!((f64::from(s.selection) - expected).abs() <= 1.0 / 200.0, "{p:?}: {} for {expected}", s.selection);
        for c in 0..4 {
            let expected = trilinear(&colour, 0, *p, |t| unorm(t[c]));
            assert!((f64::from(s.colour[c]) - expected).abs() <= 1.0 / 200.0, "{p:?} channel {c}");
        }
        let voxel = std::array::from_fn(|a| ((p[a] + 0.5).floor() as u32).min(grid.dims[a] - 1));
        assert_eq!(s.label, labels.value(voxel).unwrap() as u32, "{p:?}");
    }
    assert!(!pools.make_resident(&gpu, &fields, &frame).unwrap(), "the same frame again changes nothing");
}

/// Density at places, each against linear interpolation at the level that the page says.
pub(super) fn check_density(
    gpu: &Gpu,
    pools: &FieldPools,
    density: &Field,
    points: &[[f32; 3]],
    tolerance: f64,
) -> Vec<u32> {
    let samples = sample(gpu, pools, points);
    for (p, s) in points.iter().zip(&samples) {
        let expected = trilinear(density, s.level as u8, *p, |t| density.map().decode(t));
        let got = f64::from(s.density);
        assert!(
            (got - expected).abs() <= tolerance || got.is_nan() && expected.is_nan(),
            "{p:?} at level {}: {got} for {expected}",
            s.level
        );
    }
    samples.iter().map(|s| s.level).collect()
}

/// Budget, five eighths of it for density, whose density pool has exactly this many slots of 16 bits.
pub(super) fn budget_of(slots: usize) -> u64 {
    ((slots * SLOT_VOXELS * 2) as u64).div_ceil(20) * 32
}

pub(super) fn noisy(grid: Grid) -> Field {
    density_u16(grid, |v| (1000 + (v[0] * 631 + v[1] * 409 + v[2] * 211 + v[0] * v[1] * 7) % 3000) as u16)
}

pub(super) fn blanks(grid: &Grid) -> [Field; 3] {
    [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels].map(|kind| Field::blank(kind, grid))
}

pub(super) fn fields<'a>(density: &'a Field, [colour, selection, labels]: &'a [Field; 3]) -> Fields<'a> {
    one_volume(&unit_grid(density.dims(0)), density, colour, selection, labels)
}

/// Samplers weigh with 8 bits: a 200th of the largest step between neighbours.
pub(super) const NOISE: f64 = 3000.0 / 200.0;

#[test]
fn with_an_eighth_of_the_bricks_nothing_is_missing_and_the_nearest_are_finest() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([150, 140, 130]);
    let mut density = noisy(grid);
    let none = blanks(&grid);
    // 5·5·5 bricks, all visible.
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(125 / 8)).unwrap();
    let near = frame(&grid, ramp(0.0, 4000.0), DVec3::new(1.0, -0.4, 0.3), [256, 256]);
    let points = places(grid.dims, 4000);
    assert!(pools.make_resident(&gpu, &fields(&density, &none), &near).unwrap());
    let levels = check_density(&gpu, &pools, &density, &points, NOISE);
    assert_eq!(pools.room(FieldKind::Density), (15, 15), "no slot is wasted");
    let mean = |side: &dyn Fn(&[f32; 3]) -> bool, levels: &[u32]| {
        let of: Vec<u32> = points.iter().zip(levels).filter(|(p, _)| side(p)).map(|(_, l)| *l).collect();
        f64::from(of.iter().sum::<u32>()) / of.len() as f64
    };
    let (front, back) = (mean(&|p| p[0] > 100.0, &levels), mean(&|p| p[0] < 50.0, &levels));
    assert!(front + 0.3 < back, "front {front}, back {back}");
    // At rest nothing changes.
    for _ in 0..3 {
        assert!(!pools.make_resident(&gpu, &fields(&density, &none), &near).unwrap());
    }
    assert_eq!(check_density(&gpu, &pools, &density, &points, NOISE), levels);
    // From behind, and back again: the same as at first, whatever was held in between.
    let far = frame(&grid, ramp(0.0, 4000.0), DVec3::new(-1.0, 0.2, 0.1), [256, 256]);
    assert!(pools.make_resident(&gpu, &fields(&density, &none), &far).unwrap());
    let turned = check_density(&gpu, &pools, &density, &points, NOISE);
    assert!(mean(&|p| p[0] > 100.0, &turned) > mean(&|p| p[0] < 50.0, &turned) + 0.3);
    pools.make_resident(&gpu, &fields(&density, &none), &near).unwrap();
    assert_eq!(check_density(&gpu, &pools, &density, &points, NOISE), levels);
    // An edit of a fine brick and of a coarse one shows at whichever level is drawn.
    let changes = vec![
        (BrickIndex([4, 1, 3]), Some(Brick::Uniform([0, 16, 0, 0]))),
        (BrickIndex([0, 2, 1]), Some(Brick::Uniform([0, 4, 0, 0]))),
    ];
    let (before, refresh) = density.swap(changes).unwrap();
    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &near).unwrap();
    check_density(&gpu, &pools, &density, &points, NOISE);
    let (_, refresh) = density.swap(before).unwrap();
    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &near).unwrap();
    assert_eq!(check_density(&gpu, &pools, &density, &points, NOISE), levels);
}

#[test]
fn a_pool_that_holds_what_shows_draws_it_at_the_finest_level_and_moves_for_slices() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([96, 96, 96]);
    // Only the middle layer of bricks and what touches it shows; the rest varies below the ramp's foot.
    let density =
        density_u16(grid, |v| if v[2] / 32 == 1 { 2000 + (v[0] * 31 % 900) as u16 } else { (v[1] % 90) as u16 });
    let none = blanks(&grid);
    let visible = density
        .brick_indices(0)
        .iter()
        .filter(|b| density.summary(BrickKey { level: 0, index: **b }).max > 500.0)
        .count();
    assert_eq!(visible, 27, "aprons of the outer layers reach the middle");
    let inner =
        density_u16(
            grid,
            |v| if (34..62).contains(&v[2]) { 2000 + (v[0] * 31 % 900) as u16 } else { (v[1] % 90) as u16 },
        );
    let mut pools = FieldPools::apart(&gpu, &grid, &inner, budget_of(9)).unwrap();
    let frame = frame(&grid, ramp(500.0, 4000.0), DVec3::new(1.0, -0.4, 0.3), [64, 64]);
    pools.make_resident(&gpu, &fields(&inner, &none), &frame).unwrap();
    let points: Vec<[f32; 3]> = places(grid.dims, 3000).into_iter().filter(|p| (31.5..63.5).contains(&p[2])).collect();
    let levels = check_density(&gpu, &pools, &inner, &points, 900.0 / 100.0);
    assert!(levels.iter().all(|&l| l == 0), "nine visible bricks in nine slots");
    // Every sample of the rest is as invisible as it should be.
    let rest: Vec<[f32; 3]> = places(grid.dims, 3000).into_iter().filter(|p| !(31.5..63.5).contains(&p[2])).collect();
    assert!(sample(&gpu, &pools, &rest).iter().all(|s| s.density < 500.0));
    // A slice through invisible bricks is drawn from its own texels, level by level as room allows.
    pools
        .make_slice_resident(&gpu, &fields(&inner, &none), VolumeId::FIRST, SliceCut::Row { axis: 2, index: 5 })
        .unwrap();
    let slice: Vec<[f32; 3]> = points.iter().map(|p| [p[0], p[1], 5.0]).collect();
    check_density(&gpu, &pools, &inner, &slice, 900.0 / 100.0);
    check_density(&gpu, &pools, &inner, &points, 900.0 / 100.0);
}

#[test]
fn a_body_moved_to_the_eye_is_finer_than_one_moved_away() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([130, 130, 130]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(15)).unwrap();
    let mut exploded = frame(&grid, ramp(0.0, 4000.0), DVec3::NEG_Y, [128, 128]);
    let middle = DVec3::new(65.0, 65.0, 65.0);
    let half = |normal: DVec3, shift: DVec3| Body {
        pose: Pose { translation: shift, ..Pose::IDENTITY },
        region: vec![Plane::through(middle, normal).unwrap()],
        ..Body::whole(0)
    };
    let level = |pools: &FieldPools, x: f32| {
        let points: Vec<[f32; 3]> = places(grid.dims, 900).into_iter().map(|p| [x, p[1], p[2]]).collect();
        check_density(&gpu, pools, &density, &points, NOISE).iter().sum::<u32>()
    };
    for (near, far) in [(16.0, 112.0), (112.0, 16.0)] {
        let side = if near < 65.0 { DVec3::X } else { DVec3::NEG_X };
        exploded.bodies = vec![half(side, DVec3::NEG_Y * 120.0), half(-side, DVec3::Y * 300.0)];
        pools.make_resident(&gpu, &fields(&density, &none), &exploded).unwrap();
        assert!(level(&pools, near) < level(&pools, far));
    }
}

#[test]
fn an_axis_over_2048_draws() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([2100, 40, 37]);
    let density = density_u16(grid, |v| (v[0] * 20 + (v[1] * 409 + v[2] * 211) % 3000) as u16);
    let none = blanks(&grid);
    let frame = frame(&grid, ramp(-1.0, 60_000.0), DVec3::NEG_Y, [64, 64]);
    for (slots, finest) in [(400, true), (66 * 4 / 8, false)] {
        let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
        pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
        let levels = check_density(&gpu, &pools, &density, &places(grid.dims, 3000), NOISE);
        assert_eq!(levels.iter().all(|&l| l == 0), finest);
    }
}

#[test]
fn nan_stays_where_it_is() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([70, 40, 40]);
    // NaN at brick corners, where other slots' texels lie next to it in the pool.
    let hole = |v: [u32; 3]| [[0, 0, 0], [32, 5, 31], [63, 31, 0], [69, 39, 39]].contains(&v);
    let density = density_f32(grid, |v| if hole(v) { f32::NAN } else { (v[0] + 2 * v[1] + 3 * v[2]) as f32 });
    let none = blanks(&grid);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, 64 << 20).unwrap();
    let frame = frame(&grid, ramp(-1.0, 300.0), DVec3::NEG_Y, [64, 64]);
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    let mut points = places(grid.dims, 4000);
    points.extend([[31.5, 5.0, 31.0], [62.75, 30.75, 0.25], [0.25, 0.0, 0.5], [68.5, 38.5, 38.5]]);
    // On a lattice line the far tap has weight 0 and counts for nothing here, for NaN in hardware.
    points.retain(|p| p.iter().all(|x| x.fract() != 0.0));
    let samples = sample(&gpu, &pools, &points);
    for (p, s) in points.iter().zip(&samples) {
        let expected = trilinear(&density, 0, *p, |t| density.map().decode(t));
        let got = f64::from(s.density);
        assert!(got.is_nan() == expected.is_nan(), "{p:?}: {got} for {expected}");
        assert!(got.is_nan() || (got - expected).abs() < 0.1, "{p:?}: {got} for {expected}");
    }
    assert!(samples.iter().any(|s| s.density.is_nan()));
}

#[test]
fn an_adapter_without_16_bit_textures_draws_the_same() {
    if gpu().is_none() {
        return;
    }
    let gpu = Gpu::headless_with(wgpu::Features::empty()).unwrap();
    assert!(!gpu.has_unorm16() && !gpu.filters_float());
    let grid = unit_grid([70, 66, 40]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let frame = frame(&grid, ramp(-1.0, 4000.0), DVec3::NEG_Y, [64, 64]);
    for slots in [64, 4] {
        let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
        assert_eq!(pools.format(FieldKind::Density), Some(TexelFormat::R32Float));
        pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
        // Weights are whole floats here.
        check_density(&gpu, &pools, &density, &places(grid.dims, 2000), 0.05);
    }
}

#[test]
fn pinned_bricks_have_slots_of_their_own_until_they_are_let_go() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([96, 96, 64]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let frame = frame(&grid, ramp(0.0, 4000.0), DVec3::NEG_Y, [64, 64]);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(24)).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    // A blank selection gets slots where it is painted.
    let bricks = [BrickIndex([0, 0, 0]), BrickIndex([2, 1, 1])];
    let selection = &none[1];
    let origins = pools.pin(&gpu, FieldKind::Selection, selection, &bricks).unwrap();
    assert!(origins.len() == 2 && origins[0] != origins[1] && origins.iter().flatten().all(|o| o % 34 == 0));
    assert_eq!(
        pools.pin(&gpu, FieldKind::Selection, selection, &bricks).unwrap(),
        origins,
        "pinned again they stay where they are"
    );
    let (_, queue) = gpu.raw();
    let texture = pools.texture(FieldKind::Selection).unwrap();
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x: origins[1][0] + 1, y: origins[1][1] + 2, z: origins[1][2] + 3 },
            ..texture.as_image_copy()
        },
        &[255],
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(1), rows_per_image: Some(1) },
        wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
    );
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    let at = [[64.0, 33.0, 34.0], [64.0, 34.0, 34.0], [10.0, 10.0, 10.0]];
    let selected: Vec<f32> = sample(&gpu, &pools, &at).iter().map(|s| s.selection).collect();
    assert_eq!(selected, [1.0, 0.0, 0.0]);
    // More pins make the pool grow and keep what was written.
    let all = selection.brick_indices(0);
    pools.pin(&gpu, FieldKind::Selection, selection, &all[..4]).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    assert_eq!(sample(&gpu, &pools, &at[..1])[0].selection, 1.0);
    let error = pools.pin(&gpu, FieldKind::Selection, selection, &all[..6]).unwrap_err();
    assert!(matches!(error, GpuError::PoolFull { asked: 7, room: 5, .. }), "{error}");
    pools.unpin(FieldKind::Selection);
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    assert_eq!(sample(&gpu, &pools, &at[..1])[0].selection, 0.0, "what the host does not have is gone");
    // Density: pinned and drawn at the finest level, the rest within what room is left.
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(8)).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    pools.pin(&gpu, FieldKind::Density, &density, &bricks).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    let points = places(grid.dims, 2000);
    check_density(&gpu, &pools, &density, &points, NOISE);
    assert!(sample(&gpu, &pools, &[[70.0, 40.0, 40.0], [5.0, 5.0, 5.0]]).iter().all(|s| s.level == 0));
    pools.unpin(FieldKind::Density);
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    check_density(&gpu, &pools, &density, &points, NOISE);
}
