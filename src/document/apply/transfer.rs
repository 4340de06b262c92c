//! Commands on colour and opacity.

use crate::document::Document;
use crate::document::command::views::TransferCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::scene::first_look;
use serde_json::{Value, json};

impl Document {
    pub(crate) fn transfer(&mut self, command: TransferCommand, edit: &mut Edit) -> Result<Value, DocumentError> {
        let state = self.open_mut()?;
        let function = match command {
            TransferCommand::Set { function } => {
                edit.name("Transfer function");
                function
            }
            TransferCommand::Reset {} => {
                edit.name("Reset transfer function");
                first_look::transfer(state.grid(), &state.histogram)
            }
        };
        function.check().map_err(|found| DocumentError::NotNow(format!("transfer function: {found}")))?;
        state.scene.transfer = function;
        let (lo, hi) = state.scene.transfer.domain();
        Ok(json!({
            "colour_points": state.scene.transfer.colour.len(),
            "opacity_points": state.scene.transfer.opacity.len(),
            "domain": [lo, hi],
        }))
    }
}
