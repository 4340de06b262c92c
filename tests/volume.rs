//! Fields, levels, grids and the transfer function.

mod distance;
mod levels;
mod presets;
mod refined;

use burin::math::DVec3;
use burin::volume::*;
use std::collections::BTreeSet;
use std::sync::Arc;

fn ramp(dims: [u32; 3]) -> (Arc<MemorySource>, impl Fn([u32; 3]) -> u16) {
    let value = move |v: [u32; 3]| (v[0] * 7 + v[1] * 31 + v[2] * 131 + (v[0] * v[1] * v[2]) % 97) as u16;
    let grid = Grid::aligned(dims, DVec3::ONE, DVec3::ZERO);
    let mut voxels = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                voxels.push(value([x, y, z]));
            }
        }
    }
    (Arc::new(MemorySource::new("ramp", grid, Voxels::U16(voxels), (1.0, 0.0)).unwrap()), value)
}

fn code(texels: &[u8], i: usize) -> u16 {
    u16::from_le_bytes([texels[2 * i], texels[2 * i + 1]])
}

#[test]
fn a_slot_repeats_the_border_and_reads_over_its_neighbours() {
    let dims = [70, 33, 40];
    let (source, value) = ramp(dims);
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let field = Field::from_source(source, map, &|_| true).unwrap().unwrap();
    for index in field.brick_indices(0) {
        let slot = field.slot(BrickKey { level: 0, index }).unwrap();
        let mut i = 0;
        for z in 0..SLOT {
            for y in 0..SLOT {
                for x in 0..SLOT {
                    let at = [x, y, z];
                    let voxel = std::array::from_fn(|a| {
                        (i64::from(index.origin()[a] + at[a]) - 1).clamp(0, i64::from(dims[a]) - 1) as u32
                    });
                    assert_eq!(code(&slot, i), value(voxel), "{index:?} {at:?}");
                    i += 1;
                }
            }
        }
    }
}

#[test]
fn a_coarser_voxel_is_the_mean_of_those_it_covers() {
    let dims = [70, 33, 40];
    let (source, value) = ramp(dims);
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let field = Field::from_source(source, map, &|_| true).unwrap().unwrap();
    assert_eq!(field.level_count(), 3);
    let d = field.dims(1);
    let texels = field.read(1, [0; 3], d).unwrap();
    let mut i = 0;
    for z in 0..d[2] {
        for y in 0..d[1] {
            for x in 0..d[0] {
                let mut sum = 0.0;
                let mut n = 0.0;
                for c in 0..8_u32 {
                    let v = [2 * x + (c & 1), 2 * y + (c >> 1 & 1), 2 * z + (c >> 2)];
                    if (0..3).all(|a| v[a] < dims[a]) {
                        sum += f64::from(value(v));
                        n += 1.0;
                    }
                }
                assert!((f64::from(code(&texels, i)) - sum / n).abs() <= 0.5);
                i += 1;
            }
        }
    }
}

#[test]
fn a_swap_and_its_answer_leave_every_level_as_it_was() {
    let (source, _) = ramp([70, 33, 40]);
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let mut field = Field::from_source(source, map, &|_| true).unwrap().unwrap();
    let all = |f: &Field| (0..f.level_count()).map(|l| f.read(l, [0; 3], f.dims(l)).unwrap()).collect::<Vec<_>>();
    let about = |f: &Field| {
        (0..f.level_count())
            .flat_map(|level| f.brick_indices(level).into_iter().map(move |index| BrickKey { level, index }))
            .map(|k| (f.summary(k), f.cells(k)))
            .collect::<Vec<_>>()
    };
    let (start, start_about) = (all(&field), about(&field));
    let change = vec![(BrickIndex([1, 0, 1]), Some(Brick::Uniform([9, 200, 0, 0])))];
    let (before, refresh) = field.swap(change).unwrap();
    assert!(refresh.keys().any(|key| key == BrickKey { level: 2, index: BrickIndex([0, 0, 0]) }));
    assert_ne!(all(&field), start);
    assert_ne!(about(&field), start_about);
    field.swap(before).unwrap();
    assert_eq!(all(&field), start);
    assert_eq!(about(&field), start_about);
}

fn voxels_of(Region { lo, end }: Region) -> impl Iterator<Item = [u32; 3]> {
    (lo[2]..end[2]).flat_map(move |z| (lo[1]..end[1]).flat_map(move |y| (lo[0]..end[0]).map(move |x| [x, y, z])))
}

#[test]
fn a_swap_renews_the_slots_that_changed_and_no_other() {
    let dims = [100, 70, 40];
    let (source, _) = ramp(dims);
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let open = |source: Arc<MemorySource>| Field::from_source(source, map, &|_| true).unwrap().unwrap();
    let mut field = open(source.clone());
    let Voxels::U16(mut voxels) = source.voxels().clone() else { panic!("16 bits") };
    // Inside a brick, on one face of it, in its corner, at the volume's corner.
    for (n, voxel) in [[16, 16, 16], [32, 40, 10], [63, 31, 32], [99, 69, 39], [0, 0, 0]].into_iter().enumerate() {
        let index = BrickIndex::of_voxel(voxel);
        let slots = |f: &Field| {
            let keys = (0..f.level_count())
                .flat_map(|level| f.brick_indices(level).into_iter().map(move |index| BrickKey { level, index }));
            keys.map(|k| (k, f.slot(k).unwrap())).collect::<Vec<_>>()
        };
        let old = slots(&field);
        let code = 40_000 + 1000 * n as u16;
        let mut texels = field.brick(BrickKey { level: 0, index }).unwrap().to_texels(2);
        let at = voxel.map(|v| (v % 32) as usize);
        let at = (at[0] + 32 * (at[1] + 32 * at[2])) * 2;
        texels[at..at + 2].copy_from_slice(&code.to_le_bytes());
        voxels[(voxel[0] + dims[0] * (voxel[1] + dims[1] * voxel[2])) as usize] = code;
        let (_, refresh) = field.swap(vec![(index, Some(Brick::from_texels(texels, 2)))]).unwrap();
        let new = slots(&field);
        let changed: Vec<_> = old.iter().zip(&new).filter(|(a, b)| a.1 != b.1).map(|(a, _)| a.0).collect();
        let named: Vec<_> = refresh.keys().collect();
        assert!(changed.iter().all(|k| named.contains(k)), "{voxel:?}");
        let finest = |keys: &[BrickKey]| keys.iter().filter(|k| k.level == 0).copied().collect::<BTreeSet<_>>();
        assert_eq!(finest(&named), finest(&changed), "{voxel:?}");

        // The box that is said to be new is all that a copy of the slot needs.
        for ((key, old), (_, new)) in old.iter().zip(&new) {
            let mut copy = old.clone();
            if let Some((_, region)) = refresh.slots.iter().find(|(k, _)| k == key) {
                let part = region.in_slot(key.index, field.dims(key.level));
                for [x, y, z] in voxels_of(part) {
                    let at = (x + 34 * (y + 34 * z)) as usize * 2;
                    copy[at..at + 2].copy_from_slice(&new[at..at + 2]);
                }
            }
            assert!(copy == *new, "{voxel:?} {key:?}");
        }

        // All is as if the volume had come like that.
        let grid = *source.grid();
        let fresh = open(Arc::new(MemorySource::new("fresh", grid, Voxels::U16(voxels.clone()), (1.0, 0.0)).unwrap()));
        assert!(slots(&fresh) == new, "{voxel:?}");
        for (key, _) in new {
            assert_eq!((field.summary(key), field.cells(key)), (fresh.summary(key), fresh.cells(key)), "{key:?}");
        }
    }
    // An edit that changes nothing renews nothing.
    let index = BrickIndex([1, 1, 0]);
    let same = field.brick(BrickKey { level: 0, index }).unwrap();
    assert_eq!(field.swap(vec![(index, Some(same))]).unwrap().1.slots, []);
}

#[test]
fn a_cell_bounds_every_tap_of_its_samples() {
    let dims = [40, 36, 33];
    let (source, value) = ramp(dims);
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let field = Field::from_source(source, map, &|_| true).unwrap().unwrap();
    for index in field.brick_indices(0) {
        let Cells::Dense(cells) = field.cells(BrickKey { level: 0, index }) else { panic!("not uniform") };
        for (i, cell) in cells.iter().enumerate() {
            let i = i as u32;
            let lo: [u32; 3] = std::array::from_fn(|a| index.origin()[a] + [i % 8, i / 8 % 8, i / 64][a] * CELL);
            let mut expected = [f32::INFINITY, f32::NEG_INFINITY];
            for n in 0..216_i64 {
                let at = [n % 6, n / 6 % 6, n / 36];
                let v = std::array::from_fn(|a| (i64::from(lo[a]) + at[a] - 1).clamp(0, i64::from(dims[a]) - 1) as u32);
                expected = [expected[0].min(f32::from(value(v))), expected[1].max(f32::from(value(v)))];
            }
            // Cells beyond the volume repeat its border.
            assert_eq!(*cell, expected, "{index:?} cell {i}");
        }
    }
}

#[test]
fn codes_hold_every_integer_exactly() {
    for (min, max) in [(0.0, 255.0), (-1024.0, 3071.0), (0.0, 65_535.0), (-32_768.0, 32_767.0)] {
        let map = DensityMap::codes(min, max, Some(1.0));
        let mut v = min;
        while v <= max {
            assert_eq!(map.decode(map.encode(v)), v);
            v += 1.0;
        }
    }
    let scaled = DensityMap::codes(-10.0, 10.0, Some(0.25));
    assert_eq!(scaled.decode(scaled.encode(-3.75)), -3.75);
}

#[test]
fn opacity_is_corrected_for_the_step() {
    let tf = TransferFunction { colour: vec![(0.0, [1.0; 3])], opacity: vec![(0.0, 0.0), (10.0, 0.5)], unit_mm: 1.0 };
    // Two half steps let through what one whole step does.
    let half = tf.opacity_of_step(10.0, 0.5);
    assert!(((1.0 - half) * (1.0 - half) - 0.5).abs() < 1e-7);
    assert_eq!(tf.max_opacity_in(-5.0, 5.0), 0.25);
    assert_eq!(tf.max_opacity_in(5.0, -5.0), 0.0);
}

#[test]
fn extremes_follow_edits_that_raise_lower_and_remove_them() {
    let dims = [70, 33, 40];
    let (source, _) = ramp(dims);
    let mut field =
        Field::from_source(source, DensityMap::codes(0.0, 65_535.0, Some(1.0)), &|_| true).unwrap().unwrap();
    let every = |field: &Field| {
        let codes = field.read(0, [0; 3], dims).unwrap();
        let all = codes.chunks_exact(2).map(|t| f32::from(u16::from_le_bytes([t[0], t[1]])));
        all.fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)])
    };
    assert_eq!(field.extremes(), every(&field));
    let uniform = |value: u16| Some(Brick::Uniform([value as u8, (value >> 8) as u8, 0, 0]));
    let bricks = [[2, 1, 1], [0, 0, 0], [1, 0, 0]].map(BrickIndex);
    let mut undo = Vec::new();
    for values in [[60_000, 5, 9], [3, 3, 3], [0, 65_535, 40], [500, 600, 700]] {
        let changes = bricks.into_iter().zip(values).map(|(b, v)| (b, uniform(v))).collect();
        undo.push(field.swap(changes).unwrap().0);
        assert_eq!(field.extremes(), every(&field), "{values:?}");
    }
    for before in undo.into_iter().rev() {
        field.swap(before).unwrap();
        assert_eq!(field.extremes(), every(&field));
    }
}
