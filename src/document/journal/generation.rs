//! A save and its journal: each generation of a project has one of its own, begun before the generation is the current one.
//!
//! Owns the journals' names and which of them are superseded; steps that nobody has read are put aside, never removed.

use crate::document::disk::error::KeepError;
use crate::document::journal::Journal;
use crate::document::journal::now::Beginning;
use crate::document::journal::replay::free_aside;
use crate::document::project::manifest::{JOURNAL_HEADER, Manifest};
use crate::document::project::store::{Committed, Store, ToKeep};
use crate::document::scene::kept_poses::SavedPoses;
use std::path::Path;

/// Saves and starts the journal of the new generation.
pub(super) fn save_into(
    store: &mut Store,
    kept: &ToKeep<'_>,
    poses: &SavedPoses,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Committed<Journal>, KeepError> {
    let dir = store.dir().to_owned();
    // Before the rename, so that there is no moment at which a generation is current and nothing can be noted.
    let state = kept.state;
    let start = |generation, manifest: &Manifest| {
        let path = dir.join(journal_name(generation));
        // Of a generation that is no more; whatever steps are in it are somebody's.
        if path.symlink_metadata().is_ok_and(|about| about.is_file() && about.len() > JOURNAL_HEADER) {
            std::fs::rename(&path, free_aside(&path)).map_err(KeepError::io("set aside", &path))?;
        }
        Journal::create(&path, Beginning { scene: &state.scene, ..Beginning::of(manifest) })
    };
    let (before, next) = (store.generation(), store.next_generation());
    let committed = store.save(kept, poses, start, progress).inspect_err(|_| {
        // Its generation is not.
        let _ = std::fs::remove_file(dir.join(journal_name(next)));
    })?;
    // A power cut could bring the old generation back, which is nothing without its journal.
    if committed.doubt.is_none() {
        remove_older_journals(&dir, before, committed.saved.generation);
    }
    Ok(committed)
}

pub(super) fn journal_name(generation: u64) -> String {
    format!("journal-{generation:06}")
}

/// Journals of generations up to the one that was `read` are superseded by the current one; steps of others, that nobody has read,
/// are put aside. What was put aside stays.
pub(super) fn remove_older_journals(dir: &Path, read: u64, current: u64) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let left = name.strip_prefix("journal-").map(|rest| rest.split('.').collect::<Vec<_>>());
        let number = match left.as_deref() {
            Some([number] | [number, "gathered" | "alone" | "poses" | "poses-new"]) => {
                number.parse().ok().filter(|&n: &u64| n < current)
            }
            _ => None,
        };
        let Some(number) = number else { continue };
        let path = entry.path();
        let unread = number > read && entry.metadata().is_ok_and(|about| about.len() > JOURNAL_HEADER);
        let gone = if unread { std::fs::rename(&path, free_aside(&path)) } else { std::fs::remove_file(&path) };
        gone.unwrap_or_else(|e| tracing::warn!("{}: {e}", path.display()));
    }
}
