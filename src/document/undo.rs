//! Commands on history: undo, redo, groups, budget.

use super::{Document, DocumentError, HistoryCommand};
use serde_json::{Value, json};

impl Document {
    pub(super) fn travel(&mut self, command: HistoryCommand) -> Result<Value, DocumentError> {
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        match command {
            HistoryCommand::Undo { steps } | HistoryCommand::Redo { steps } => {
                let back = matches!(command, HistoryCommand::Undo { .. });
                if self.history.in_group() {
                    self.views.group_closed();
                    self.history.end(state)?;
                }
                let mut names = Vec::new();
                let mut failure = None;
                for _ in 0..steps {
                    let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
                    let turned = if back { self.history.undo(state) } else { self.history.redo(state) };
                    match turned {
                        Ok(Some((name, refreshed))) => {
                            self.mirror(&refreshed);
                            names.push(name);
                        }
                        Ok(None) => break,
                        // Steps already taken stand; the answer must say so, and the rest is an error only if it is all.
                        Err(error) if names.is_empty() => return Err(error),
                        Err(error) => {
                            failure = Some(error.to_string());
                            break;
                        }
                    }
                }
                let warning = failure.or(self.history.spill());
                let mut answer = json!({
                    if back { "undone" } else { "redone" }: names,
                    "undo": self.history.undo_names().len(),
                    "redo": self.history.redo_names().len(),
                });
                if let Some(warning) = warning {
                    answer["warning"] = json!(warning);
                }
                Ok(answer)
            }
            HistoryCommand::Budget { bytes } => {
                let warning = self.history.set_budget(bytes);
                let (memory, disk) = self.history.bytes();
                let mut answer = json!({ "budget": bytes, "memory": memory, "disk": disk });
                if let Some(warning) = warning {
                    answer["warning"] = json!(warning);
                }
                Ok(answer)
            }
            HistoryCommand::Begin {} => {
                self.history.begin()?;
                Ok(json!({ "group": "open" }))
            }
            HistoryCommand::End {} => {
                let (step, warning) = self.history.end(state)?;
                self.views.group_closed();
                let mut answer = json!({ "group": "closed", "step": step });
                if let Some(warning) = warning {
                    answer["warning"] = json!(warning);
                }
                Ok(answer)
            }
            HistoryCommand::Cancel {} => {
                let refreshed = self.history.cancel(state)?;
                self.views.group_closed();
                self.mirror(&refreshed);
                Ok(json!({ "group": "cancelled" }))
            }
        }
    }
}
