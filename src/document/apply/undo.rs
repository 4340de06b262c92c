//! Commands on history: undo, redo, groups, budget.

use crate::document::Document;
use crate::document::command::answers::{Answer, BudgetSaid, GroupSaid, GroupState, Said, TravelledSaid};
use crate::document::command::{Command, HistoryCommand};
use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;

impl Document {
    pub(crate) fn undo_redo(&mut self, command: &HistoryCommand) -> Result<Answer, DocumentError> {
        let mut warnings = Vec::new();
        let said = match *command {
            HistoryCommand::Undo { steps } => self.walk(steps, true, &mut warnings)?,
            HistoryCommand::Redo { steps } => self.walk(steps, false, &mut warnings)?,
            HistoryCommand::Budget { bytes } => {
                warnings.extend(self.history.set_budget(bytes));
                let (memory, disk) = self.history.bytes();
                BudgetSaid { budget: bytes, memory, disk }.into()
            }
            HistoryCommand::Begin {} => {
                self.open()?;
                self.history.begin()?;
                GroupSaid { group: GroupState::Open, step: None }.into()
            }
            HistoryCommand::End {} => {
                let step = self.end_group(&mut warnings)?;
                GroupSaid { group: GroupState::Closed, step: Some(step) }.into()
            }
            HistoryCommand::Cancel {} => {
                let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
                let before = state.scene.explosion.clone();
                let refreshed = self.history.cancel(state)?;
                self.motion.travelled(&before, &state.scene.explosion);
                state.past.group_cancelled(std::mem::take(&mut self.past_group), &mut state.scene);
                self.travelled(HistoryCommand::Cancel {}, &refreshed, &mut warnings);
                GroupSaid { group: GroupState::Cancelled, step: None }.into()
            }
        };
        Ok(Answer { trouble: warnings, ..Answer::from(said) })
    }

    /// Takes back or does again as many steps as there are. An open group is closed first. Between two steps it can be stopped:
    /// those already taken stand.
    fn walk(&mut self, steps: u32, back: bool, warnings: &mut Vec<String>) -> Result<Said, DocumentError> {
        if self.history.in_group() {
            self.end_group(warnings)?;
        }
        let mut names = Vec::new();
        let mut all = Refreshed::default();
        let there = if back { self.history.undo_names().len() } else { self.history.redo_names().len() };
        let steps = (steps as usize).min(there);
        let before = self.open()?.scene.explosion.clone();
        for done in 0..steps {
            if steps > 1 && !self.watch.proceed(done as f32 / steps as f32) {
                warnings.push(format!("stopped on request after {done} of {steps} steps"));
                break;
            }
            let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
            match if back { self.history.undo(state) } else { self.history.redo(state) } {
                Ok(Some((name, refreshed))) => {
                    names.push(name);
                    all.join(refreshed);
                }
                Ok(None) => break,
                // Steps already taken stand and are told; a failure is the answer only where there is no other.
                Err(error) if names.is_empty() => return Err(error),
                Err(error) => {
                    warnings.push(error.to_string());
                    break;
                }
            }
        }
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        self.motion.travelled(&before, &state.scene.explosion);
        warnings.extend(self.history.spill());
        if !names.is_empty() {
            let steps = names.len() as u32;
            let said = if back { HistoryCommand::Undo { steps } } else { HistoryCommand::Redo { steps } };
            self.travelled(said, &all, warnings);
        }
        let (undone, redone) = if back { (Some(names), None) } else { (None, Some(names)) };
        let (undo, redo) = (self.history.undo_names().len(), self.history.redo_names().len());
        Ok(TravelledSaid { undone, redone, undo, redo }.into())
    }

    fn end_group(&mut self, warnings: &mut Vec<String>) -> Result<Option<String>, DocumentError> {
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        let (step, warning) = self.history.end(state)?;
        state.past.group_closed(std::mem::take(&mut self.past_group), &state.scene);
        warnings.extend(warning);
        Ok(step)
    }

    fn travelled(&mut self, said: HistoryCommand, refreshed: &Refreshed, warnings: &mut Vec<String>) {
        self.unsaved = true;
        self.mirror(refreshed);
        warnings.extend(self.note(&Command::History(said), refreshed, true));
        self.note_poses();
    }
}
