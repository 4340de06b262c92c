//! What Enter means: a folder is gone into, a file is taken, a name that is written over is asked about.

use crate::io::in_words;
use crate::ui::browse::listing::Kind;
use crate::ui::browse::names::{ends_with, resolve, shown, with_ending};
use crate::ui::browse::{Asks, Browser, Purpose, Wake, listing};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The ending of a project's folder.
const PROJECT: &str = ".burin";

impl Browser {
    /// A path for a file to be written that another dialog has asked for, with an ending if it has none.
    ///
    /// # Errors
    /// A browser that asks, where the ending makes of it the name of something that is there already: nobody was asked about that.
    pub fn given(purpose: Purpose, path: &Path, home: Option<PathBuf>, wake: Wake) -> Result<PathBuf, Box<Self>> {
        let whole = with_ending(path.to_path_buf(), purpose.endings);
        if whole == path || !whole.exists() {
            return Ok(whole);
        }
        let folder = whole.parent().unwrap_or(Path::new("."));
        let mut browser = Box::new(Self::new(purpose, folder, &entry_name(&whole).to_string_lossy(), home, wake));
        browser.for_writing(whole).ok_or(browser)
    }

    /// Enter: answers the path that was chosen, if there is one to be had; a folder is gone into instead.
    pub fn enter(&mut self) -> Option<PathBuf> {
        self.error = None;
        if self.by_list || self.text.trim().is_empty() {
            return self.activate();
        }
        match resolve(self.name_typed(), &self.folder, self.home.as_deref()) {
            Ok(path) => self.typed(path),
            Err(error) => {
                self.fail(error);
                None
            }
        }
    }

    /// The ending of the name that is offered, which stays while the rest is typed over; empty if it has none.
    pub(crate) fn ending_offered(&self) -> &'static str {
        let known = self.purpose.endings.iter().copied().chain([PROJECT]);
        known.filter(|e| ends_with(self.suggested.as_ref(), &[e])).max_by_key(|e| e.len()).unwrap_or_default()
    }

    /// What was typed, where an ending of one's own stands before the offered one without that one.
    fn name_typed(&self) -> &str {
        let ending = self.ending_offered();
        let cut = self.text.len().saturating_sub(ending.len());
        let own = [self.purpose.endings, &[ending]].concat();
        match self.text.get(..cut) {
            Some(left) if !ending.is_empty() && self.text.ends_with(ending) && ends_with(left.as_ref(), &own) => left,
            _ => &self.text,
        }
    }

    /// What a double click does.
    pub fn activate(&mut self) -> Option<PathBuf> {
        let entry = self.row().and_then(|row| self.entry(row))?;
        let (path, kind) = (self.folder.join(&entry.name), entry.kind);
        match (kind, self.purpose.asks) {
            (Kind::Folder, _) | (Kind::Project, Asks::SaveFile) => {
                self.go(&path);
                None
            }
            (Kind::Project | Kind::File, Asks::Open) => Some(path),
            (Kind::File, Asks::SaveFile) => self.for_writing(path),
            (Kind::Project | Kind::File, Asks::SaveFolder) => {
                self.fail(format!("“{}” is there already. Type another name.", shown(&entry_name(&path))));
                None
            }
        }
    }

    fn typed(&mut self, path: PathBuf) -> Option<PathBuf> {
        let about = std::fs::metadata(&path);
        let named = shown(&entry_name(&path));
        match (self.purpose.asks, about) {
            (Asks::Open, Ok(about)) if about.is_dir() && !listing::is_project(&path) => {
                self.go(&path);
                None
            }
            (Asks::Open, Ok(_)) => Some(path),
            // What was jumped to is meant where the text is no whole name.
            (Asks::Open, Err(error)) if error.kind() == std::io::ErrorKind::NotFound => {
                if self.row().is_some() {
                    return self.activate();
                }
                if path.parent() != Some(&self.folder) {
                    // A path of its own is taken at its word: who opens it says what is wrong.
                    return Some(path);
                }
                self.fail(format!("There is no “{named}” in this folder."));
                None
            }
            (Asks::SaveFile, Ok(about)) if about.is_dir() => {
                self.go(&path);
                self.text.clone_from(&self.suggested);
                None
            }
            (Asks::SaveFile, Ok(_)) => self.for_writing(path),
            (Asks::SaveFolder, Ok(about)) if about.is_dir() => {
                let empty = std::fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_none());
                if empty || listing::is_project(&path) {
                    // Whether a project may be saved over another is the document's to say.
                    return Some(path);
                }
                self.go(&path);
                self.text.clone_from(&self.suggested);
                None
            }
            (Asks::SaveFolder, Ok(_)) => {
                self.fail(format!("“{named}” is a file there. Type another name."));
                None
            }
            (Asks::SaveFile | Asks::SaveFolder, Err(error)) if error.kind() == std::io::ErrorKind::NotFound => {
                if path.file_name().is_none() {
                    self.fail("Type a name.".into());
                    return None;
                }
                match path.parent() {
                    Some(parent) if !parent.is_dir() => {
                        self.fail(format!("There is no folder {}.", shown(parent.as_os_str())));
                        None
                    }
                    _ if self.purpose.asks == Asks::SaveFile => self.for_writing(path),
                    _ => Some(path),
                }
            }
            (_, Err(error)) => {
                self.fail(format!("“{named}” cannot be used: {}.", in_words(&error)));
                None
            }
        }
    }

    /// A file to be written gets an ending; what is there already is asked about.
    fn for_writing(&mut self, path: PathBuf) -> Option<PathBuf> {
        let path = with_ending(path, self.purpose.endings);
        match std::fs::metadata(&path) {
            Ok(about) if about.is_file() => {
                self.replace = Some(path);
                None
            }
            Ok(_) => {
                self.fail(format!("“{}” is no file. Type another name.", shown(&entry_name(&path))));
                None
            }
            // Whatever else is wrong with it is told by who writes.
            Err(_) => Some(path),
        }
    }
}

fn entry_name(path: &Path) -> OsString {
    path.file_name().unwrap_or(path.as_os_str()).to_owned()
}
