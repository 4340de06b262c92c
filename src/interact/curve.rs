//! Changes of a transfer function by hand that keep it a function: points stay in order, numbers in range.

use crate::volume::TransferFunction;

/// The nearest place to `value` between the neighbours of point `i`, a little away from both.
fn between<T>(points: &[(f64, T)], i: usize, value: f64, gap: f64) -> f64 {
    let lo = if i > 0 { points[i - 1].0 + gap } else { f64::NEG_INFINITY };
    let hi = points.get(i + 1).map_or(f64::INFINITY, |p| p.0 - gap);
    // Neighbours that stand closer than two gaps leave no room: the point keeps its place.
    if lo <= hi { value.clamp(lo, hi) } else { points[i].0 }
}

/// Moves an opacity point; `gap` is the least distance of neighbours.
pub fn move_opacity(function: &mut TransferFunction, i: usize, value: f64, opacity: f64, gap: f64) {
    if i < function.opacity.len() {
        let value = between(&function.opacity, i, value, gap);
        function.opacity[i] = (value, opacity.clamp(0.0, 1.0) as f32);
    }
}

/// The colour point that stands where opacity point `i` does, as both do after a start from the histogram.
pub fn colour_beside(function: &TransferFunction, i: usize, gap: f64) -> Option<usize> {
    let value = function.opacity.get(i)?.0;
    function.colour.iter().position(|p| (p.0 - value).abs() < gap)
}

/// Moves a colour point.
pub fn move_colour(function: &mut TransferFunction, i: usize, value: f64, gap: f64) {
    if i < function.colour.len() {
        function.colour[i].0 = between(&function.colour, i, value, gap);
    }
}

/// Adds an opacity point unless one stands there; answers its place.
pub fn add_opacity(function: &mut TransferFunction, value: f64, opacity: f64, gap: f64) -> Option<usize> {
    let i = room(&function.opacity, value, gap)?;
    function.opacity.insert(i, (value, opacity.clamp(0.0, 1.0) as f32));
    Some(i)
}

/// Adds a colour point of the colour that is there already.
pub fn add_colour(function: &mut TransferFunction, value: f64, gap: f64) -> Option<usize> {
    let i = room(&function.colour, value, gap)?;
    let colour = function.colour_at(value);
    function.colour.insert(i, (value, colour));
    Some(i)
}

fn room<T>(points: &[(f64, T)], value: f64, gap: f64) -> Option<usize> {
    let free = value.is_finite() && points.iter().all(|p| (p.0 - value).abs() >= gap);
    free.then(|| points.partition_point(|p| p.0 < value))
}

/// Removes a point; the last one stays.
pub fn remove<T>(points: &mut Vec<(f64, T)>, i: usize) {
    if points.len() > 1 && i < points.len() {
        points.remove(i);
    }
}
