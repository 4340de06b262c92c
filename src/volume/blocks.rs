//! Moving boxes of texels between blocks; every block is x fastest and tightly packed.

use super::{BRICK, BRICK_VOXELS, Brick, SLOT};

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
