//! Commands on the brush's settings. The brush is a tool: it is saved, and undo leaves it alone.

use super::{BrushCommand, Document, DocumentError};
use crate::paint::Brush;
use serde_json::{Value, json};

impl Document {
    pub(in crate::document) fn brush(&mut self, command: BrushCommand) -> Result<Value, DocumentError> {
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
        brush.check()?;
        state.scene.brush = brush;
        Ok(json!({ "brush": brush }))
    }
}
