//! What questions are answered with; see `answers`.

#![allow(missing_docs)] // fields: what they are called is what they say

use crate::document::command::resolved::ResolvedCommand;
use crate::explode::{PartId, PartRecord};
use crate::volume::{Number, TexelFormat, VolumeId, VoxelType};
use serde::Serialize;
use std::collections::BTreeMap;

/// `ask.volume`, and what is told of a volume that was opened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeSaid {
    pub name: String,
    pub dims: [u32; 3],
    pub voxel_type: VoxelType,
    /// Rows of the matrix from index to world.
    pub world_from_index: [[f64; 4]; 3],
    pub spacing_mm: [f64; 3],
    /// `None` of a volume without a finite value.
    pub min: Option<Number>,
    pub max: Option<Number>,
    pub sum: Number,
    pub nan_count: u64,
    pub texels: TexelFormat,
    pub half_step: f64,
    pub levels: u8,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartsSaid {
    pub degree: f64,
    pub parts: Vec<PartRecord>,
}

/// `ask.voxel`: of a pixel that shows nothing only that it is not inside.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct VoxelSaid {
    pub inside: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mm: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index: Option<[f64; 3]>,
    #[serde(flatten)]
    pub values: Option<VoxelValues>,
    /// What every visible volume has at that place of the world, where the document has several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub volumes: Vec<VolumeVoxelSaid>,
}

/// What one of several volumes has at a place; no more than its name where the place is outside.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeVoxelSaid {
    pub volume: VolumeId,
    pub name: String,
    #[serde(flatten)]
    pub values: Option<VoxelValues>,
}

/// What is in a voxel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VoxelValues {
    pub voxel: [u32; 3],
    pub density: Number,
    /// By how much a painted density may be off.
    pub half_step: f64,
    pub colour: [f32; 4],
    pub selection: f32,
    pub label: u16,
    pub segment: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PickSaid {
    pub hit: Option<HitSaid>,
}

/// The first visible surface under a pixel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HitSaid {
    pub mm: [f64; 3],
    pub rest_mm: [f64; 3],
    /// In the voxels of the volume that is hit.
    pub index: [f64; 3],
    pub part: PartId,
    /// Whose voxel it is.
    pub volume: Option<VolumeId>,
    /// Its label, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segment: Option<u16>,
    /// Whether it is matter of the body of what is selected, or, while all is drawn in one piece, of a volume of which something is
    /// selected; `selected` tells more.
    pub selection: bool,
    /// Whether its volume is selected there, by half at least, wherever its parts are.
    pub selected: bool,
    pub depth_mm: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldSaid {
    pub field: &'static str,
    pub sum: Number,
    pub nonzero: u64,
    pub min: Option<Number>,
    pub max: Option<Number>,
    pub edited_bricks: usize,
    /// Of labels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxels_by_label: Option<BTreeMap<u16, u64>>,
    /// Of labels: how much of the volume each has; a voxel on a face of a sub-volume counts as far as it lies outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mm3_by_label: Option<BTreeMap<u16, f64>>,
    /// Of the selection: how much is selected, what is selected in part by its part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub selected_mm3: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VisibilitySaid {
    pub share: f64,
    pub selected: u64,
    pub visible: u64,
    pub hidden_by: Vec<HiddenBy>,
}

/// Pixels of the selection that a part alone hides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HiddenBy {
    pub part: u32,
    pub pixels: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistorySaid {
    /// Names, the newest first.
    pub undo: Vec<String>,
    /// Names, the next one first.
    pub redo: Vec<String>,
    pub memory: u64,
    pub disk: u64,
    pub budget: u64,
    pub views: PastCounts,
    pub looks: PastCounts,
    /// What made the steps of `undo`, if that was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undo_commands: Option<Vec<Vec<ResolvedCommand>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub redo_commands: Option<Vec<Vec<ResolvedCommand>>>,
}

/// Changes behind and ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PastCounts {
    pub back: usize,
    pub forward: usize,
}

/// `ask.contact`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactSaid {
    /// The place, world mm at rest.
    pub mm: [f64; 3],
    /// Whose surface.
    pub volume: VolumeId,
    /// Its value.
    pub value: f64,
    /// Whether the place lies in the volume.
    pub known: bool,
    /// Whether the value there is above the surface's.
    pub inside: bool,
    /// Whether it is inside, or outside within the tolerance.
    pub touching: bool,
    /// (f − value)/|∇f|, below 0 outside; `null` where the field is even.
    pub depth_mm: Option<f64>,
    /// Outward; `null` where the field is even.
    pub normal: Option<[f64; 3]>,
    /// On the hand, N.
    pub force_n: [f64; 3],
}
