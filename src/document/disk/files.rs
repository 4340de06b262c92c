//! Files that survive a crash: written beside the old ones, synced, and made true by one rename.
//!
//! Owns nothing but the habit: no file of a generation is ever changed once it is there, so that a hard link to it is a copy.
//! Knows no format.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::io::disk;
use rayon::prelude::*;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// A generation that is being written beside the previous one.
#[derive(Debug)]
pub(crate) struct Writer {
    /// The new generation's folder.
    pub dir: PathBuf,
    /// The folder of the generation before it.
    pub previous: Option<PathBuf>,
    written: AtomicU64,
    linked: AtomicU64,
    unsynced: Mutex<Vec<PathBuf>>,
}

impl Writer {
    /// Starts in an empty folder; what a crash left there goes.
    pub(crate) fn new(dir: PathBuf, previous: Option<PathBuf>) -> Result<Self, KeepError> {
        remove_dir(&dir)?;
        std::fs::create_dir(&dir).map_err(KeepError::io("create", &dir))?;
        Ok(Self { dir, previous, written: AtomicU64::new(0), linked: AtomicU64::new(0), unsynced: Mutex::default() })
    }

    /// Writes a new file. `name` is relative to the folder, with slashes.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), KeepError> {
        let path = self.place(name)?;
        create_new(&path, bytes).map_err(KeepError::io("write", &path))?;
        self.wrote(path, bytes.len() as u64);
        Ok(())
    }

    fn wrote(&self, path: PathBuf, bytes: u64) {
        self.written.fetch_add(bytes, Ordering::Relaxed);
        self.unsynced.lock().unwrap_or_else(PoisonError::into_inner).push(path);
    }

    /// Links the previous generation's file of that name; a file system without links gets a copy.
    pub(crate) fn link(&self, name: &str) -> Result<(), KeepError> {
        self.link_from(name, name)
    }

    /// The same of a file that had another name, `before`.
    pub(crate) fn link_from(&self, before: &str, name: &str) -> Result<(), KeepError> {
        let path = self.place(name)?;
        let Some(previous) = &self.previous else {
            let missing = std::io::Error::from(ErrorKind::NotFound);
            return Err(KeepError::Io { doing: "link", path, source: missing });
        };
        let from = inside::check_file(previous, before).map_err(KeepError::io("link", &previous.join(before)))?;
        if std::fs::hard_link(&from, &path).is_ok() {
            self.linked.fetch_add(1, Ordering::Relaxed);
            return Ok(());
        }
        let copied =
            inside::open(previous, before).and_then(|mut file| std::io::copy(&mut file, &mut File::create_new(&path)?));
        let bytes = copied.map_err(KeepError::io("copy", &from))?;
        self.wrote(path, bytes);
        Ok(())
    }

    /// Links if the previous generation has exactly these bytes, writes otherwise.
    pub(crate) fn write_or_link(&self, name: &str, bytes: &[u8]) -> Result<(), KeepError> {
        let same = |dir: &PathBuf| inside::read(dir, name, bytes.len() as u64).is_ok_and(|old| old == bytes);
        if self.previous.as_ref().is_some_and(same) { self.link(name) } else { self.write(name, bytes) }
    }

    /// Syncs what was written, and every folder, so that names are as safe as contents. All at the end: synced one by one
    /// as they are written, each file would wait for a transaction of the file system of its own.
    pub(crate) fn sync(&self) -> Result<(), KeepError> {
        fn walk(dir: &Path) -> Result<(), KeepError> {
            for entry in std::fs::read_dir(dir).map_err(KeepError::io("read", dir))? {
                let entry = entry.map_err(KeepError::io("read", dir))?;
                if entry.file_type().is_ok_and(|t| t.is_dir()) {
                    walk(&entry.path())?;
                }
            }
            sync_dir(dir)
        }
        let files = std::mem::take(&mut *self.unsynced.lock().unwrap_or_else(PoisonError::into_inner));
        let sync = |path: &PathBuf| OpenOptions::new().write(true).open(path).and_then(|f| disk::sync(&f, path));
        files.par_iter().try_for_each(|path| sync(path).map_err(KeepError::io("sync", path)))?;
        walk(&self.dir)
    }

    /// Bytes written so far; linked files count for nothing.
    pub(crate) fn bytes_written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// Files linked so far.
    pub(crate) fn files_linked(&self) -> u64 {
        self.linked.load(Ordering::Relaxed)
    }

    fn place(&self, name: &str) -> Result<PathBuf, KeepError> {
        let path = self.dir.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(KeepError::io("create", parent))?;
        }
        Ok(path)
    }
}

/// Writes a file that is not there yet, and syncs it.
pub(crate) fn write_new(path: &Path, bytes: &[u8]) -> Result<(), KeepError> {
    create_new(path, bytes).and_then(|file| disk::sync(&file, path)).map_err(KeepError::io("write", path))
}

fn create_new(path: &Path, bytes: &[u8]) -> std::io::Result<File> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(bytes)?;
    Ok(file)
}

/// Makes `path` hold `bytes`: whoever looks finds the old file or the new one, also after a crash. A power cut may still bring
/// the old one back until the folder is synced.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<(), KeepError> {
    let old = path.symlink_metadata().ok();
    if old.as_ref().is_some_and(|about| about.permissions().readonly()) {
        let protected = std::io::Error::new(ErrorKind::PermissionDenied, "the file is write-protected");
        return Err(KeepError::io("replace", path)(protected));
    }
    let beside = path.with_extension("new");
    match std::fs::remove_file(&beside) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(KeepError::io("replace", &beside)(error)),
        _ => {}
    }
    let written = write_new(&beside, bytes).and_then(|()| match old.filter(std::fs::Metadata::is_file) {
        Some(old) => std::fs::set_permissions(&beside, old.permissions()).map_err(KeepError::io("replace", path)),
        None => Ok(()),
    });
    let replaced = written.and_then(|()| disk::rename(&beside, path).map_err(KeepError::io("replace", path)));
    if replaced.is_err() {
        // What little was written would only keep a full disk full.
        let _ = std::fs::remove_file(&beside);
    }
    replaced
}

/// Makes the names in a folder survive a power cut.
pub(crate) fn sync_dir(dir: &Path) -> Result<(), KeepError> {
    disk::sync_dir(dir).map_err(KeepError::io("sync", dir))
}

/// Makes a folder, and those above it that are missing, so that they survive a power cut.
pub(crate) fn create_dir(dir: &Path) -> Result<(), KeepError> {
    let missing: Vec<&Path> = dir.ancestors().take_while(|d| !d.as_os_str().is_empty() && !d.exists()).collect();
    std::fs::create_dir_all(dir).map_err(KeepError::io("create", dir))?;
    let above = |d: &Path| d.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned();
    missing.into_iter().try_for_each(|d| sync_dir(&above(d)))
}

/// Removes a folder with all that is in it, if it is there.
pub(crate) fn remove_dir(dir: &Path) -> Result<(), KeepError> {
    match std::fs::remove_dir_all(dir) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(KeepError::io("remove", dir)(error)),
        _ => Ok(()),
    }
}
