//! The transfer function: density to colour and opacity.

use serde::{Deserialize, Serialize};

/// Entries of the table that the ray caster reads.
pub const TABLE_ENTRIES: usize = 4096;

/// Extinction of a step that stands for an opaque one: nothing that counts comes through, and sums of it stay exact.
pub(super) const MOST_EXTINCTION: f64 = 50.0;

/// Piecewise-linear colour and opacity over density, constant beyond their first and last points. Points rise in value.
///
/// Colour is display-referred (composited as it is, as the field's tools do); opacity is that of `unit_mm` of matter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct TransferFunction {
    /// (value, [r, g, b] in 0..1).
    pub colour: Vec<(f64, [f32; 3])>,
    /// (value, opacity in 0..1 per `unit_mm`).
    pub opacity: Vec<(f64, f32)>,
    /// Length in mm that `opacity` is meant for, positive.
    pub unit_mm: f64,
}

impl TransferFunction {
    /// Checks that points rise and numbers are in range.
    ///
    /// # Errors
    /// A sentence that names the field, what was found and what was expected.
    pub fn check(&self) -> Result<(), String> {
        fn rising(name: &str, values: impl Iterator<Item = f64>) -> Result<(), String> {
            let mut last = f64::NEG_INFINITY;
            let mut count = 0;
            for (i, v) in values.enumerate() {
                if !v.is_finite() || v <= last {
                    return Err(format!("{name}[{i}]: value {v} found, a finite number above {last} expected"));
                }
                last = v;
                count += 1;
            }
            if count == 0 { Err(format!("{name}: no point found, at least one expected")) } else { Ok(()) }
        }
        rising("colour", self.colour.iter().map(|p| p.0))?;
        rising("opacity", self.opacity.iter().map(|p| p.0))?;
        if let Some((v, _)) = self.colour.iter().find(|(_, c)| c.iter().any(|x| !(0.0..=1.0).contains(x))) {
            return Err(format!("colour at {v}: components between 0 and 1 expected"));
        }
        if let Some((v, a)) = self.opacity.iter().find(|(_, a)| !(0.0..=1.0).contains(a)) {
            return Err(format!("opacity at {v}: {a} found, 0 to 1 expected"));
        }
        if !(self.unit_mm.is_finite() && self.unit_mm > 0.0) {
            return Err(format!("unit_mm: {} found, a positive length expected", self.unit_mm));
        }
        Ok(())
    }

    /// Colour at a value.
    pub fn colour_at(&self, value: f64) -> [f32; 3] {
        interpolate(&self.colour, value, |a, b, t| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t))
    }

    /// Opacity of `unit_mm` at a value.
    pub fn opacity_at(&self, value: f64) -> f32 {
        interpolate(&self.opacity, value, |a, b, t| a + (b - a) * t)
    }

    /// Opacity of a step of `step_mm`: `1 − (1 − α)^(step/unit)`.
    pub fn opacity_of_step(&self, value: f64, step_mm: f64) -> f64 {
        1.0 - (1.0 - f64::from(self.opacity_at(value))).powf(step_mm / self.unit_mm)
    }

    /// The largest opacity anywhere in `[lo, hi]`: 0 means that a cell of these values is invisible.
    pub fn max_opacity_in(&self, lo: f64, hi: f64) -> f32 {
        if lo > hi {
            return 0.0;
        }
        let inner = self.opacity.iter().filter(|(v, _)| (lo..=hi).contains(v)).map(|&(_, a)| a);
        inner.fold(self.opacity_at(lo).max(self.opacity_at(hi)), f32::max)
    }

    /// First and last value of any point: the table's range. Constant beyond.
    pub fn domain(&self) -> (f64, f64) {
        let lo = self.colour[0].0.min(self.opacity[0].0);
        let hi = self.colour[self.colour.len() - 1].0.max(self.opacity[self.opacity.len() - 1].0);
        if hi > lo { (lo, hi) } else { (lo, lo + 1.0) }
    }

    /// [`TABLE_ENTRIES`] of (r, g, b, opacity of one step of `step_mm`) over [`domain`](Self::domain), entry i at
    /// `lo + i/(entries − 1)·(hi − lo)`. Colour is not multiplied by opacity.
    pub fn table(&self, step_mm: f64) -> Vec<[f32; 4]> {
        let (lo, hi) = self.domain();
        (0..TABLE_ENTRIES)
            .map(|i| {
                let value = mix(lo, hi, i as f64 / (TABLE_ENTRIES - 1) as f64);
                let [r, g, b] = self.colour_at(value);
                [r, g, b, self.opacity_of_step(value, step_mm) as f32]
            })
            .collect()
    }

    /// What lies below each of the table's entries: `∫τ dx` and `∫τ·(x − middle) dx` from the first entry on, x in entries, τ the
    /// extinction of a step of `step_mm`, at most [`MOST_EXTINCTION`]; τ itself; and 0. The middle is half of [`TABLE_ENTRIES`].
    pub fn integrals(&self, step_mm: f64) -> Vec<[f32; 4]> {
        let (lo, hi) = self.domain();
        let extinction = |i: usize| {
            let value = mix(lo, hi, i as f64 / (TABLE_ENTRIES - 1) as f64);
            (-(1.0 - self.opacity_of_step(value, step_mm)).ln()).min(MOST_EXTINCTION)
        };
        let (mut sum, mut moment) = (0.0, 0.0);
        let mut here = extinction(0);
        (0..TABLE_ENTRIES)
            .map(|i| {
                let entry = [sum as f32, moment as f32, here as f32, 0.0];
                // Extinction is taken as linear from entry to entry.
                let next = if i + 1 < TABLE_ENTRIES { extinction(i + 1) } else { here };
                let from = i as f64 - (TABLE_ENTRIES / 2) as f64;
                sum += (here + next) / 2.0;
                moment += from * (here + next) / 2.0 + here / 6.0 + next / 3.0;
                here = next;
                entry
            })
            .collect()
    }
}

fn interpolate<T: Copy>(points: &[(f64, T)], value: f64, mix: impl Fn(T, T, f32) -> T) -> T {
    let after = points.partition_point(|p| p.0 <= value);
    if after == 0 {
        points[0].1
    } else if after == points.len() {
        points[after - 1].1
    } else {
        let ((a, x), (b, y)) = (points[after - 1], points[after]);
        // Halves, since the distance of two numbers may be beyond all numbers.
        let t = (value * 0.5 - a * 0.5) / (b * 0.5 - a * 0.5);
        // Of numbers so small that they have no halves there is nothing between.
        mix(x, y, if t.is_finite() { t as f32 } else { 0.0 })
    }
}

/// Between two numbers, also where their distance is beyond all numbers.
pub(super) fn mix(a: f64, b: f64, t: f64) -> f64 {
    if (b - a).is_finite() { a + (b - a) * t } else { a * (1.0 - t) + b * t }
}
