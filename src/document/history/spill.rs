//! The temporary folder that older steps of history go to, and what is left of those of processes that died.
//!
//! A folder is its owner's alone and has a lock in it, which the system gives back when the process ends, however it ends. A
//! folder whose lock nobody holds is nobody's. Knows no steps.

use crate::document::disk::lock::Lock;
use std::path::Path;
use tempfile::TempDir;

const PREFIX: &str = "burin-history-";
const LOCK: &str = "lock";
/// Between its making and its lock a folder may be taken for a dead process's, at worst this often in a row.
const TRIES: u32 = 8;

/// Removed when dropped.
#[derive(Debug)]
pub(crate) struct SpillFolder {
    // Given back first: a file that is open cannot be removed everywhere.
    _lock: Lock,
    dir: TempDir,
}

impl SpillFolder {
    /// A new folder inside `parent`. `Err` says what is wrong.
    pub(crate) fn new(parent: &Path) -> Result<Self, String> {
        let mut last = String::new();
        for _ in 0..TRIES {
            let mut builder = tempfile::Builder::new();
            builder.prefix(PREFIX);
            // What was painted on is nobody else's to read.
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
            let dir = builder.tempdir_in(parent).map_err(|e| e.to_string())?;
            match Lock::take(dir.path()) {
                Ok(lock) if dir.path().join(LOCK).exists() => return Ok(Self { _lock: lock, dir }),
                Ok(_) => last = "the folder was removed by another program".into(),
                Err(error) => last = error.to_string(),
            }
        }
        Err(last)
    }

    pub(crate) fn path(&self) -> &Path {
        self.dir.path()
    }
}

/// Removes the folders inside `parent` whose processes died; answers how many. What cannot be read or removed stays: it is
/// another user's.
pub fn remove_dead_history(parent: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(parent) else { return 0 };
    let named = entries.flatten().filter(|e| e.file_name().to_string_lossy().starts_with(PREFIX));
    named.filter(|entry| is_dead(&entry.path()) && std::fs::remove_dir_all(entry.path()).is_ok()).count()
}

/// Whether a folder is one of ours and its lock is free. Nothing is followed, made or written in it: the temporary folder is
/// everybody's.
fn is_dead(dir: &Path) -> bool {
    let about = |path: &Path| std::fs::symlink_metadata(path).ok();
    // Older versions made folders that others could look into; into none of ours could others write.
    let ours = |dir: &std::fs::Metadata| {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            dir.uid() == rustix::process::geteuid().as_raw() && dir.mode() & 0o022 == 0
        }
        #[cfg(not(unix))]
        return dir.is_dir();
    };
    let lock = dir.join(LOCK);
    about(dir).is_some_and(|d| d.is_dir() && ours(&d))
        && about(&lock).is_some_and(|l| l.is_file())
        && crate::io::open_regular(&lock).is_ok_and(|file| file.try_lock().is_ok())
}
