//! Documents that were never saved: their journals, in a folder of the user's own.
//!
//! Each has a folder with a lock, a `generation.json` that links the opened file, and a journal. A process that ends well
//! removes its folder; what a crash leaves is offered at the next start. Whoever calls names the place; for programs it is
//! [`state_dir`].

use crate::document::command::answers::Lost;
use crate::document::disk::error::KeepError;
use crate::document::disk::files::{create_dir, remove_dir};
use crate::document::disk::inside;
use crate::document::disk::lock::Lock;
use crate::document::journal::Journal;
use crate::document::project::manifest::Manifest;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The journal's name in a recovery folder.
pub(crate) const JOURNAL: &str = "journal";
const FOLDER: &str = "recovery";

/// What crashes left behind, the latest first. Documents that are open in some process are not lost. What cannot be read is
/// left out, and told by `tracing`.
///
/// # Errors
/// If the folder is there and cannot be read.
pub fn list(state_dir: &Path) -> Result<Vec<Lost>, KeepError> {
    let dir = state_dir.join(FOLDER);
    let entries = match std::fs::read_dir(&dir) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(KeepError::io("read", &dir))?,
    };
    let mut lost: Vec<Lost> = entries.flatten().filter_map(|e| look(&e.path())).collect();
    lost.sort_by(|a, b| b.changed.cmp(&a.changed).then_with(|| a.id.cmp(&b.id)));
    Ok(lost)
}

/// Throws a lost document away.
///
/// # Errors
/// If it is open, or the system refuses.
pub fn discard(state_dir: &Path, id: &str) -> Result<(), KeepError> {
    let dir = folder(state_dir, id)?;
    let _lock = Lock::take(&dir)?;
    remove_dir(&dir)
}

fn look(dir: &Path) -> Option<Lost> {
    let id = dir.file_name()?.to_str()?.to_owned();
    inside::check_folder(dir).ok()?;
    let _lock = Lock::take(dir).ok()?;
    let about = std::fs::symlink_metadata(dir.join(JOURNAL)).ok().filter(std::fs::Metadata::is_file)?;
    let manifest = Manifest::read(dir).map_err(|e| tracing::warn!("{e}")).ok()?;
    // A crash before the first step of work lost nothing. What cannot be looked into may be work.
    if !Journal::holds_work(&dir.join(JOURNAL)).unwrap_or(true) {
        remove_dir(dir).map_err(|e| tracing::warn!("{e}")).ok()?;
        return None;
    }
    let changed = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
    let origin =
        manifest.scene.volumes.all.values().next().map_or_else(PathBuf::new, |volume| volume.origin.path.clone());
    Some(Lost { id, origin, changed, bytes: about.len() })
}

/// A new folder for a document, locked.
pub(crate) fn create(state_dir: &Path) -> Result<(PathBuf, Lock), KeepError> {
    let all = state_dir.join(FOLDER);
    create_dir(&all)?;
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_nanos());
    let dir = all.join(format!("{now:x}-{:x}", std::process::id()));
    create_dir(&dir)?;
    // What was painted on is nobody else's to read.
    #[cfg(unix)]
    std::fs::set_permissions(&dir, std::os::unix::fs::PermissionsExt::from_mode(0o700))
        .map_err(KeepError::io("create", &dir))?;
    let lock = Lock::take(&dir)?;
    Ok((dir, lock))
}

/// The folder of a lost document.
pub(crate) fn folder(state_dir: &Path, id: &str) -> Result<PathBuf, KeepError> {
    let plain = !id.is_empty() && id.bytes().all(|b| b.is_ascii_hexdigit() || b == b'-');
    let dir = state_dir.join(FOLDER).join(id);
    if plain && inside::check_folder(&dir).is_ok() {
        Ok(dir)
    } else {
        Err(KeepError::NothingLost { id: id.to_owned() })
    }
}

/// Where programs keep unsaved documents: `$BURIN_STATE_DIR`, else `$XDG_STATE_HOME/burin`, else `~/.local/state/burin`
/// (`%LOCALAPPDATA%\burin` on Windows).
///
/// # Errors
/// If none of the variables is set.
pub fn state_dir() -> Result<PathBuf, KeepError> {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    set("BURIN_STATE_DIR")
        .or_else(|| set("XDG_STATE_HOME").map(|d| d.join("burin")))
        .or_else(|| if cfg!(windows) { set("LOCALAPPDATA").map(|d| d.join("burin")) } else { None })
        .or_else(|| set("HOME").map(|d| d.join(".local/state/burin")))
        .ok_or(KeepError::NoStateDir)
}
