//! What is connected to a voxel through the faces of open ones (6-connected), brick by brick.
//!
//! A brick is asked for when the fill comes to it and filled in rows of 32 voxels at once, so that the cost is that of what is filled. Knows
//! not what makes a voxel open.

use crate::paint::voxel_set::{BrickBits, VoxelSet, place};
use crate::volume::{BRICK, BrickIndex};
use std::collections::{BTreeMap, HashMap};

/// Rows of a brick, and of one of its layers.
const ROWS: usize = (BRICK * BRICK) as usize;
const LAYER: usize = BRICK as usize;

/// The open voxels that are connected to any of the `starts` in a volume of `dims` voxels; `open` has those of a brick, none beyond the
/// volume.
///
/// # Errors
/// Those of `open`.
pub fn connected<E>(
    dims: [u32; 3],
    starts: &[[u32; 3]],
    mut open: impl FnMut(BrickIndex) -> Result<Box<BrickBits>, E>,
) -> Result<VoxelSet, E> {
    let count = dims.map(|d| d.div_ceil(BRICK));
    let mut masks: HashMap<BrickIndex, Box<BrickBits>> = HashMap::new();
    let mut filled = VoxelSet::default();
    let mut seeds: BTreeMap<BrickIndex, Box<BrickBits>> = BTreeMap::new();
    for &voxel in starts.iter().filter(|v| (0..3).all(|a| v[a] < dims[a])) {
        let (word, bit) = place(voxel);
        seeds.entry(BrickIndex::of_voxel(voxel)).or_insert_with(none)[word] |= bit;
    }
    while let Some((brick, seed)) = seeds.pop_first() {
        let mask = match masks.entry(brick) {
            std::collections::hash_map::Entry::Occupied(held) => held.into_mut(),
            std::collections::hash_map::Entry::Vacant(place) => place.insert(open(brick)?),
        };
        let rows = filled.brick_mut(brick);
        let mut grows = false;
        for ((row, seed), mask) in rows.iter_mut().zip(seed.iter()).zip(mask.iter()) {
            grows |= seed & mask & !*row != 0;
            *row |= seed & mask;
        }
        if !grows {
            continue;
        }
        fill(rows, mask);
        let rows = *rows;
        for axis in 0..3 {
            for (up, step) in [(false, -1_i64), (true, 1)] {
                let at = i64::from(brick.0[axis]) + step;
                if at < 0 || at >= i64::from(count[axis]) {
                    continue;
                }
                let mut index = brick.0;
                index[axis] = at as u32;
                let beside = face(&rows, axis, up);
                if beside.iter().any(|row| *row != 0) {
                    let seeds = seeds.entry(BrickIndex(index)).or_insert_with(none);
                    seeds.iter_mut().zip(beside.iter()).for_each(|(a, b)| *a |= b);
                }
            }
        }
    }
    Ok(filled)
}

fn none() -> Box<BrickBits> {
    Box::new([0; ROWS])
}

/// Fills a brick's open voxels from those that are filled already.
fn fill(rows: &mut BrickBits, mask: &BrickBits) {
    loop {
        let mut grew = false;
        let mut visit = |row: usize| {
            let (y, z) = (row % LAYER, row / LAYER);
            let mut near = rows[row];
            for beside in [
                (y > 0).then(|| row - 1),
                (y + 1 < LAYER).then(|| row + 1),
                (z > 0).then(|| row - LAYER),
                (z + 1 < LAYER).then(|| row + LAYER),
            ] {
                near |= beside.map_or(0, |beside| rows[beside]);
            }
            let new = along(near & mask[row], mask[row]);
            grew |= new != rows[row];
            rows[row] = new;
        };
        (0..ROWS).for_each(&mut visit);
        (0..ROWS).rev().for_each(&mut visit);
        if !grew {
            return;
        }
    }
}

/// Spreads bits along runs of the mask.
fn along(seed: u32, mask: u32) -> u32 {
    let (mut up, mut down) = (seed, seed);
    let (mut up_mask, mut down_mask) = (mask, mask);
    for shift in [1, 2, 4, 8, 16] {
        up |= up_mask & (up << shift);
        up_mask &= up_mask << shift;
        down |= down_mask & (down >> shift);
        down_mask &= down_mask >> shift;
    }
    up | down
}

/// The voxels of the next brick along an axis that lie beside filled ones.
fn face(rows: &BrickBits, axis: usize, up: bool) -> Box<BrickBits> {
    let mut beside = none();
    let last = LAYER - 1;
    match (axis, up) {
        (0, true) => beside.iter_mut().zip(rows).for_each(|(to, row)| *to = row >> 31),
        (0, false) => beside.iter_mut().zip(rows).for_each(|(to, row)| *to = row << 31),
        (1, true) => (0..LAYER).for_each(|z| beside[z * LAYER] = rows[z * LAYER + last]),
        (1, false) => (0..LAYER).for_each(|z| beside[z * LAYER + last] = rows[z * LAYER]),
        (_, true) => (0..LAYER).for_each(|y| beside[y] = rows[last * LAYER + y]),
        (_, false) => (0..LAYER).for_each(|y| beside[last * LAYER + y] = rows[y]),
    }
    beside
}
