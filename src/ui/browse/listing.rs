//! What is in a folder: read on a thread of its own and in pieces, so that neither ten thousand files nor a disk that has to wake
//! up first hold the window.

use crate::io::in_words;
use crate::ui::browse::Wake;
use crate::ui::browse::names::in_order;
use std::cmp::Ordering;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant, SystemTime};

/// Entries of a folder that are read at most; whoever has more types a path.
const MOST: usize = 50_000;
/// How long entries are gathered before they are shown.
const PIECE: Duration = Duration::from_millis(100);

/// What an entry is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A folder.
    Folder,
    /// A folder that is a project of this program.
    Project,
    /// A regular file.
    File,
}

/// An entry of a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// As the system has it, whatever its encoding.
    pub name: OsString,
    /// What it is.
    pub kind: Kind,
    /// Of a file.
    pub bytes: u64,
    /// When it was written last.
    pub changed: Option<SystemTime>,
    /// What names are compared by.
    key: String,
}

/// What the list is sorted by; folders come first all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// By what.
    pub by: By,
    /// The largest, latest or last first.
    pub falling: bool,
}

/// A column of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// Name; numbers in it by their value.
    Name,
    /// Bytes.
    Size,
    /// When it was written last.
    Date,
}

impl Default for Order {
    fn default() -> Self {
        Self { by: By::Name, falling: false }
    }
}

impl Order {
    /// By a column, the usual way round: dates and sizes begin with the latest and the largest.
    pub const fn by(by: By) -> Self {
        Self { by, falling: !matches!(by, By::Name) }
    }

    pub(super) const fn turned(self) -> Self {
        Self { by: self.by, falling: !self.falling }
    }

    pub(super) fn sort(self, rows: &mut [usize], entries: &[Entry]) {
        let names = |a: &Entry, b: &Entry| a.key.cmp(&b.key).then_with(|| a.name.cmp(&b.name));
        let compare = |a: &Entry, b: &Entry| -> Ordering {
            let by = match self.by {
                By::Name => names(a, b),
                By::Size => a.bytes.cmp(&b.bytes),
                By::Date => a.changed.cmp(&b.changed),
            };
            if self.falling { by.reverse() } else { by }
        };
        rows.sort_by(|&a, &b| {
            let (a, b) = (&entries[a], &entries[b]);
            (a.kind != Kind::Folder).cmp(&(b.kind != Kind::Folder)).then(compare(a, b)).then_with(|| names(a, b))
        });
    }
}

/// How far a folder has been read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reading {
    /// There may be more.
    On,
    /// All of it.
    Whole,
    /// As much as is shown at most.
    Cut,
    /// Not: why, in a sentence.
    Failed(String),
}

enum Piece {
    Entries(Vec<Entry>),
    End(Reading),
}

/// A folder that is being read or was.
pub struct Listing {
    entries: Vec<Entry>,
    reading: Reading,
    pieces: Receiver<Piece>,
}

impl Listing {
    /// Begins to read a folder; the reader ends by itself when this is dropped.
    pub fn read(folder: &Path, wake: Wake) -> Self {
        let (sender, pieces) = channel();
        let path = folder.to_path_buf();
        let started = std::thread::Builder::new().name("folder".into()).spawn(move || {
            let end = read(&path, &sender, &wake);
            // Nobody there any more: another folder is shown.
            let _gone = sender.send(Piece::End(end));
            wake();
        });
        let reading = match started {
            Ok(_) => Reading::On,
            Err(error) => Reading::Failed(format!("This folder cannot be read: {}.", in_words(&error))),
        };
        Self { entries: Vec::new(), reading, pieces }
    }

    /// Takes in what was read meanwhile; answers whether anything was.
    pub fn poll(&mut self) -> bool {
        let mut news = false;
        for piece in self.pieces.try_iter() {
            news = true;
            match piece {
                Piece::Entries(mut entries) => self.entries.append(&mut entries),
                Piece::End(end) => self.reading = end,
            }
        }
        news
    }

    /// What was read so far, in no order.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// How far it is.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }
}

fn read(folder: &Path, to: &Sender<Piece>, wake: &Wake) -> Reading {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => return Reading::Failed(format!("This folder cannot be shown: {}.", in_words(&error))),
    };
    let (mut gathered, mut since, mut count) = (Vec::new(), Instant::now(), 0);
    let mut end = Reading::Whole;
    for entry in entries.flatten() {
        if count == MOST {
            end = Reading::Cut;
            break;
        }
        let Some(entry) = look(&entry.path(), entry.file_name()) else { continue };
        gathered.push(entry);
        count += 1;
        if since.elapsed() > PIECE {
            if to.send(Piece::Entries(std::mem::take(&mut gathered))).is_err() {
                return end;
            }
            wake();
            since = Instant::now();
        }
    }
    // Nobody there any more: the end says so to nobody, too.
    let _gone = to.send(Piece::Entries(gathered));
    end
}

/// Only what can be opened or gone into: no devices, pipes and links to nothing.
fn look(path: &Path, name: OsString) -> Option<Entry> {
    let about = std::fs::metadata(path).ok()?;
    let kind = match (about.is_dir(), about.is_file()) {
        (true, _) if is_project(path) => Kind::Project,
        (true, _) => Kind::Folder,
        (_, true) => Kind::File,
        _ => return None,
    };
    let key = in_order(&name);
    Some(Entry {
        name,
        kind,
        bytes: if kind == Kind::File { about.len() } else { 0 },
        changed: about.modified().ok(),
        key,
    })
}

/// A project has its manifest, or at least its name: one that lost its manifest is for the document to judge.
pub(super) fn is_project(folder: &Path) -> bool {
    let named = folder.extension().is_some_and(|e| e.eq_ignore_ascii_case(OsStr::new("burin")));
    folder.join("project.json").is_file() || (named && std::fs::read_dir(folder).is_ok_and(|mut e| e.next().is_some()))
}
