//! Why something could not be kept or brought back. Nothing that was kept before is harmed by any of these.

use crate::volume::SourceError;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// See the module's head.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// The system refused.
    #[error("cannot {doing} {}: {source}; {}", path.display(), advice(source))]
    Io {
        /// What was tried: "write", "read", …
        doing: &'static str,
        /// File or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}: {field}: {found} found, {expected} expected; {MALFORMED}", path.display())]
    Malformed {
        /// File.
        path: PathBuf,
        /// Part of the file.
        field: String,
        /// What it held.
        found: String,
        /// What it should hold.
        expected: String,
    },
    /// The file was written by another version.
    #[error("{}: version: {found} found, {expected} expected; open it with the version of Burin that wrote it", path.display())]
    Version {
        /// File.
        path: PathBuf,
        /// Its version.
        found: u64,
        /// The one that is understood.
        expected: u64,
    },
    /// Somebody else has the project open.
    #[error(
        "{} is open in another window or script ({holder}); close it there, or save a copy of this document elsewhere",
        path.display()
    )]
    Locked {
        /// Project.
        path: PathBuf,
        /// Who, as the lock file says.
        holder: String,
    },
    /// No project there.
    #[error("{} is no project: project.json not found; choose a folder that Burin saved", path.display())]
    NotAProject {
        /// Folder.
        path: PathBuf,
    },
    /// A new project needs a place of its own.
    #[error("{} is not empty: {found} found, a new or an empty folder expected; choose another folder", path.display())]
    NotEmpty {
        /// Folder.
        path: PathBuf,
        /// The first thing in it.
        found: String,
    },
    /// The file that the density is linked to is not the one that was painted on.
    #[error(
        "{}: {field}: {found} found, {expected} expected; put the file back as it was when the document was kept",
        path.display()
    )]
    SourceChanged {
        /// File.
        path: PathBuf,
        /// `bytes`, `modified_ns` or `blake3`.
        field: &'static str,
        /// What it is now.
        found: String,
        /// What it was.
        expected: String,
    },
    /// The scene holds something that no file can bring back.
    #[error("the scene cannot be written: {reason}; undo the last change and save again")]
    Scene {
        /// What the writer said.
        reason: String,
    },
    /// The voxels behind the density failed.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The first save needs a place.
    #[error("the document was never saved: give a path (project.save path)")]
    NoPath,
    /// No such lost document.
    #[error("no lost document {id:?}; it was recovered or thrown away, or is one of another user")]
    NothingLost {
        /// What was asked for.
        id: String,
    },
    /// Nowhere to keep unsaved documents.
    #[error(
        "no folder for unsaved documents: none of BURIN_STATE_DIR, XDG_STATE_HOME and HOME is set; set one of them"
    )]
    NoStateDir,
    /// Who watched the progress said no.
    #[error("saving was stopped on request; the project is as it was")]
    Stopped,
}

const MALFORMED: &str = "restore the file from a copy";

fn advice(error: &std::io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "free some space or save elsewhere; what was saved before is intact"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "choose a folder that you may write to",
        ErrorKind::NotFound => "check that it is still there",
        _ => "check the disk and try again; what was saved before is intact",
    }
}

impl KeepError {
    /// For `map_err`: the system refused `doing` to `path`.
    pub(in crate::document) fn io(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { doing, path, source }
    }

    pub(in crate::document) fn malformed(
        path: &Path,
        field: impl Into<String>,
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            field: field.into(),
            found: found.to_string(),
            expected: expected.into(),
        }
    }
}
