//! The one command set. A script's line is one command as JSON, e.g. `{"brush":{"set":{"radius_mm":4.0}}}`.
//!
//! Grouped by noun; each noun has its handler file. Fields that a command leaves out keep their value. Here are the set itself,
//! places, and the nouns of what is in a document; files, views, brush and parts have files of their own.

#![allow(missing_docs)] // fields: the command's own text says what they are

pub(crate) mod annotations;
pub mod answers;
pub mod answers_annotations;
pub mod answers_ask;
pub mod answers_files;
pub mod answers_paint;
pub mod answers_sub_volumes;
pub(crate) mod brush;
pub(crate) mod component;
pub mod effects;
pub(crate) mod files;
pub mod looks;
pub(crate) mod parts;
pub(crate) mod resolved;
pub(crate) mod sub_volumes;
pub(crate) mod views;

use crate::document::command::annotations::{AnnotationCommand, CutawayCommand, LabelCommand};
use crate::document::command::brush::{BrushCommand, StrokeCommand};
use crate::document::command::component::ComponentCommand;
use crate::document::command::files::{ProjectCommand, RenderCommand, VolumeCommand};
use crate::document::command::looks::LookSetting;
use crate::document::command::parts::{ExplosionCommand, PartCommand};
use crate::document::command::sub_volumes::{Scale, SubVolumeCommand};
use crate::document::command::views::{LayerChange, TransferCommand, ViewCommand};
use crate::document::scene::ViewName;
use crate::document::scene::annotations::AnnotationId;
use crate::document::scene::cutaways::CutawayId;
use crate::math::Camera;
use crate::volume::{FieldKind, VolumeId};
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
    /// Boxes of a volume with a resolution of their own.
    SubVolume(SubVolumeCommand),
    /// Colour and opacity.
    Transfer(TransferCommand),
    /// Cameras, slices, looks and layers.
    View(ViewCommand),
    /// The brush's settings.
    Brush(BrushCommand),
    /// Painting. While a stroke runs, any command but a question, a move of the view or a step of the simulation ends it first.
    Stroke(StrokeCommand),
    /// What is connected: kept alone, removed, selected or labelled in one go, undone in one step.
    Component(ComponentCommand),
    /// The selection as a whole.
    Selection(SelectionCommand),
    /// The table of segments.
    Segment(SegmentCommand),
    /// Parts of the background.
    Part(PartCommand),
    /// The forces that move them.
    Explosion(ExplosionCommand),
    /// Texts, images, patterns, arrows and rulers on surfaces.
    Annotation(AnnotationCommand),
    /// Texts beside the picture.
    Label(LabelCommand),
    /// Windows into what lies behind surfaces.
    Cutaway(CutawayCommand),
    /// Undo and redo of everything but views, looks, layers and window, which have `view.back`, and the brush.
    History(HistoryCommand),
    /// Questions; they change nothing.
    Ask(Question),
    /// Pictures to files.
    Render(RenderCommand),
}

impl Command {
    /// The volume that it names; `None` where it means the active one, or none at all.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Transfer(TransferCommand::Set { volume, .. } | TransferCommand::Reset { volume })
            | Self::View(ViewCommand::Window { volume, .. } | ViewCommand::Layer(LayerChange { volume, .. })) => {
                *volume
            }
            Self::Stroke(command) => command.volume(),
            Self::Component(command) => command.connected().volume,
            Self::Selection(command) => command.volume(),
            Self::Segment(command) => command.volume(),
            Self::SubVolume(command) => command.volume(),
            Self::Annotation(command) => command.volume(),
            Self::Label(command) => command.volume(),
            Self::Cutaway(command) => command.volume(),
            Self::View(_)
            | Self::Project(_)
            | Self::Volume(_)
            | Self::Brush(_)
            | Self::Part(_)
            | Self::Explosion(_)
            | Self::History(_)
            | Self::Ask(_)
            | Self::Render(_) => None,
        }
    }

    /// Whether what it does to the scene hangs on the values of its volume.
    pub(crate) fn reads_values(&self) -> bool {
        matches!(self, Self::Transfer(TransferCommand::Reset { .. }))
    }
}

impl Command {
    /// Whether there is nothing that it could do in a document without volumes: cameras turn there too, and a brush is a tool.
    pub(crate) fn needs_volume(&self) -> bool {
        match self {
            Self::Brush(_) => false,
            Self::View(command) => matches!(command, ViewCommand::Window { .. } | ViewCommand::Layer(_)),
            _ => true,
        }
    }
}

impl SelectionCommand {
    /// The volume that it names.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Import { volume, .. }
            | Self::FromLabel { volume, .. }
            | Self::Clear { volume }
            | Self::Set { volume, .. } => *volume,
        }
    }
}

impl SegmentCommand {
    /// The volume that it names.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Set { volume, .. }
            | Self::Remove { volume, .. }
            | Self::Import { volume, .. }
            | Self::ShowOnly { volume, .. } => *volume,
        }
    }
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
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Selects the voxels of a label.
    FromLabel {
        label: u16,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Nothing is selected.
    Clear {
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// How selected matter is shown in 3D.
    Set {
        /// A look for itself, or `"inherit"`: what is left out stays as it is.
        look: LookSetting,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
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
        /// A look for its matter in 3D, or `"inherit"`: what is left out stays as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        look: Option<LookSetting>,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Takes a segment out of the table and its label out of the voxels.
    Remove {
        id: u16,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Shows matter of these labels alone in 3D, 0 among them for what has none; all of it if they are left out.
    ShowOnly {
        #[serde(default)]
        ids: Option<Vec<u16>>,
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
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
        /// The active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
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
    /// Grid, type, statistics of the volume: those of its file; of a sub-volume of its own samples as they are now.
    Volume {
        /// Which volume, the active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// Sub-volumes: their boxes, their samples and the memory that they may take and do take.
    SubVolumes {
        /// Those cut out of this one; all if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// What a sub-volume would be that `sub_volume.add` makes of the same numbers: its samples, the memory that it may take and what there
    /// is of it; refused with a reason where that would be.
    SubVolumeFit {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
        lo: [u32; 3],
        hi: [u32; 3],
        scale: Scale,
    },
    /// The whole scene, and where its parts stand.
    Scene {},
    /// Parts with their poses.
    Parts {},
    /// Density, colour, selection and label of the voxel at a place.
    Voxel {
        at: Place,
        /// Which volume, the active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// First visible surface under a pixel of the 3D view: world mm, rest mm, index, part.
    Pick {
        px: [f64; 2],
        #[serde(default)]
        size: Option<[u32; 2]>,
    },
    /// Sum, count of non-zero and largest of a field's voxels.
    Field {
        field: FieldKind,
        /// Which volume, the active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
    },
    /// How a point stands to a surface, and what force a device feels there: stiffness × depth along the outward normal, the depth that
    /// of the value over its gradient.
    Contact {
        at: Place,
        /// Whose surface, the active one's if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
        /// The surface's value; that of the iso-surface if one is shown.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        value: Option<f64>,
        /// N/mm.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stiffness: Option<f64>,
        /// The greatest force, N.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        most: Option<f64>,
        /// How far outside it counts as touched, mm.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        tolerance_mm: Option<f64>,
    },
    /// Share of the selection's pixels with less than 5 % opacity before it.
    Visibility {
        #[serde(default)]
        camera: Option<Camera>,
        #[serde(default)]
        size: Option<[u32; 2]>,
    },
    /// Annotations and how their grids lie.
    Annotations {
        /// One of them; all if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        id: Option<AnnotationId>,
        /// Also the vertices of their grids.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        vertices: bool,
    },
    /// Where a picture of the 3D view has its labels.
    Labels {
        #[serde(default)]
        camera: Option<Camera>,
        #[serde(default)]
        size: Option<[u32; 2]>,
    },
    /// Cutaways and their meshes.
    Cutaways {
        /// One of them; all if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        id: Option<CutawayId>,
        /// Also corners and triangles of their meshes.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        mesh: bool,
    },
    /// Steps that can be undone and redone.
    History {
        /// Also the commands that made them, in `undo_commands` and `redo_commands`: for each step a list, its places in world mm, with
        /// the brush of strokes and the hashes of files that were read.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        commands: bool,
    },
}
