//! The commands that say how things are seen: cameras, slices, looks, layers, the transfer function; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::Place;
use crate::document::scene::focus::FarMatter;
use crate::document::scene::past::PastOf;
use crate::document::scene::{Layer, ViewName};
use crate::math::Camera;
use crate::volume::{FieldKind, Lighting, Mode, TransferFunction, VolumeId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// See [`Command::Transfer`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TransferCommand {
    /// Replaces the whole function.
    Set {
        function: TransferFunction,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Starts again from the histogram.
    Reset {
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
}

/// See [`ViewCommand::Layer`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerChange {
    /// Field.
    pub field: FieldKind,
    /// Painted fields: in slices and in 3D. Density: in slices; in 3D the transfer function says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// Strength of its overlay, 0..1; without `opacity_3d` in slices and in 3D. Density has 1: what it lies over is black.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f32>,
    /// Strength of its overlay in 3D alone, 0..1. Until it is said, and whenever `opacity` is said alone, that of slices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity_3d: Option<f32>,
    /// Whose field: that volume then shows it in its own way. Left out: the active one's own way if it has one, else the document's,
    /// which all volumes share that have none of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeId>,
    /// The volume shows the field as the document does again; nothing else can be said beside it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared: bool,
}

impl From<Layer> for LayerChange {
    fn from(Layer { field, visible, opacity, opacity_3d }: Layer) -> Self {
        Self { field, visible: Some(visible), opacity: Some(opacity), opacity_3d, volume: None, shared: false }
    }
}

/// See [`ViewCommand::Focus`]. What is left out stays; where `as` becomes another, the opacity is that which suits it unless it is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FocusChange {
    /// Left out: it is on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<bool>,
    /// How far about the footprint matter is drawn as it is, mm, 0 or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
    /// Opacity of what lies farther, 0..1: of all of it before what is near together, and of all behind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f32>,
    /// How that is drawn.
    #[serde(default, rename = "as", skip_serializing_if = "Option::is_none")]
    pub far: Option<FarMatter>,
    /// A place that it stays at, whatever is painted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Place>,
    /// It goes with the brush again; said without `at`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub follow: bool,
}

/// See [`Command::View`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ViewCommand {
    /// Sets the 3D view's camera.
    Camera { camera: Camera },
    /// Frames the volume from a side: the direction from the volume towards the eye, world RAS+. The projection stays.
    Frame {
        from: [f64; 3],
        #[serde(default)]
        up: Option<[f64; 3]>,
        /// Distance as a multiple of the one that just fits.
        #[serde(default)]
        zoom: Option<f64>,
    },
    /// Fits a view: the whole slice as large as its picture holds, or in 3D all visible parts where they stand now; direction and
    /// projection stay.
    Fit { view: ViewName },
    /// Turns about the target, degrees.
    Orbit { azimuth_deg: f64, elevation_deg: f64 },
    /// Shifts a view by pixels.
    Pan { view: ViewName, px: [f64; 2] },
    /// Scales a view: below 1 is nearer.
    Zoom { view: ViewName, factor: f64 },
    /// Size in pixels that pixel coordinates refer to.
    Size { view: ViewName, size: [u32; 2] },
    /// Moves the crosshair, and with it all three slices.
    Crosshair { at: Place },
    /// Steps a slice view by voxels.
    Scroll { view: ViewName, voxels: i32 },
    /// Mode, lighting, step and background of the 3D view.
    Look {
        #[serde(default)]
        mode: Option<Mode>,
        /// `false`: unshaded.
        #[serde(default)]
        shaded: Option<bool>,
        #[serde(default)]
        lighting: Option<Lighting>,
        /// Distance of samples in voxels of the smallest spacing. Said without `refine` it means plain samples.
        #[serde(default)]
        step_voxels: Option<f64>,
        /// Whether samples stand for all matter since the one before: no rings on smooth surfaces.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        refine: Option<bool>,
        #[serde(default)]
        background: Option<[f32; 3]>,
    },
    /// What the 3D view looks at: what lies near the brush's footprint is drawn as it is, all else faintly or as contours. The footprint
    /// is that under the hand, in a script that of the last dab. Strokes and picks do not heed it.
    Focus(FocusChange),
    /// Grey window of the slices.
    Window {
        level: f64,
        width: f64,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// How a field is shown; what is left out stays.
    Layer(LayerChange),
    /// What was seen before the last change of view, look, layer, window or transfer function; with `of` before the last change of
    /// views or of looks alone.
    Back {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        of: Option<PastOf>,
    },
    /// Undoes `back`.
    Forward {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        of: Option<PastOf>,
    },
}
