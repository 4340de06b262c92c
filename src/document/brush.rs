//! Commands on the brush's settings. The brush is a tool: it is saved, and undo leaves it alone.

use super::{BrushCommand, Document, DocumentError};
use crate::paint::{Brush, Target};
use serde_json::{Value, json};

impl Document {
    pub(super) fn brush(&mut self, command: BrushCommand) -> Result<Value, DocumentError> {
        let state = self.open_mut()?;
        let BrushCommand::Set {
            shape,
            radius_mm,
            falloff,
            strength,
            operation,
            tip,
            target,
            spacing,
            range,
            any_value,
            erase,
        } = command;
        let old = state.scene.brush;
        let brush = Brush {
            shape: shape.unwrap_or(old.shape),
            radius_mm: radius_mm.unwrap_or(old.radius_mm),
            falloff: falloff.unwrap_or(old.falloff),
            strength: strength.unwrap_or(old.strength),
            operation: operation.unwrap_or(old.operation),
            tip: tip.unwrap_or(old.tip),
            target: target.unwrap_or(old.target),
            spacing: spacing.unwrap_or(old.spacing),
            range: if any_value { None } else { range.or(old.range) },
            erase: erase.unwrap_or(old.erase),
        };
        if any_value && range.is_some() {
            return Err(DocumentError::invalid("any_value", "true beside a range", "either one or the other"));
        }
        check(&brush)?;
        state.scene.brush = brush;
        Ok(json!({ "brush": brush }))
    }
}

fn check(brush: &Brush) -> Result<(), DocumentError> {
    let invalid = |field: &str, found: String, expected: &str| Err(DocumentError::invalid(field, found, expected));
    if !(brush.radius_mm.is_finite() && brush.radius_mm >= 0.0) {
        return invalid("radius_mm", brush.radius_mm.to_string(), "a length in mm that is not negative");
    }
    if !(0.0..=1.0).contains(&brush.strength) {
        return invalid("strength", brush.strength.to_string(), "0 to 1");
    }
    if !(brush.spacing > 0.0 && brush.spacing <= 0.25) {
        return invalid("spacing", brush.spacing.to_string(), "above 0, at most 0.25 of the radius");
    }
    if let Some([lo, hi]) = brush.range
        && !(lo.is_finite() && hi.is_finite() && lo <= hi)
    {
        return invalid("range", format!("[{lo}, {hi}]"), "two finite values, the smaller first");
    }
    match brush.target {
        Target::Density(value) if !value.is_finite() => invalid("target", value.to_string(), "a finite density"),
        Target::Selection(value) if !(0.0..=1.0).contains(&value) => {
            invalid("target", value.to_string(), "a selection of 0 to 1")
        }
        Target::Colour(c) if c.iter().any(|x| !(0.0..=1.0).contains(x)) => {
            invalid("target", format!("{c:?}"), "red, green, blue and alpha of 0 to 1")
        }
        _ => Ok(()),
    }
}
