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
#[expect(clippy::large_enum_variant, reason = "made by hand, one at a time")]
pub enum BrushCommand {
    /// Changes what is given and leaves the rest.
    Set(BrushChange),
    /// Lets strokes that name no volume paint these besides the active one, while they are visible; an empty list: none. As the rest
    /// of the brush it is saved, and undo leaves it alone. Answers `also`, the volumes in order.
    Also {
        /// Their numbers.
        volumes: Vec<VolumeId>,
    },
}

/// See [`Command::Stroke`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StrokeCommand {
    /// A whole stroke at once. On several volumes it is one path, one coverage in mm and one step of history; each is painted where it
    /// lies, by its own values, segments and locks. The answer is of all of them together, and in `volumes` of each.
    Paint {
        points: Vec<StrokePoint>,
        /// What is painted, if it is one. Without `volume` and `volumes` the active one, and those that `brush.also` names.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
        /// What is painted, if it is several. Places in index or on slices, and where a disc
        /// faces that nobody says, are those of the first; pixels of the 3D view are what it
        /// shows there, of whatever volume.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volumes: Option<Vec<VolumeId>>,
    },
    /// Fills a contour on a slice with what the brush paints, at the brush's full strength, in one step.
    Lasso(Lasso),
    /// Starts a stroke.
    Begin {
        points: Vec<StrokePoint>,
        /// As of `stroke.paint`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
        /// As of `stroke.paint`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volumes: Option<Vec<VolumeId>>,
    },
    /// Continues it.
    Extend { points: Vec<StrokePoint> },
    /// Ends it: one step of history, none if nothing changed.
    End {},
    /// Takes it back.
    Cancel {},
}

/// A contour that fills; see [`StrokeCommand::Lasso`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lasso {
    /// Its corners, 3 or more; the last is joined to the first. Pixels of one slice, or places in mm or index, whose plane goes through the
    /// first. What the contour winds about is inside, however it crosses itself.
    pub points: Vec<Place>,
    /// How far it fills to either side of the slice, mm; 0: the layer of voxels of the slice. As the brush says (`depth_mm`) if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// Of places in mm or index: where the plane faces, any length; that of the axial slice if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// 0..1; scales the brush's strength.
    #[serde(default = "one")]
    pub pressure: f32,
    /// As of `stroke.paint`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeId>,
    /// As of `stroke.paint`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volumes: Option<Vec<VolumeId>>,
}

impl Lasso {
    /// Of these corners, on what the brush paints.
    pub(crate) fn of(points: Vec<Place>) -> Self {
        Self { points, depth_mm: None, normal: None, pressure: 1.0, volume: None, volumes: None }
    }
}

impl StrokeCommand {
    /// Starts a stroke on what the brush paints.
    pub(crate) fn begin(points: Vec<StrokePoint>) -> Self {
        Self::Begin { points, volume: None, volumes: None }
    }

    /// The volume that it names, or the first of them, where it begins a stroke.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Paint { volume, volumes, .. } | Self::Begin { volume, volumes, .. } => {
                volume.or_else(|| volumes.as_ref()?.first().copied())
            }
            Self::Lasso(Lasso { volume, volumes, .. }) => volume.or_else(|| volumes.as_ref()?.first().copied()),
            Self::Extend { .. } | Self::End {} | Self::Cancel {} => None,
        }
    }
}
