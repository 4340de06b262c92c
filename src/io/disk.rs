//! Syncs and renames: on their order it hangs whether a power cut leaves the old, the new, or neither.
//!
//! Everything that must survive one goes through here, and whoever wants to know in which order can watch. Knows no files by name.

use std::fs::File;
use std::io::Result;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the disk was told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// To keep a file's or a folder's content.
    Sync(PathBuf),
    /// To put a file in another's place: the other's name.
    Rename(PathBuf),
}

type Notes = Arc<Mutex<Vec<Told>>>;

static WITNESSES: Mutex<Vec<(PathBuf, Notes)>> = Mutex::new(Vec::new());

/// Sees what the disk is told of a folder and all below, as long as it lives.
#[derive(Debug)]
pub struct Witness {
    notes: Notes,
}

impl Witness {
    /// From now on; `below` as whoever writes there calls it.
    pub fn new(below: &Path) -> Self {
        let notes = Notes::default();
        lock(&WITNESSES).push((below.to_owned(), notes.clone()));
        Self { notes }
    }

    /// What was told so far, in order.
    pub fn told(&self) -> Vec<Told> {
        lock(&self.notes).clone()
    }
}

impl Drop for Witness {
    fn drop(&mut self) {
        lock(&WITNESSES).retain(|(_, notes)| !Arc::ptr_eq(notes, &self.notes));
    }
}

/// Makes a file's content and length survive a power cut.
pub(crate) fn sync(file: &File, path: &Path) -> Result<()> {
    file.sync_all()?;
    note(path, Told::Sync);
    Ok(())
}

/// The same without what nobody reads, such as times.
pub(crate) fn sync_data(file: &File, path: &Path) -> Result<()> {
    file.sync_data()?;
    note(path, Told::Sync);
    Ok(())
}

/// Makes the names in a folder survive a power cut.
pub(crate) fn sync_dir(dir: &Path) -> Result<()> {
    // Only Unix opens a folder as a file.
    if cfg!(unix) { sync(&File::open(dir)?, dir) } else { Ok(()) }
}

/// Puts a file in another's place.
pub(crate) fn rename(from: &Path, to: &Path) -> Result<()> {
    std::fs::rename(from, to)?;
    renamed(to);
    Ok(())
}

/// Says that a file was put in another's place.
pub(crate) fn renamed(to: &Path) {
    note(to, Told::Rename);
}

fn note(path: &Path, told: impl Fn(PathBuf) -> Told) {
    for (below, notes) in &*lock(&WITNESSES) {
        if path.starts_with(below) {
            lock(notes).push(told(path.to_owned()));
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
