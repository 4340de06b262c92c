//! A small file browser, for systems that show no file dialog of their own: everything about it but its drawing.
//!
//! One field takes names and paths, and is the keyboard's home: typing jumps to the first entry that begins so, the arrows move
//! through the list, Enter takes what was touched last. Owns the folder that is shown, what was typed and what is wrong with it;
//! an error never takes the text away. Knows no document and no egui.

pub(crate) mod glance;
pub(crate) mod listing;
pub(crate) mod names;
pub(crate) mod places;
pub(crate) mod taking;

pub use listing::{By, Entry, Kind, Listing, Order, Reading};
pub use names::{date, ends_with, resolve, shown, with_ending};
pub use places::{Place, places};

use crate::io::in_words;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Called from another thread when there is something new to show.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// What is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asks {
    /// Something that is there: a file, or a project's folder.
    Open,
    /// A file to be written.
    SaveFile,
    /// A folder to be made or filled.
    SaveFolder,
}

/// What the browser is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Purpose {
    /// What is chosen.
    pub asks: Asks,
    /// Endings of the files that are shown, lower case with their dot; a file to be written gets the first if it has none.
    pub endings: &'static [&'static str],
}

/// A folder that is shown, the text that is typed, and what was chosen of both.
pub struct Browser {
    purpose: Purpose,
    home: Option<PathBuf>,
    wake: Wake,
    folder: PathBuf,
    listing: Listing,
    /// Entries of the listing that are shown, in order.
    rows: Vec<usize>,
    at: Option<OsString>,
    /// The list was touched after the field.
    by_list: bool,
    moved: bool,
    fresh: bool,
    text: String,
    suggested: String,
    order: Order,
    all_files: bool,
    hidden: bool,
    error: Option<String>,
    replace: Option<PathBuf>,
    new_folder: Option<String>,
}

impl Browser {
    /// Shows a folder, or the nearest one above it that is there; `name` is what a file or folder to be written is called first.
    pub fn new(purpose: Purpose, folder: &Path, name: &str, home: Option<PathBuf>, wake: Wake) -> Self {
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
        let there = folder.ancestors().find(|f| f.is_dir()).map(Path::to_path_buf);
        let folder = there.or_else(|| home.clone()).unwrap_or_else(|| PathBuf::from("/"));
        let listing = Listing::read(&folder, wake.clone());
        Self {
            purpose,
            home,
            wake,
            folder,
            listing,
            rows: Vec::new(),
            at: None,
            by_list: false,
            moved: false,
            fresh: !name.is_empty(),
            text: name.to_owned(),
            suggested: name.to_owned(),
            order: Order::default(),
            all_files: false,
            hidden: false,
            error: None,
            replace: None,
            new_folder: None,
        }
    }

    /// What it is for.
    pub fn purpose(&self) -> Purpose {
        self.purpose
    }

    /// The folder that is shown.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What stands in the field.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What is wrong, in a sentence.
    pub fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// Says what is wrong; what was typed stays.
    pub fn fail(&mut self, error: String) {
        self.error = Some(error);
        self.replace = None;
    }

    /// The file that is there already and would be written over.
    pub fn replaces(&self) -> Option<&Path> {
        self.replace.as_deref()
    }

    /// The name of a folder to be made, while it is typed.
    pub fn new_folder(&self) -> Option<&str> {
        self.new_folder.as_deref()
    }

    /// How the list is sorted.
    pub fn order(&self) -> Order {
        self.order
    }

    /// Whether the field has its first name still, and this is asked for the first time.
    pub fn take_fresh(&mut self) -> bool {
        std::mem::take(&mut self.fresh)
    }

    /// How far the folder has been read.
    pub fn reading(&self) -> &Reading {
        self.listing.reading()
    }

    /// How many entries are shown.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// One of the entries that are shown.
    pub fn entry(&self, row: usize) -> Option<&Entry> {
        self.listing.entries().get(*self.rows.get(row)?)
    }

    /// The row that is chosen.
    pub fn row(&self) -> Option<usize> {
        let at = self.at.as_ref()?;
        self.rows.iter().position(|&i| self.listing.entries()[i].name == *at)
    }

    /// Whether the chosen row has changed since the last time this was asked, and should be in sight.
    pub fn take_moved(&mut self) -> bool {
        std::mem::take(&mut self.moved)
    }

    /// Whether files of all kinds are shown, and hidden ones.
    pub fn shows(&self) -> (bool, bool) {
        (self.all_files, self.hidden)
    }

    /// Shows files of all kinds, and hidden ones, or not.
    pub fn show(&mut self, all_files: bool, hidden: bool) {
        (self.all_files, self.hidden) = (all_files, hidden);
        self.arrange();
    }

    /// Sorts by a column; by the same once more, the other way round.
    pub fn sort(&mut self, order: Order) {
        self.order = if self.order == order { order.turned() } else { order };
        self.arrange();
    }

    /// Takes in what was read meanwhile.
    pub fn poll(&mut self) {
        if self.listing.poll() {
            self.arrange();
            if !self.by_list {
                self.jump();
            }
        }
    }

    fn arrange(&mut self) {
        let entries = self.listing.entries();
        let (purpose, all, hidden) = (self.purpose, self.all_files, self.hidden);
        let seen = |e: &Entry| {
            let dotted = e.name.as_encoded_bytes().first() == Some(&b'.');
            let wanted = e.kind != Kind::File
                || all
                || (purpose.asks != Asks::SaveFolder && ends_with(&e.name, purpose.endings));
            (hidden || !dotted) && wanted
        };
        self.rows = (0..entries.len()).filter(|&i| seen(&entries[i])).collect();
        self.order.sort(&mut self.rows, entries);
    }

    /// Reads the folder anew.
    pub fn refresh(&mut self) {
        self.listing = Listing::read(&self.folder, self.wake.clone());
        self.rows.clear();
    }

    /// Shows another folder. What is typed for a file to be written stays.
    pub fn go(&mut self, folder: &Path) {
        let inner = self.folder.strip_prefix(folder).ok().and_then(|rest| rest.components().next());
        // On the way up the folder that one comes from is where one was.
        self.at = inner.map(|c| c.as_os_str().to_owned());
        self.folder = folder.to_path_buf();
        self.by_list = false;
        self.moved = true;
        (self.error, self.replace, self.new_folder) = (None, None, None);
        if self.purpose.asks == Asks::Open {
            self.text.clear();
        }
        self.refresh();
    }

    /// Shows the folder above.
    pub fn up(&mut self) {
        if let Some(above) = self.folder.parent().map(Path::to_path_buf) {
            self.go(&above);
        }
    }

    /// The field was typed into: the first entry that begins so is chosen.
    pub fn type_text(&mut self, text: String) {
        self.text = text;
        self.by_list = false;
        (self.error, self.replace) = (None, None);
        self.jump();
    }

    fn jump(&mut self) {
        let wanted = self.text.to_lowercase();
        if wanted.is_empty() || self.purpose.asks != Asks::Open {
            return;
        }
        let named = |&&i: &&usize| self.listing.entries()[i].name.to_string_lossy().to_lowercase().starts_with(&wanted);
        self.at = self.rows.iter().find(named).map(|&i| self.listing.entries()[i].name.clone());
        self.moved = true;
    }

    /// Moves the choice by rows.
    pub fn step(&mut self, rows: isize) {
        let Some(last) = self.rows.len().checked_sub(1).filter(|_| rows != 0) else { return };
        let row = match self.row() {
            Some(row) => row.saturating_add_signed(rows).min(last),
            None if rows < 0 => last,
            None => (rows.unsigned_abs() - 1).min(last),
        };
        self.choose(row);
    }

    /// Chooses a row, as a click does.
    pub fn choose(&mut self, row: usize) {
        let Some(entry) = self.entry(row) else { return };
        let (name, kind) = (entry.name.clone(), entry.kind);
        // Only a name that is text can stand in the field.
        if kind == Kind::File
            && self.purpose.asks != Asks::Open
            && let Some(name) = name.to_str()
        {
            self.text = name.to_owned();
        }
        self.at = Some(name);
        self.by_list = true;
        self.moved = true;
        (self.error, self.replace) = (None, None);
    }

    /// The file that is there already may be written over.
    pub fn replace(&mut self) -> Option<PathBuf> {
        self.replace.take()
    }

    /// Escape: answers whether there was something smaller to leave than the whole browser.
    pub fn back_out(&mut self) -> bool {
        self.new_folder.take().is_some() || self.replace.take().is_some()
    }

    /// The name of a folder to be made is being typed.
    pub fn name_folder(&mut self, name: String) {
        if self.new_folder.as_ref() != Some(&name) {
            self.new_folder = Some(name);
            self.error = None;
        }
    }

    /// Makes the folder and goes there.
    pub fn make_folder(&mut self) {
        let Some(name) = self.new_folder.clone() else { return };
        let name = name.trim();
        let plain = Path::new(name).components().count() == 1 && Path::new(name).file_name() == Some(OsStr::new(name));
        if !plain {
            self.error = Some("Type one name for the folder, without “/”.".into());
            return;
        }
        let path = self.folder.join(name);
        match std::fs::create_dir(&path) {
            Ok(()) => self.go(&path),
            Err(error) => {
                self.error =
                    Some(format!("The folder “{}” was not made: {}.", shown(OsStr::new(name)), in_words(&error)));
            }
        }
    }
}
