//! Boxes of voxels, and moving boxes of texels between blocks; every block is x fastest and tightly packed.

use crate::volume::brick::{BRICK, BRICK_VOXELS, Brick, BrickIndex, SLOT};

/// A box of voxels of a level, not empty: from `lo` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Its first voxel.
    pub lo: [u32; 3],
    /// One beyond its last.
    pub end: [u32; 3],
}

impl Region {
    /// The texels of a brick's slot, counted from the apron on, that show any of it; `dims` are the level's voxels. Slots
    /// repeat the volume's border.
    #[must_use]
    pub fn in_slot(&self, brick: BrickIndex, dims: [u32; 3]) -> Self {
        let before = brick.origin();
        Self {
            lo: std::array::from_fn(|a| if self.lo[a] == 0 { 0 } else { (self.lo[a] + 1).saturating_sub(before[a]) }),
            end: std::array::from_fn(|a| match self.end[a] >= dims[a] {
                true => SLOT,
                false => (self.end[a] + 1 - before[a]).min(SLOT),
            }),
        }
    }

    /// Voxels along i, j, k.
    pub fn size(&self) -> [u32; 3] {
        std::array::from_fn(|a| self.end[a] - self.lo[a])
    }

    pub(super) fn count(&self) -> usize {
        self.size().iter().map(|&s| s as usize).product()
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            lo: std::array::from_fn(|a| self.lo[a].min(other.lo[a])),
            end: std::array::from_fn(|a| self.end[a].max(other.end[a])),
        }
    }

    /// The voxels of the next coarser level that cover any of these.
    pub(super) fn halved(&self) -> Self {
        Self { lo: self.lo.map(|v| v / 2), end: self.end.map(|v| v.div_ceil(2)) }
    }

    pub(super) fn shifted(&self, by: [u32; 3]) -> Self {
        Self { lo: std::array::from_fn(|a| self.lo[a] + by[a]), end: std::array::from_fn(|a| self.end[a] + by[a]) }
    }

    /// Bricks whose slot holds any of it, of `bricks` along each axis.
    pub(super) fn slots(&self, bricks: [u32; 3]) -> Vec<BrickIndex> {
        let range = |a: usize| self.lo[a].saturating_sub(1) / BRICK..=(self.end[a] / BRICK).min(bricks[a] - 1);
        range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| BrickIndex([x, y, z])))).collect()
    }
}

/// The least box of texels in which two bricks differ, within the brick.
pub(super) fn difference(a: &Brick, b: &Brick, bytes: usize) -> Option<Region> {
    if let (Brick::Uniform(a), Brick::Uniform(b)) = (a, b) {
        return (a != b).then_some(Region { lo: [0; 3], end: [BRICK; 3] });
    }
    let (a, b) = (a.texels(bytes), b.texels(bytes));
    let row = BRICK as usize * bytes;
    let mut found: Option<Region> = None;
    for (i, (a, b)) in a.chunks_exact(row).zip(b.chunks_exact(row)).enumerate() {
        if a == b {
            continue;
        }
        let unequal = |(a, b): (&u8, &u8)| a != b;
        let first = a.iter().zip(b).position(unequal).unwrap_or(0) / bytes;
        let last = a.iter().zip(b).rposition(unequal).unwrap_or(0) / bytes;
        let [y, z] = [i as u32 % BRICK, i as u32 / BRICK];
        let part = Region { lo: [first as u32, y, z], end: [last as u32 + 1, y + 1, z + 1] };
        found = Some(found.map_or(part, |f| f.union(&part)));
    }
    found
}

/// The 32³ texels inside a slot's apron.
pub(super) fn interior(slot: &[u8], bytes: usize) -> Brick {
    let mut texels = vec![0; BRICK_VOXELS * bytes];
    copy_box(slot, [SLOT; 3], [1; 3], &mut texels, [BRICK; 3], [0; 3], [BRICK; 3], bytes);
    Brick::from_texels(texels, bytes)
}

fn offset(at: [u32; 3], dims: [u32; 3]) -> usize {
    at[0] as usize + dims[0] as usize * (at[1] as usize + dims[1] as usize * at[2] as usize)
}

/// Copies a box of `count` texels between two blocks, each x fastest.
pub(super) fn copy_box(
    from: &[u8],
    from_dims: [u32; 3],
    from_at: [u32; 3],
    to: &mut [u8],
    to_dims: [u32; 3],
    to_at: [u32; 3],
    count: [u32; 3],
    bytes: usize,
) {
    let row = count[0] as usize * bytes;
    for z in 0..count[2] {
        for y in 0..count[1] {
            let a = offset([from_at[0], from_at[1] + y, from_at[2] + z], from_dims) * bytes;
            let b = offset([to_at[0], to_at[1] + y, to_at[2] + z], to_dims) * bytes;
            to[b..b + row].copy_from_slice(&from[a..a + row]);
        }
    }
}

pub(super) fn fill_box(value: &[u8], to: &mut [u8], to_dims: [u32; 3], to_at: [u32; 3], count: [u32; 3]) {
    for z in 0..count[2] {
        for y in 0..count[1] {
            let start = offset([to_at[0], to_at[1] + y, to_at[2] + z], to_dims) * value.len();
            for texel in to[start..start + count[0] as usize * value.len()].chunks_exact_mut(value.len()) {
                texel.copy_from_slice(value);
            }
        }
    }
}
