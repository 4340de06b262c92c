//! A set of voxels of one brick: none, all, or a bit each.
//!
//! A row of a brick along x is one word, so that what rows share is one operation for 32 voxels.

use crate::volume::BRICK;

/// Rows along x of a brick.
pub const ROWS: usize = (BRICK * BRICK) as usize;

/// Bit x of word y + 32·z is the voxel (x, y, z) of a brick.
pub type RowBits = [u32; ROWS];

/// Which voxels of a brick are in a set. Of a brick at the volume's end the voxels beyond it are in none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BrickMask {
    /// None.
    None,
    /// All that are in the volume.
    All,
    /// These.
    Some(Box<RowBits>),
}

impl BrickMask {
    /// Of the first `valid` voxels of a brick along each axis those that `is_in` says, asked by their place in the brick, x fastest.
    pub fn new(valid: [u32; 3], mut is_in: impl FnMut([u32; 3]) -> bool) -> Self {
        let mut bits = Box::new([0; ROWS]);
        for z in 0..valid[2] {
            for y in 0..valid[1] {
                let mut word = 0;
                for x in 0..valid[0] {
                    word |= u32::from(is_in([x, y, z])) << x;
                }
                bits[row(y, z)] = word;
            }
        }
        Self::of_bits(bits, valid)
    }

    /// Of bits, those beyond the first `valid` voxels along each axis being 0.
    pub fn of_bits(bits: Box<RowBits>, valid: [u32; 3]) -> Self {
        if bits.iter().all(|&word| word == 0) {
            return Self::None;
        }
        let full = full_row(valid[0]);
        let all = (0..valid[2]).all(|z| (0..valid[1]).all(|y| bits[row(y, z)] == full));
        if all { Self::All } else { Self::Some(bits) }
    }

    /// Whether it holds a voxel, counted within the brick and inside the volume.
    pub fn contains(&self, [x, y, z]: [u32; 3]) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Some(bits) => bits[row(y, z)] >> x & 1 == 1,
        }
    }

    /// Voxels in it, of a brick with so many in the volume along each axis.
    pub fn count(&self, valid: [u32; 3]) -> u64 {
        match self {
            Self::None => 0,
            Self::All => valid.iter().map(|&n| u64::from(n)).product(),
            Self::Some(bits) => bits.iter().map(|word| u64::from(word.count_ones())).sum(),
        }
    }

    /// The row along x at (y, z), of a brick with so many voxels in the volume along each axis.
    pub fn row(&self, y: u32, z: u32, valid: [u32; 3]) -> u32 {
        match self {
            Self::Some(bits) => bits[row(y, z)],
            Self::All if y < valid[1] && z < valid[2] => full_row(valid[0]),
            Self::All | Self::None => 0,
        }
    }

    /// What is in both.
    #[must_use]
    pub fn and(self, other: Self, valid: [u32; 3]) -> Self {
        match (self, other) {
            (Self::None, _) | (_, Self::None) => Self::None,
            (Self::All, mask) | (mask, Self::All) => mask,
            (Self::Some(mut bits), Self::Some(other)) => {
                bits.iter_mut().zip(other.iter()).for_each(|(a, b)| *a &= b);
                Self::of_bits(bits, valid)
            }
        }
    }

    /// What is in either.
    #[must_use]
    pub fn or(self, other: Self, valid: [u32; 3]) -> Self {
        match (self, other) {
            (Self::All, _) | (_, Self::All) => Self::All,
            (Self::None, mask) | (mask, Self::None) => mask,
            (Self::Some(mut bits), Self::Some(other)) => {
                bits.iter_mut().zip(other.iter()).for_each(|(a, b)| *a |= b);
                Self::of_bits(bits, valid)
            }
        }
    }

    /// What is in this one and not in the other.
    #[must_use]
    pub fn without(self, other: &Self, valid: [u32; 3]) -> Self {
        match (self, other) {
            (Self::None, _) | (_, Self::All) => Self::None,
            (mask, Self::None) => mask,
            (mask, Self::Some(other)) => {
                let mut bits = Box::new([0; ROWS]);
                for z in 0..valid[2] {
                    for y in 0..valid[1] {
                        bits[row(y, z)] = mask.row(y, z, valid) & !other[row(y, z)];
                    }
                }
                Self::of_bits(bits, valid)
            }
        }
    }
}

/// The place of a row among a brick's.
pub(super) fn row(y: u32, z: u32) -> usize {
    (y + BRICK * z) as usize
}

/// A row with its first `count` voxels.
pub(super) fn full_row(count: u32) -> u32 {
    if count >= BRICK { u32::MAX } else { (1 << count) - 1 }
}
