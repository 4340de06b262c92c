//! Colour voxels: red, green, blue and perhaps alpha of eight bits each, as a density and as colours.
//!
//! The density is their brightness: Rec. 709's luma of the display-referred values, 0.2126 R + 0.7152 G + 0.0722 B, times alpha,
//! rounded. Alpha that is 0 everywhere was not filled in by whoever wrote the file, and counts as none.

use super::{IoError, Progress, statistics};
use crate::volume::{BrickSource, Grid, SourceError, VoxelType, Voxels};
use std::sync::Arc;

/// The parts of one frame: three, or four where alpha says anything.
pub(super) fn parts(
    mut parts: Vec<Arc<dyn BrickSource>>,
    progress: Progress<'_>,
) -> Result<Vec<Arc<dyn BrickSource>>, IoError> {
    if let Some(alpha) = parts.get(3)
        && statistics(alpha.as_ref(), progress)?.max <= 0.0
    {
        parts.truncate(3);
    }
    Ok(parts)
}

/// The brightness of colour voxels.
#[derive(Debug)]
pub(super) struct Luminance {
    pub(super) parts: Vec<Arc<dyn BrickSource>>,
}

impl BrickSource for Luminance {
    fn grid(&self) -> &Grid {
        self.parts[0].grid()
    }

    fn voxel_type(&self) -> VoxelType {
        VoxelType::U8
    }

    fn scaling(&self) -> (f64, f64) {
        (1.0, 0.0)
    }

    fn name(&self) -> &str {
        self.parts[0].name()
    }

    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        let parts = self.parts.iter().map(|part| part.read(lo, size)).collect::<Result<Vec<_>, _>>()?;
        let part = |n: usize| parts.get(n).map(Voxels::as_bytes);
        let (Some(red), Some(green), Some(blue)) = (part(0), part(1), part(2)) else {
            return Ok(Voxels::U8(Vec::new()));
        };
        let luma = |i: usize| {
            let luma = 0.2126 * f64::from(red[i]) + 0.7152 * f64::from(green[i]) + 0.0722 * f64::from(blue[i]);
            let alpha = part(3).map_or(1.0, |alpha| f64::from(alpha[i]) / 255.0);
            (luma * alpha).round() as u8
        };
        Ok(Voxels::U8((0..red.len()).map(luma).collect()))
    }
}
