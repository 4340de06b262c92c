//! What is connected within one brick: runs of voxels along x, joined where rows beside each other touch.
//!
//! A run is the whole of what it is joined by: a row of 32 voxels that are all in the set is one, and neighbouring rows touch where
//! their words have bits in common. Owns which voxels are neighbours ([`Connectivity`]).

use crate::segment::mask::{BrickMask, ROWS, RowBits, row};
use crate::volume::BRICK;

/// Which voxels are neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Connectivity {
    /// Those that share a face.
    #[default]
    Six,
    /// Those that share a face or an edge.
    Eighteen,
    /// Those that share a face, an edge or a corner.
    TwentySix,
}

/// From a voxel to half of its neighbours, the other half being the way back: by faces, by edges, by corners.
const STEPS: [[i32; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [-1, 1, 0],
    [1, 0, 1],
    [-1, 0, 1],
    [0, 1, 1],
    [0, -1, 1],
    [1, 1, 1],
    [-1, 1, 1],
    [1, -1, 1],
    [-1, -1, 1],
];

impl Connectivity {
    /// Along how many axes neighbours lie apart at most.
    pub(super) fn most(self) -> u32 {
        match self {
            Self::Six => 1,
            Self::Eighteen => 2,
            Self::TwentySix => 3,
        }
    }

    /// From a voxel to half of its neighbours.
    pub(super) fn steps(self) -> &'static [[i32; 3]] {
        match self {
            Self::Six => &STEPS[..3],
            Self::Eighteen => &STEPS[..9],
            Self::TwentySix => &STEPS,
        }
    }
}

/// Sets that are joined: each member names one that came before it, or itself.
#[derive(Debug)]
pub(super) struct Union(Vec<u32>);

impl Union {
    pub(super) fn new(count: u32) -> Self {
        Self((0..count).collect())
    }

    /// The first of those that a member is joined with.
    pub(super) fn first(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let next = self.0[member as usize];
            // Every second one on the way is led past the next: ways stay short.
            self.0[member as usize] = self.0[next as usize];
            member = next;
        }
        member
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        if a != b {
            self.0[a.max(b) as usize] = a.min(b);
        }
    }

    /// The number of each member's set, sets counted in the order of their first members, and how many there are.
    pub(super) fn numbers(mut self) -> (Vec<u32>, u32) {
        let mut count = 0;
        // Whoever a member names came before it, and has its number.
        for member in 0..self.0.len() {
            let before = self.0[member] as usize;
            self.0[member] = if before == member {
                count += 1;
                count - 1
            } else {
                self.0[before]
            };
        }
        (self.0, count)
    }
}

/// Runs along x of one brick, with the component within the brick that each belongs to.
#[derive(Debug)]
pub(super) struct Runs {
    pub(super) bits: Box<RowBits>,
    /// Of each row the number of its first run; the last is the number of all.
    first: Box<[u16; ROWS + 1]>,
    /// The component of each run.
    component: Vec<u16>,
}

/// A brick's part of a set, taken apart.
#[derive(Debug)]
pub(super) enum Piece {
    None,
    All,
    Some(Runs),
}

impl Piece {
    /// Takes apart the set of a brick with so many voxels in the volume along each axis; answers the voxels of each component too.
    pub(super) fn new(mask: BrickMask, steps: &[[i32; 3]], valid: [u32; 3]) -> (Self, Vec<u32>) {
        match mask {
            BrickMask::None => (Self::None, Vec::new()),
            BrickMask::All => (Self::All, vec![valid.iter().product()]),
            BrickMask::Some(bits) => {
                let (runs, sizes) = Runs::new(bits, steps);
                (Self::Some(runs), sizes)
            }
        }
    }

    /// The row along x at (y, z).
    pub(super) fn row(&self, y: u32, z: u32, valid: [u32; 3]) -> u32 {
        match self {
            Self::Some(runs) => runs.bits[row(y, z)],
            Self::All => BrickMask::All.row(y, z, valid),
            Self::None => 0,
        }
    }

    /// The component within the brick of a voxel that is in the set.
    pub(super) fn component(&self, [x, y, z]: [u32; 3]) -> u32 {
        match self {
            Self::Some(runs) => u32::from(runs.component[runs.run(row(y, z), x)]),
            Self::All | Self::None => 0,
        }
    }

    /// The whole set again.
    pub(super) fn mask(&self) -> BrickMask {
        match self {
            Self::None => BrickMask::None,
            Self::All => BrickMask::All,
            Self::Some(runs) => BrickMask::Some(runs.bits.clone()),
        }
    }

    /// What of it is of the components that `is_wanted`.
    pub(super) fn only(&self, valid: [u32; 3], is_wanted: impl Fn(u32) -> bool) -> BrickMask {
        let Self::Some(runs) = self else {
            return if is_wanted(0) { self.mask() } else { BrickMask::None };
        };
        let mut bits = Box::new([0; ROWS]);
        for (at, &word) in runs.bits.iter().enumerate() {
            let mut left = word;
            let mut run = usize::from(runs.first[at]);
            while left != 0 {
                let bits_of = lowest_run(left);
                left &= !bits_of;
                if is_wanted(u32::from(runs.component[run])) {
                    bits[at] |= bits_of;
                }
                run += 1;
            }
        }
        BrickMask::of_bits(bits, valid)
    }
}

impl Runs {
    fn new(bits: Box<RowBits>, steps: &[[i32; 3]]) -> (Self, Vec<u32>) {
        let mut first = Box::new([0; ROWS + 1]);
        for (at, word) in bits.iter().enumerate() {
            first[at + 1] = first[at] + starts(*word).count_ones() as u16;
        }
        let mut runs = Self { bits, first, component: Vec::new() };
        let mut union = Union::new(u32::from(runs.first[ROWS]));
        for &[dx, dy, dz] in steps.iter().filter(|[_, dy, dz]| (*dy, *dz) != (0, 0)) {
            for z in inside(dz) {
                for y in inside(dy) {
                    let (from, to) = (row(y, z), row(y.wrapping_add_signed(dy), z.wrapping_add_signed(dz)));
                    touching(runs.bits[from], runs.bits[to], dx, |a, b| {
                        union.join(runs.run(from, a) as u32, runs.run(to, b) as u32);
                    });
                }
            }
        }
        let (component, count) = union.numbers();
        let mut sizes = vec![0; count as usize];
        let mut run = 0;
        for &word in runs.bits.iter() {
            let mut left = word;
            while left != 0 {
                let bits_of = lowest_run(left);
                left &= !bits_of;
                sizes[component[run] as usize] += bits_of.count_ones();
                run += 1;
            }
        }
        // A row has 16 runs at most.
        runs.component = component.into_iter().map(|c| c as u16).collect();
        (runs, sizes)
    }

    /// The number of the run that a voxel of a row is in.
    fn run(&self, row: usize, x: u32) -> usize {
        let before = starts(self.bits[row]) & (u32::MAX >> (BRICK - 1 - x));
        usize::from(self.first[row]) + before.count_ones() as usize - 1
    }
}

/// From where along an axis a step stays in the brick.
fn inside(step: i32) -> std::ops::Range<u32> {
    u32::from(step < 0)..BRICK - u32::from(step > 0)
}

/// The first voxels of a row's runs.
fn starts(word: u32) -> u32 {
    word & !(word << 1)
}

/// The voxels of a row's first run; the row has one.
fn lowest_run(word: u32) -> u32 {
    let start = word.trailing_zeros();
    let length = (!(word >> start)).trailing_zeros().min(BRICK - start);
    crate::segment::mask::full_row(length) << start
}

/// For each two runs of rows that touch, `dx` apart within the brick, a voxel of either that do.
pub(super) fn touching(from: u32, to: u32, dx: i32, mut meet: impl FnMut(u32, u32)) {
    let moved = match dx {
        1 => from << 1,
        -1 => from >> 1,
        _ => from,
    };
    // What is in one piece of both is of one run in either.
    let mut pieces = starts(moved & to);
    while pieces != 0 {
        let x = pieces.trailing_zeros();
        meet(x.wrapping_add_signed(-dx), x);
        pieces &= pieces - 1;
    }
}
