//! Connected components of a set of voxels: brick by brick, then joined across the bricks' faces (and edges and corners).
//!
//! Bricks are taken apart in parallel; what joins across borders is one list of pairs. Memory follows the bricks that are neither
//! all in nor all out. Components are numbered in the order of bricks, so that they are the same on every run.

use crate::segment::mask::BrickMask;
use crate::segment::runs::{Connectivity, Piece, Union, touching};
use crate::volume::{BRICK, BrickIndex};
use rayon::prelude::*;

/// Names a component of [`Components`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ComponentId(pub u32);

/// The connected components of a set of voxels.
#[derive(Debug)]
pub struct Components {
    dims: [u32; 3],
    bricks: [u32; 3],
    /// By brick, x fastest.
    pieces: Vec<Piece>,
    /// Of each brick the number of its first component among all bricks'; the last is the number of all.
    first: Vec<u32>,
    /// The component of each of those.
    of: Vec<u32>,
    sizes: Vec<u64>,
}

impl Components {
    /// Of a set over `dims` voxels, of which `mask` tells a brick of level 0 at a time. Cost: that of the bricks that are neither all
    /// in nor all out. A volume has room for 2³² components.
    ///
    /// # Errors
    /// Whatever `mask` fails with.
    pub fn new<E: Send>(
        dims: [u32; 3],
        connectivity: Connectivity,
        mask: impl Fn(BrickIndex) -> Result<BrickMask, E> + Sync,
    ) -> Result<Self, E> {
        let bricks = dims.map(|d| d.div_ceil(BRICK));
        let steps = connectivity.steps();
        let count = bricks.iter().map(|&n| n as usize).product::<usize>();
        let apart = |at: usize| {
            let index = brick_at(at, bricks);
            Ok(Piece::new(mask(index)?, steps, valid(index, dims)))
        };
        let (pieces, sizes_of): (Vec<_>, Vec<_>) =
            (0..count).into_par_iter().map(apart).collect::<Result<Vec<_>, E>>()?.into_iter().unzip();
        let mut first = vec![0_u32];
        for sizes in &sizes_of {
            first.push(first.last().copied().unwrap_or(0) + sizes.len() as u32);
        }
        let total = first.last().copied().unwrap_or(0);
        let mut all = Self { dims, bricks, pieces, first, of: Vec::new(), sizes: Vec::new() };
        let pairs: Vec<Vec<[u32; 2]>> = (0..count).into_par_iter().map(|at| all.joins(at, steps)).collect();
        let mut union = Union::new(total);
        for [a, b] in pairs.into_iter().flatten() {
            union.join(a, b);
        }
        let (of, count) = union.numbers();
        all.sizes = vec![0; count as usize];
        for (&component, size) in of.iter().zip(sizes_of.into_iter().flatten()) {
            all.sizes[component as usize] += u64::from(size);
        }
        all.of = of;
        Ok(all)
    }

    /// Which components of a brick and of those after it are neighbours.
    fn joins(&self, at: usize, steps: &[[i32; 3]]) -> Vec<[u32; 2]> {
        let here = &self.pieces[at];
        let mut pairs = Vec::new();
        if matches!(here, Piece::None) {
            return pairs;
        }
        let index = brick_at(at, self.bricks);
        let own = valid(index, self.dims);
        for &step in steps {
            // Which borders the step crosses: of each axis along which it goes, none or the brick's.
            for crossed in 1..8_u32 {
                let over = std::array::from_fn(|a| if crossed >> a & 1 == 1 { step[a] } else { 0 });
                if (0..3).any(|a| crossed >> a & 1 == 1 && step[a] == 0) {
                    continue;
                }
                let Some(other) = self.beside(index, over) else { continue };
                let there = &self.pieces[other];
                let mut join = |a: [u32; 3], b: [u32; 3]| {
                    let pair = [self.first[at] + here.component(a), self.first[other] + there.component(b)];
                    if pairs.last() != Some(&pair) {
                        pairs.push(pair);
                    }
                };
                match there {
                    Piece::None => continue,
                    Piece::All if matches!(here, Piece::All) => {
                        join([0; 3], [0; 3]);
                        continue;
                    }
                    _ => {}
                }
                let theirs = valid(brick_at(other, self.bricks), self.dims);
                for z in along(step[2], over[2]) {
                    for y in along(step[1], over[1]) {
                        let [ty, tz] =
                            [(y, step[1]), (z, step[2])].map(|(from, by)| from.wrapping_add_signed(by) % BRICK);
                        let (a, b) = (here.row(y, z, own), there.row(ty, tz, theirs));
                        match over[0] {
                            0 => touching(a, b, step[0], |x, tx| join([x, y, z], [tx, ty, tz])),
                            1 if a >> (BRICK - 1) & b & 1 == 1 => join([BRICK - 1, y, z], [0, ty, tz]),
                            -1 if a & b >> (BRICK - 1) & 1 == 1 => join([0, y, z], [BRICK - 1, ty, tz]),
                            _ => {}
                        }
                    }
                }
            }
        }
        pairs
    }

    /// The place of the brick that lies so many bricks from one, if there is one.
    fn beside(&self, index: BrickIndex, by: [i32; 3]) -> Option<usize> {
        let mut at = 0;
        for a in (0..3).rev() {
            let i = index.0[a].checked_add_signed(by[a]).filter(|i| *i < self.bricks[a])?;
            at = at * self.bricks[a] as usize + i as usize;
        }
        Some(at)
    }

    fn place(&self, index: BrickIndex) -> Option<usize> {
        self.beside(index, [0; 3])
    }

    /// Voxels of a brick along each axis.
    pub(super) fn valid(&self, index: BrickIndex) -> [u32; 3] {
        valid(index, self.dims)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.sizes.len()
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.sizes.is_empty()
    }

    /// The component of a voxel; `None` if it is not in the set, or outside of the volume.
    pub fn at(&self, voxel: [u32; 3]) -> Option<ComponentId> {
        let index = BrickIndex::of_voxel(voxel);
        let at = self.place(index)?;
        let [x, y, z] = voxel.map(|v| v % BRICK);
        let is_in = self.pieces[at].row(y, z, valid(index, self.dims)) >> x & 1 == 1;
        is_in.then(|| ComponentId(self.of[(self.first[at] + self.pieces[at].component([x, y, z])) as usize]))
    }

    /// Voxels of a component.
    pub fn size(&self, id: ComponentId) -> u64 {
        self.sizes.get(id.0 as usize).copied().unwrap_or(0)
    }

    /// Voxels of each component, in order.
    pub fn sizes(&self) -> &[u64] {
        &self.sizes
    }

    /// The one with the most voxels, the first of several.
    pub fn largest(&self) -> Option<ComponentId> {
        let all = (0..self.sizes.len() as u32).map(ComponentId);
        all.reduce(|best, next| if self.size(next) > self.size(best) { next } else { best })
    }

    /// What of a brick is of the components that `is_wanted`.
    pub fn mask(&self, index: BrickIndex, is_wanted: impl Fn(ComponentId) -> bool) -> BrickMask {
        let Some(at) = self.place(index) else { return BrickMask::None };
        let range = self.first[at] as usize..self.first[at + 1] as usize;
        let own = &self.of[range];
        // Most bricks hold nothing of a component, or nothing else.
        let wanted: Vec<bool> = own.iter().map(|&id| is_wanted(ComponentId(id))).collect();
        if wanted.iter().all(|w| !w) {
            return BrickMask::None;
        }
        if wanted.iter().all(|w| *w) {
            return self.pieces[at].mask();
        }
        self.pieces[at].only(valid(index, self.dims), |local| wanted[local as usize])
    }

    /// The bricks that hold anything of the components that `is_wanted`, in order, with what they hold.
    pub fn voxels(&self, is_wanted: impl Fn(ComponentId) -> bool + Sync) -> Vec<(BrickIndex, BrickMask)> {
        let one = |at: usize| {
            let index = brick_at(at, self.bricks);
            let mask = self.mask(index, &is_wanted);
            (mask != BrickMask::None).then_some((index, mask))
        };
        (0..self.pieces.len()).into_par_iter().filter_map(one).collect()
    }
}

fn brick_at(at: usize, bricks: [u32; 3]) -> BrickIndex {
    let [nx, ny, _] = bricks.map(|n| n as usize);
    BrickIndex([at % nx, at / nx % ny, at / nx / ny].map(|i| i as u32))
}

/// Voxels of a brick in the volume along each axis.
fn valid(index: BrickIndex, dims: [u32; 3]) -> [u32; 3] {
    let origin = index.origin();
    std::array::from_fn(|a| BRICK.min(dims[a] - origin[a]))
}

/// The rows along an axis from which a step leads into the brick `over` there.
fn along(step: i32, over: i32) -> std::ops::Range<u32> {
    match over {
        1 => BRICK - 1..BRICK,
        -1 => 0..1,
        _ => u32::from(step < 0)..BRICK - u32::from(step > 0),
    }
}
