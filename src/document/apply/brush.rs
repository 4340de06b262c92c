//! Commands on the brush's settings. The brush is a tool: it is saved, and undo leaves it alone.

use crate::document::Document;
use crate::document::command::brush::BrushCommand;
use crate::document::error::DocumentError;
use serde_json::{Value, json};

impl Document {
    pub(crate) fn brush(&mut self, command: BrushCommand) -> Result<Value, DocumentError> {
        let state = self.open_mut()?;
        let BrushCommand::Set { range, any_value, .. } = &command;
        if *any_value && range.is_some() {
            return Err(DocumentError::invalid("any_value", "true beside a range", "either one or the other"));
        }
        let brush = command.applied_to(&state.scene.brush);
        brush.check()?;
        state.scene.brush = brush;
        Ok(json!({ "brush": brush }))
    }
}
