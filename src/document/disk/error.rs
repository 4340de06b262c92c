//! Why something could not be kept or brought back. Nothing that was kept before is harmed by any of these.

use crate::io::in_words;
use crate::volume::SourceError;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Why something could not be written, read or taken on disk; each names the file and what to do.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// The system refused.
    #[error("cannot {doing} {}: {}; {}", path.display(), in_words(source), advice(source))]
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
    #[error("{}: {}", path.display(), crate::io::what_is(path))]
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
        "{}: {field}: {found} found, {expected} expected; put the file back as it was when the document was kept, or name \
         the one that it was as the source (project.open source)",
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
    /// A file that the density was read from is not what it was.
    #[error(
        "{}: {field}: {found} found, {expected} expected; a project that only names the file would open something else: \
         save with density \"whole\" to keep the voxels in the project, or put the file back as it was",
        path.display()
    )]
    LinkLost {
        /// File.
        path: PathBuf,
        /// `file`, `bytes` or `blake3`.
        field: &'static str,
        /// What it is now.
        found: String,
        /// What it was.
        expected: String,
    },
    /// The file that the density is linked to is nowhere.
    #[error(
        "{} holds the project's voxels and cannot be had ({reason}); a file of {bytes} bytes with blake3 {blake3} \
         expected: name it as the source (project.open source)",
        path.display()
    )]
    SourceMissing {
        /// Where it was.
        path: PathBuf,
        /// What the system said.
        reason: String,
        /// Its length.
        bytes: u64,
        /// Its hash.
        blake3: String,
    },
    /// The folder lost its `project.json`; what is in it is somebody's work.
    #[error(
        "{} holds a project already{}; open it (project.open) to go on with it, or save to another folder",
        path.display(),
        generation.map_or_else(String::new, |n| format!(", generation {n} of it"))
    )]
    LostProject {
        /// Folder.
        path: PathBuf,
        /// The newest generation in it.
        generation: Option<u64>,
    },
    /// The current generation is damaged, one before it is not.
    #[error("{source}; generation {whole} before it is whole: open that one (project.open generation {whole})")]
    Damaged {
        /// What is wrong.
        source: Box<KeepError>,
        /// The generation that can be opened.
        whole: u64,
    },
    /// A path that JSON cannot say.
    #[error(
        "{}: a name that is not UTF-8 found, UTF-8 expected: a project cannot name such a file; \
         save with density \"whole\", or rename the file or its folder",
        path.display()
    )]
    NotUtf8 {
        /// File.
        path: PathBuf,
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
    #[error("the document was never saved, or its project is open to look at only: give a path (project.save path)")]
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
        ErrorKind::NotADirectory => "choose a folder",
        ErrorKind::InvalidInput => "nothing in a project leads out of it: put the file itself there, or take it away",
        _ => "check the disk and try again; what was saved before is intact",
    }
}

impl KeepError {
    /// For `map_err`: the system refused `doing` to `path`.
    pub(crate) fn io(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { doing, path, source }
    }

    /// Whether it says only that nothing can be written there, for want of rights or room.
    pub(crate) fn is_unwritable(&self) -> bool {
        let refused = |kind| {
            use ErrorKind::{FileTooLarge, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
            matches!(kind, PermissionDenied | ReadOnlyFilesystem | StorageFull | QuotaExceeded | FileTooLarge)
        };
        matches!(self, Self::Io { doing, source, .. } if *doing != "read" && refused(source.kind()))
    }

    pub(crate) fn malformed(
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
