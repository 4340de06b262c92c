//! Density in place: what shaders read, what edits leave, and when bricks lie apart after all.

use super::pools::blanks;
use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{Body, FieldPools, Frame, Gpu, LabelLooks, Look, VolumeFields};
use burin::math::DVec3;
use burin::volume::*;
use std::sync::Arc;

/// Two bricks and a half along x, one and a bit along y; the last brick is of one value.
fn mixed() -> (Grid, Field) {
    let grid = unit_grid([80, 40, 33]);
    let density = density_u16(grid, |v| {
        let n = (v[0] * 631 + v[1] * 409 + v[2] * 211 + v[0] * v[1] * 7) % 3000;
        if v[0] >= 63 { 2000 } else { (1000 + n) as u16 }
    });
    (grid, density)
}

fn is_in_place(gpu: &Gpu, pools: &FieldPools) -> bool {
    pools.defs(gpu).iter().any(|d| d.0 == "IN_PLACE")
}

/// Samplers weigh with 8 bits: a 200th of the largest step between neighbours.
fn check(gpu: &Gpu, pools: &FieldPools, density: &Field, points: &[[f32; 3]]) {
    for (p, s) in points.iter().zip(sample(gpu, pools, points)) {
        let expected = trilinear(density, 0, *p, |t| density.map().decode(t));
        assert!((f64::from(s.density) - expected).abs() <= 4000.0 / 200.0, "{p:?}: {} for {expected}", s.density);
    }
}

#[test]
fn a_volume_that_fits_lies_in_place_and_follows_edits() {
    let Some(gpu) = gpu() else { return };
    let (grid, mut density) = mixed();
    let none = [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels].map(|kind| Field::blank(kind, &grid));
    let [colour, selection, labels] = &none;
    let mut pools = FieldPools::new(&gpu, &grid, &density, 64 << 20).unwrap();
    // Nothing below 1,500 shows: bricks in place are right all the same.
    let frame = frame(&grid, ramp(1500.0, 4000.0), DVec3::NEG_Y, [64, 64]);
    let fields = one_volume(&grid, &density, colour, selection, labels);
    assert!(pools.make_resident(&gpu, &fields, &frame).unwrap());
    assert!(is_in_place(&gpu, &pools));
    let mut points = places(grid.dims, 3000);
    // Across every border between bricks, and on the volume's faces.
    points.extend([[31.5, 31.5, 31.5], [31.9, 10.2, 31.1], [63.5, 31.4, 32.0], [-0.5, -0.5, -0.5], [79.5, 39.5, 32.5]]);
    check(&gpu, &pools, &density, &points);
    assert!(!pools.make_resident(&gpu, &fields, &frame).unwrap(), "the same frame again changes nothing");

    // A brick becomes another, one of one value too, and goes back.
    let other = |value: u16| {
        let bytes = (0..BRICK_VOXELS).flat_map(|i| (value + (i % 97) as u16).to_le_bytes()).collect::<Vec<_>>();
        Brick::from_texels(bytes, 2)
    };
    let changes = vec![(BrickIndex([0, 0, 0]), Some(other(300))), (BrickIndex([2, 1, 0]), Some(other(2500)))];
    let (before, refresh) = density.swap(changes).unwrap();
    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &one_volume(&grid, &density, colour, selection, labels), &frame).unwrap();
    check(&gpu, &pools, &density, &points);
    let (_, refresh) = density.swap(before).unwrap();
    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &one_volume(&grid, &density, colour, selection, labels), &frame).unwrap();
    check(&gpu, &pools, &density, &points);
}

#[test]
fn every_brick_may_be_pinned_where_all_have_their_place() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = mixed();
    let mut pools = FieldPools::new(&gpu, &grid, &density, 64 << 20).unwrap();
    let all = density.brick_indices(0);
    let origins = pools.pin(&gpu, FieldKind::Density, &density, &all).unwrap();
    let expected: Vec<_> = all.iter().map(|b| b.0.map(|i| 32 * i)).collect();
    assert_eq!(origins, expected);
    check(&gpu, &pools, &density, &places(grid.dims, 500));
}

#[test]
fn what_takes_more_than_half_of_its_share_lies_apart() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = mixed();
    // 98 × 66 × 66 texels of two bytes; density has five eighths.
    let bytes = 98 * 66 * 66 * 2 * 2 * 8 / 5 + 32;
    for (budget, expected) in [(bytes, true), (bytes * 9 / 10, false)] {
        let pools = FieldPools::new(&gpu, &grid, &density, budget).unwrap();
        assert_eq!(is_in_place(&gpu, &pools), expected);
    }
    let long = unit_grid([2100, 4, 4]);
    let density = density_u16(long, |v| v[0] as u16);
    let pools = FieldPools::new(&gpu, &long, &density, 64 << 20).unwrap();
    let longest = gpu.raw().0.limits().max_texture_dimension_3d;
    assert_eq!(is_in_place(&gpu, &pools), longest >= 66 * 32 + 2);
}

fn labels_in_place(gpu: &Gpu, pools: &FieldPools) -> bool {
    pools.defs(gpu).iter().any(|d| d.0 == "LABELS_IN_PLACE")
}

#[test]
fn labels_lie_in_place_once_looks_go_by_them_and_follow_edits() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = mixed();
    let [colour, selection] = [FieldKind::Colour, FieldKind::Selection].map(|kind| Field::blank(kind, &grid));
    let of = |v: [u32; 3]| if v[0] >= 40 { 7_u16 } else { (v[0] + 3 * v[1] + 5 * v[2]) as u16 };
    let mut labels = painted(FieldKind::Labels, &grid, |v| {
        let [a, b] = of(v).to_le_bytes();
        [a, b, 0, 0]
    });
    let plain = frame(&grid, ramp(1500.0, 4000.0), DVec3::NEG_Y, [64, 64]);
    let look = Look { transfer: plain.transfer.clone(), mode: plain.mode, lighting: None, opacity: 1.0 };
    let by_label = [(7, None)].into_iter().collect();
    let looks = Arc::new(LabelLooks { default: Some(0), by_label });
    let bodies = vec![Body { labels: Some(looks), ..Body::whole(0) }];
    let dressed = Frame { looks: vec![look], bodies, ..plain.clone() };
    let mut points = places(grid.dims, 2000);
    points.extend([
        [31.4, 31.4, 31.4],
        [31.6, 10.2, 31.1],
        [63.4, 31.4, 32.0],
        [-0.49, -0.49, -0.49],
        [79.4, 39.4, 32.4],
    ]);
    let check = |pools: &FieldPools, expected: &dyn Fn([u32; 3]) -> u16, what: &str| {
        for (p, s) in points.iter().zip(sample(&gpu, pools, &points)) {
            let voxel = std::array::from_fn(|a| ((p[a] + 0.5).floor().max(0.0) as u32).min(grid.dims[a] - 1));
            assert_eq!(s.label, u32::from(expected(voxel)), "{what}: {p:?}");
        }
    };
    let mut pools = FieldPools::new(&gpu, &grid, &density, 64 << 20).unwrap();
    let fields = one_volume(&grid, &density, &colour, &selection, &labels);
    pools.make_resident(&gpu, &fields, &plain).unwrap();
    assert!(!labels_in_place(&gpu, &pools), "a picture that asks for labels of what shows alone");
    check(&pools, &of, "apart");
    // A stroke holds labels' slots where they are.
    pools.pin(&gpu, FieldKind::Labels, &labels, &[BrickIndex([1, 1, 0])]).unwrap();
    pools.make_resident(&gpu, &fields, &dressed).unwrap();
    assert!(!labels_in_place(&gpu, &pools), "no slot that is painted may go");
    pools.unpin(FieldKind::Labels);
    assert!(pools.make_resident(&gpu, &fields, &dressed).unwrap());
    assert!(labels_in_place(&gpu, &pools));
    check(&pools, &of, "in place");
    let work = pools.work();
    assert!(!pools.make_resident(&gpu, &fields, &dressed).unwrap(), "the same frame again changes nothing");
    pools.make_resident(&gpu, &fields, &plain).unwrap();
    pools.make_resident(&gpu, &fields, &dressed).unwrap();
    assert_eq!(pools.work().1, work.1, "nothing is uploaded again");
    let origins = pools.pin(&gpu, FieldKind::Labels, &labels, &[BrickIndex([2, 1, 1])]).unwrap();
    assert_eq!(origins, [[64, 32, 32]], "a stroke paints them where they are");
    pools.unpin(FieldKind::Labels);

    // A brick of one label becomes one of many, and goes back.
    let many = (0..BRICK_VOXELS).flat_map(|i| ((i % 251) as u16).to_le_bytes()).collect::<Vec<_>>();
    let (before, refresh) = labels.swap(vec![(BrickIndex([2, 0, 0]), Some(Brick::from_texels(many, 2)))]).unwrap();
    pools.refresh(&gpu, FieldKind::Labels, &labels, &refresh).unwrap();
    pools.make_resident(&gpu, &one_volume(&grid, &density, &colour, &selection, &labels), &dressed).unwrap();
    assert!(pools.work().1 - work.1 <= 8, "an edit costs its brick and the aprons of its neighbours");
    let edited = |v: [u32; 3]| {
        if v[0] < 64 || v[1] >= 32 || v[2] >= 32 { of(v) } else { ((v[0] - 64 + 32 * (v[1] + 32 * v[2])) % 251) as u16 }
    };
    check(&pools, &edited, "edited");
    let (_, refresh) = labels.swap(before).unwrap();
    pools.refresh(&gpu, FieldKind::Labels, &labels, &refresh).unwrap();
    pools.make_resident(&gpu, &one_volume(&grid, &density, &colour, &selection, &labels), &dressed).unwrap();
    check(&pools, &of, "as before");

    // Beside another volume they lie apart; alone again, in place.
    let mut two = one_volume(&grid, &density, &colour, &selection, &labels);
    let none = blanks(&grid);
    let [colour_b, selection_b, labels_b] = &none;
    let other = VolumeFields { grid, density: &density, colour: colour_b, selection: selection_b, labels: labels_b };
    two.put(VolumeId(2), other);
    let bodies = vec![dressed.bodies[0].clone(), Body { volume: VolumeId(2), ..Body::whole(1) }];
    pools.make_resident(&gpu, &two, &Frame { bodies, ..dressed.clone() }).unwrap();
    assert!(!labels_in_place(&gpu, &pools));
    pools.bind(&gpu, &[VolumeId::FIRST]).unwrap();
    check(&pools, &of, "beside another volume");
    pools.make_resident(&gpu, &one_volume(&grid, &density, &colour, &selection, &labels), &dressed).unwrap();
    assert!(labels_in_place(&gpu, &pools));
    check(&pools, &of, "alone again");
}
