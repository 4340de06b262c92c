//! Undo and redo without a limit in steps: a budget of bytes in memory, older steps in files.
//!
//! Every step is one exchange either way (see `step`). A group gathers all steps between its begin and its end into one. A step
//! that cannot go to disk stays in memory and says so; nothing is lost for want of room.

pub(crate) mod edit;
pub(crate) mod packed;
pub(crate) mod spill;
pub(crate) mod step;

use crate::document::command::resolved::ResolvedCommand;
use crate::document::error::DocumentError;
use crate::document::history::packed::Packed;
use crate::document::history::spill::SpillFolder;
use crate::document::history::step::{Bare, Refreshed, Step};
use crate::document::state::State;
use crate::volume::{Volume, VolumeId};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Memory for steps unless told otherwise.
pub const DEFAULT_BUDGET_BYTES: u64 = 256 << 20;

#[derive(Debug)]
struct Entry {
    name: String,
    step: Packed,
    /// Volumes that come or go with the step: what was painted on them is packed, their sources are no bytes.
    volumes: BTreeMap<VolumeId, Option<Bare>>,
}

impl Entry {
    fn commands(&self) -> Result<Vec<ResolvedCommand>, DocumentError> {
        self.step.commands(&self.name).map_err(DocumentError::NotNow)
    }
}

/// Steps that can be undone and redone, newest last, within a budget of bytes in memory; older ones lie in files.
#[derive(Debug)]
pub struct History {
    undo: Vec<Entry>,
    redo: Vec<Entry>,
    group: Option<Step>,
    budget_bytes: u64,
    folder: Option<SpillFolder>,
    parent: PathBuf,
    serial: u64,
}

impl Default for History {
    fn default() -> Self {
        Self::new(std::env::temp_dir())
    }
}

impl History {
    /// Nothing done yet; older steps will go to a temporary folder inside `parent`, removed in the end.
    pub fn new(parent: PathBuf) -> Self {
        Self {
            undo: Vec::new(),
            redo: Vec::new(),
            group: None,
            budget_bytes: DEFAULT_BUDGET_BYTES,
            folder: None,
            parent,
            serial: 0,
        }
    }

    /// An empty one with the same budget and place.
    pub(crate) fn successor(&self) -> Self {
        Self { budget_bytes: self.budget_bytes, ..Self::new(self.parent.clone()) }
    }

    /// Names of the steps that undo takes back, the oldest first.
    pub fn undo_names(&self) -> impl DoubleEndedIterator<Item = &str> + ExactSizeIterator {
        self.undo.iter().map(|e| e.name.as_str())
    }

    /// Names of the steps that redo does again, the next one first.
    pub fn redo_names(&self) -> impl DoubleEndedIterator<Item = &str> + ExactSizeIterator {
        self.redo.iter().rev().map(|e| e.name.as_str())
    }

    /// What made the steps that undo takes back, the newest first.
    ///
    /// # Errors
    /// If a step on disk cannot be read.
    pub(crate) fn undo_commands(&self) -> Result<Vec<Vec<ResolvedCommand>>, DocumentError> {
        self.undo.iter().rev().map(Entry::commands).collect()
    }

    /// What made the steps that redo does again, the next one first.
    ///
    /// # Errors
    /// If a step on disk cannot be read.
    pub(crate) fn redo_commands(&self) -> Result<Vec<Vec<ResolvedCommand>>, DocumentError> {
        self.redo.iter().rev().map(Entry::commands).collect()
    }

    /// Memory and disk that the steps take, in bytes.
    pub fn bytes(&self) -> (u64, u64) {
        let all = || self.undo.iter().chain(&self.redo);
        (all().map(|e| e.step.memory()).sum(), all().map(|e| e.step.disk()).sum())
    }

    /// Memory for steps, bytes.
    pub fn budget_bytes(&self) -> u64 {
        self.budget_bytes
    }

    /// Whether the open group changed parts, degree or forces already.
    pub(crate) fn group_has_explosion(&self) -> bool {
        self.group.as_ref().is_some_and(|step| step.scene.has_explosion())
    }

    /// Whether a group is open.
    pub fn in_group(&self) -> bool {
        self.group.is_some()
    }

    /// Volumes that went and can be brought back.
    pub(crate) fn set_aside(&self) -> BTreeMap<VolumeId, &Volume> {
        let entries = self.undo.iter().chain(&self.redo).map(|entry| &entry.volumes);
        let all = entries.chain(self.group.iter().map(|step| &step.volumes)).flatten();
        all.filter_map(|(id, bare)| Some((*id, &bare.as_ref()?.volume))).collect()
    }

    /// Forgets everything; budget and folder stay.
    pub(crate) fn clear(&mut self) {
        self.undo.clear();
        self.redo.clear();
        self.group = None;
    }

    /// Another budget.
    pub(crate) fn set_budget(&mut self, bytes: u64) -> Option<String> {
        self.budget_bytes = bytes;
        self.spill()
    }

    /// Adds a step that was just done; answers a warning if older steps could not go to disk.
    pub(crate) fn push(&mut self, step: Step) -> Result<Option<String>, DocumentError> {
        if let Some(group) = &mut self.group {
            group.absorb(step);
            return Ok(None);
        }
        let entry = pack(&step)?;
        self.redo.clear();
        self.undo.push(entry);
        Ok(self.spill())
    }

    /// Opens a group.
    pub(crate) fn begin(&mut self) -> Result<(), DocumentError> {
        if self.group.is_some() {
            return Err(DocumentError::NotNow("a group is open already; close it with history.end first".into()));
        }
        self.group = Some(Step::default());
        Ok(())
    }

    /// Closes the group; answers its name (`None` if nothing changed) and a warning as [`push`](Self::push) does.
    pub(crate) fn end(&mut self, state: &State) -> Result<(Option<String>, Option<String>), DocumentError> {
        let Some(mut step) = self.group.take() else {
            return Err(DocumentError::NotNow("no group is open; history.begin opens one".into()));
        };
        step.prune(state);
        if step.is_empty() {
            return Ok((None, None));
        }
        let name = step.name.clone();
        Ok((Some(name), self.push(step)?))
    }

    /// Closes the group and takes back what it did.
    pub(crate) fn cancel(&mut self, state: &mut State) -> Result<Refreshed, DocumentError> {
        let Some(mut step) = self.group.take() else {
            return Err(DocumentError::NotNow("no group is open; history.begin opens one".into()));
        };
        match step.exchange(state) {
            Ok(refreshed) => Ok(refreshed),
            Err(error) => {
                self.group = Some(step);
                Err(error.into())
            }
        }
    }

    /// Takes back the newest step; `None` if there is none.
    pub(crate) fn undo(&mut self, state: &mut State) -> Result<Option<(String, Refreshed)>, DocumentError> {
        let Some(entry) = self.undo.pop() else { return Ok(None) };
        match turn(&entry, state) {
            Ok((turned, refreshed)) => {
                let name = turned.name.clone();
                self.redo.push(turned);
                Ok(Some((name, refreshed)))
            }
            Err(error) => {
                self.undo.push(entry);
                Err(error)
            }
        }
    }

    /// Does the step again that was taken back last; `None` if there is none.
    pub(crate) fn redo(&mut self, state: &mut State) -> Result<Option<(String, Refreshed)>, DocumentError> {
        let Some(entry) = self.redo.pop() else { return Ok(None) };
        match turn(&entry, state) {
            Ok((turned, refreshed)) => {
                let name = turned.name.clone();
                self.undo.push(turned);
                Ok(Some((name, refreshed)))
            }
            Err(error) => {
                self.redo.push(entry);
                Err(error)
            }
        }
    }

    /// Moves the steps that are furthest away to files until the rest fits; what cannot go stays, with a warning.
    pub(crate) fn spill(&mut self) -> Option<String> {
        let mut memory = self.bytes().0;
        if memory <= self.budget_bytes {
            return None;
        }
        if self.folder.is_none() {
            match SpillFolder::new(&self.parent) {
                Ok(folder) => self.folder = Some(folder),
                Err(e) => return Some(format!("older steps of history cannot go to {}: {e}", self.parent.display())),
            }
        }
        let folder = self.folder.as_ref()?.path();
        // The oldest of undo first; what was taken back goes only after all of that.
        for entry in self.undo.iter_mut().chain(&mut self.redo) {
            if memory <= self.budget_bytes {
                break;
            }
            let bytes = entry.step.memory();
            if bytes > 0 {
                self.serial += 1;
                if let Err(said) = entry.step.spill(&folder.join(format!("step-{}", self.serial))) {
                    return Some(format!("{said}; it stays in memory"));
                }
                memory -= bytes;
            }
        }
        None
    }
}

fn pack(step: &Step) -> Result<Entry, DocumentError> {
    let packed = Packed::new(step).map_err(DocumentError::NotNow)?;
    Ok(Entry { name: step.name.clone(), step: packed, volumes: step.volumes.clone() })
}

/// Exchanges an entry with the state and answers the entry that turns it back.
fn turn(entry: &Entry, state: &mut State) -> Result<(Entry, Refreshed), DocumentError> {
    let mut step = entry.step.load(&entry.name).map_err(DocumentError::NotNow)?;
    step.volumes.clone_from(&entry.volumes);
    let refreshed = step.exchange(state)?;
    match pack(&step) {
        Ok(turned) => Ok((turned, refreshed)),
        Err(error) => {
            step.exchange(state)?;
            Err(error)
        }
    }
}
