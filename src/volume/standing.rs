//! Which voxels of a volume its sub-volumes leave it, and how much of each: every place is told by one volume alone.
//!
//! A voxel's cell reaches half a voxel about its centre and ends at the faces of its own box. A sub-volume stands for all between its
//! faces: a voxel on a face keeps what of its cell lies outside, and one whose cell lies in sub-volumes altogether is not asked. What lies
//! beyond the outermost centres of a whole volume is told by whoever tells the inner side. So cells of neighbours need not touch: a box
//! may lie between. Knows boxes, no fields.

use crate::volume::brick::{BRICK, BrickIndex};
use crate::volume::computed::SubBox;
use std::collections::BTreeSet;

/// What of a volume's voxels, or of a sub-volume's samples, sub-volumes inside it leave to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    dims: [u32; 3],
    inner: Vec<SubBox>,
    /// How far cells reach beyond the first and the last centre along each axis, in voxels.
    beyond: [[f64; 2]; 3],
}

/// What of a brick's voxels are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// None.
    None,
    /// All.
    All,
    /// Some, perhaps.
    Some,
}

impl Standing {
    /// Of a volume that is no sub-volume, of so many voxels, with the sub-volumes that are cut out of it.
    pub fn of_whole(dims: [u32; 3], inner: Vec<SubBox>) -> Self {
        Self { dims, inner, beyond: [[0.5; 2]; 3] }
    }

    /// Of a sub-volume that is cut out of this one, with those that are cut out of it.
    #[must_use]
    pub fn of_inner(&self, of: &SubBox, inner: Vec<SubBox>) -> Self {
        let beyond = |a: usize| {
            let (first, last) = (of.lo[a] == 0, of.hi[a] + 1 == self.dims[a]);
            let scale = f64::from(of.scale[a]);
            [(first, 0), (last, 1)].map(|(ends, end)| if ends { self.beyond[a][end] * scale } else { 0.0 })
        };
        Self { dims: of.dims(), inner, beyond: [0, 1, 2].map(beyond) }
    }

    /// Voxels along each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The sub-volumes inside it.
    pub fn inner(&self) -> &[SubBox] {
        &self.inner
    }

    /// Whether it has no sub-volumes: then all is asked.
    pub fn is_plain(&self) -> bool {
        self.inner.is_empty()
    }

    /// The voxels that a box alone stands for along an axis: from the first on and before the second.
    fn core(&self, of: &SubBox, a: usize) -> [u32; 2] {
        let (lo, hi) = (of.lo[a], of.hi[a]);
        [if lo == 0 { 0 } else { lo + 1 }, if hi + 1 == self.dims[a] { hi + 1 } else { hi }]
    }

    /// What of a brick is asked.
    pub fn brick(&self, index: BrickIndex) -> Asked {
        let lo = index.origin();
        let end: [u32; 3] = std::array::from_fn(|a| (lo[a] + BRICK).min(self.dims[a]));
        let mut asked = Asked::All;
        for of in &self.inner {
            let core = [0, 1, 2].map(|a| self.core(of, a));
            if (0..3).all(|a| core[a][0] <= lo[a] && end[a] <= core[a][1]) {
                return Asked::None;
            }
            if (0..3).all(|a| lo[a] <= of.hi[a] && of.lo[a] < end[a]) {
                asked = Asked::Some;
            }
        }
        asked
    }

    /// Whether a voxel is asked for anything: whether any of its cell is left to it.
    pub fn is_asked(&self, voxel: [u32; 3]) -> bool {
        let mut near = 0;
        for of in &self.inner {
            let within = |a: usize, [from, end]: [u32; 2]| from <= voxel[a] && voxel[a] < end;
            if (0..3).all(|a| within(a, self.core(of, a))) {
                return false;
            }
            near += u32::from((0..3).all(|a| within(a, [of.lo[a], of.hi[a] + 1])));
        }
        near == 0 || self.octants(voxel).any(|volume| volume > 0.0)
    }

    /// The eighths of a voxel's cell that are left to it, a bit each: bit 0 of a place among them is the upper half along i, and so on.
    fn left(&self, voxel: [u32; 3]) -> u8 {
        self.octants(voxel).enumerate().fold(0, |left, (n, volume)| left | u8::from(volume > 0.0) << n)
    }

    /// The voxel that lies so far from one, if the volume has it.
    pub fn beside(&self, voxel: [u32; 3], by: [i32; 3]) -> Option<[u32; 3]> {
        let along = |a: usize| voxel[a].checked_add_signed(by[a]).filter(|v| *v < self.dims[a]);
        Some([along(0)?, along(1)?, along(2)?])
    }

    /// Whether what is left of the cells of two voxels, a step apart along one axis or more, touches in a face, for `most` 1, or else in
    /// an edge (2) or a corner (3).
    pub fn touch(&self, voxel: [u32; 3], by: [i32; 3], most: u32) -> bool {
        let Some(other) = self.beside(voxel, by) else { return false };
        let (own, theirs) = (self.left(voxel), self.left(other));
        let (stepped, up) = (0..3).fold((0_u8, 0_u8), |(stepped, up), a| {
            (stepped | u8::from(by[a] != 0) << a, up | u8::from(by[a] > 0) << a)
        });
        (0..8_u8).filter(|n| own >> n & 1 == 1 && n & stepped == up).any(|n| {
            let facing = |m: &u8| theirs >> m & 1 == 1 && m & stepped == stepped & !up;
            (0..8_u8).filter(facing).any(|m| (stepped | (n ^ m)).count_ones() <= most)
        })
    }

    /// The voxels that are asked of which a neighbour, a step of at most `most` axes away, is asked too and not touched.
    pub fn parted(&self, most: u32) -> BTreeSet<[u32; 3]> {
        let mut near: Vec<[[u32; 3]; 2]> = Vec::new();
        for (n, of) in self.inner.iter().enumerate() {
            // One thick box parts nothing but diagonals.
            if most > 1 || (0..3).any(|a| of.hi[a] - of.lo[a] == 1) {
                near.push([of.lo, of.hi]);
            }
            for other in &self.inner[..n] {
                let lo: [u32; 3] = std::array::from_fn(|a| of.lo[a].max(other.lo[a]));
                let hi: [u32; 3] = std::array::from_fn(|a| of.hi[a].min(other.hi[a]));
                if (0..3).all(|a| lo[a] <= hi[a]) {
                    near.push([lo, hi]);
                }
            }
        }
        let steps: Vec<[i32; 3]> = (0..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]).collect();
        let steps: Vec<[i32; 3]> = steps
            .into_iter()
            .filter(|by| (1..=most as usize).contains(&by.iter().filter(|d| **d != 0).count()))
            .collect();
        let mut parted = BTreeSet::new();
        for [lo, hi] in near {
            let along = |a: usize| lo[a]..=hi[a];
            for voxel in along(2).flat_map(|z| along(1).flat_map(move |y| along(0).map(move |x| [x, y, z]))) {
                let is_parted = |by: &[i32; 3]| {
                    self.beside(voxel, *by).is_some_and(|other| self.is_asked(other)) && !self.touch(voxel, *by, most)
                };
                if self.is_asked(voxel) && steps.iter().any(is_parted) {
                    parted.insert(voxel);
                }
            }
        }
        parted
    }

    /// How much of a voxel it stands for: 1 is a whole one.
    pub fn share(&self, voxel: [u32; 3]) -> f64 {
        self.octants(voxel).sum()
    }

    /// Whether voxels of a brick may stand for more or less than a whole one.
    pub fn is_odd_in(&self, index: BrickIndex) -> bool {
        let lo = index.origin();
        let ends = |a: usize| [(lo[a] == 0, 0), (lo[a] + BRICK >= self.dims[a], 1)];
        let beyond = (0..3).any(|a| ends(a).iter().any(|(is, end)| *is && self.beyond[a][*end] != 0.5));
        beyond || self.brick(index) != Asked::All
    }

    /// The eighths of a voxel's cell, the volume of each that is left.
    fn octants(&self, voxel: [u32; 3]) -> impl Iterator<Item = f64> {
        (0..8_usize).map(move |n| {
            let upper = |a: usize| n >> a & 1 == 1;
            let covered = |of: &SubBox| {
                (0..3).all(|a| {
                    let (v, first, last) = (voxel[a], voxel[a] == 0, voxel[a] + 1 == self.dims[a]);
                    let [from, to] = [of.lo[a], of.hi[a]];
                    match upper(a) {
                        true if last => to == v,
                        true => from <= v && v < to,
                        false if first => from == 0,
                        false => from < v && v <= to,
                    }
                })
            };
            if self.inner.iter().any(covered) {
                return 0.0;
            }
            let reach = |a: usize| match upper(a) {
                true if voxel[a] + 1 == self.dims[a] => self.beyond[a][1],
                false if voxel[a] == 0 => self.beyond[a][0],
                _ => 0.5,
            };
            reach(0) * reach(1) * reach(2)
        })
    }
}
