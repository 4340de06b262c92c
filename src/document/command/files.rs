//! The commands that read and write files: projects, volumes, pictures; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::looks::LookSetting;
use crate::document::scene::ViewName;
use crate::math::Camera;
use crate::math::Pose;
use crate::volume::{FieldKind, VolumeId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// See [`Command::Project`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ProjectCommand {
    /// Opens a project folder; replays what its journal holds beyond the last save.
    Open {
        path: PathBuf,
        /// The file of a linked density, where it is not at the place that the project knows; it must be the same by its hash.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        source: Option<PathBuf>,
        /// An older generation than the last, where that one is damaged.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        generation: Option<u64>,
    },
    /// Writes the next generation; `path` for the first save or for a copy elsewhere.
    Save {
        #[serde(default)]
        path: Option<PathBuf>,
        /// Whether the project holds all of the density or names the file it came from; as it was if left out, and all of it the
        /// first time.
        #[serde(default)]
        density: Option<DensityKeeping>,
    },
    /// Lists unsaved documents that crashes left behind.
    Lost {},
    /// Brings one of them back.
    Recover { id: String },
    /// Throws one of them away.
    Forget { id: String },
}

/// Whether a project holds its density or only says where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DensityKeeping {
    /// All voxels are in the project.
    #[default]
    Whole,
    /// The source file is named by path, length and hash, and has to stay where it is.
    Linked,
}

/// See [`Command::Volume`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum VolumeCommand {
    /// Opens a file as a new, unsaved document.
    Open {
        path: PathBuf,
        /// Counted from 0; if left out the first, and of colour voxels their brightness, with the colours in the colour field.
        #[serde(default = "usual_component")]
        component: u32,
        #[serde(default)]
        frame: u32,
        /// Values that the 16-bit codes span; from the data if left out.
        #[serde(default)]
        range: Option<[f64; 2]>,
        /// What its values mean. They become the density all the same.
        #[serde(default, rename = "as", skip_serializing_if = "OpenAs::is_image")]
        open_as: OpenAs,
    },
    /// Opens a file as one more volume beside those that are there, on its own grid with its own fields, segments and look. In a
    /// program that has nothing open it opens it. The answer says its number.
    Add {
        path: PathBuf,
        /// As of `open`.
        #[serde(default = "usual_component")]
        component: u32,
        #[serde(default)]
        frame: u32,
        #[serde(default)]
        range: Option<[f64; 2]>,
        #[serde(default, rename = "as", skip_serializing_if = "OpenAs::is_image")]
        open_as: OpenAs,
        /// The file's if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// 0 to 1, how strongly it lies over the others; 1 if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        opacity: Option<f32>,
    },
    /// Takes a volume away, with all that was painted on it.
    Remove { volume: VolumeId },
    /// Changes what is given of a volume.
    Set {
        volume: VolumeId,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        visible: Option<bool>,
        /// 0 to 1.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        opacity: Option<f32>,
        /// A look of its own in 3D, or `"inherit"`: what is left out is as it is shown now. Its opacity is the volume's.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        look: Option<LookSetting>,
        /// The same as `"look": "inherit"`: it is shown as the document is.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        shared_look: bool,
        /// From where its file puts it to where it lies.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pose: Option<Pose>,
        /// `true`: commands that name no volume mean this one from now on.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        active: bool,
    },
    /// Writes a field to NRRD (`.nrrd`; labels also `.seg.nrrd`) or NIfTI (`.nii`, `.nii.gz`) on the original grid. Density keeps
    /// the source's type, unedited voxels bit for bit; labels have the ids of the file that they came from. To STL, PLY, OBJ (`.stl`,
    /// `.ply`, `.obj`, in world mm) or glTF (`.glb`, in metres, upright) the closed surface of the selection, where it is a half, or
    /// of a label, smooth and within half a voxel of its voxels' faces, where the volume lies. Answers of these `triangles`,
    /// `vertices`, `volume_mm3`, `closed` and `bytes`.
    Export {
        field: FieldKind,
        /// Of a mesh of labels: the segment. If left out the only one that there is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        label: Option<u16>,
        path: PathBuf,
        /// Which volume, the active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
}

/// What the values of a file mean to whoever opens it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OpenAs {
    /// Measurements; nothing is labelled or selected.
    #[default]
    Image,
    /// Ids of segments, 0 for none: whole numbers of any type and size, at most 65,535 different ones. The label field holds them
    /// as ids of 1 to 65535; where that is another number, the segment's `source_value` says the file's. The answer has
    /// `segments`, `labelled_voxels` and `warnings`.
    Labels,
    /// What is selected: all voxels above 0. The answer has `selected_voxels` and `warnings`.
    Selection,
}

impl OpenAs {
    fn is_image(&self) -> bool {
        *self == Self::Image
    }
}

/// See [`Command::Render`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RenderCommand {
    /// A view to PNG or EXR (by extension). An EXR has linear colour `R G B A`, and of the 3D view what each pixel shows: `Z`, mm along
    /// its ray, infinite where nothing is; `id`, the body's (a part's, 0 for what is in one piece or selected) plus 1, 0 for nothing;
    /// `volume`, its id plus 1, 0 for nothing; `segment`, the label, 0 for none; `selected`, 1 where the volume is selected there
    /// by half at least, wherever its parts are.
    Image {
        path: PathBuf,
        #[serde(default = "three_d")]
        view: ViewName,
        #[serde(default)]
        size: Option<[u32; 2]>,
        #[serde(default)]
        camera: Option<Camera>,
        /// A PNG that is transparent instead of the look's background; an EXR always is.
        #[serde(default)]
        transparent: bool,
        /// What lies behind the picture instead of the look's background: display-referred red, green and blue of 0 to 1.
        #[serde(default)]
        background: Option<[f32; 3]>,
        /// Drawn so many times larger either way and averaged, 1 to 8: smooth edges. Depth and object are not averaged.
        #[serde(default = "one_sample")]
        supersample: u32,
    },
}

/// No file has so many: whichever shows it as it is meant.
pub const USUAL_COMPONENT: u32 = u32::MAX;

fn usual_component() -> u32 {
    USUAL_COMPONENT
}

fn three_d() -> ViewName {
    ViewName::ThreeD
}

fn one_sample() -> u32 {
    1
}
