//! What density must be able to hold before a brush paints on it: its 16-bit codes, wider ones, or 32-bit floats.
//!
//! Codes are half as large and are kept for as long as they lose nothing that the brush means: they hold every value, the
//! source's outliers too, the number painted is one of them, and a step of integer data has codes enough for what lies between; or
//! the numbers are so large and so near each other that floats would lose more.
//! Otherwise density moves to floats, which hold every value to 24 bits. Nothing is ever refused for want of room. Knows fields,
//! neither documents nor the GPU.

use crate::paint::brush::{Brush, Operation, Target, Tip};
use crate::paint::error::PaintError;
use crate::paint::falloff::Falloff;
use crate::volume::{DensityMap, Field, Statistics, TexelFormat, unit};

/// Codes between neighbouring integers below which a soft brush would paint in steps.
const CODES_BETWEEN: f64 = 8.0;

impl Brush {
    /// The map that density needs before this brush paints on it where up to `coverage` adds up on a voxel (Σ G of building up, at
    /// least 1); `None` if it has it. `source` is of the values that were there before any painting.
    pub fn map_for(&self, density: &Field, source: &Statistics, coverage: f64) -> Option<DensityMap> {
        let Target::Density(value) = self.effective_target() else { return None };
        let restores = self.effective() == Operation::Restore;
        // Where nothing was painted there is nothing to take back.
        if density.format() != TexelFormat::R16Unorm || (restores && density.edits().is_empty()) {
            return None;
        }
        let all_finite =
            source.nan_count + source.infinite_count == 0 && source.min.is_finite() && source.max.is_finite();
        if !all_finite {
            return Some(DensityMap::FLOAT);
        }
        let unit = density.source().and_then(|s| unit(&**s));
        let painted = held(density).unwrap_or_else(|| {
            let map = density.map();
            if density.edits().is_empty() { [source.min, source.max] } else { [map.lo, map.hi()] }
        });
        let [lo, hi] = self.made([painted[0].min(source.min), painted[1].max(source.max)], density, coverage);
        let number = match self.effective() {
            Operation::Add | Operation::Subtract => value * f64::from(self.strength),
            _ => value,
        };
        let size = lo.abs().max(hi.abs());
        let holds = |map: &DensityMap| {
            let slack = map.half_step() * 0.01 + size * f64::EPSILON;
            lo >= map.lo - slack && hi <= map.hi() + slack
        };
        // Of large numbers near each other codes lose less than floats do.
        let finer = |map: &DensityMap| holds(map) && map.half_step() <= size * f64::from(f32::EPSILON) * 0.5;
        let keeps = |map: &DensityMap| {
            let code = match self.effective() {
                Operation::Add | Operation::Subtract => number * map.codes_per_unit,
                _ => (number - map.lo) * map.codes_per_unit,
            };
            let is_code = (code - code.round()).abs() <= 1e-9 * (1.0 + code.abs());
            let whole = self.falloff == Falloff::Hard && self.strength >= 1.0;
            let anything = restores || self.effective().looks_around();
            let between = unit.is_none_or(|u| whole || map.codes_per_unit * u >= CODES_BETWEEN * (1.0 - 1e-9));
            finer(map) || (holds(map) && (restores || ((is_code || anything) && between)))
        };
        if keeps(density.map()) {
            return None;
        }
        let wider = match unit {
            Some(unit) => {
                // Ends where the source has integers.
                let lo = source.min + ((lo - source.min) / unit).floor() * unit;
                let hi = source.min + ((hi - source.min) / unit).ceil() * unit;
                ((hi - lo) / unit <= 65_535.0).then(|| DensityMap::codes(lo, hi, Some(unit)))
            }
            None => Some(DensityMap::codes(lo, hi, None)).filter(finer),
        };
        Some(wider.filter(keeps).unwrap_or(DensityMap::FLOAT))
    }

    /// # Errors
    /// If the brush's number is beyond what density as it is now can keep.
    pub fn check_on(&self, density: &Field) -> Result<(), PaintError> {
        let Target::Density(value) = self.effective_target() else { return Ok(()) };
        let map = density.map();
        let kept = map.format != TexelFormat::R32Float || map.decode(map.encode(value)).is_finite();
        let expected = "a value within 32-bit floats, which keep what is painted: up to 3.4e38 either way";
        let wrong = || PaintError::Brush { field: "target.density", found: format!("{value:e}"), expected };
        if kept || self.effective() == Operation::Restore || self.effective().looks_around() {
            Ok(())
        } else {
            Err(wrong())
        }
    }

    /// The range of values after this brush has painted on values of the range `ends`: these, and what one application makes of
    /// them, or up to `coverage` of them. Beyond one application no more room is made than the source's own type has.
    pub(super) fn made(&self, ends: [f64; 2], density: &Field, coverage: f64) -> [f64; 2] {
        let [min, max] = ends;
        let Target::Density(value) = self.effective_target() else { return ends };
        let [lo, hi] = match self.effective() {
            Operation::Restore => ends,
            operation if operation.looks_around() => ends,
            Operation::Replace | Operation::Blend => [value, value],
            Operation::Add | Operation::Subtract => {
                let offset = self.offset(value);
                let [least, greatest] = limits(density);
                [
                    (min + offset * coverage).max(least).min(min + offset),
                    (max + offset * coverage).min(greatest).max(max + offset),
                ]
            }
            _ => ends,
        };
        [lo.min(min), hi.max(max)]
    }

    /// Where what adds up ends: at what the source's type can hold, or what one application makes where that is further.
    /// Without adding, no end.
    pub fn bounds(&self, density: &Field) -> [f64; 2] {
        match (self.effective_target(), self.effective()) {
            (Target::Density(value), Operation::Add | Operation::Subtract) => {
                let offset = self.offset(value);
                let ([least, greatest], [min, max]) = (limits(density), density.extremes().map(f64::from));
                [least.min(min + offset), greatest.max(max + offset)]
            }
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// What one application adds at most.
    fn offset(&self, value: f64) -> f64 {
        let sign = if self.effective() == Operation::Add { 1.0 } else { -1.0 };
        sign * value * if self.tip == Tip::Wash { f64::from(self.strength) } else { 1.0 }
    }

    /// The range of values that density must be able to hold for this brush, if its 16-bit codes cannot yet.
    pub fn range_needed(&self, density: &Field) -> Option<[f64; 2]> {
        let of_density =
            matches!(self.effective_target(), Target::Density(_)) && density.format() == TexelFormat::R16Unorm;
        if !of_density || self.effective() == Operation::Restore {
            return None;
        }
        let map = density.map();
        let [lo, hi] = self.made(held(density)?, density, 1.0);
        let slack = map.half_step();
        (lo < map.lo - slack || hi > map.hi() + slack).then(|| [lo.min(map.lo), hi.max(map.hi())])
    }
}

/// The extremes of what density holds in its texels. They are known to 32 bits, which is none where the numbers are so large and so
/// near each other that these are more than the codes' steps.
fn held(density: &Field) -> Option<[f64; 2]> {
    let (ends, map) = (density.extremes().map(f64::from), density.map());
    let unsure = ends[0].abs().max(ends[1].abs()) * f64::from(f32::EPSILON);
    (map.format != TexelFormat::R16Unorm || unsure <= map.half_step()).then_some(ends)
}

/// What the source's type can hold, in the volume's unit.
fn limits(density: &Field) -> [f64; 2] {
    let of = |source: &std::sync::Arc<dyn crate::volume::BrickSource>| {
        let (slope, intercept) = source.scaling();
        let [a, b] = source.voxel_type().limits()?.map(|stored| slope * stored + intercept);
        Some([a.min(b), a.max(b)])
    };
    density.source().and_then(of).unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
}
