//! The commands of the hand: what the brush is, and its strokes; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::Place;
use crate::paint::BrushChange;
use crate::volume::VolumeId;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One input point of a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrokePoint {
    /// Where.
    pub at: Place,
    /// 0..1; scales the brush's strength.
    #[serde(default = "one")]
    pub pressure: f32,
    /// Whether the path begins anew here instead of coming from the point before. Where pixels of the 3D view need that it is found.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub breaks: bool,
    /// Of a place in mm or index: where a disc faces, any length; that of the axial slice if left out. A pixel knows it itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
}

fn one() -> f32 {
    1.0
}

/// See [`Command::Brush`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BrushCommand {
    /// Changes what is given and leaves the rest.
    Set(BrushChange),
}

/// See [`Command::Stroke`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StrokeCommand {
    /// A whole stroke at once.
    Paint {
        points: Vec<StrokePoint>,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Starts a stroke.
    Begin {
        points: Vec<StrokePoint>,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Continues it.
    Extend { points: Vec<StrokePoint> },
    /// Ends it: one step of history, none if nothing changed.
    End {},
    /// Takes it back.
    Cancel {},
}

impl StrokeCommand {
    /// The volume that it names, where it begins a stroke.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Paint { volume, .. } | Self::Begin { volume, .. } => *volume,
            Self::Extend { .. } | Self::End {} | Self::Cancel {} => None,
        }
    }
}
