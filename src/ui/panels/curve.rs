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
pub(super) fn move_opacity(function: &mut TransferFunction, i: usize, value: f64, opacity: f64, gap: f64) {
    if i < function.opacity.len() {
        let value = between(&function.opacity, i, value, gap);
        function.opacity[i] = (value, opacity.clamp(0.0, 1.0) as f32);
    }
}

/// Moves a colour point.
pub(super) fn move_colour(function: &mut TransferFunction, i: usize, value: f64, gap: f64) {
    if i < function.colour.len() {
        function.colour[i].0 = between(&function.colour, i, value, gap);
    }
}

/// Adds an opacity point unless one stands there; answers its place.
pub(super) fn add_opacity(function: &mut TransferFunction, value: f64, opacity: f64, gap: f64) -> Option<usize> {
    let i = room(&function.opacity, value, gap)?;
    function.opacity.insert(i, (value, opacity.clamp(0.0, 1.0) as f32));
    Some(i)
}

/// Adds a colour point of the colour that is there already.
pub(super) fn add_colour(function: &mut TransferFunction, value: f64, gap: f64) -> Option<usize> {
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
pub(super) fn remove<T>(points: &mut Vec<(f64, T)>, i: usize) {
    if points.len() > 1 && i < points.len() {
        points.remove(i);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn function() -> TransferFunction {
        TransferFunction {
            colour: vec![(0.0, [0.0; 3]), (100.0, [1.0; 3])],
            opacity: vec![(10.0, 0.0), (50.0, 0.5), (90.0, 1.0)],
            unit_mm: 1.0,
        }
    }

    #[test]
    fn a_dragged_point_never_passes_its_neighbours() {
        for value in [-1e9, 10.0, 50.0, 90.0, 1e9] {
            for i in 0..3 {
                let mut f = function();
                move_opacity(&mut f, i, value, 2.0, 1.0);
                f.check().unwrap();
                assert_eq!(f.opacity[i].1, 1.0, "opacity is clamped");
            }
        }
        let mut f = function();
        move_opacity(&mut f, 1, 70.0, 0.25, 1.0);
        assert_eq!(f.opacity[1], (70.0, 0.25));
        move_opacity(&mut f, 1, 200.0, 0.25, 1.0);
        assert_eq!(f.opacity[1].0, 89.0);
    }

    #[test]
    fn neighbours_without_room_keep_a_point_where_it_is() {
        let mut f = function();
        f.opacity = vec![(10.0, 0.0), (10.5, 0.5), (11.0, 1.0)];
        move_opacity(&mut f, 1, 99.0, 0.5, 1.0);
        assert_eq!(f.opacity[1].0, 10.5);
    }

    #[test]
    fn added_points_stand_in_order_and_a_colour_point_changes_no_colour() {
        let mut f = function();
        assert_eq!(add_opacity(&mut f, 60.0, 0.1, 1.0), Some(2));
        assert_eq!(add_opacity(&mut f, 60.5, 0.1, 1.0), None);
        let before = f.colour_at(25.0);
        assert_eq!(add_colour(&mut f, 25.0, 1.0), Some(1));
        assert_eq!(f.colour_at(25.0), before);
        f.check().unwrap();
    }

    #[test]
    fn the_last_point_stays() {
        let mut f = function();
        for _ in 0..5 {
            remove(&mut f.opacity, 0);
        }
        assert_eq!(f.opacity.len(), 1);
    }
}
