//! Files and projects that were open lately, kept in a file of the user's own.
//!
//! The list is a comfort: whatever is wrong with its file costs the list and nothing else, and is told by `tracing` alone. It is
//! private, written whole or not at all, and read again before it is written, so that two windows do not undo each other.

use crate::document::OpenAs;
use crate::ui::browse::Wake;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{Error, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Entries that are kept.
const MOST: usize = 24;
/// Folders that are offered.
const FOLDERS: usize = 6;
/// Bytes that a list can have; a longer file is none.
const MOST_BYTES: u64 = 1 << 20;
const NAME: &str = "recent.json";

/// Something that was open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seen {
    /// A volume's file or a project's folder, absolute.
    pub path: PathBuf,
    /// Whether it is a project.
    pub project: bool,
    /// What the values of a volume were opened as.
    pub open_as: Option<OpenAs>,
    /// When it was opened or saved last.
    pub when: SystemTime,
}

/// Whether something is still there.
struct Found {
    path: PathBuf,
    there: bool,
}

/// The list of files and projects that were open lately, newest first, and who looks whether they are still there.
pub struct Recent {
    /// The folder of the list; without one nothing is kept.
    folder: Option<PathBuf>,
    entries: Vec<Seen>,
    there: BTreeMap<PathBuf, bool>,
    looked: (Sender<Found>, Receiver<Found>),
}

impl Default for Recent {
    /// An empty list that is kept nowhere.
    fn default() -> Self {
        Self { folder: None, entries: Vec::new(), there: BTreeMap::new(), looked: channel() }
    }
}

impl Recent {
    /// The list that is kept in a folder, which need not be there yet.
    pub fn kept_in(folder: PathBuf) -> Self {
        let entries = read(&folder.join(NAME));
        Self { folder: Some(folder), entries, ..Self::default() }
    }

    /// The last one first.
    pub fn entries(&self) -> &[Seen] {
        &self.entries
    }

    /// The folder that the list is kept in.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Whether a path lies where this program keeps its own things.
    pub fn owns(&self, path: &Path) -> bool {
        self.folder.as_ref().is_some_and(|folder| path.starts_with(folder))
    }

    /// Folders of what was open lately, the last one first.
    pub fn folders(&self) -> Vec<PathBuf> {
        let mut folders: Vec<PathBuf> = Vec::new();
        for parent in self.entries.iter().filter_map(|seen| seen.path.parent()) {
            if folders.len() < FOLDERS && !folders.iter().any(|f| f == parent) {
                folders.push(parent.to_path_buf());
            }
        }
        folders
    }

    /// Notes a project that was opened or saved now.
    pub fn note_project(&mut self, path: &Path) {
        self.note(path, true, None);
    }

    /// Notes a volume that was opened now, and as what.
    pub fn note_volume(&mut self, path: &Path, open_as: OpenAs) {
        self.note(path, false, Some(open_as));
    }

    fn note(&mut self, path: &Path, project: bool, open_as: Option<OpenAs>) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        if self.owns(&path) {
            return;
        }
        self.there.insert(path.clone(), true);
        self.change(|entries| {
            entries.retain(|seen| seen.path != path);
            entries.insert(0, Seen { path, project, open_as, when: SystemTime::now() });
            entries.truncate(MOST);
        });
    }

    /// Takes one out of the list.
    pub fn forget(&mut self, path: &Path) {
        self.change(|entries| entries.retain(|seen| seen.path != path));
    }

    /// Empties the list.
    pub fn forget_all(&mut self) {
        self.change(Vec::clear);
    }

    fn change(&mut self, change: impl FnOnce(&mut Vec<Seen>)) {
        if let Some(folder) = &self.folder {
            let file = folder.join(NAME);
            if file.exists() {
                self.entries = read(&file);
            }
        }
        change(&mut self.entries);
        if let Some(folder) = &self.folder
            && let Err(error) = write(folder, &self.entries)
        {
            tracing::warn!("{}: {error}", folder.join(NAME).display());
        }
    }

    /// Asks, on a thread of its own, which of them are still there: a disk that is away may take its time.
    pub fn look(&self, wake: Wake) {
        let paths: Vec<(PathBuf, bool)> = self.entries.iter().map(|s| (s.path.clone(), s.project)).collect();
        let back = self.looked.0.clone();
        let started = std::thread::Builder::new().name("recent".into()).spawn(move || {
            for (path, project) in paths {
                let there = std::fs::metadata(&path).is_ok_and(|about| about.is_dir() == project);
                if back.send(Found { path, there }).is_err() {
                    return;
                }
            }
            wake();
        });
        if let Err(error) = started {
            tracing::warn!("{error}");
        }
    }

    /// Takes in what the look has found.
    pub fn poll(&mut self) {
        for Found { path, there } in self.looked.1.try_iter() {
            self.there.insert(path, there);
        }
    }

    /// Whether it is gone, as far as anybody has looked.
    pub fn is_gone(&self, path: &Path) -> bool {
        self.there.get(path) == Some(&false)
    }
}

/// What can be made out of a list, entry by entry.
fn read(file: &Path) -> Vec<Seen> {
    let text = match whole(file) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Vec::new(),
        Err(error) => {
            tracing::warn!("{}: {error}", file.display());
            return Vec::new();
        }
    };
    let list: Value = serde_json::from_slice(&text).unwrap_or_else(|error| {
        tracing::warn!("{}: {error}", file.display());
        Value::Null
    });
    let entries = list["entries"].as_array().into_iter().flatten();
    let mut seen: Vec<Seen> = Vec::new();
    for entry in entries.filter_map(entry_of) {
        if seen.len() < MOST && !seen.iter().any(|s| s.path == entry.path) {
            seen.push(entry);
        }
    }
    seen
}

/// A regular file of a sensible length, and no link to something else.
fn whole(file: &Path) -> Result<Vec<u8>, Error> {
    let about = std::fs::symlink_metadata(file)?;
    if !about.is_file() || about.len() > MOST_BYTES {
        return Err(Error::other("no list of recent files"));
    }
    let mut text = Vec::new();
    std::fs::File::open(file)?.take(MOST_BYTES).read_to_end(&mut text)?;
    Ok(text)
}

fn entry_of(entry: &Value) -> Option<Seen> {
    let path = match &entry["path"] {
        Value::String(text) => PathBuf::from(text),
        Value::Array(bytes) => {
            let bytes = bytes.iter().map(|b| b.as_u64().and_then(|b| u8::try_from(b).ok()));
            PathBuf::from(from_bytes(bytes.collect::<Option<Vec<u8>>>()?)?)
        }
        _ => return None,
    };
    let seconds = entry["when"].as_u64().unwrap_or(0);
    let when = UNIX_EPOCH.checked_add(Duration::from_secs(seconds)).unwrap_or(UNIX_EPOCH);
    let open_as = serde_json::from_value(entry["as"].clone()).ok();
    path.is_absolute().then_some(Seen { path, project: entry["project"] == true, open_as, when })
}

fn write(folder: &Path, entries: &[Seen]) -> Result<(), Error> {
    let entries: Vec<Value> = entries
        .iter()
        .map(|seen| {
            // A name that is no text is kept as its bytes.
            let path = match seen.path.to_str() {
                Some(text) => json!(text),
                None => json!(seen.path.as_os_str().as_encoded_bytes()),
            };
            let when = seen.when.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
            json!({ "path": path, "project": seen.project, "as": seen.open_as, "when": when })
        })
        .collect();
    let text = serde_json::to_vec_pretty(&json!({ "version": 1, "entries": entries }))?;
    private_folder(folder)?;
    // Temporary files are for their owner alone, and so is what they are renamed to.
    let mut part = tempfile::Builder::new().prefix(".recent-").tempfile_in(folder)?;
    part.write_all(&text)?;
    part.as_file().sync_all()?;
    part.persist(folder.join(NAME))?;
    Ok(())
}

/// Makes a folder that others may not look into, if it is not there.
pub(crate) fn private_folder(folder: &Path) -> Result<(), Error> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

#[cfg(unix)]
fn from_bytes(bytes: Vec<u8>) -> Option<OsString> {
    Some(std::os::unix::ffi::OsStringExt::from_vec(bytes))
}

#[cfg(not(unix))]
fn from_bytes(bytes: Vec<u8>) -> Option<OsString> {
    String::from_utf8(bytes).ok().map(OsString::from)
}
