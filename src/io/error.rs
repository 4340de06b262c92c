//! What can go wrong with a file, in words that name the file, the field, what was found and what was expected.

use crate::io::words::in_words;
use crate::volume::SourceError;
use std::path::Path;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum IoError {
    /// The system refused.
    #[error("{file}: cannot {action}: {}", in_words(source))]
    System {
        /// File.
        file: String,
        /// What was tried, as a verb and its object.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file or folder that is known, and not read.
    #[error("{file}: this is {what}; {advice}")]
    Foreign {
        /// File or folder.
        file: String,
        /// What it is.
        what: String,
        /// What to do.
        advice: String,
    },
    /// No reader knows the file.
    #[error("{file}: format: found {found}; expected one of: {expected}")]
    Unknown {
        /// File.
        file: String,
        /// The first bytes, or what else is wrong.
        found: String,
        /// What could be read.
        expected: String,
    },
    /// A field of the header cannot be used, or not yet.
    #[error("{file}: {field}: found {found}; expected {expected}")]
    Field {
        /// File.
        file: String,
        /// Field of the header, by the format's own name for it.
        field: String,
        /// What is there.
        found: String,
        /// What could be used, or what to do.
        expected: String,
    },
    /// The file ends before its voxels do, or cannot hold them.
    #[error("{file}: voxel data: found {found}; expected {expected}; the file is cut off or its header is wrong")]
    Truncated {
        /// File.
        file: String,
        /// What there is.
        found: String,
        /// What the header asks for.
        expected: String,
    },
    /// The encoded data are damaged.
    #[error(
        "{file}: voxel data in {encoding}: found damage ({reason}); expected whole {encoding} data; get the file again"
    )]
    Damaged {
        /// File.
        file: String,
        /// What they are encoded in.
        encoding: &'static str,
        /// What the decoder said.
        reason: String,
    },
    /// Not enough memory.
    #[error("{file}: voxel data: found no memory for {bytes} bytes; close other volumes or open a smaller file")]
    OutOfMemory {
        /// File.
        file: String,
        /// Bytes asked for.
        bytes: u64,
    },
    /// A component or frame that the file does not have.
    #[error("{file}: {what}: found {count}; asked for number {asked}, counted from 0")]
    NoSuch {
        /// File.
        file: String,
        /// `components` or `frames`.
        what: &'static str,
        /// How many there are.
        count: u32,
        /// Which one was asked for.
        asked: u32,
    },
    /// The caller's `progress` said no.
    #[error("{file}: cancelled")]
    Cancelled {
        /// File.
        file: String,
    },
    /// Voxels could not be had while writing.
    #[error(transparent)]
    Source(#[from] SourceError),
}

impl IoError {
    pub(super) fn system(file: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let file = file.display().to_string();
        move |source| Self::System { file, action, source }
    }

    pub(super) fn field(
        file: &str,
        field: impl Into<String>,
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Field {
            file: file.into(),
            field: field.into(),
            found: shown(&found.to_string()),
            expected: expected.into(),
        }
    }
}

/// A found text, short and printable: headers may hold anything.
pub(super) fn shown(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars().take(80) {
        if c.is_control() { out.extend(c.escape_debug()) } else { out.push(c) }
    }
    if text.chars().nth(80).is_some() {
        out.push('…');
    }
    if out.is_empty() { "nothing".into() } else { out }
}
