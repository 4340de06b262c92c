//! What is known of cells while a stroke runs, and how a long stroke is submitted.

use super::*;
use crate::common::gpu::{sample, sample_maps};
use burin::gpu::Mask;

/// Two frames: asks, waits for the GPU as time would, takes what has come.
fn follow(gpu: &Gpu, canvas: &mut Canvas) -> Vec<(BrickIndex, LiveCells)> {
    let Canvas { density, colour, selection, labels, painter, pools, grid, .. } = canvas;
    let fields = one_volume(grid, density, colour, selection, labels);
    painter.follow(pools, &fields).unwrap();
    gpu.wait().unwrap();
    painter.follow(pools, &fields).unwrap();
    painter.take_live().into_iter().map(|(_, brick, cells)| (brick, cells)).collect()
}

/// The field as the running stroke shows it, from read-back texels.
fn shown(canvas: &Canvas, kind: FieldKind) -> Field {
    let Canvas { density, colour, selection, labels, painter, pools, grid, .. } = canvas;
    let fields = one_volume(grid, density, colour, selection, labels);
    let live = |b: BrickIndex| Some((b, Some(painter.live(pools, &fields, VolumeId::FIRST, b).unwrap()?)));
    let bricks = touched(painter).into_iter().filter_map(live).collect();
    let mut field = canvas.field(kind).clone();
    field.swap(bricks).unwrap();
    field
}

#[test]
fn the_cells_of_a_running_stroke_are_those_of_its_texels() {
    let Some(gpu) = gpu() else { return };
    let plain = Gpu::headless_with(wgpu::Features::empty()).unwrap();
    let grid = grids()[1];
    let targets = [Target::Selection(0.7), Target::Density(31_000.3)];
    let erase = [false, true];
    for (device, floats) in [(&gpu, false), (&gpu, true), (&plain, false)] {
        for target in targets {
            // The selection is the same on all.
            if target.field() == FieldKind::Selection && (floats || !device.has_unorm16()) {
                continue;
            }
            for erase in erase {
                let mut canvas = if floats { Canvas::floats(device, grid) } else { Canvas::codes(device, grid) };
                let brush = Brush { target, erase, radius_mm: 5.0, strength: 0.8, ..Brush::default() };
                let kind = target.field();
                canvas.begin(&brush);
                let mut known = std::collections::BTreeMap::new();
                for at in [[30.0, 30.0, 30.0], [34.0, 31.0, 33.0], [5.0, 20.0, 16.0]] {
                    canvas.extend(&[dab_at(&grid, DVec3::from_array(at), 5.0)]);
                    known.extend(follow(device, &mut canvas));
                }
                assert!(!canvas.painter.is_due(), "all has come");
                assert!(follow(device, &mut canvas).is_empty(), "nothing is told twice");
                assert_eq!(known.keys().copied().collect::<Vec<_>>(), touched(&canvas.painter));
                let after = shown(&canvas, kind);
                let before = |index| LiveCells::of(canvas.field(kind), index).unwrap();
                // Where nothing was painted, taking density's paint away changes nothing.
                let changes = known.iter().any(|(index, cells)| *cells != before(*index));
                assert_eq!(changes, !erase || kind == FieldKind::Selection, "{target:?}");
                for (index, cells) in &known {
                    let expected = LiveCells::of(&after, *index).unwrap();
                    assert!(*cells == expected, "{target:?} erase {erase} floats {floats} {index:?}");
                }
            }
        }
    }
}

#[test]
fn cells_in_doubt_may_show_anything_and_then_what_they_hold() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([64, 64, 64]);
    let mut canvas = Canvas::blank(&gpu, grid);
    let frame = frame(&grid, ramp(1000.0, 4000.0), DVec3::NEG_Y, [32, 32]);
    let skips = |canvas: &mut Canvas| {
        let Canvas { density, colour, selection, labels, pools, grid, .. } = canvas;
        let fields = one_volume(grid, density, colour, selection, labels);
        pools.make_resident(&gpu, &fields, &frame).unwrap();
        let maps = pools.skip_maps(&gpu, &fields, &[matter(&frame, Mask::None)]).unwrap();
        // In the ball; in its block but not in it; in its brick but in another block.
        let at = [[6.0, 6.0, 6.0], [14.0, 14.0, 14.0], [28.0, 28.0, 28.0]];
        sample_maps(&gpu, &canvas.pools, &maps, &at).iter().map(|s| s.skip[0]).collect::<Vec<_>>()
    };
    assert_eq!(skips(&mut canvas), [15; 3]);
    let brush = Brush { target: Target::Density(3000.0), radius_mm: 4.0, falloff: Falloff::Hard, ..Brush::default() };
    canvas.begin(&brush);
    canvas.extend(&[dab_at(&grid, DVec3::splat(6.0), 4.0)]);
    let [ball, block, brick] = skips(&mut canvas)[..] else { panic!() };
    assert!(ball == 0 && block == 0 && brick == 4, "{ball} {block} {brick}: a block in doubt is 16 voxels wide");
    follow(&gpu, &mut canvas);
    let [ball, block, brick] = skips(&mut canvas)[..] else { panic!() };
    // The ball ends at 10, within the cell from 8 to 12, which also is the last tap's.
    assert!(ball == 0 && block == 1 && brick == 5, "{ball} {block} {brick}");
    // Painted away again within the same stroke's brick.
    canvas.finish();
    assert_eq!(skips(&mut canvas), [15; 3], "what was not kept leaves nothing");
}

#[test]
fn cells_that_were_asked_for_and_not_answered_may_show_anything() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([64, 64, 64]);
    let mut canvas = Canvas::blank(&gpu, grid);
    let frame = frame(&grid, ramp(1000.0, 4000.0), DVec3::NEG_Y, [32, 32]);
    let skip = |canvas: &mut Canvas, at: f32| {
        let Canvas { density, colour, selection, labels, pools, grid, .. } = canvas;
        let fields = one_volume(grid, density, colour, selection, labels);
        pools.make_resident(&gpu, &fields, &frame).unwrap();
        let maps = pools.skip_maps(&gpu, &fields, &[matter(&frame, Mask::None)]).unwrap();
        sample_maps(&gpu, &canvas.pools, &maps, &[[at; 3]])[0].skip[0]
    };
    let brush = Brush { target: Target::Density(3000.0), radius_mm: 3.0, falloff: Falloff::Hard, ..Brush::default() };
    canvas.begin(&brush);
    canvas.extend(&[dab_at(&grid, DVec3::splat(6.0), 3.0)]);
    // Asked, and the answer not taken; then another block of the same brick is painted.
    let Canvas { density, colour, selection, labels, painter, pools, .. } = &mut canvas;
    painter.follow(pools, &one_volume(&grid, density, colour, selection, labels)).unwrap();
    canvas.extend(&[dab_at(&grid, DVec3::splat(26.0), 3.0)]);
    assert_eq!(skip(&mut canvas, 6.0), 0, "the first ball must not be skipped by what was there before it");
    assert_eq!(skip(&mut canvas, 26.0), 0);
    follow(&gpu, &mut canvas);
    assert_eq!([skip(&mut canvas, 6.0), skip(&mut canvas, 26.0)], [0; 2]);
    canvas.finish();
}

#[test]
fn a_long_stroke_is_submitted_in_parts_and_paints_the_same() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([40, 34, 20]);
    let brush = Brush { radius_mm: 9.0, tip: Tip::BuildUp, strength: 0.02, ..Brush::default() };
    let mut rng = StdRng::seed_from_u64(4);
    let mut place =
        || DVec3::new(rng.random_range(0.0..40.0), rng.random_range(0.0..34.0), rng.random_range(0.0..20.0));
    let dabs: Vec<Dab> = (0..1000).map(|_| dab_at(&grid, place(), 9.0)).collect();
    let mut at_once = Canvas::blank(&gpu, grid);
    at_once.begin(&brush);
    at_once.extend(&dabs);
    // Eleven groups of dabs on four bricks, of which one submission takes 2²² texels times dabs: all of 34³ in one brick,
    // parts of it in the others.
    let submits = at_once.painter.submits();
    assert!((6..=44).contains(&submits), "{submits} submissions");
    let mut in_turn = Canvas::blank(&gpu, grid);
    in_turn.begin(&brush);
    for dabs in dabs.chunks(60) {
        let before = in_turn.painter.submits();
        in_turn.extend(dabs);
        assert!(in_turn.painter.submits() > before);
    }
    assert!(at_once.finish() == in_turn.finish());
    // A frame's few dabs are one submission.
    let before = at_once.painter.submits();
    at_once.begin(&brush);
    at_once.extend(&dabs[..3]);
    assert_eq!(at_once.painter.submits(), before + 1);
}

#[test]
fn a_stroke_over_many_bricks_is_followed_and_taken_back_as_a_whole() {
    let Some(gpu) = gpu() else { return };
    // 150 bricks: more than one submission takes of their cells and of their texels.
    let grid = unit_grid([1600, 96, 4]);
    let mut canvas = Canvas::blank(&gpu, grid);
    canvas.selection = painted(FieldKind::Selection, &grid, |v| [(v[0] ^ v[1]) as u8 | 1, 0, 0, 0]);
    canvas.pools = FieldPools::new(&gpu, &grid, &canvas.density, 256 << 20).unwrap();
    let brush = Brush { target: Target::Selection(1.0), falloff: Falloff::Hard, radius_mm: 900.0, ..Brush::default() };
    canvas.begin(&brush);
    assert_eq!(canvas.extend(&[dab_at(&grid, DVec3::new(800.0, 48.0, 2.0), 900.0)]).len(), 150);
    let known = follow(&gpu, &mut canvas);
    assert_eq!(known.len(), 150);
    for (index, cells) in known {
        assert!(cells.ranges.iter().all(|r| *r == [1.0; 2]), "{index:?}");
        for (i, cell) in cells.selected.iter().enumerate() {
            // Only the first layer of cells is in the volume.
            let full = SelectedCell { min: 255, max: 255, sum: 255 * 64 };
            assert_eq!(*cell, if i < 64 { full } else { SelectedCell::NOTHING }, "{index:?} {i}");
        }
    }
    let Canvas { density, colour, selection, labels, painter, pools, grid, .. } = &mut canvas;
    let (fields, uploaded) = (one_volume(grid, density, colour, selection, labels), pools.work().1);
    let refresh = of_one(painter.cancel(pools).unwrap());
    pools.refresh_painted(&gpu, FieldKind::Selection, selection, &refresh).unwrap();
    assert_eq!(pools.work().1, uploaded, "what was put back is not uploaded");
    let frame = frame(grid, ramp(-1.0, 10.0), DVec3::NEG_Y, [16, 16]);
    pools.make_resident(&gpu, &fields, &frame).unwrap();
    let voxels: Vec<[u32; 3]> = selection.brick_indices(0).iter().map(|b| b.origin().map(|v| v + 1)).collect();
    let at: Vec<[f32; 3]> = voxels.iter().map(|v| v.map(|v| v as f32)).collect();
    for (voxel, s) in voxels.iter().zip(sample(&gpu, pools, &at)) {
        assert!((s.selection - selection.value(*voxel).unwrap()).abs() < 0.5 / 255.0, "{voxel:?}");
    }
}
