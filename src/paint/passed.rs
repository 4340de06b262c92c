//! The voxels that a segment passes, in order, for strokes too thin to reach the centres of those that they run through.
//!
//! A voxel's cell is the unit cube about its index, half open: it holds p where ⌊p + ½⌋ is its index. A segment that runs exactly
//! through an edge or a corner passes from cell to cell without those that it only touches. After Amanatides and Woo 1987, with the
//! number of steps along each axis known before, so that rounding can neither lose nor add one.

use crate::math::DVec3;

/// Crossings nearer to each other than this share of the segment are one.
const SAME: f64 = 1e-12;

/// Index of the cell that holds a place; what is far outside of any volume counts as its border.
pub(super) fn cell_of(place: DVec3) -> [i64; 3] {
    (place + 0.5).floor().to_array().map(|v| v as i64)
}

/// The cells that a segment from `a` to `b` (continuous indices) leaves, in order, each with the share of the segment at which it
/// does. The cell that holds `b` is not among them.
pub(super) fn left(a: DVec3, b: DVec3) -> Vec<([i64; 3], f64)> {
    let (mut cell, end) = (cell_of(a), cell_of(b));
    let mut steps: [i64; 3] = std::array::from_fn(|i| (end[i] - cell[i]).abs());
    let way = b - a;
    // Where the face is crossed through which the cell is left along an axis.
    let crossing = |cell: &[i64; 3], i: usize| {
        let face = cell[i] as f64 + if way[i] > 0.0 { 0.5 } else { -0.5 };
        ((face - a[i]) / way[i]).clamp(0.0, 1.0)
    };
    let mut cells = Vec::new();
    while steps != [0; 3] {
        let at: [f64; 3] = std::array::from_fn(|i| if steps[i] > 0 { crossing(&cell, i) } else { f64::INFINITY });
        let first = at.into_iter().fold(f64::INFINITY, f64::min);
        cells.push((cell, first));
        for i in (0..3).filter(|&i| at[i] <= first + SAME) {
            cell[i] += (end[i] - cell[i]).signum();
            steps[i] -= 1;
        }
    }
    cells
}
