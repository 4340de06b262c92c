//! What residency costs: an edit its bricks, a stroke's end nothing twice, hidden parts nothing, a picture in motion no more
//! than it may.

use super::pools::{NOISE, blanks, budget_of, check_density, fields, noisy};
use crate::common::gpu::{gpu, sample};
use crate::common::one::of_one;
use crate::common::volumes::*;
use burin::gpu::{Body, FieldPools, Frame, Gpu, Mask, Painter};
use burin::math::{DVec3, Plane};
use burin::paint::{Brush, Dab, Falloff, Reach, Target};
use burin::volume::*;

/// One voxel in the middle of a brick becomes another: no other slot of its level shows it.
fn touch(field: &mut Field, brick: [u32; 3]) -> Refresh {
    let bytes = field.format().bytes();
    let index = BrickIndex(brick);
    let mut texels = field.brick(BrickKey { level: 0, index }).unwrap().to_texels(bytes);
    texels[(16 + 32 * (16 + 32 * 16)) * bytes] ^= 0x55;
    field.swap(vec![(index, Some(Brick::from_texels(texels, bytes)))]).unwrap().1
}

#[test]
fn an_edit_costs_its_bricks_and_not_the_volume() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([256, 256, 96]);
    let all = 8 * 8 * 3;
    // With room for all, and with room for an eighth.
    for slots in [2 * all, all / 8] {
        let mut density = noisy(grid);
        let none = blanks(&grid);
        let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
        let frame = frame(&grid, ramp(0.0, 4000.0), DVec3::new(1.0, -0.4, 0.3), [64, 64]);
        pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
        let (first, _) = pools.work();
        assert!(first >= all as u64, "{first}: all was looked at once");
        let refresh = touch(&mut density, [3, 4, 1]);
        let (judged, uploaded) = pools.work();
        pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
        pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
        let (judged, uploaded) = (pools.work().0 - judged, pools.work().1 - uploaded);
        assert!(judged <= 2, "{slots} slots: {judged} bricks looked at for one edited");
        assert!(uploaded <= 1 + 8, "{slots} slots: {uploaded} bricks uploaded for one edited");
        let at = [[112.0, 144.0, 48.0]];
        let (found, level) = (sample(&gpu, &pools, &at)[0].density, sample(&gpu, &pools, &at)[0].level as u8);
        let expected = trilinear(&density, level, at[0], |t| density.map().decode(t));
        assert!((f64::from(found) - expected).abs() < 1.0, "{found} for {expected} at level {level}");
    }
}

#[test]
fn edits_of_a_few_voxels_leave_the_slots_as_the_field_is() {
    let Some(gpu) = gpu() else { return };
    let mut adapters = vec![gpu];
    adapters.push(Gpu::headless_with(wgpu::Features::empty()).unwrap());
    // No axis a multiple of a brick, and axes of one voxel.
    for (gpu, dims) in adapters.iter().flat_map(|gpu| [[80, 40, 33], [1, 70, 34], [33, 1, 1]].map(|dims| (gpu, dims))) {
        let grid = unit_grid(dims);
        let none = blanks(&grid);
        let view = frame(&grid, ramp(-1.0, 4000.0), DVec3::NEG_Y, [16, 16]);
        for apart in [false, true] {
            let mut density = noisy(grid);
            let budget = budget_of(64) * 4;
            let pools = if apart { FieldPools::apart } else { FieldPools::new };
            let mut pools = pools(gpu, &grid, &density, budget).unwrap();
            pools.make_resident(gpu, &fields(&density, &none), &view).unwrap();
            assert_eq!(pools.defs(gpu).iter().any(|d| d.0 == "IN_PLACE"), !apart);
            let mut edited = Vec::new();
            for (i, place) in places(dims, 24).iter().enumerate() {
                let voxel: [u32; 3] = std::array::from_fn(|a| (place[a].round().max(0.0) as u32).min(dims[a] - 1));
                edited.push(voxel);
                let index = BrickIndex(voxel.map(|v| v / BRICK));
                let [x, y, z] = voxel.map(|v| (v % BRICK) as usize);
                let mut texels = density.brick(BrickKey { level: 0, index }).unwrap().to_texels(2);
                texels[(x + 32 * (y + 32 * z)) * 2] ^= 0x80 | i as u8;
                let (_, refresh) = density.swap(vec![(index, Some(Brick::from_texels(texels, 2)))]).unwrap();
                pools.refresh(gpu, FieldKind::Density, &density, &refresh).unwrap();
            }
            pools.make_resident(gpu, &fields(&density, &none), &view).unwrap();
            // At voxels' own centres no weights are rounded.
            let near: Vec<[f32; 3]> = edited
                .iter()
                .flat_map(|v| {
                    (0..27)
                        .map(|i| [i % 3, i / 3 % 3, i / 9].map(|s| s as f32 - 1.0))
                        .map(move |s| std::array::from_fn(|a| (v[a] as f32 + s[a]).clamp(0.0, dims[a] as f32 - 1.0)))
                })
                .collect();
            check_density(gpu, &pools, &density, &near, 0.1);
            // Aprons: an edit is of 128 or more, of which its neighbours' borders show a half.
            check_density(gpu, &pools, &density, &places(dims, 24), NOISE);
        }
    }
}

#[test]
fn what_a_stroke_painted_is_not_uploaded_again_and_what_it_did_not_keep_is() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([96, 96, 64]);
    let mut density = noisy(grid);
    let none = blanks(&grid);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(64)).unwrap();
    let mut painter = Painter::new(&gpu).unwrap();
    let frame = frame(&grid, ramp(0.0, 4000.0), DVec3::NEG_Y, [64, 64]);
    let brush = Brush { target: Target::Density(3900.0), radius_mm: 6.0, falloff: Falloff::Hard, ..Brush::default() };
    let centre = DVec3::new(31.5, 40.0, 31.5);
    let dab = Dab { centre, radius_mm: 6.0, pressure: 1.0, normal: DVec3::Z };
    let at = [[31.5, 40.0, 31.5], [31.0, 41.0, 33.0]];
    let values = |pools: &FieldPools| sample(&gpu, pools, &at).iter().map(|s| s.density.round()).collect::<Vec<_>>();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    let before = values(&pools);
    let stroke = |painter: &mut Painter, pools: &mut FieldPools, density: &Field| {
        painter.begin(VolumeId::FIRST, &fields(density, &none), &brush, &Segments::default(), Reach([0.0; 2])).unwrap();
        painter.extend(pools, &fields(density, &none), &[(VolumeId::FIRST, &[dab])]).unwrap();
    };
    // Taken back: the slots are right again without an upload.
    stroke(&mut painter, &mut pools, &density);
    let uploaded = pools.work().1;
    let refresh = of_one(painter.cancel(&mut pools).unwrap());
    pools.refresh_painted(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    assert_eq!((pools.work().1, values(&pools)), (uploaded, before.clone()), "cancelled");
    // Lost on the way to the field: the slots are made as the field is.
    stroke(&mut painter, &mut pools, &density);
    let bricks = of_one(painter.finish(&mut pools, &fields(&density, &none)).unwrap());
    assert_eq!(values(&pools), [3900.0; 2]);
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    assert_eq!(values(&pools), before, "not kept");
    // The same where an edit of one voxel comes first: it renews all of what the stroke left in its slot.
    stroke(&mut painter, &mut pools, &density);
    painter.finish(&mut pools, &fields(&density, &none)).unwrap();
    let refresh = touch(&mut density, [0, 1, 0]);
    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    assert_eq!(values(&pools), before, "not kept, and edited elsewhere");
    let refresh = touch(&mut density, [0, 1, 0]);
    pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    // Kept: nothing of level 0 is uploaded.
    stroke(&mut painter, &mut pools, &density);
    assert_eq!(of_one(painter.finish(&mut pools, &fields(&density, &none)).unwrap()), bricks);
    let (_, refresh) = density.swap(bricks.into_iter().map(|(i, b)| (i, Some(b))).collect()).unwrap();
    let uploaded = pools.work().1;
    pools.refresh_painted(&gpu, FieldKind::Density, &density, &refresh).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &frame).unwrap();
    assert_eq!((pools.work().1, values(&pools)), (uploaded, vec![3900.0; 2]), "kept");
}

/// The frame with its matter divided at x = 64: the lower half, the upper half, or the selection, as asked.
fn halves(frame: &Frame, lower: Option<Mask>, upper: Option<Mask>, selection: bool) -> Frame {
    let half = |normal: DVec3, mask: Mask| Body {
        region: vec![Plane::through(DVec3::new(63.5, 0.0, 0.0), normal).unwrap()],
        mask,
        ..Body::whole(1)
    };
    let lower = lower.map(|mask| half(DVec3::X, mask));
    let upper = upper.map(|mask| half(DVec3::NEG_X, mask));
    let selection = selection.then(|| Body { mask: Mask::Selection, ..Body::whole(0) });
    Frame { bodies: [lower, upper, selection].into_iter().flatten().collect(), ..frame.clone() }
}

#[test]
fn bricks_that_only_hidden_parts_cover_are_not_asked_for() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([192, 64, 64]);
    let density = noisy(grid);
    let mut none = blanks(&grid);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(100)).unwrap();
    let whole = frame(&grid, ramp(0.0, 4000.0), DVec3::NEG_Y, [64, 64]);
    let lower = halves(&whole, Some(Mask::None), None, false);
    pools.make_resident(&gpu, &fields(&density, &none), &lower).unwrap();
    // Two layers of four bricks below the plane; it runs along a border, and a brick's apron reaches over.
    assert_eq!(pools.room(FieldKind::Density).0, 12);
    // Shown again, the other half comes.
    pools
        .make_resident(&gpu, &fields(&density, &none), &halves(&whole, Some(Mask::None), Some(Mask::None), false))
        .unwrap();
    assert_eq!(pools.room(FieldKind::Density).0, 24);
    // The selection among hidden parts needs its own bricks only, and those that are being painted.
    none[1] = painted(FieldKind::Selection, &grid, |v| [if v[0] > 180 { 255 } else { 0 }, 0, 0, 0]);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(100)).unwrap();
    let selection = halves(&whole, None, None, true);
    pools.make_resident(&gpu, &fields(&density, &none), &selection).unwrap();
    assert_eq!(pools.room(FieldKind::Density).0, 4);
    pools.set_live(FieldKind::Selection, BrickIndex([0, 1, 1]), Cells::Uniform([0.0, 1.0]));
    pools.make_resident(&gpu, &fields(&density, &none), &selection).unwrap();
    assert_eq!(pools.room(FieldKind::Density).0, 5);
    // What is wholly selected is no background.
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(100)).unwrap();
    none[1] = painted(FieldKind::Selection, &grid, |_| [255, 0, 0, 0]);
    let background = halves(&whole, Some(Mask::Background), Some(Mask::Background), false);
    pools.make_resident(&gpu, &fields(&density, &none), &background).unwrap();
    assert_eq!(pools.room(FieldKind::Density).0, 0);
    // A selection that changes is followed.
    let bricks = vec![(BrickIndex([5, 0, 0]), None)];
    let (_, refresh) = none[1].swap(bricks).unwrap();
    pools.refresh(&gpu, FieldKind::Selection, &none[1], &refresh).unwrap();
    pools.make_resident(&gpu, &fields(&density, &none), &background).unwrap();
    assert_eq!(pools.room(FieldKind::Density).0, 8, "the brick and those whose taps reach it");
}

/// The level that every place is drawn from; each place must hold its level's own value.
fn levels(gpu: &Gpu, pools: &FieldPools, density: &Field, points: &[[f32; 3]]) -> Vec<u32> {
    let samples = sample(gpu, pools, points);
    for (p, s) in points.iter().zip(&samples) {
        let expected = trilinear(density, s.level as u8, *p, |t| density.map().decode(t));
        let got = f64::from(s.density);
        assert!((got - expected).abs() <= 3000.0 / 200.0, "{p:?} at level {}: {got} for {expected}", s.level);
    }
    samples.iter().map(|s| s.level).collect()
}

#[test]
fn bounded_uploads_leave_no_hole_and_end_where_unbounded_ones_do() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([150, 140, 130]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let points = places(grid.dims, 2000);
    for slots in [200, 15] {
        let near = frame(&grid, ramp(0.0, 4000.0), DVec3::new(1.0, -0.4, 0.3), [256, 256]);
        let far = frame(&grid, ramp(0.0, 4000.0), DVec3::new(-1.0, 0.2, 0.1), [256, 256]);
        let mut at_once = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
        at_once.make_resident(&gpu, &fields(&density, &none), &far).unwrap();
        let rest = levels(&gpu, &at_once, &density, &points);
        let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(slots)).unwrap();
        pools.bound_uploads(Some(4));
        for frame in [&near, &far] {
            for turn in 0.. {
                let uploaded = pools.work().1;
                let changed = pools.make_resident(&gpu, &fields(&density, &none), frame).unwrap();
                let uploaded = pools.work().1 - uploaded;
                assert!(uploaded <= 4 + 1, "{uploaded} with the one that stands in for all");
                levels(&gpu, &pools, &density, &points);
                if !pools.is_pending() {
                    break;
                }
                assert!(changed && turn < 60, "it gets on");
            }
        }
        assert_eq!(levels(&gpu, &pools, &density, &points), rest, "{slots} slots");
        // At rest all that is missing comes at once.
        pools.make_resident(&gpu, &fields(&density, &none), &near).unwrap();
        pools.bound_uploads(None);
        pools.make_resident(&gpu, &fields(&density, &none), &far).unwrap();
        assert!(!pools.is_pending() && !pools.make_resident(&gpu, &fields(&density, &none), &far).unwrap());
        assert_eq!(levels(&gpu, &pools, &density, &points), rest, "{slots} slots, at rest");
    }
}

#[test]
fn the_same_view_in_fewer_pixels_is_not_chosen_anew() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([150, 140, 130]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(15)).unwrap();
    let full = frame(&grid, ramp(0.0, 4000.0), DVec3::new(1.0, -0.4, 0.3), [1000, 701]);
    pools.make_resident(&gpu, &fields(&density, &none), &full).unwrap();
    let before = pools.work();
    for size in [[500, 351], [250, 175], [1000, 701]] {
        let smaller = Frame { size, ..full.clone() };
        assert!(!pools.make_resident(&gpu, &fields(&density, &none), &smaller).unwrap());
        assert_eq!(pools.work(), before, "{size:?}");
    }
    // Another shape shows other bricks.
    let wide = Frame { size: [1000, 300], ..full.clone() };
    pools.make_resident(&gpu, &fields(&density, &none), &wide).unwrap();
    assert!(pools.work().0 > before.0);
}

#[test]
fn what_was_not_drawn_for_longest_gives_up_its_slot() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([12 * 32, 20, 20]);
    let density = noisy(grid);
    let none = blanks(&grid);
    let mut pools = FieldPools::apart(&gpu, &grid, &density, budget_of(9)).unwrap();
    // Some bricks on end, well inside of the outer ones.
    let row = |first: u32, count: u32| {
        let wall = |x: f64, normal: DVec3| Plane::through(DVec3::new(x, 0.0, 0.0), normal).unwrap();
        let [lo, hi] = [first * 32 + 8, (first + count) * 32 - 8].map(f64::from);
        let region = vec![wall(lo, DVec3::NEG_X), wall(hi, DVec3::X)];
        let bodies = vec![Body { region, ..Body::whole(0) }];
        Frame { bodies, ..frame(&grid, ramp(0.0, 4000.0), DVec3::NEG_Y, [32, 32]) }
    };
    let mut uploads = |first: u32, count: u32| {
        let before = pools.work().1;
        pools.make_resident(&gpu, &fields(&density, &none), &row(first, count)).unwrap();
        pools.work().1 - before
    };
    assert_eq!(uploads(0, 9), 9);
    let mut three = |first: u32| uploads(first, 3);
    assert_eq!([0, 3, 6].map(&mut three), [0; 3], "nothing has to go");
    assert_eq!([9, 6, 3, 9].map(&mut three), [3, 0, 0, 0], "the first three went");
    assert_eq!([0, 3, 9].map(&mut three), [3, 0, 0], "and now the third three");
    assert_eq!([6, 0, 3, 9].map(&mut three), [3; 4], "each time those that come next");
}
