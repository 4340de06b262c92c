//! An iso-surface as annotation grids see it, and the way back onto it.
//!
//! What lies on a surface needs two things of the volume: how far the field is above the iso-value, and the gradient by which it is
//! shaded. This module owns the trait that gives them and the back-tracing of a point along a given direction ("Direct Volume
//! Editing", section 5, with the crossing told by the change of sign and the step divided by the gradient's length). It knows
//! nothing of how voxels are stored, of grids or of texts.

use glam::DVec3;

/// The most evaluations that one back-tracing may take.
const MOST_STEPS: usize = 64;

/// The iso-surface of a trilinear field. Positions are world mm.
pub trait Surface: Sync {
    /// The trilinear field minus the iso-value at `p`, in the volume's units: positive in dense matter, zero on the surface. None
    /// outside of the volume.
    fn value(&self, p: DVec3) -> Option<f64>;

    /// The gradient at `p`, in the volume's units per mm along the world's axes: central differences at voxel centres, interpolated
    /// trilinearly (section 5). None outside of the volume.
    fn gradient(&self, p: DVec3) -> Option<DVec3>;
}

/// The unit normal at `p`, world axes: against the gradient, so outward of dense matter. None outside of the volume, and where the
/// gradient vanishes.
pub fn normal<S: Surface + ?Sized>(surface: &S, p: DVec3) -> Option<DVec3> {
    (-surface.gradient(p)?).try_normalize()
}

/// The point in which the line through `p` along `direction` (an outward unit normal, world axes) meets the surface, sought from
/// `p`, outward if `p` lies in dense matter, else inward. It lies within `tolerance_mm` of a change of sign along that line.
///
/// None if the line leaves the volume first, the gradient vanishes on the way, or the surface is not met within 64 evaluations.
pub fn project<S: Surface + ?Sized>(surface: &S, p: DVec3, direction: DVec3, tolerance_mm: f64) -> Option<DVec3> {
    project_within(surface, p, direction, tolerance_mm, f64::INFINITY)
}

/// As [`project`]; None also if the surface lies more than `reach_mm` from `p`.
pub fn project_within<S: Surface + ?Sized>(
    surface: &S,
    p: DVec3,
    direction: DVec3,
    tolerance_mm: f64,
    reach_mm: f64,
) -> Option<DVec3> {
    let (mut at, mut value) = (0.0, surface.value(p)?);
    if value == 0.0 {
        return Some(p);
    }
    // The step is a length: the difference to the iso-value over the field's slope.
    let slope = surface.gradient(p)?.length();
    if slope <= 0.0 || !slope.is_finite() {
        return None;
    }
    let mut steps = 0;
    let (mut next, mut beyond);
    loop {
        next = at + value / slope;
        if value.abs() / slope <= tolerance_mm {
            // So near that the step over the surface, and not only toward it, has to be small.
            next = at + tolerance_mm.copysign(value);
        }
        if (next - at).abs() > reach_mm {
            next = at + reach_mm.copysign(value);
        }
        beyond = surface.value(p + direction * next)?;
        if beyond == 0.0 {
            return (next.abs() <= reach_mm).then(|| p + direction * next);
        }
        steps += 1;
        if (beyond > 0.0) != (value > 0.0) {
            break;
        }
        if steps > MOST_STEPS || next.abs() >= reach_mm {
            return None;
        }
        (at, value) = (next, beyond);
    }
    // Crossed: the step is divided, by false position and every third time by half, until it is within the tolerance.
    while (next - at).abs() > tolerance_mm && steps <= 2 * MOST_STEPS {
        let share = if steps % 3 == 2 { 0.5 } else { (value / (value - beyond)).clamp(0.02, 0.98) };
        let middle = at + (next - at) * share;
        let found = surface.value(p + direction * middle)?;
        if found == 0.0 {
            (at, next) = (middle, middle);
        } else if (found > 0.0) == (value > 0.0) {
            (at, value) = (middle, found);
        } else {
            (next, beyond) = (middle, found);
        }
        steps += 1;
    }
    let share = if next == at { 0.0 } else { value / (value - beyond) };
    let root = at + (next - at) * share;
    (root.abs() <= reach_mm).then(|| p + direction * root)
}
