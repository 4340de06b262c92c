//! The commands on what is written on and about volumes: annotations on surfaces, labels beside the picture, cutaways; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::Place;
use crate::document::scene::annotations::{AnnotationId, Content, Directions};
use crate::document::scene::cutaways::CutawayId;
use crate::document::scene::labels::LabelId;
use crate::explode::PartId;
use crate::volume::VolumeId;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// What of an annotation is said; what is left out stays as it is, or begins as is usual.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub struct AnnotationChange {
    /// Which one; of `set` alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<AnnotationId>,
    /// Its centre, on a surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Place>,
    /// A second place: from the centre to it goes the text. A new one goes to the picture's right if it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toward: Option<Place>,
    /// Turns it about its centre, counter-clockwise seen from outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_deg: Option<f64>,
    /// A text; short for `content` of that text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// What it shows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub content: Option<Content>,
    /// Where a ruler ends, on the same surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Place>,
    /// Whose surface; the one that is picked, else the active one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeId>,
    /// The surface's value; of a new one that of the iso-surface that is shown, else the value at its centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Whether it stays with the selection; as the matter at its centre is if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub selected: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Of texts and rulers the height of letters, of all others their width, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_mm: Option<f64>,
    /// Distance of its grid's vertices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_mm: Option<f64>,
    /// How near they come to the surface, voxels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Where its grid's lines go.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub directions: Option<Directions>,
    /// Whether its grid is relaxed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxed: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<[f32; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub halo: Option<[f32; 3]>,
    /// Takes the halo away.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub no_halo: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lit: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
}

/// See [`Command::Annotation`](crate::document::Command::Annotation).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum AnnotationCommand {
    /// Lays a text, an image, a pattern, an arrow or a ruler on a surface. Answers its number and how its grid lies: the share of its
    /// vertices that the surface has no room for, and how much it had to be stretched.
    Add(AnnotationChange),
    /// Changes what is given of one, in place.
    Set(AnnotationChange),
    /// Takes one away.
    Remove { id: AnnotationId },
}

/// What of a label is said; what is left out stays as it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub struct LabelChange {
    /// Which one; of `set` alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<LabelId>,
    /// Of one that names a segment, a part or an annotation its name if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// What it names: one of the following.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Place>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub segment: Option<u16>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<PartId>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub annotation: Option<AnnotationId>,
    /// Whose place or segment; the picked or active one if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeId>,
    /// Whether the place is selected matter's; as it is there if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub selected: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
}

/// See [`Command::Label`](crate::document::Command::Label).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LabelCommand {
    /// A text beside the picture with a leader to what it names.
    Add(LabelChange),
    /// Changes what is given of one.
    Set(LabelChange),
    /// Takes one away.
    Remove { id: LabelId },
    /// Labels every visible segment that has voxels and no label yet, each at the voxel that is deepest inside it.
    FromSegments {
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
        /// Which ones; all visible ones if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        segments: Option<Vec<u16>>,
    },
    /// How all labels look; what is left out stays as it is.
    Style {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        visible: Option<bool>,
        /// Numbers in the picture and a key beside it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        numbers: Option<bool>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        size_px: Option<f32>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        colour: Option<[f32; 3]>,
        /// Takes the colour away: what stands out from the background.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        own_colour: bool,
    },
}

/// What of a cutaway is said; what is left out stays as it is, or begins as is usual.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub struct CutawayChange {
    /// Which one; of `set` alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<CutawayId>,
    /// An annotation whose place and size it takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub annotation: Option<AnnotationId>,
    /// Its middle, on a surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Place>,
    /// Its width goes from the middle to here; to the picture's right if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toward: Option<Place>,
    /// On the surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// On the surface; the width if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// A closed line on the surface instead, by 3 places and more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lasso: Option<Vec<Place>>,
    /// As of an annotation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeId>,
    /// As of an annotation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// How far its floor lies behind the surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// Width of its visible edge; 0: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_colour: Option<[f32; 3]>,
    /// Whether its walls grow darker with depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shaded: Option<bool>,
    /// Whether selected matter stands in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spare_selection: Option<bool>,
    /// Segments that stand in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spare_segments: Option<BTreeSet<u16>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<bool>,
}

/// See [`Command::Cutaway`](crate::document::Command::Cutaway).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CutawayCommand {
    /// Opens a window into what lies behind a surface: what of volumes lies inside it is not drawn.
    Add(CutawayChange),
    /// Changes what is given of one.
    Set(CutawayChange),
    /// Closes and forgets one.
    Remove { id: CutawayId },
}

impl AnnotationCommand {
    /// The volume that it names.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Add(change) | Self::Set(change) => change.volume,
            Self::Remove { .. } => None,
        }
    }
}

impl LabelCommand {
    /// The volume that it names.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Add(change) | Self::Set(change) => change.volume,
            Self::FromSegments { volume, .. } => *volume,
            Self::Remove { .. } | Self::Style { .. } => None,
        }
    }
}

impl CutawayCommand {
    /// The volume that it names.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Add(change) | Self::Set(change) => change.volume,
            Self::Remove { .. } => None,
        }
    }
}
