//! From a header's numbers to a grid: dimensions that are sane, affines that can be inverted.

use crate::io::error::IoError;
use crate::math::{DAffine3, DMat3};
use crate::volume::Grid;

/// Least volume of the unit box spanned by an affine's directions: below, the axes lie in one plane for all purposes.
const LEAST_DETERMINANT: f64 = 1e-6;

/// What keeps an affine from being a place for voxels, if anything does.
pub(super) fn flaw(affine: &DAffine3) -> Option<String> {
    let m = affine.matrix3;
    if !affine.is_finite() {
        return Some("a number that is not finite".into());
    }
    for (axis, v) in [("i", m.x_axis), ("j", m.y_axis), ("k", m.z_axis)] {
        // Sizes at which neither squares nor their inverses leave f64 and GPU f32 alike.
        if !(1e-12..1e12).contains(&v.length()) {
            return Some(format!("a voxel of {:?} mm along {axis}", v.length()));
        }
    }
    if affine.translation.abs().max_element() > 1e15 {
        return Some(format!("an origin {:?} mm away", affine.translation.abs().max_element()));
    }
    let unit = DMat3::from_cols(m.x_axis.normalize(), m.y_axis.normalize(), m.z_axis.normalize());
    (unit.determinant().abs() < LEAST_DETERMINANT).then(|| "directions that lie in one plane".into())
}

/// A dimension of the grid.
pub(super) fn dimension(file: &str, field: &str, n: u64) -> Result<u32, IoError> {
    match u32::try_from(n) {
        // Indices are also kept as i32 on the GPU.
        Ok(n) if n > 0 && n <= i32::MAX as u32 => Ok(n),
        _ => Err(IoError::field(file, field, n, "1 to 2147483647 voxels")),
    }
}

/// The grid, if its affine can be used.
pub(super) fn grid(file: &str, field: &str, dims: [u32; 3], world_from_index: DAffine3) -> Result<Grid, IoError> {
    match flaw(&world_from_index) {
        None => Ok(Grid { dims, world_from_index }),
        Some(flaw) => Err(IoError::field(file, field, flaw, "three finite, independent directions and an origin")),
    }
}
