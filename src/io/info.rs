//! What `burin info` tells of a file.

use crate::io::error::IoError;
use crate::io::open::open;
use crate::io::progress::Progress;
use crate::io::reader::NamedLabel;
use crate::volume::Number;
use serde::Serialize;
use std::path::Path;

/// A file's header and the range of its values. In JSON a number that does not exist (`min` and `max` of a file whose values
/// are all NaN or infinite) is `null`; 64-bit integers are given to the last digit, a sum beyond all numbers as `"inf"`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Info {
    /// The format's name, with its version or encoding.
    pub format: String,
    /// Voxels along i (fastest in the file), j, k.
    pub dims: [u32; 3],
    /// Numbers per voxel.
    pub components: u32,
    /// Volumes in the file.
    pub frames: u32,
    /// Type as stored: `u8`, `i8`, `u16`, … `f64`.
    pub voxel_type: &'static str,
    /// Rows x, y, z of the 3×4 matrix from (i, j, k, 1), centres at integers, to RAS+ mm.
    pub world_from_index: [[f64; 4]; 3],
    /// Smallest finite value, after slope and intercept, over all components of all frames.
    pub min: Option<Number>,
    /// Largest finite value, likewise.
    pub max: Option<Number>,
    /// Sum of all finite values, likewise; 0 if there is none.
    pub sum: Number,
    /// How many values are NaN, likewise.
    pub nan_count: u64,
    /// Segments that the header names; left out if it names none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub segments: Vec<NamedLabel>,
    /// What was odd about the file and how it was taken.
    pub warnings: Vec<String>,
}

/// Reads all of a file once, a piece at a time.
///
/// # Errors
/// Whatever keeps the file from being read; `Cancelled` if `progress` said no.
pub fn info(path: impl AsRef<Path>, progress: Progress<'_>) -> Result<Info, IoError> {
    let opened = open(path)?;
    let statistics = opened.statistics(progress)?;
    let [min, max, sum] = statistics.numbers();
    let (m, t) = (opened.grid.world_from_index.matrix3, opened.grid.world_from_index.translation);
    Ok(Info {
        format: opened.format,
        dims: opened.grid.dims,
        components: opened.components,
        frames: opened.frames,
        voxel_type: opened.voxel_type.name(),
        world_from_index: std::array::from_fn(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]]),
        min: Some(min).filter(|n| !n.is_nan()),
        max: Some(max).filter(|n| !n.is_nan()),
        sum,
        nan_count: statistics.nan_count,
        segments: opened.labels,
        warnings: opened.warnings,
    })
}
