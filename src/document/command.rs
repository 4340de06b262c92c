//! The one command set. A script's line is one command as JSON, e.g. `{"brush":{"set":{"radius_mm":4.0}}}`.
//!
//! Grouped by noun; each noun has its handler file. Fields that a command leaves out keep their value.

#![allow(missing_docs)] // fields: the command's own text says what they are

use super::command_parts::{ExplosionCommand, PartCommand};
use super::keep::store::DensityKeeping;
use super::scene::{Layer, ViewName};
use crate::math::Camera;
use crate::paint::{Brush, EraseDensity, Falloff, Operation, Shape, Target, Tip};
use crate::volume::{FieldKind, Lighting, Mode, Number, TransferFunction};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Everything that can be done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// The project on disk.
    Project(ProjectCommand),
    /// The volume's density as a whole.
    Volume(VolumeCommand),
    /// Colour and opacity.
    Transfer(TransferCommand),
    /// Cameras, slices, looks and layers.
    View(ViewCommand),
    /// The brush's settings.
    Brush(BrushCommand),
    /// Painting. While a stroke runs, any command but a question, a move of the view or a step of the simulation ends it first.
    Stroke(StrokeCommand),
    /// The selection as a whole.
    Selection(SelectionCommand),
    /// The table of segments.
    Segment(SegmentCommand),
    /// Parts of the background.
    Part(PartCommand),
    /// The forces that move them.
    Explosion(ExplosionCommand),
    /// Undo and redo of everything but views, looks, layers and window, which have `view.back`, and the brush.
    History(HistoryCommand),
    /// Questions; they change nothing.
    Ask(Question),
    /// Pictures to files.
    Render(RenderCommand),
}

/// A place: world mm, continuous index, or a pixel of a named view (in the 3D view: of the picked surface).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Place {
    /// World RAS+ mm, of the rest pose.
    Mm([f64; 3]),
    /// Continuous index, voxel centres at integers.
    Index([f64; 3]),
    /// A pixel; (0, 0) is the picture's top-left corner. `size` is the picture's size, the view's own if left out.
    Pixel {
        /// View.
        view: ViewName,
        /// x right, y down.
        px: [f64; 2],
        /// Width and height in pixels.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        size: Option<[u32; 2]>,
    },
}

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
}

fn one() -> f32 {
    1.0
}

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
    /// Writes a field to NRRD (`.nrrd`; labels also `.seg.nrrd`) or NIfTI (`.nii`, `.nii.gz`) on the original grid. Density keeps
    /// the source's type, unedited voxels bit for bit; labels have the ids of the file that they came from.
    Export { field: FieldKind, path: PathBuf },
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

/// See [`Command::Transfer`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TransferCommand {
    /// Replaces the whole function.
    Set { function: TransferFunction },
    /// Starts again from the histogram.
    Reset {},
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
        #[serde(default)]
        step_voxels: Option<f64>,
        #[serde(default)]
        background: Option<[f32; 3]>,
    },
    /// Grey window of the slices.
    Window { level: f64, width: f64 },
    /// How a field is shown.
    Layer(Layer),
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

/// What `view.back` walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PastOf {
    /// Cameras, slices, crosshair.
    Views,
    /// Transfer function, look, window, layers.
    Looks,
}

/// See [`Command::Brush`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BrushCommand {
    /// Changes what is given and leaves the rest.
    Set {
        #[serde(default)]
        shape: Option<Shape>,
        #[serde(default)]
        radius_mm: Option<f64>,
        /// Hard if left out where `target` becomes a label; labels are painted by the hard ball in any case.
        #[serde(default)]
        falloff: Option<Falloff>,
        #[serde(default)]
        strength: Option<f32>,
        #[serde(default)]
        operation: Option<Operation>,
        #[serde(default)]
        tip: Option<Tip>,
        #[serde(default)]
        target: Option<Target>,
        #[serde(default)]
        spacing: Option<f64>,
        /// Closed range of densities that may be painted, compared in the source's own type: integers to the last digit; `"inf"`
        /// and `"-inf"` are ends too.
        #[serde(default)]
        range: Option<[Number; 2]>,
        /// Takes the range away.
        #[serde(default)]
        any_value: bool,
        #[serde(default)]
        erase: Option<bool>,
        /// What erasing does to density: `"restore"` takes edits back, `{"to": value}` removes by painting that value.
        #[serde(default)]
        erase_density: Option<EraseDensity>,
        /// Whether strokes keep to the surface that the 3D view shows.
        #[serde(default)]
        visible_only: Option<bool>,
    },
}

impl BrushCommand {
    /// The brush after the command.
    pub fn applied_to(&self, old: &Brush) -> Brush {
        let Self::Set {
            shape,
            radius_mm,
            falloff,
            strength,
            operation,
            tip,
            target,
            spacing,
            range,
            any_value,
            erase,
            erase_density,
            visible_only,
        } = self;
        let is_label = |target: &Target| matches!(target, Target::Label(_));
        let becomes_label = target.as_ref().is_some_and(is_label) && !is_label(&old.target);
        Brush {
            shape: shape.unwrap_or(old.shape),
            radius_mm: radius_mm.unwrap_or(old.radius_mm),
            falloff: falloff.unwrap_or(if becomes_label { Falloff::Hard } else { old.falloff }),
            strength: strength.unwrap_or(old.strength),
            operation: operation.unwrap_or(old.operation),
            tip: tip.unwrap_or(old.tip),
            target: target.unwrap_or(old.target),
            spacing: spacing.unwrap_or(old.spacing),
            range: range.or(if *any_value { None } else { old.range }),
            erase: erase.unwrap_or(old.erase),
            erase_density: erase_density.unwrap_or(old.erase_density),
            visible_only: visible_only.unwrap_or(old.visible_only),
        }
    }
}

/// See [`Command::Stroke`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StrokeCommand {
    /// A whole stroke at once.
    Paint { points: Vec<StrokePoint> },
    /// Starts a stroke.
    Begin { points: Vec<StrokePoint> },
    /// Continues it.
    Extend { points: Vec<StrokePoint> },
    /// Ends it: one step of history, none if nothing changed.
    End {},
    /// Takes it back.
    Cancel {},
}

/// See [`Command::Selection`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SelectionCommand {
    /// Reads another volume of the same grid, resampled by world position if the grid differs: above `threshold` is selected. A
    /// soft border of `soften_mm` is laid about it. A file that selects nothing because it lies elsewhere is refused; the answer's
    /// `covered` is the share of the volume that the file covers, `warnings` says what was left out.
    Import {
        path: PathBuf,
        #[serde(default)]
        threshold: f64,
        #[serde(default)]
        soften_mm: f64,
    },
    /// Selects the voxels of a label.
    FromLabel { label: u16 },
    /// Nothing is selected.
    Clear {},
}

/// See [`Command::Segment`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SegmentCommand {
    /// Adds a segment or changes what is given of one.
    Set {
        id: u16,
        #[serde(default)]
        name: Option<String>,
        #[serde(default)]
        colour: Option<[f32; 3]>,
        #[serde(default)]
        visible: Option<bool>,
        #[serde(default)]
        locked: Option<bool>,
    },
    /// Takes a segment out of the table and its label out of the voxels.
    Remove { id: u16 },
    /// Brings in the labels of a file, nearest voxel by world position where the grid differs. They lie over those that are there,
    /// but for voxels of locked segments. An id that is taken by another segment becomes a free one, and the segment's
    /// `source_value` says the file's. Answers `segments` (each with `id`, `value` in the file, `name`, `voxels`),
    /// `labelled_voxels`, `kept_locked` (voxels left alone), `covered` (share of the volume that the file covers), `resampled`
    /// and `warnings`.
    Import {
        path: PathBuf,
        /// Of a file with several numbers a voxel: which layer.
        #[serde(default)]
        component: u32,
        #[serde(default)]
        frame: u32,
    },
}

/// See [`Command::History`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum HistoryCommand {
    /// Takes back steps.
    Undo {
        #[serde(default = "one_step")]
        steps: u32,
    },
    /// Does them again.
    Redo {
        #[serde(default = "one_step")]
        steps: u32,
    },
    /// Memory for steps in bytes; older ones go to disk.
    Budget { bytes: u64 },
    /// Opens a group: everything until its end is one step (the drag of a slider, of a part, of a point of a curve).
    Begin {},
    /// Closes the group: one step under the last change's name, none if nothing changed.
    End {},
    /// Closes the group and takes back what it did.
    Cancel {},
}

fn one_step() -> u32 {
    1
}

/// See [`Command::Ask`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Question {
    /// Grid, type, statistics of the volume.
    Volume {},
    /// The whole scene.
    Scene {},
    /// Parts with their poses.
    Parts {},
    /// Density, colour, selection and label of the voxel at a place.
    Voxel { at: Place },
    /// First visible surface under a pixel of the 3D view: world mm, rest mm, index, part.
    Pick {
        px: [f64; 2],
        #[serde(default)]
        size: Option<[u32; 2]>,
    },
    /// Sum, count of non-zero and largest of a field's voxels.
    Field { field: FieldKind },
    /// Share of the selection's pixels with less than 5 % opacity before it.
    Visibility {
        #[serde(default)]
        camera: Option<Camera>,
        #[serde(default)]
        size: Option<[u32; 2]>,
    },
    /// Steps that can be undone and redone.
    History {},
}

/// See [`Command::Render`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RenderCommand {
    /// A view to PNG or EXR (by extension; EXR has colour, depth in mm and object id).
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
