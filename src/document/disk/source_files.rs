//! The files behind a document's density: known as they were when they were opened, and by their hash.
//!
//! The hash is taken on a thread of its own, so that a picture need not wait for it; whoever writes a link does. Of a linked project
//! the hash is compared with the one that was saved. A file that is not what it was is never linked. Knows no project.

use crate::document::disk::error::KeepError;
use crate::io::{FileMark, open_regular};
use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Bytes read between two looks at whether anybody still wants the hash.
const PIECE: usize = 1 << 20;
/// How often whoever waits is asked whether to go on.
const LOOK: Duration = Duration::from_millis(50);

/// What is wrong with a file behind the density.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Trouble {
    file: String,
    field: &'static str,
    found: String,
    expected: String,
}

impl Trouble {
    pub(crate) fn error(self) -> KeepError {
        let Self { file, field, found, expected } = self;
        KeepError::LinkLost { path: file.into(), field, found, expected }
    }
}

/// The files that a volume is read from: length and time as opened, and their hash (blake3), which a thread of its own takes.
#[derive(Debug)]
pub struct SourceFiles {
    files: Vec<FileMark>,
    is_compared: bool,
    work: Arc<Work>,
}

#[derive(Debug, Default)]
struct Work {
    stop: AtomicBool,
    done: Mutex<Option<Result<Vec<String>, Trouble>>>,
    told: Condvar,
}

impl SourceFiles {
    /// Files that were just opened, the one that was named first.
    pub fn opened(files: Vec<FileMark>) -> Arc<Self> {
        Self::expecting(files, Vec::new())
    }

    /// The same, of which these hashes are expected, as far as they are known.
    pub(crate) fn expecting(files: Vec<FileMark>, expected: Vec<Option<String>>) -> Arc<Self> {
        let is_compared = expected.iter().any(Option::is_some);
        let work = Arc::<Work>::default();
        let (marks, theirs) = (files.clone(), work.clone());
        let hash = move || {
            let done = hash_all(&marks, &expected, &theirs.stop);
            *theirs.done.lock().unwrap_or_else(PoisonError::into_inner) = done;
            theirs.told.notify_all();
        };
        // Without a thread it is done here and now.
        let hash = Arc::new(Mutex::new(Some(hash)));
        let run = move || {
            let task = hash.lock().unwrap_or_else(PoisonError::into_inner).take();
            task.into_iter().for_each(|hash| hash());
        };
        if std::thread::Builder::new().name("hash".into()).spawn(run.clone()).is_err() {
            run();
        }
        Arc::new(Self { files, is_compared, work })
    }

    /// The file that was named.
    pub fn path(&self) -> &Path {
        self.files.first().map_or(Path::new(""), |file| &file.path)
    }

    /// All of them, as they were when they were opened.
    pub fn files(&self) -> &[FileMark] {
        &self.files
    }

    /// Whether the hash is compared with one that was saved.
    pub fn is_compared(&self) -> bool {
        self.is_compared
    }

    /// Whether the hash is still being taken.
    pub fn is_pending(&self) -> bool {
        self.work.done.lock().unwrap_or_else(PoisonError::into_inner).is_none()
    }

    /// What is wrong with the files as far as is known now, without waiting.
    pub fn trouble(&self) -> Option<String> {
        let done = self.work.done.lock().unwrap_or_else(PoisonError::into_inner);
        done.as_ref()?.as_ref().err().map(|trouble| trouble.clone().error().to_string())
    }

    /// Waits for the hashes; `go_on` is asked meanwhile.
    ///
    /// # Errors
    /// If a file is not what it was, or `go_on` said no.
    pub(crate) fn hashes(&self, proceed: &dyn Fn() -> bool) -> Result<Vec<String>, KeepError> {
        let mut done = self.work.done.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(done) = &*done {
                return done.clone().map_err(Trouble::error);
            }
            if !proceed() {
                return Err(KeepError::Stopped);
            }
            done = self.work.told.wait_timeout(done, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// The hashes, once the files are known to be at their places as they were opened.
    ///
    /// # Errors
    /// As [`hashes`](Self::hashes).
    pub(crate) fn unchanged(&self, proceed: &dyn Fn() -> bool) -> Result<Vec<String>, KeepError> {
        let hashes = self.hashes(proceed)?;
        for (file, hash) in self.files.iter().zip(&hashes) {
            still(file, hash, proceed)?;
        }
        Ok(hashes)
    }
}

impl Drop for SourceFiles {
    fn drop(&mut self) {
        self.work.stop.store(true, Ordering::Relaxed);
    }
}

/// Fails unless what lies at a file's place has the bytes that were opened.
fn still(file: &FileMark, hash: &str, proceed: &dyn Fn() -> bool) -> Result<(), KeepError> {
    let now = FileMark::of(&file.path).map_err(|e| unreadable(&file.path, &e).error())?;
    // A name or a right that changed leaves the bytes what they are: they are looked at again.
    if now == *file {
        return Ok(());
    }
    let stop = || !proceed();
    match hash_one(&now, Some(hash), &stop) {
        Ok(Some(_)) => Ok(()),
        Ok(None) => Err(KeepError::Stopped),
        Err(trouble) => Err(trouble.error()),
    }
}

fn hash_all(
    files: &[FileMark],
    expected: &[Option<String>],
    stop: &AtomicBool,
) -> Option<Result<Vec<String>, Trouble>> {
    let mut hashes = Vec::new();
    for (i, file) in files.iter().enumerate() {
        let expected = expected.get(i).and_then(Option::as_deref);
        match hash_one(file, expected, &|| stop.load(Ordering::Relaxed)) {
            Ok(Some(hash)) => hashes.push(hash),
            Ok(None) => return None,
            Err(trouble) => return Some(Err(trouble)),
        }
    }
    Some(Ok(hashes))
}

/// The hash of a file that is, before and after, what its mark says; `None` if nobody wants it any more.
pub(crate) fn hash_one(
    mark: &FileMark,
    expected: Option<&str>,
    stop: &dyn Fn() -> bool,
) -> Result<Option<String>, Trouble> {
    let refused = |e: std::io::Error| unreadable(&mark.path, &e);
    let mut file = open_regular(&mark.path).map_err(refused)?;
    same(mark, &FileMark::of_open(&mark.path, &file).map_err(refused)?)?;
    let mut hasher = blake3::Hasher::new();
    let mut piece = vec![0; PIECE];
    loop {
        if stop() {
            return Ok(None);
        }
        match file.read(&mut piece).map_err(refused)? {
            0 => break,
            n => hasher.update(&piece[..n]),
        };
    }
    same(mark, &FileMark::of_open(&mark.path, &file).map_err(refused)?)?;
    let found = hasher.finalize().to_hex().to_string();
    match expected {
        Some(expected) if expected != found => Err(trouble(&mark.path, "blake3", found, expected)),
        _ => Ok(Some(found)),
    }
}

fn same(mark: &FileMark, now: &FileMark) -> Result<(), Trouble> {
    let differs = |field, found: &dyn std::fmt::Debug, expected: &dyn std::fmt::Debug| {
        Err(trouble(&mark.path, field, format!("{found:?}"), format!("{expected:?}")))
    };
    if mark == now {
        Ok(())
    } else if mark.bytes != now.bytes {
        differs("bytes", &now.bytes, &mark.bytes)
    } else if mark.place != now.place {
        Err(trouble(&mark.path, "file", "another one of that name".into(), "the one that was opened"))
    } else {
        Err(trouble(&mark.path, "file", "one that was written to".into(), "the one that was opened, unchanged"))
    }
}

fn trouble(path: &Path, field: &'static str, found: String, expected: impl Into<String>) -> Trouble {
    Trouble { file: path.display().to_string(), field, found, expected: expected.into() }
}

fn unreadable(path: &Path, error: &std::io::Error) -> Trouble {
    trouble(path, "file", error.to_string(), "the one that was opened")
}
