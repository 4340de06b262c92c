//! Colour voxels: red, green, blue and perhaps alpha, as a density and as colours.
//!
//! The density is their brightness in their own type: Rec. 709's luma of the display-referred values, 0.2126 R + 0.7152 G + 0.0722 B,
//! times alpha, integers rounded. Full is the greatest integer of the type, or 1 of numbers with a fraction. Alpha that is 0 everywhere was not filled in by whoever wrote the file, and counts as none.

use crate::io::error::IoError;
use crate::io::progress::Progress;
use crate::io::statistics;
use crate::volume::{BrickSource, Grid, SourceError, Value, VoxelType, Voxels};
use crate::with_voxel_type;
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
        self.parts[0].voxel_type()
    }

    fn scaling(&self) -> (f64, f64) {
        (1.0, 0.0)
    }

    fn name(&self) -> &str {
        self.parts[0].name()
    }

    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        let parts = self.parts.iter().map(|part| part.read(lo, size)).collect::<Result<Vec<_>, _>>()?;
        let [red, green, blue] = match &parts[..] {
            [red, green, blue, ..] => [red, green, blue],
            _ => return Ok(Voxels::U8(Vec::new())),
        };
        let full = self.voxel_type().full();
        let luma = |i: usize| {
            let luma = 0.2126 * red.get(i) + 0.7152 * green.get(i) + 0.0722 * blue.get(i);
            luma * parts.get(3).map_or(1.0, |alpha| alpha.get(i) / full)
        };
        Ok(with_voxel_type!(self.voxel_type(), T => T::wrap((0..red.len()).map(|i| T::from_f64(luma(i))).collect())))
    }
}
