//! What slots, aprons and the host's bricks hold during and after strokes.

use super::*;
use crate::common::volumes::Watched;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// All texels of a field's pool, x fastest.
fn pool(gpu: &Gpu, canvas: &Canvas, kind: FieldKind) -> (Vec<u8>, [u32; 3], usize) {
    let texture = canvas.pools.texture(kind).unwrap();
    let bytes = canvas.pools.format(kind).unwrap().bytes();
    let size = texture.size();
    let pitch = (size.width as usize * bytes).next_multiple_of(256);
    let (device, queue) = gpu.raw();
    let rows = (size.height * size.depth_or_array_layers) as usize;
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: (pitch * rows) as u64,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch as u32), rows_per_image: Some(size.height) };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        size,
    );
    queue.submit([encoder.finish()]);
    let padded = gpu.read_buffer(&buffer, "pool").unwrap();
    let texels = padded.chunks_exact(pitch).flat_map(|row| row[..size.width as usize * bytes].to_vec()).collect();
    (texels, [size.width, size.height, size.depth_or_array_layers], bytes)
}

/// Gives every brick of a field a slot; if slots lie apart, fills those that belong to nobody with a sentinel. Answers the
/// slots' origins.
fn pin_all(gpu: &Gpu, canvas: &mut Canvas, kind: FieldKind) -> Vec<(BrickIndex, [u32; 3])> {
    let all = canvas.field(kind).brick_indices(0);
    let field = canvas.field(kind).clone();
    let origins = canvas.pools.pin(gpu, kind, &field, &all).unwrap();
    let texture = canvas.pools.texture(kind).unwrap();
    let bytes = canvas.pools.format(kind).unwrap().bytes() as u32;
    let size = texture.size();
    let (_, queue) = gpu.raw();
    if canvas.in_place(gpu, kind) {
        return all.into_iter().zip(origins).collect();
    }
    let slots = [size.width, size.height, size.depth_or_array_layers].map(|s| s / SLOT);
    let mut free = 0;
    for at in each(slots, |s| s.map(|i| i * SLOT)) {
        if origins.contains(&at) {
            continue;
        }
        free += 1;
        let origin = wgpu::Origin3d { x: at[0], y: at[1], z: at[2] };
        queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            &vec![0xcd; SLOT_VOXELS * bytes as usize],
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SLOT * bytes), rows_per_image: Some(SLOT) },
            wgpu::Extent3d { width: SLOT, height: SLOT, depth_or_array_layers: SLOT },
        );
    }
    assert!(free > 0);
    all.into_iter().zip(origins).collect()
}

fn slot_of(pool: &[u8], size: [u32; 3], bytes: usize, origin: [u32; 3]) -> Vec<u8> {
    let mut out = Vec::with_capacity(SLOT_VOXELS * bytes);
    for z in origin[2]..origin[2] + SLOT {
        for y in origin[1]..origin[1] + SLOT {
            let i = (origin[0] + size[0] * (y + size[1] * z)) as usize * bytes;
            out.extend_from_slice(&pool[i..i + SLOT as usize * bytes]);
        }
    }
    out
}

/// A slot as the host's field has it.
fn slot_from(dense: &[u8], bytes: usize, dims: [u32; 3], brick: BrickIndex) -> Vec<u8> {
    let at = |a: usize, t: u32| (brick.origin()[a] + t).saturating_sub(1).min(dims[a] - 1);
    let mut out = Vec::with_capacity(SLOT_VOXELS * bytes);
    for z in 0..SLOT {
        for y in 0..SLOT {
            let row = dims[0] * (at(1, y) + dims[1] * at(2, z));
            for x in 0..SLOT {
                let i = (row + at(0, x)) as usize * bytes;
                out.extend_from_slice(&dense[i..i + bytes]);
            }
        }
    }
    out
}

const TARGETS: [Target; 4] =
    [Target::Density(30_000.0), Target::Colour([0.2, 0.9, 0.5, 0.8]), Target::Selection(0.7), Target::Label(300)];

/// Every target with bricks in slots of their own, and density, which alone may lie in place, in place too.
fn cases() -> impl Iterator<Item = (Target, bool)> {
    TARGETS.into_iter().map(|target| (target, true)).chain([(TARGETS[0], false)])
}

/// A path through all eight bricks, along a border and out of the volume.
fn way(grid: &Grid, brush: &Brush) -> Vec<Dab> {
    let stops = [[3.0, 3.0, 3.0], [31.6, 31.4, 10.0], [32.1, 31.9, 33.0], [38.0, 5.0, 31.5], [45.0, 40.0, 20.0]];
    let normal = dab_at(grid, DVec3::ZERO, 0.0).normal;
    let samples = stops.map(|s| Sample {
        position: grid.world_from_index.transform_point3(DVec3::from_array(s)),
        normal,
        pressure: 0.9,
        breaks: false,
    });
    StrokePath::new(brush, grid).unwrap().extend(&samples).unwrap()
}

#[test]
fn aprons_repeat_their_neighbours_after_every_frame() {
    let Some(gpu) = gpu() else { return };
    for (target, apart) in cases() {
        let kind = target.field();
        let mut canvas = Canvas::codes(&gpu, grids()[2]);
        canvas.lay(&gpu, apart);
        let slots = pin_all(&gpu, &mut canvas, kind);
        let brush = Brush { target, tip: Tip::BuildUp, radius_mm: 4.0, strength: 0.4, ..Brush::default() };
        let dabs = way(&canvas.grid, &brush);
        let bytes = canvas.field(kind).format().bytes();
        let mut dense = canvas.texels(kind);
        canvas.begin(&brush);
        for frame in dabs.chunks(dabs.len().div_ceil(4)) {
            canvas.extend(frame);
            let (texels, size, _) = pool(&gpu, &canvas, kind);
            let before = dense.clone();
            for (brick, origin) in &slots {
                let slot = slot_of(&texels, size, bytes, *origin);
                let o = brick.origin();
                let valid = std::array::from_fn::<_, 3, _>(|a| BRICK.min(DIMS[a] - o[a]));
                for z in 0..valid[2] {
                    for y in 0..valid[1] {
                        let from = (1 + SLOT * ((y + 1) + SLOT * (z + 1))) as usize * bytes;
                        let to = (o[0] + DIMS[0] * (o[1] + y + DIMS[1] * (o[2] + z))) as usize * bytes;
                        let row = valid[0] as usize * bytes;
                        dense[to..to + row].copy_from_slice(&slot[from..from + row]);
                    }
                }
            }
            assert_ne!(dense, before, "the frame shows nothing");
            for (brick, origin) in &slots {
                assert!(
                    slot_of(&texels, size, bytes, *origin) == slot_from(&dense, bytes, DIMS, *brick),
                    "{kind:?} {brick:?}"
                );
            }
        }
        canvas.finish();
    }
}

#[test]
fn nothing_but_the_touched_slots_is_written() {
    let Some(gpu) = gpu() else { return };
    for (target, apart) in cases() {
        let kind = target.field();
        let mut canvas = Canvas::codes(&gpu, grids()[0]);
        canvas.lay(&gpu, apart);
        let slots = pin_all(&gpu, &mut canvas, kind);
        let (before, size, bytes) = pool(&gpu, &canvas, kind);
        let brush = Brush { target, radius_mm: 3.0, ..Brush::default() };
        canvas.begin(&brush);
        let index = DVec3::new(10.0, 12.0, 3.0);
        let touched = canvas.extend(&[dab_at(&canvas.grid, index, 3.0)]);
        assert_eq!(touched, [BrickIndex([0; 3])]);
        let (after, after_size, _) = pool(&gpu, &canvas, kind);
        assert_eq!(size, after_size);
        let home = slots[0].1;
        let mut painted = 0;
        for (i, at) in each(size, |t| t).into_iter().enumerate() {
            // Voxel 3·0.7 mm is 4.3 voxels, 3.3 and 1.2: nothing beyond 5, 4, 2 of the centre.
            let near = (0..3).all(|a| {
                let t = i64::from(at[a]) - i64::from(home[a]) - 1;
                (t - index[a] as i64).abs() <= [5, 4, 2][a]
            });
            let same = before[i * bytes..(i + 1) * bytes] == after[i * bytes..(i + 1) * bytes];
            assert!(near || same, "{kind:?} {at:?}");
            painted += usize::from(!same);
        }
        assert!(painted > 3, "{kind:?} {painted}");
        canvas.finish();
    }
}

#[test]
fn undo_of_a_stroke_returns_every_byte() {
    let Some(gpu) = gpu() else { return };
    for (target, apart) in cases() {
        let kind = target.field();
        let mut canvas = Canvas::codes(&gpu, grids()[1]);
        canvas.lay(&gpu, apart);
        let all = |c: &Canvas| {
            let f = c.field(kind);
            (0..f.level_count()).map(|l| f.read(l, [0; 3], f.dims(l)).unwrap()).collect::<Vec<_>>()
        };
        let start = all(&canvas);
        let brush = Brush { target, radius_mm: 5.0, ..Brush::default() };
        let dabs = way(&canvas.grid, &brush);
        canvas.begin(&brush);
        canvas.extend(&dabs);
        let changed = canvas.finish();
        assert!(changed.windows(2).all(|w| w[0].0 < w[1].0));
        let changes = changed.into_iter().map(|(i, b)| (i, Some(b))).collect();
        let (before, refresh) = canvas.field_mut(kind).swap(changes).unwrap();
        let painted = all(&canvas);
        assert_ne!(painted, start);
        // The slots already show what the host has now.
        let slots = pin_all(&gpu, &mut canvas, kind);
        let (texels, size, bytes) = pool(&gpu, &canvas, kind);
        for (brick, origin) in &slots {
            assert!(
                slot_of(&texels, size, bytes, *origin) == slot_from(&painted[0], bytes, DIMS, *brick),
                "{kind:?} {brick:?}"
            );
        }
        let field = canvas.field(kind).clone();
        canvas.pools.refresh(&gpu, kind, &field, &refresh).unwrap();
        canvas.field_mut(kind).swap(before).unwrap();
        assert_eq!(all(&canvas), start);
    }
}

#[test]
fn cancel_leaves_no_trace() {
    let Some(gpu) = gpu() else { return };
    for (target, apart) in cases() {
        let kind = target.field();
        let mut canvas = Canvas::codes(&gpu, grids()[1]);
        canvas.lay(&gpu, apart);
        pin_all(&gpu, &mut canvas, kind);
        let (before, ..) = pool(&gpu, &canvas, kind);
        let brush = Brush { target, radius_mm: 5.0, ..Brush::default() };
        let dabs = way(&canvas.grid, &brush);
        canvas.begin(&brush);
        canvas.extend(&dabs[..10]);
        canvas.extend(&dabs[10..]);
        assert!(pool(&gpu, &canvas, kind).0 != before);
        let touched = touched(&canvas.painter);
        let Canvas { painter, pools, .. } = &mut canvas;
        let refresh = of_one(painter.cancel(pools).unwrap());
        assert_eq!(refresh.finest().collect::<Vec<_>>(), touched);
        assert!(!painter.is_painting());
        assert!(pool(&gpu, &canvas, kind).0 == before, "{kind:?}");
        // And the next stroke starts clean, in the buffers of the one before.
        canvas.begin(&brush);
        assert!(canvas.finish().is_empty());
    }
}

#[test]
fn a_stroke_that_changes_nothing_gives_no_brick() {
    let Some(gpu) = gpu() else { return };
    let mut canvas = Canvas::codes(&gpu, grids()[0]);
    let brush = |target, operation| Brush { target, operation, radius_mm: 6.0, ..Brush::default() };
    let same = canvas.texels(FieldKind::Selection).iter().all(|&t| t == 0);
    assert!(!same);
    let blank = Field::blank(FieldKind::Selection, &canvas.grid);
    let mut nothing = vec![
        // Erasing what was never edited, locked labels, a range that holds nothing, pressure 0, outside of the volume.
        (Brush { erase: true, ..brush(Target::Density(1.0), Operation::Replace) }, 1.0, 20.0),
        (Brush { range: Some([1e6, 1e7].map(Number::Real)), ..brush(Target::Label(7), Operation::Replace) }, 1.0, 20.0),
        (brush(Target::Label(7), Operation::Replace), 0.0, 20.0),
        (brush(Target::Label(7), Operation::Replace), 1.0, 400.0),
        (Brush { strength: 0.4, ..brush(Target::Label(7), Operation::Replace) }, 1.0, 20.0),
        (brush(Target::Colour([1.0; 4]), Operation::Subtract), 0.0, 20.0),
    ];
    canvas.segments = Segments::default();
    for (brush, pressure, at) in nothing.drain(..) {
        canvas.begin(&brush);
        let dab = Dab { pressure, ..dab_at(&canvas.grid, DVec3::splat(at), 6.0) };
        canvas.extend(&[dab]);
        assert_eq!(canvas.finish(), vec![], "{brush:?}");
    }
    canvas.selection = blank;
    canvas.pools = FieldPools::new(&gpu, &canvas.grid, &canvas.density, 64 << 20).unwrap();
    canvas.begin(&Brush { erase: true, ..brush(Target::Selection(1.0), Operation::Replace) });
    let dab = dab_at(&canvas.grid, DVec3::splat(20.0), 6.0);
    canvas.extend(&[dab]);
    assert_eq!(canvas.finish(), vec![]);
}

#[test]
fn a_lost_device_replays_the_stroke() {
    let Some(gpu) = gpu() else { return };
    let doomed = Gpu::headless().unwrap();
    let brush = Brush { tip: Tip::BuildUp, strength: 0.3, radius_mm: 5.0, ..Brush::default() };
    let mut canvas = Canvas::codes(&gpu, grids()[1]);
    let dabs = way(&canvas.grid, &brush);
    canvas.begin(&brush);
    canvas.extend(&dabs);
    let expected = canvas.finish();
    assert!(!expected.is_empty());

    let mut canvas = Canvas::codes(&doomed, grids()[1]);
    canvas.begin(&brush);
    let (first, rest) = dabs.split_at(dabs.len() / 2);
    canvas.extend(first);
    doomed.raw().0.destroy();
    let _ = doomed.wait();
    let Canvas { density, colour, selection, labels, painter, pools, grid, .. } = &mut canvas;
    let fields = one_volume(grid, density, colour, selection, labels);
    assert!(painter.extend(pools, &fields, &[(VolumeId::FIRST, rest)]).is_err());
    assert!(painter.finish(pools, &fields).is_err());
    *pools = FieldPools::new(&gpu, grid, density, 64 << 20).unwrap();
    painter.replay(&gpu, pools, &fields).unwrap();
    painter.extend(pools, &fields, &[(VolumeId::FIRST, rest)]).unwrap();
    assert_eq!(of_one(painter.finish(pools, &fields).unwrap()), expected);
}

#[test]
fn a_stroke_beyond_its_budget_keeps_what_it_has() {
    let Some(gpu) = gpu() else { return };
    let mut canvas = Canvas::blank(&gpu, unit_grid([196, 196, 8]));
    let brush = Brush { radius_mm: 4.0, ..Brush::default() };
    canvas.painter.set_budget(16 * 300_000);
    canvas.begin(&brush);
    canvas.extend(&[dab_at(&canvas.grid, DVec3::new(20.0, 20.0, 3.0), 4.0)]);
    let many: Vec<_> = (0..7)
        .flat_map(|x| (0..7).map(move |y| DVec3::new(16.0 + 30.0 * f64::from(x), 16.0 + 30.0 * f64::from(y), 3.0)))
        .map(|p| dab_at(&canvas.grid, p, 4.0))
        .collect();
    let Canvas { density, colour, selection, labels, painter, pools, grid, .. } = &mut canvas;
    let fields = one_volume(grid, density, colour, selection, labels);
    let error = painter.extend(pools, &fields, &[(VolumeId::FIRST, &many)]).unwrap_err().to_string();
    assert!(error.contains("stroke needs") && error.contains("4800000"), "{error}");
    let live = painter.live(pools, &fields, VolumeId::FIRST, BrickIndex([0; 3])).unwrap().unwrap();
    assert_eq!(painter.live(pools, &fields, VolumeId::FIRST, BrickIndex([5, 5, 0])).unwrap(), None);
    let bricks = of_one(painter.finish(pools, &fields).unwrap());
    assert_eq!(bricks, [(BrickIndex([0; 3]), live)]);
    // Nothing of it is kept on the host, so the slots go back too.
    let slots = vec![BrickKey { level: 0, index: BrickIndex([0; 3]) }];
    pools.refresh(&gpu, FieldKind::Selection, selection, &Refresh::whole(slots)).unwrap();
    // A stroke may grow over many chunks.
    painter.set_budget(1 << 30);
    canvas.begin(&brush);
    for dabs in many.chunks(9) {
        canvas.extend(dabs);
    }
    assert!(touched(&canvas.painter).len() > 48);
    let found = canvas.finish();
    let mut once = Canvas::blank(&gpu, canvas.grid);
    once.begin(&brush);
    once.extend(&many);
    assert!(once.finish() == found);
}

#[test]
fn calls_out_of_turn_are_answers() {
    let Some(gpu) = gpu() else { return };
    let mut canvas = Canvas::codes(&gpu, grids()[0]);
    let Canvas { density, colour, selection, labels, painter, pools, grid, segments, .. } = &mut canvas;
    let fields = one_volume(grid, density, colour, selection, labels);
    assert!(painter.extend(pools, &fields, &[]).is_err());
    assert!(painter.finish(pools, &fields).is_err());
    assert!(painter.cancel(pools).is_err());
    let bad = Brush { strength: 2.0, ..Brush::default() };
    assert!(
        painter
            .begin(VolumeId::FIRST, &fields, &bad, segments, Reach([0.0; 2]))
            .unwrap_err()
            .to_string()
            .starts_with("brush.strength")
    );
    let high = Brush { target: Target::Density(70_000.0), ..Brush::default() };
    match painter.begin(VolumeId::FIRST, &fields, &high, segments, Reach([0.0; 2])).unwrap_err() {
        burin::gpu::GpuError::BeyondRange { needed, held } => {
            assert_eq!((needed, held), ([0.0, 70_000.0], [0.0, 65_535.0]));
        }
        other => panic!("{other}"),
    }
    painter.begin(VolumeId::FIRST, &fields, &Brush::default(), segments, Reach([0.0; 2])).unwrap();
    assert!(painter.begin(VolumeId::FIRST, &fields, &Brush::default(), segments, Reach([0.0; 2])).is_err());
}

#[test]
fn a_device_without_16_bit_textures_paints_the_same_codes() {
    let Some(gpu) = gpu() else { return };
    let lesser = Gpu::headless_with(wgpu::Features::empty()).unwrap();
    assert!(!lesser.has_unorm16(), "a device that lacks 16-bit textures");
    let brush = Brush {
        target: Target::Density(12_345.0),
        tip: Tip::BuildUp,
        strength: 0.37,
        radius_mm: 5.0,
        range: Some([100.0, 50_000.0].map(Number::Real)),
        ..Brush::default()
    };
    for erase in [false, true] {
        let brush = Brush { erase, ..brush };
        let [a, b] = [&gpu, &lesser].map(|gpu| {
            let mut canvas = Canvas::codes(gpu, grids()[2]);
            canvas.density.swap(vec![(BrickIndex([0, 1, 0]), Some(Brick::Uniform([1, 99, 0, 0])))]).unwrap();
            canvas.pools = FieldPools::new(gpu, &canvas.grid, &canvas.density, 64 << 20).unwrap();
            let dabs = way(&canvas.grid, &brush);
            canvas.begin(&brush);
            canvas.extend(&dabs);
            canvas.finish()
        });
        assert!(!a.is_empty() && a == b);
    }
}

#[test]
fn a_stroke_whose_source_fails_goes_on_once_it_answers_again() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([160, 24, 24]);
    let voxels = Voxels::U16(each(grid.dims, |v| noise(v, 0) as u16));
    let memory = MemorySource::new("failing", grid, voxels, (1.0, 0.0)).unwrap();
    let failing = Arc::new(AtomicBool::new(false));
    // Its first bricks along x cannot be read while it fails.
    let source = Arc::new(Watched(memory, {
        let fails = failing.clone();
        move |lo: [u32; 3], _| match lo[0] < 32 && fails.load(Ordering::Relaxed) {
            true => Err(SourceError::Unreadable { name: "failing".into(), reason: "made to fail".into() }),
            false => Ok(()),
        }
    }));
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let density = Field::from_source(source, map, &|_| true).unwrap().unwrap();
    let brush = Brush {
        target: Target::Selection(0.7),
        range: Some([0.0, 40_000.0].map(Number::from)),
        visible_only: true,
        radius_mm: 6.0,
        strength: 0.4,
        ..Brush::default()
    };
    let dab = |x: f64| dab_at(&grid, DVec3::new(x, 12.0, 12.0), 6.0);
    let column = |from: u32, to: u32| {
        let mut set = VoxelSet::default();
        each([to - from, 24, 24], |[x, y, z]| set.insert([from + x, y, z]));
        set
    };
    let mut results = Vec::new();
    for fails in [false, true] {
        let mut canvas = Canvas::new(&gpu, grid, density.clone());
        canvas.begin(&brush);
        canvas.painter.open(VolumeId::FIRST, &column(0, 16));
        canvas.extend(&[dab(14.0)]);
        let before = touched(&canvas.painter);
        // What was seen since lies in a brick whose gate is made already, and in one that is new.
        canvas.painter.open(VolumeId::FIRST, &column(16, 20));
        canvas.painter.open(VolumeId::FIRST, &column(128, 150));
        failing.store(fails, Ordering::Relaxed);
        if fails {
            let Canvas { density, colour, selection, labels, painter, pools, grid, .. } = &mut canvas;
            let fields = one_volume(grid, density, colour, selection, labels);
            let error = painter.extend(pools, &fields, &[(VolumeId::FIRST, &[dab(140.0)])]).unwrap_err().to_string();
            assert!(error.contains("made to fail"), "{error}");
            assert_eq!(touched(painter), before, "as it was");
            failing.store(false, Ordering::Relaxed);
        }
        canvas.extend(&[dab(140.0)]);
        canvas.extend(&[dab(17.0)]);
        results.push(canvas.finish());
    }
    assert_eq!(results[0].len(), 2, "both ends are painted");
    assert!(results[0] == results[1]);
}
