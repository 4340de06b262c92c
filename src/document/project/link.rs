//! The link of a project to the files that hold its density: by path, by the way from the project, by length and hash.
//!
//! A project that was moved together with its source finds it by the way between them; one whose source is elsewhere says which
//! file it wants, by length and hash. Knows nothing of voxels.

use crate::document::disk::error::KeepError;
use crate::document::disk::source_files::{SourceFiles, hash_one};
use crate::io::FileMark;
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Files that must be the same when they are read again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Link {
    /// Absolute.
    path: PathBuf,
    /// From the project's folder to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    relative: Option<PathBuf>,
    #[serde(flatten)]
    file: Known,
    /// The other files that it names, in the reader's order; missing in older projects.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    others: Vec<Known>,
}

/// What is known of a file's bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Known {
    bytes: u64,
    /// Nanoseconds since 1970; for a link that lives only until the next start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modified_ns: Option<u64>,
    /// Of all of it; for a link that lasts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    blake3: Option<String>,
}

impl Link {
    /// A link that lasts, from a project's folder to files that are as they were opened; waits for their hash.
    pub(crate) fn to(files: &SourceFiles, project: &Path, proceed: &dyn Fn() -> bool) -> Result<Self, KeepError> {
        let hashes = files.unchanged(proceed)?;
        let known =
            |(mark, hash): (&FileMark, String)| Known { bytes: mark.bytes, modified_ns: None, blake3: Some(hash) };
        let mut all = files.files().iter().zip(hashes).map(known);
        let path = absolute(files.path())?;
        let relative = std::fs::canonicalize(project).ok().and_then(|dir| way(&dir, &path));
        match all.next() {
            Some(file) => Ok(Self { path, relative, file, others: all.collect() }),
            None => Err(KeepError::NoPath),
        }
    }

    /// A link for the next start: the files as they were opened, by length and time.
    pub(crate) fn until_next_start(files: &[FileMark]) -> Result<Self, KeepError> {
        let known = |mark: &FileMark| Known { bytes: mark.bytes, modified_ns: mark.modified_ns, blake3: None };
        match files {
            [first, others @ ..] => Ok(Self {
                path: absolute(&first.path)?,
                relative: None,
                file: known(first),
                others: others.iter().map(known).collect(),
            }),
            [] => Err(KeepError::NoPath),
        }
    }

    /// The files, as far as lengths tell; their hashes are being compared from here on. A file that is `given` is compared now.
    pub(crate) fn find(&self, project: &Path, given: Option<&Path>) -> Result<Arc<SourceFiles>, KeepError> {
        let expected: Vec<Option<String>> = self.all().map(|known| known.blake3.clone()).collect();
        if let Some(path) = given {
            let marks = self.marks(path)?;
            for (mark, known) in marks.iter().zip(self.all()) {
                hash_one(mark, known.blake3.as_deref(), &|| false).map_err(|trouble| self.not_it(trouble.error()))?;
            }
            return Ok(SourceFiles::expecting(marks, expected));
        }
        let beside = self.relative.as_ref().and_then(|way| std::fs::canonicalize(project.join(way)).ok());
        let mut found: Vec<Vec<FileMark>> = Vec::new();
        let mut first = None;
        for path in beside.iter().chain([&self.path]) {
            match self.marks(path) {
                Ok(marks) if found.iter().any(|known| known[0].is_same_file(&marks[0])) => {}
                Ok(marks) => found.push(marks),
                Err(error) if path == &self.path || matches!(error, KeepError::SourceChanged { .. }) => {
                    first.get_or_insert(error);
                }
                Err(_) => {}
            }
        }
        // Two files of the right length: only one of them may be it.
        if found.len() > 1 {
            let is_it = |marks: &Vec<FileMark>| {
                marks.iter().zip(self.all()).all(|(m, k)| hash_one(m, k.blake3.as_deref(), &|| false).is_ok())
            };
            let at = found.iter().position(is_it).unwrap_or(0);
            found.swap(0, at);
        }
        match (found.into_iter().next(), first) {
            (Some(marks), _) => Ok(SourceFiles::expecting(marks, expected)),
            (None, Some(error @ KeepError::SourceChanged { .. })) => Err(error),
            (None, error) => Err(KeepError::SourceMissing {
                path: self.path.clone(),
                reason: match error {
                    Some(KeepError::Io { source, .. }) => crate::io::in_words(&source),
                    Some(other) => crate::io::without_numbers(&other.to_string()),
                    None => "not found".into(),
                },
                bytes: self.file.bytes,
                blake3: self.file.blake3.clone().unwrap_or_else(|| "unknown".into()),
            }),
        }
    }

    fn all(&self) -> impl Iterator<Item = &Known> {
        std::iter::once(&self.file).chain(&self.others)
    }

    /// The files behind a path; an error if they cannot be those that are linked.
    fn marks(&self, path: &Path) -> Result<Vec<FileMark>, KeepError> {
        let mark = FileMark::of(path).map_err(KeepError::io("read", path))?;
        self.compare(&mark, &self.file)?;
        if self.others.is_empty() {
            return Ok(vec![mark]);
        }
        let refused =
            |e: crate::io::IoError| self.changed(path, "header", e.to_string(), "one that can be read".into());
        let files = crate::io::open(path).map_err(refused)?.files;
        if files.len() != self.others.len() + 1 {
            let (found, expected) = (files.len().to_string(), (self.others.len() + 1).to_string());
            return Err(self.changed(path, "files", found, expected));
        }
        files.iter().zip(self.all()).try_for_each(|(mark, known)| self.compare(mark, known))?;
        Ok(files)
    }

    fn compare(&self, mark: &FileMark, known: &Known) -> Result<(), KeepError> {
        if mark.bytes != known.bytes {
            return Err(self.changed(&mark.path, "bytes", mark.bytes.to_string(), known.bytes.to_string()));
        }
        match (known.modified_ns, mark.modified_ns) {
            (Some(expected), Some(found)) if expected != found => {
                Err(self.changed(&mark.path, "modified_ns", found.to_string(), expected.to_string()))
            }
            _ => Ok(()),
        }
    }

    fn changed(&self, path: &Path, field: &'static str, found: String, expected: String) -> KeepError {
        KeepError::SourceChanged { path: path.to_owned(), field, found, expected }
    }

    /// Says of a file that was given what is said of one that was found.
    fn not_it(&self, error: KeepError) -> KeepError {
        match error {
            KeepError::LinkLost { path, field, found, expected } => {
                KeepError::SourceChanged { path, field, found, expected }
            }
            other => other,
        }
    }
}

fn absolute(path: &Path) -> Result<PathBuf, KeepError> {
    let path = std::fs::canonicalize(path).map_err(KeepError::io("read", path))?;
    match path.to_str() {
        Some(_) => Ok(path),
        None => Err(KeepError::NotUtf8 { path }),
    }
}

/// The way from a folder to a file, both absolute; `None` if they have nothing in common.
fn way(from: &Path, to: &Path) -> Option<PathBuf> {
    let mut from = from.components().peekable();
    let mut to = to.components().peekable();
    if from.peek() != to.peek() {
        return None;
    }
    while from.peek().is_some() && from.peek() == to.peek() {
        from.next();
        to.next();
    }
    Some(from.map(|_| Component::ParentDir).chain(to).collect())
}
