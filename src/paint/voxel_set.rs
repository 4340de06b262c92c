//! A set of voxels, by brick: what a stroke on the visible surface may paint.
//!
//! Memory follows the bricks that hold any. Knows neither fields nor how its voxels were found.

use crate::paint::gate::GATE_WORDS;
use crate::volume::{BRICK, BRICK_VOXELS, BrickIndex, SLOT};
use std::collections::HashMap;

/// A bit for every voxel of a brick, x fastest.
pub type BrickBits = [u32; BRICK_VOXELS / 32];

/// Voxels by brick of level 0, a bit each; bricks without any take no room.
#[derive(Clone, Debug, Default)]
pub struct VoxelSet {
    bricks: HashMap<BrickIndex, Box<BrickBits>>,
    /// Boxes, from a voxel on and before another: then it is all voxels but theirs, and no bricks.
    all_but: Vec<[[u32; 3]; 2]>,
}

impl VoxelSet {
    /// All voxels but those of boxes, each from a voxel on and before another; at least one box, and nothing is to be added.
    pub fn all_but(boxes: Vec<[[u32; 3]; 2]>) -> Self {
        Self { all_but: boxes, ..Self::default() }
    }

    /// Whether it holds a voxel.
    pub fn contains(&self, voxel: [u32; 3]) -> bool {
        if !self.all_but.is_empty() {
            let inside = |[lo, end]: &[[u32; 3]; 2]| (0..3).all(|a| lo[a] <= voxel[a] && voxel[a] < end[a]);
            return !self.all_but.iter().any(inside);
        }
        let (word, bit) = place(voxel);
        self.bricks.get(&BrickIndex::of_voxel(voxel)).is_some_and(|bits| bits[word] & bit != 0)
    }

    /// Adds a voxel; answers whether it is new.
    pub fn insert(&mut self, voxel: [u32; 3]) -> bool {
        let (word, bit) = place(voxel);
        let bits = self.bricks.entry(BrickIndex::of_voxel(voxel)).or_insert_with(|| Box::new([0; BRICK_VOXELS / 32]));
        let new = bits[word] & bit == 0;
        bits[word] |= bit;
        new
    }

    /// Adds all voxels of another; answers those that are new.
    pub fn extend(&mut self, other: &Self) -> Self {
        let mut new = Self::default();
        for (brick, bits) in &other.bricks {
            let own = self.brick_mut(*brick);
            if own.iter().zip(bits.iter()).any(|(a, b)| b & !a != 0) {
                let rows = new.brick_mut(*brick);
                for ((own, bits), new) in own.iter_mut().zip(bits.iter()).zip(rows) {
                    *new = bits & !*own;
                    *own |= bits;
                }
            }
        }
        new
    }

    /// A bit for every texel of a slot of level 0 in a volume of `dims` voxels, as [`Gate::slot`](crate::paint::gate::Gate::slot) has them: apron
    /// texels as the voxels that they repeat.
    pub fn slot(&self, index: BrickIndex, dims: [u32; 3]) -> Vec<u32> {
        let origin = index.origin();
        let voxel = |a: usize, t: u32| (origin[a] + t).saturating_sub(1).min(dims[a] - 1);
        let mut bits = vec![0_u32; GATE_WORDS];
        for texel in 0..SLOT * SLOT * SLOT {
            let [x, y, z] = [texel % SLOT, texel / SLOT % SLOT, texel / (SLOT * SLOT)];
            let open = self.contains([voxel(0, x), voxel(1, y), voxel(2, z)]);
            bits[(texel / 32) as usize] |= u32::from(open) << (texel % 32);
        }
        bits
    }

    /// A brick's own voxels of the bits of its slot.
    pub fn of_slot(index: BrickIndex, bits: &[u32]) -> Self {
        let mut set = Self::default();
        let rows = set.brick_mut(index);
        for (n, row) in (0_u32..).zip(rows.iter_mut()) {
            let first = 1 + SLOT * (1 + n % BRICK + SLOT * (1 + n / BRICK));
            for x in 0..BRICK {
                let texel = (first + x) as usize;
                *row |= (bits[texel / 32] >> (texel % 32) & 1) << x;
            }
        }
        set
    }

    /// All of them, brick by brick, x fastest.
    pub fn voxels(&self) -> Vec<[u32; 3]> {
        let mut bricks: Vec<_> = self.bricks.iter().collect();
        bricks.sort_unstable_by_key(|(brick, _)| **brick);
        let mut all = Vec::new();
        for (brick, bits) in bricks {
            let origin = brick.origin();
            for (word, bits) in (0_u32..).zip(bits.iter()).filter(|(_, bits)| **bits != 0) {
                let set = (0..BRICK).filter(|x| bits >> x & 1 == 1);
                all.extend(set.map(|x| [origin[0] + x, origin[1] + word % BRICK, origin[2] + word / BRICK]));
            }
        }
        all
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.all_but.is_empty() && self.bricks.values().all(|bits| bits.iter().all(|word| *word == 0))
    }

    /// Puts a brick's voxels in place of those that it holds: `row` has the 32 of a row along x, counted along y and then z.
    pub fn put(&mut self, index: BrickIndex, row: impl Fn(u32) -> u32) {
        (0..).zip(self.brick_mut(index)).for_each(|(n, bits)| *bits = row(n));
    }

    /// A brick's voxels, to change them.
    fn brick_mut(&mut self, index: BrickIndex) -> &mut BrickBits {
        self.bricks.entry(index).or_insert_with(|| Box::new([0; BRICK_VOXELS / 32]))
    }

    /// Which voxels from `lo` to `end` (exclusive) are in it, x fastest; `None` if none is.
    pub(super) fn within(&self, lo: [u32; 3], end: [u32; 3]) -> Option<Vec<bool>> {
        let whole = crate::paint::dab::IndexBox { lo, end };
        let size: [usize; 3] = std::array::from_fn(|a| (end[a] - lo[a]) as usize);
        let mut held = None;
        for (index, bits) in whole.bricks().filter_map(|index| Some((index, self.bricks.get(&index)?))) {
            for voxel in whole.within(index).voxels() {
                let (word, bit) = place(voxel);
                if bits[word] & bit != 0 {
                    let [x, y, z]: [usize; 3] = std::array::from_fn(|a| (voxel[a] - lo[a]) as usize);
                    let held = held.get_or_insert_with(|| vec![false; size.iter().product()]);
                    held[x + size[0] * (y + size[1] * z)] = true;
                }
            }
        }
        held
    }

    /// Bricks whose slots show any of its voxels, or one so near to one of them along an axis, in a volume of `dims` voxels.
    pub fn slots(&self, dims: [u32; 3], margin: [u32; 3]) -> Vec<BrickIndex> {
        let reach = |index: &BrickIndex| {
            let origin = index.origin();
            let lo: [u32; 3] = std::array::from_fn(|a| origin[a].saturating_sub(margin[a]));
            let end = std::array::from_fn(|a| (origin[a] + BRICK).saturating_add(margin[a]).min(dims[a]));
            crate::paint::dab::IndexBox { lo, end }.slots(dims)
        };
        let mut all: Vec<_> = self.bricks.keys().flat_map(reach).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// The word of a brick's bits that a voxel lies in, and its bit.
pub(super) fn place(voxel: [u32; 3]) -> (usize, u32) {
    let [x, y, z] = voxel.map(|v| v % BRICK);
    let i = x + BRICK * (y + BRICK * z);
    ((i / 32) as usize, 1 << (i % 32))
}
