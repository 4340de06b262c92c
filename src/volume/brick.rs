//! Bricks: the unit of storage, editing, transfer and history.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;

/// Voxels along an edge of a brick.
pub const BRICK: u32 = 32;
/// Voxels in a brick.
pub const BRICK_VOXELS: usize = (BRICK * BRICK * BRICK) as usize;
/// Voxels along an edge of a slot: a brick and one voxel of apron on either side.
pub const SLOT: u32 = BRICK + 2;
/// Voxels in a slot.
pub const SLOT_VOXELS: usize = (SLOT * SLOT * SLOT) as usize;
/// Voxels along an edge of a cell of the empty-space map.
pub const CELL: u32 = 4;
/// Cells in a brick.
pub const CELLS_PER_BRICK: usize = ((BRICK / CELL) * (BRICK / CELL) * (BRICK / CELL)) as usize;

/// Place of a brick within a level, in bricks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct BrickIndex(pub [u32; 3]);

/// A brick of a level; level 0 is the finest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct BrickKey {
    /// Level.
    pub level: u8,
    /// Place within the level.
    pub index: BrickIndex,
}

impl BrickIndex {
    /// First voxel of the brick.
    pub fn origin(self) -> [u32; 3] {
        self.0.map(|b| b * BRICK)
    }

    /// The brick that holds a voxel.
    pub fn of_voxel(voxel: [u32; 3]) -> Self {
        Self(voxel.map(|v| v / BRICK))
    }

    /// The brick one level coarser that covers this one.
    #[must_use]
    pub fn parent(self) -> Self {
        Self(self.0.map(|b| b / 2))
    }
}

/// 32³ texels of a field in the field's format, x fastest, always all 32³: texels beyond the volume repeat nothing and are
/// zero. A brick of one value is that value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Brick {
    /// Every texel has these bytes (the first `bytes_per_texel` count, the others are 0).
    Uniform([u8; 4]),
    /// `BRICK_VOXELS · bytes_per_texel` bytes.
    Dense(Arc<[u8]>),
}

impl Brick {
    /// From 32³ texels; becomes `Uniform` if all are equal.
    pub fn from_texels(texels: Vec<u8>, bytes_per_texel: usize) -> Self {
        match shared_texel(&texels, bytes_per_texel) {
            Some(value) => Self::Uniform(value),
            None => Self::Dense(texels.into()),
        }
    }

    /// The same brick with other texels; becomes `Uniform` if all are equal.
    #[must_use]
    pub(crate) fn edited(&self, bytes_per_texel: usize, edit: impl FnOnce(&mut [u8])) -> Self {
        let mut texels: Arc<[u8]> = match self {
            Self::Uniform(value) => value[..bytes_per_texel].repeat(BRICK_VOXELS).into(),
            Self::Dense(texels) => Arc::from(&texels[..]),
        };
        // Copied once, and this one is nobody else's.
        edit(Arc::make_mut(&mut texels));
        match shared_texel(&texels, bytes_per_texel) {
            Some(value) => Self::Uniform(value),
            None => Self::Dense(texels),
        }
    }

    /// All 32³ texels.
    pub fn to_texels(&self, bytes_per_texel: usize) -> Vec<u8> {
        self.texels(bytes_per_texel).into_owned()
    }

    /// All 32³ texels, copied only where the brick has none.
    pub(super) fn texels(&self, bytes_per_texel: usize) -> Cow<'_, [u8]> {
        match self {
            Self::Uniform(value) => Cow::Owned(value[..bytes_per_texel].repeat(BRICK_VOXELS)),
            Self::Dense(texels) => Cow::Borrowed(texels),
        }
    }

    /// The bytes of the texel at (x, y, z) within the brick, padded with zeros.
    pub fn texel(&self, at: [u32; 3], bytes_per_texel: usize) -> [u8; 4] {
        match self {
            Self::Uniform(value) => *value,
            Self::Dense(texels) => {
                let i = (at[0] + BRICK * (at[1] + BRICK * at[2])) as usize * bytes_per_texel;
                let mut value = [0; 4];
                value[..bytes_per_texel].copy_from_slice(&texels[i..i + bytes_per_texel]);
                value
            }
        }
    }

    /// How many of the first `valid` texels along each axis differ from another brick's of the same format.
    pub fn differing(&self, other: &Self, valid: [u32; 3], bytes_per_texel: usize) -> u64 {
        fn count<const N: usize>(a: &[u8], b: &[u8]) -> u64 {
            let (a, b) = (a.as_chunks::<N>().0, b.as_chunks::<N>().0);
            a.iter().zip(b).map(|(a, b)| u64::from(a != b)).sum()
        }
        if self == other {
            return 0;
        }
        let (a, b) = (self.texels(bytes_per_texel), other.texels(bytes_per_texel));
        let row = valid[0] as usize * bytes_per_texel;
        let rows = (0..valid[2]).flat_map(|z| (0..valid[1]).map(move |y| (BRICK * (y + BRICK * z)) as usize));
        rows.map(|first| {
            let at = first * bytes_per_texel..first * bytes_per_texel + row;
            match bytes_per_texel {
                1 => count::<1>(&a[at.clone()], &b[at]),
                2 => count::<2>(&a[at.clone()], &b[at]),
                _ => count::<4>(&a[at.clone()], &b[at]),
            }
        })
        .sum()
    }

    /// Memory of the texels in bytes, 0 for a uniform brick.
    pub fn heap_bytes(&self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::Dense(texels) => texels.len(),
        }
    }
}

/// The texel that all are equal to, if they are: a block of one value equals itself a texel further.
pub(super) fn shared_texel(texels: &[u8], bytes: usize) -> Option<[u8; 4]> {
    let mut value = [0; 4];
    value[..bytes].copy_from_slice(&texels[..bytes]);
    (texels[bytes..] == texels[..texels.len() - bytes]).then_some(value)
}
