//! One process per project. The lock is the system's own, so a process that dies leaves none behind.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use std::fs::{File, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

/// The file that is locked.
pub(crate) const LOCK: &str = "lock";

/// Held as long as it lives.
#[derive(Debug)]
pub(crate) struct Lock(File);

impl Lock {
    /// Takes the lock of a folder.
    ///
    /// # Errors
    /// `Locked` with the holder's process id, or the system's refusal.
    pub(crate) fn take(dir: &Path) -> Result<Self, KeepError> {
        let path = dir.join(LOCK);
        inside::check_writable(dir).map_err(KeepError::io("write into", dir))?;
        let mut file = inside::open_or_create(dir, LOCK).map_err(KeepError::io("open", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                let read = (&file).take(64).read_to_string(&mut holder);
                let named = read.is_ok() && !holder.trim().is_empty();
                let holder = if named { holder.trim().to_owned() } else { "an unknown process".to_owned() };
                return Err(KeepError::Locked { path: dir.to_owned(), holder });
            }
            Err(TryLockError::Error(error)) => return Err(KeepError::io("lock", &path)(error)),
        }
        // The name is for people; the lock holds without it, also on a full disk.
        if let Err(error) = sign(&mut file) {
            tracing::debug!("{}: holder's name not written: {error}", path.display());
        }
        Ok(Self(file))
    }

    /// Gives the folder to whoever wants it, until [`retake`](Self::retake).
    pub(crate) fn release(&self, dir: &Path) -> Result<(), KeepError> {
        self.0.unlock().map_err(KeepError::io("unlock", dir))
    }

    /// Takes the folder again, if nobody else has it.
    pub(crate) fn retake(&self, dir: &Path) -> Result<(), KeepError> {
        match self.0.try_lock() {
            Ok(()) => Ok(()),
            Err(TryLockError::WouldBlock) => {
                Err(KeepError::Locked { path: dir.to_owned(), holder: "an unknown process".to_owned() })
            }
            Err(TryLockError::Error(error)) => Err(KeepError::io("lock", dir)(error)),
        }
    }
}

/// Writes the process's name into the lock, unless it is something else that is named so: that is nobody's to empty.
fn sign(file: &mut File) -> std::io::Result<()> {
    let mut found = Vec::new();
    (&*file).take(64).read_to_end(&mut found)?;
    let ours = found.len() < 64 && (found.is_empty() || found.starts_with(b"process "));
    if !ours || inside::has_other_names(file)? {
        return Ok(());
    }
    file.set_len(0)?;
    file.seek(SeekFrom::Start(0))?;
    file.write_all(format!("process {}\n", std::process::id()).as_bytes())
}

impl Drop for Lock {
    /// Closing the file is not enough: a program that is being started at this moment holds a copy of it for a while.
    fn drop(&mut self) {
        if let Err(error) = self.0.unlock() {
            tracing::debug!("project lock not given back: {error}");
        }
    }
}
