//! What commands on projects and volumes say: what was opened, recovered, saved and written.

#![allow(missing_docs)] // fields: what they are called is what they say

use crate::document::command::answers_ask::VolumeSaid;
use crate::document::command::answers_paint::LabelsSaid;
use crate::document::scene::volumes::{OwnLook, VolumeSettings};
use crate::io::{Exported, ExportedMesh};
use crate::volume::VolumeId;
use serde::Serialize;
use serde_json::Value;
use std::path::PathBuf;
use std::time::SystemTime;

/// `volume.open`, `project.open`, `project.recover`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenedSaid {
    /// The active one; none in a document without volumes.
    #[serde(flatten)]
    pub volume: Option<VolumeSaid>,
    /// Opened as labels.
    #[serde(flatten)]
    pub labels: Option<LabelsSaid>,
    /// Opened as a selection.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub selected_voxels: Option<u64>,
    pub warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recovered: Option<RecoveredSaid>,
}

/// `volume.add`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AddedSaid {
    /// Its number.
    pub volume: VolumeId,
    #[serde(flatten)]
    pub about: OpenedSaid,
}

/// `volume.remove`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeRemovedSaid {
    pub removed: VolumeId,
    /// The one that commands mean now which name none.
    pub active: Option<VolumeId>,
}

/// `volume.set`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeSetSaid {
    pub volume: VolumeId,
    #[serde(flatten)]
    pub settings: VolumeSettings,
    pub look: Option<OwnLook>,
    pub active: bool,
}

/// What an earlier end of the program had left, and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecoveredSaid {
    pub steps: u64,
    /// The last command, as the journal has it.
    pub last: Value,
    pub stroke: StrokeFate,
    pub torn_bytes: u64,
}

/// What became of the stroke that ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StrokeFate {
    /// None ran.
    None,
    /// It is painted as far as it had come.
    Painted,
    /// It could not be.
    Lost,
}

/// What a save did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Saved {
    /// The generation that is now current.
    pub generation: u64,
    /// Bytes written, metadata included.
    pub bytes_written: u64,
    /// Files of the generation before that did not change.
    pub files_linked: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SavedSaid {
    pub saved: Saved,
    pub path: Option<String>,
}

/// A document that a crash left behind.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Lost {
    /// Names it for `Autosave::recover` and `discard`.
    pub id: String,
    /// The file that was open.
    pub origin: PathBuf,
    /// When it was last changed.
    pub changed: SystemTime,
    /// Bytes of its journal.
    pub bytes: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LostSaid {
    pub lost: Vec<Lost>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForgottenSaid {
    pub forgotten: String,
}

/// A surface that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExportedMeshSaid {
    pub exported: ExportedMesh,
    pub warnings: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExportedSaid {
    pub exported: Exported,
    pub warnings: Vec<String>,
}
