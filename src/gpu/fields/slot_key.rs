//! Names of what lies in slots: bricks of any level of any volume, and how bricks of level 0 are numbered.

use crate::volume::{BrickIndex, BrickKey, VolumeId};

/// A brick of a volume. In order of level first, so that of equal ones the finer level goes before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SlotKey {
    pub(crate) brick: BrickKey,
    pub(crate) volume: VolumeId,
}

impl SlotKey {
    pub(crate) fn new(volume: VolumeId, brick: BrickKey) -> Self {
        Self { brick, volume }
    }

    /// The brick of the next coarser level that it lies in.
    pub(crate) fn parent(self) -> Self {
        let BrickKey { level, index } = self.brick;
        Self { brick: BrickKey { level: level + 1, index: index.parent() }, ..self }
    }
}

/// The brick of level 0 with a number, x fastest.
pub(crate) fn brick_of(bricks: [u32; 3], i: usize) -> BrickIndex {
    let [nx, ny, _] = bricks.map(|n| n as usize);
    BrickIndex([i % nx, i / nx % ny, i / (nx * ny)].map(|b| b as u32))
}

/// The number of a brick of level 0.
pub(crate) fn number_of(bricks: [u32; 3], b: BrickIndex) -> usize {
    let [nx, ny, _] = bricks.map(|n| n as usize);
    b.0[0] as usize + nx * (b.0[1] as usize + ny * b.0[2] as usize)
}

/// How many bricks of level 0 there are.
pub(crate) fn count_of(bricks: [u32; 3]) -> usize {
    bricks.iter().map(|&b| b as usize).product()
}
