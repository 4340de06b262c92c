//! What a project is beside its voxels: everything here is saved and journaled; undo knows volumes with their segments, parts and forces.

pub(crate) mod annotations;
pub(crate) mod cause;
pub(crate) mod check;
pub(crate) mod components;
pub(crate) mod cutaways;
pub(crate) mod defaults;
pub(crate) mod first_look;
pub mod focus;
pub(crate) mod histogram;
pub(crate) mod kept_poses;
pub(crate) mod labels;
pub(crate) mod outliers;
pub mod own_looks;
pub(crate) mod painted;
pub(crate) mod past;
pub(crate) mod shared;
pub(crate) mod slice_plane;
pub(crate) mod volumes;

use crate::document::scene::annotations::Annotations;
use crate::document::scene::components::components;
use crate::document::scene::cutaways::Cutaways;
use crate::document::scene::defaults::brush_for;
use crate::document::scene::focus::ViewFocus;
use crate::document::scene::labels::Labels;
use crate::document::scene::own_looks::OwnLooks;
use crate::document::scene::shared::Shared;
use crate::document::scene::volumes::{VolumeLook, VolumeSettings, Volumes};
use crate::explode::Explosion;
use crate::math::{Camera, DVec3};
use crate::paint::Brush;
use crate::volume::{FieldKind, Lighting, Mode, TransferFunction, VolumeId};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// How the 3D view looks, as far as volumes have no look of their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ViewLook {
    /// Mode.
    pub mode: Mode,
    /// `None`: unshaded.
    pub lighting: Option<Lighting>,
    /// Step along the ray in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// Whether a sample of direct volume rendering stands for all matter since the one before it, so that smooth surfaces show no
    /// rings. Projects that do not say keep the plain samples that they were seen with.
    #[serde(default)]
    pub refine: bool,
    /// Display-referred background of the window and of PNGs without alpha.
    pub background: [f32; 3],
}

impl Default for ViewLook {
    /// Plain samples a voxel apart show rings like the grain of wood on surfaces that turn away from the eye.
    fn default() -> Self {
        let lighting = Some(Lighting::default());
        Self { mode: Mode::Dvr, lighting, step_voxels: 0.5, refine: true, background: [0.0; 3] }
    }
}

/// One of the four views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ViewName {
    /// The ray-cast picture.
    #[serde(rename = "3d")]
    ThreeD,
    /// From the feet: patient's right on the left, anterior up.
    Axial,
    /// From the front: patient's right on the left, superior up.
    Coronal,
    /// From the left: anterior on the left, superior up.
    Sagittal,
}

/// A slice view's place. Slices run along the voxel axis nearest to the anatomical one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SliceView {
    /// World mm in the picture's centre.
    #[schemars(with = "[f64; 3]")]
    pub centre: DVec3,
    /// Height of the picture in mm.
    pub height_mm: f64,
    /// Size in pixels that pixel coordinates of scripts refer to.
    pub size: [u32; 2],
}

/// All views. Saved and journaled; they have a past of their own (`view.back`), so that undo never moves the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Views {
    /// Camera of the 3D view.
    pub camera: Camera,
    /// Size in pixels that pixel coordinates of scripts refer to.
    pub size: [u32; 2],
    /// Axial, coronal, sagittal.
    pub slices: [SliceView; 3],
    /// Where the slices meet, world mm.
    #[schemars(with = "[f64; 3]")]
    pub crosshair: DVec3,
}

/// Grey window of the slices: black at `level − width/2`, white at `level + width/2`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Window {
    /// Value in the middle of the grey ramp.
    pub level: f64,
    /// Values from black to white, positive.
    pub width: f64,
}

/// Whether and how strongly a field is shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Layer {
    /// Field.
    pub field: FieldKind,
    /// Painted fields: in slices and in 3D. Density: in slices; in 3D the transfer function says it.
    pub visible: bool,
    /// Strength of its overlay, 0..1. Density has 1: what it lies over is black.
    pub opacity: f32,
    /// The same in 3D where it is another one than in slices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity_3d: Option<f32>,
}

/// How everything is shown. It has a past of its own, as views have (`view.back`); undo leaves it alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Looks {
    /// Colour and opacity.
    pub transfer: Shared<TransferFunction>,
    /// The 3D view's appearance.
    pub look: Shared<ViewLook>,
    /// Fields' display.
    pub layers: Shared<Vec<Layer>>,
    /// What the 3D view looks at.
    #[serde(default)]
    pub focus: Shared<ViewFocus>,
    /// How each volume is shown.
    pub shown: Shared<BTreeMap<VolumeId, VolumeLook>>,
}

/// The file that the density comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Origin {
    /// As opened.
    #[serde(serialize_with = "in_utf8")]
    pub path: PathBuf,
    /// Component and frame of the file.
    pub component: u32,
    /// Frame.
    pub frame: u32,
}

impl Origin {
    /// Of what came from no file.
    pub(crate) fn nowhere() -> Self {
        Self { path: PathBuf::new(), component: 0, frame: 0 }
    }
}

/// A path as JSON can say it: what is not UTF-8 in it becomes a mark.
fn in_utf8<S: serde::Serializer>(path: &std::path::Path, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(&path.display())
}

/// What nobody said need not be kept.
fn is_empty(looks: &Shared<OwnLooks>) -> bool {
    looks.is_empty()
}

/// The same of what begins empty.
fn is_fresh<T: Default + PartialEq>(held: &Shared<T>) -> bool {
    **held == T::default()
}

components! {
    (grid, histogram, volume)
    /// Which volumes there are.
    volumes: Volumes, Undo, Volumes::of_one(volume);
    /// How each of them is shown.
    shown: BTreeMap<VolumeId, VolumeLook>, Looks, VolumeLook::of_first(histogram);
    /// Colour and opacity.
    transfer: TransferFunction, Looks, first_look::transfer(grid, histogram);
    /// The 3D view's appearance.
    look: ViewLook, Looks, first_look::look(grid);
    /// Views.
    views: Views, Views, Views::new(grid);
    /// Fields' display.
    layers: Vec<Layer>, Looks, FieldKind::ALL.map(Layer::new).to_vec();
    /// What the 3D view looks at.
    #[serde(default)]
    focus: ViewFocus, Looks, ViewFocus::of(grid);
    /// The brush.
    brush: Brush, Tool, brush_for(grid);
    /// What strokes that name no volume paint besides the active one.
    #[serde(default)]
    also: BTreeSet<VolumeId>, Tool, BTreeSet::new();
    /// Parts and forces.
    explosion: Explosion, Undo, Explosion::whole(grid);
    /// What is other about the looks of parts, selections and segments.
    #[serde(default, skip_serializing_if = "is_empty")]
    own_looks: OwnLooks, Undo, OwnLooks::default();
    /// Pictures that lie on surfaces.
    #[serde(default, skip_serializing_if = "is_fresh")]
    annotations: Annotations, Undo, Annotations::default();
    /// Texts in the picture's plane.
    #[serde(default, skip_serializing_if = "is_fresh")]
    labels: Labels, Undo, Labels::default();
    /// Windows into what lies behind surfaces.
    #[serde(default, skip_serializing_if = "is_fresh")]
    cutaways: Cutaways, Undo, Cutaways::default();
}
