//! Several volumes on the device at once: they share slots by need, and each is drawn from its own.

use super::pools::{NOISE, blanks, budget_of, check_density, noisy};
use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{Body, FieldPools, Fields, Frame, Gpu, VolumeFields};
use burin::math::{Camera, DVec3, Projection};
use burin::volume::*;

fn put<'a>(
    fields: &mut Fields<'a>,
    id: u32,
    grid: Grid,
    density: &'a Field,
    [colour, selection, labels]: &'a [Field; 3],
) {
    fields.put(VolumeId(id), VolumeFields { grid, density, colour, selection, labels });
}

fn whole(id: u32) -> Body {
    Body { volume: VolumeId(id), ..Body::whole(0) }
}

/// Levels that a volume is drawn from at places spread over it; each must hold its level's own value.
fn levels(gpu: &Gpu, pools: &mut FieldPools, id: u32, density: &Field) -> Vec<u32> {
    pools.bind(gpu, &[VolumeId(id)]).unwrap();
    check_density(gpu, pools, density, &places(density.dims(0), 400), NOISE)
}

#[test]
fn ten_volumes_that_do_not_fit_miss_nothing_and_the_nearest_are_finest() {
    let Some(gpu) = gpu() else { return };
    // A row along x, 27 bricks each, seen from its end.
    let at = |i: u32| Grid::aligned([90; 3], DVec3::ONE, DVec3::new(f64::from(i) * 100.0, 0.0, 0.0));
    let densities: Vec<Field> = (0..10).map(|i| noisy(at(i))).collect();
    let none = blanks(&at(0));
    let mut fields = Fields::default();
    for (i, density) in (0..).zip(&densities) {
        put(&mut fields, i, at(i), density, &none);
    }
    let mut pools = FieldPools::empty(&gpu, budget_of(60)).unwrap();
    let eye = DVec3::new(-60.0, 45.0, 45.0);
    let projection = Projection::Perspective { fov_y_deg: 60.0 };
    let camera = Camera { eye, target: eye + DVec3::X, up: DVec3::Z, projection };
    let thin = TransferFunction { opacity: vec![(0.0, 1e-6)], ..ramp(0.0, 4000.0) };
    let view = Frame { camera, bodies: (0..10).map(whole).collect(), ..frame(&at(0), thin, DVec3::X, [256; 2]) };
    assert!(pools.make_resident(&gpu, &fields, &view).unwrap());
    let (held, most) = pools.room(FieldKind::Density);
    assert!(held == most && most >= 60, "no slot is wasted: {held} of {most}");
    let mean = |levels: Vec<u32>| levels.iter().sum::<u32>() as f64 / levels.len() as f64;
    let means: Vec<f64> =
        (0..).zip(&densities).map(|(i, density)| mean(levels(&gpu, &mut pools, i, density))).collect();
    assert!(means[0] < 0.2, "the nearest is nearly all at its finest: {means:?}");
    assert!(means.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9) && means[9] >= 1.9, "{means:?}");
    pools.make_resident(&gpu, &fields, &view).unwrap();
    assert!(!pools.make_resident(&gpu, &fields, &view).unwrap(), "at rest nothing changes");
    // From the other end the last one is the nearest.
    let eye = DVec3::new(1060.0, 45.0, 45.0);
    let turned = Frame { camera: Camera { eye, target: eye - DVec3::X, ..camera }, ..view.clone() };
    pools.make_resident(&gpu, &fields, &turned).unwrap();
    assert!(mean(levels(&gpu, &mut pools, 9, &densities[9])) < 0.2);
    assert!(mean(levels(&gpu, &mut pools, 0, &densities[0])) >= 1.9);
    // One alone has all the room; the others keep nothing that it needs.
    let alone = Frame { bodies: vec![whole(4)], ..view };
    pools.make_resident(&gpu, &fields, &alone).unwrap();
    assert_eq!(mean(levels(&gpu, &mut pools, 4, &densities[4])), 0.0);
}

#[test]
fn codes_and_floats_lie_beside_each_other_and_a_volume_that_goes_gives_up_its_slots() {
    let Some(gpu) = gpu() else { return };
    let (one, two) = (unit_grid([70, 40, 33]), unit_grid([40, 70, 33]));
    let codes = noisy(one);
    let floats = density_f32(two, |v| (v[0] * 31 + v[1] * 57 + v[2] * 11) as f32 * 0.25 - 300.0);
    let (mut blank_one, mut blank_two) = (blanks(&one), blanks(&two));
    blank_one[2] = painted(FieldKind::Labels, &one, |v| [(v[0] / 3) as u8, 0, 0, 0]);
    blank_two[2] = painted(FieldKind::Labels, &two, |v| [(v[2] / 3 + 100) as u8, 0, 0, 0]);
    blank_two[1] = painted(FieldKind::Selection, &two, |v| [(v[1] * 3) as u8, 0, 0, 0]);
    let mut fields = Fields::default();
    put(&mut fields, 3, one, &codes, &blank_one);
    let view = Frame { bodies: vec![whole(3)], ..frame(&one, ramp(-1e4, 1e4), DVec3::NEG_Y, [32; 2]) };
    let mut pools = FieldPools::empty(&gpu, 64 << 20).unwrap();
    pools.make_resident(&gpu, &fields, &view).unwrap();
    assert!(pools.defs(&gpu).iter().any(|d| d.0 == "IN_PLACE"), "alone it lies in place");
    put(&mut fields, 7, two, &floats, &blank_two);
    let both = Frame { bodies: vec![whole(3), whole(7)], ..view.clone() };
    pools.make_resident(&gpu, &fields, &both).unwrap();
    assert_eq!(pools.format(FieldKey::new(VolumeId(7), FieldKind::Density)), Some(TexelFormat::R32Float));
    let names: Vec<_> = pools.defs(&gpu).iter().map(|d| d.0).collect();
    assert!(!names.contains(&"IN_PLACE") && names.contains(&"MANY_VOLUMES"), "{names:?}");
    levels(&gpu, &mut pools, 3, &codes);
    pools.bind(&gpu, &[VolumeId(7)]).unwrap();
    let points = places(two.dims, 400);
    for (p, s) in points.iter().zip(sample(&gpu, &pools, &points)) {
        let expected = trilinear(&floats, 0, *p, |t| f64::from(f32::from_le_bytes(t)));
        assert!((f64::from(s.density) - expected).abs() < 0.2, "{p:?}: {} for {expected}", s.density);
        let expected = trilinear(&blank_two[1], 0, *p, |t| f64::from(t[0]) / 255.0);
        assert!((f64::from(s.selection) - expected).abs() <= 1.0 / 200.0, "{p:?}");
        if p.iter().all(|v| (v + 0.5 - (v + 0.5).round()).abs() > 1e-3) {
            let voxel = p.map(|v| (v + 0.5) as u32);
            assert_eq!(u64::from(s.label), blank_two[2].value(voxel).unwrap() as u64, "{p:?}");
        }
    }
    // The selection of the one is not that of the other.
    pools.bind(&gpu, &[VolumeId(3)]).unwrap();
    assert!(sample(&gpu, &pools, &places(one.dims, 50)).iter().all(|s| s.selection == 0.0));
    // Gone: the one that is left lies in place again, and is right.
    let mut fields = Fields::default();
    put(&mut fields, 3, one, &codes, &blank_one);
    pools.make_resident(&gpu, &fields, &view).unwrap();
    assert_eq!(pools.volumes().collect::<Vec<_>>(), [VolumeId(3)]);
    assert!(pools.texture(FieldKey::new(VolumeId(7), FieldKind::Selection)).is_none());
    assert!(pools.defs(&gpu).iter().any(|d| d.0 == "IN_PLACE"));
    levels(&gpu, &mut pools, 3, &codes);
    let error = pools.make_resident(&gpu, &fields, &both).unwrap_err();
    assert!(error.to_string().contains("volume 7"), "{error}");
}

#[test]
fn an_adapter_without_16_bit_textures_knows_bricks_of_one_value() {
    if gpu().is_none() {
        return;
    }
    let gpu = Gpu::headless_with(wgpu::Features::empty()).unwrap();
    let grid = unit_grid([70, 40, 40]);
    // Bricks of one value, and some of several.
    let density = density_u16(grid, |v| if v[0] < 40 { 2500 } else { 1000 + (v[1] * 7) as u16 });
    let none = blanks(&grid);
    let mut fields = Fields::default();
    put(&mut fields, 0, grid, &density, &none);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, 64 << 20).unwrap();
    let view = frame(&grid, ramp(0.0, 4000.0), DVec3::NEG_Y, [16; 2]);
    pools.make_resident(&gpu, &fields, &view).unwrap();
    check_density(&gpu, &pools, &density, &places(grid.dims, 300), 0.05);
}
