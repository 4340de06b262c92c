//! Which values of a volume a look shows at all, so that bricks and cells of others are neither held nor looked at.
//!
//! Pure.

use crate::gpu::picture::frame::LookRef;
use crate::volume::{Mode, TABLE_ENTRIES, TransferFunction};

/// The values that show nothing under a look.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleValues {
    clear: Vec<(f64, f64)>,
}

impl VisibleValues {
    /// Under a transfer function and mode. Iso: below the surface's value. What lies above it shows where a cut opens it.
    /// MIP: up to the first value with opacity. Values within half an entry of the caster's table count as showing.
    pub fn of(transfer: &TransferFunction, mode: Mode) -> Self {
        let points = &transfer.opacity;
        let (lo, hi) = transfer.domain();
        let guard = (hi - lo) / (TABLE_ENTRIES - 1) as f64 * 0.51;
        let mut clear: Vec<(f64, f64)> = Vec::new();
        if let Mode::Iso(value) = mode {
            // What is less by no more than the GPU's rounding may pass for the value.
            return Self { clear: vec![(f64::NEG_INFINITY, value - value.abs() * 4e-7)] };
        }
        let mut start = None;
        for (i, &(value, opacity)) in points.iter().enumerate() {
            if opacity > 0.0 {
                if let Some(from) = start.take() {
                    // Opacity rises from the point before on.
                    clear.push((from, points[i - 1].0 - guard));
                }
            } else if start.is_none() {
                start = Some(if i == 0 { f64::NEG_INFINITY } else { value + guard });
            }
        }
        if let Some(from) = start {
            clear.push((from, f64::INFINITY));
        }
        if mode == Mode::Mip {
            clear.retain(|c| c.0 == f64::NEG_INFINITY);
        }
        Self { clear }
    }

    /// All above a value.
    pub(crate) fn above(value: f64) -> Self {
        Self { clear: vec![(f64::NEG_INFINITY, value)] }
    }

    /// Under a look: none where it is clear.
    pub fn of_look(look: LookRef<'_>) -> Self {
        if look.opacity > 0.0 {
            Self::of(look.transfer, look.mode)
        } else {
            Self { clear: vec![(f64::NEG_INFINITY, f64::INFINITY)] }
        }
    }

    /// Whether anything in `[min, max]` may show; an empty interval holds no value.
    pub fn any(&self, min: f32, max: f32) -> bool {
        let (min, max) = (f64::from(min), f64::from(max));
        min <= max && !self.clear.iter().any(|&(from, to)| from <= min && max <= to)
    }
}
