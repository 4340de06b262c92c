//! Why a command was refused. A command that fails has changed nothing.

use crate::explode::ExplodeError;
use crate::gpu::{GpuError, ImageError};
use crate::io::IoError;
use crate::paint::PaintError;
use crate::volume::{Segments, SourceError};

/// Why a command was refused: each says what was found, what was expected and what to do.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    /// The command needs an open document.
    #[error("nothing is open; open a volume (volume.open) or a project (project.open) first")]
    NothingOpen,
    /// The command needs a volume, and the document holds none.
    #[error(
        "this document holds no volume; add one (volume.add), or undo what took the last one away (history.undo) first"
    )]
    NoVolume,
    /// The command needs a GPU.
    #[error("{what} needs a GPU, and there is none: {reason}")]
    NoGpu {
        /// What was asked.
        what: &'static str,
        /// Why there is none, and what to do.
        reason: String,
    },
    /// A field of the command is out of range.
    #[error("{field}: {found} found, {expected} expected")]
    Invalid {
        /// Field of the command.
        field: String,
        /// What it held.
        found: String,
        /// What it may hold.
        expected: String,
    },
    /// A file of labels whose values are none.
    #[error("{file}: label ids: found {found}; expected {expected}")]
    Labels {
        /// File.
        file: String,
        /// What it holds.
        found: String,
        /// What it may hold, or what to do.
        expected: String,
    },
    /// A volume that is brought in and lies elsewhere.
    #[error(
        "{file}: place: found {found}; expected them in the volume, at {expected}; is it another scan's, or has it lost its place?"
    )]
    Elsewhere {
        /// File.
        file: String,
        /// What there is and where it lies.
        found: String,
        /// Where the volume lies.
        expected: String,
    },
    /// A box that would no longer hold all that was edited in it: how many samples.
    #[error(
        "lo, hi: {0} edited samples outside of it found, a box that holds all that is edited expected, or \"discard\": true"
    )]
    WouldLose(u64),
    /// The command does not fit what is going on.
    #[error("{0}")]
    NotNow(String),
    /// A brush or a stroke that cannot be painted.
    #[error(transparent)]
    Paint(#[from] PaintError),
    /// A part, a splitter or forces that cannot be.
    #[error(transparent)]
    Explode(#[from] ExplodeError),
    /// Saving, journal or recovery failed.
    #[error(transparent)]
    Keep(#[from] crate::document::disk::error::KeepError),
    /// A volume file that cannot be read or written.
    #[error(transparent)]
    Io(IoError),
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A picture could not be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The voxels behind the volume failed.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// Who watched the progress said no.
    #[error("stopped on request; nothing was changed")]
    Stopped,
}

impl DocumentError {
    pub(super) fn invalid(
        field: impl Into<String>,
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Invalid { field: field.into(), found: found.to_string(), expected: expected.into() }
    }

    /// A pixel of the 3D view where only numbers say where it is.
    pub(super) fn of_picture(field: &str) -> Self {
        Self::invalid(field, "a pixel of the 3D view", "a place in mm: what a pixel shows is known once it is drawn")
    }

    /// The same of a field inside another.
    pub(super) fn within(self, outer: &str) -> Self {
        match self {
            Self::Invalid { field, found, expected } => {
                Self::Invalid { field: format!("{outer}.{field}"), found, expected }
            }
            other => other,
        }
    }

    /// A label that is no segment's.
    pub(super) fn no_segment(field: &str, label: impl std::fmt::Display, segments: &Segments) -> Self {
        let known: Vec<u16> = segments.0.iter().map(|s| s.id).collect();
        let expected = match known[..] {
            [] => "a segment's id; there is no segment yet".to_owned(),
            _ => format!("a segment's id, one of {known:?}"),
        };
        Self::invalid(field, label, expected)
    }
}
