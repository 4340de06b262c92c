//! The colour field of a file of colour voxels: filled when the file is opened, as if it had been painted, and saved as such.

use crate::document::error::DocumentError;
use crate::volume::{BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickSource, Changes, Field};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The bricks of the colour field that hold red, green and blue, and alpha if there is a fourth part, 255 otherwise.
///
/// # Errors
/// If a part cannot be read or `progress` said no.
pub(crate) fn changes(
    field: &Field,
    parts: &[Arc<dyn BrickSource>],
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Changes, DocumentError> {
    let bricks = field.brick_indices(0);
    let done = AtomicUsize::new(0);
    let one = |&index: &BrickIndex| {
        if !progress(done.fetch_add(1, Ordering::Relaxed) as f32 / bricks.len() as f32) {
            return Err(DocumentError::Stopped);
        }
        let origin = index.origin();
        let dims = field.dims(0);
        let size: [u32; 3] = std::array::from_fn(|a| BRICK.min(dims[a] - origin[a]));
        let mut texels = vec![0_u8; BRICK_VOXELS * 4];
        for channel in 0..4 {
            let read = parts.get(channel).map(|part| part.read(origin, size)).transpose()?;
            let full = read.as_ref().map_or(1.0, |voxels| voxels.voxel_type().full());
            let [nx, ny, nz] = size.map(|n| n as usize);
            for i in 0..nx * ny * nz {
                let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)];
                let at = x + BRICK as usize * (y + BRICK as usize * z);
                // Of what is no number nothing is taken.
                texels[at * 4 + channel] = read.as_ref().map_or(255, |v| (v.get(i) / full * 255.0).round() as u8);
            }
        }
        Ok((index, Some(Brick::from_texels(texels, 4))))
    };
    bricks.par_iter().map(one).collect()
}
