//! What a command says it did: a type for every verb's answer; JSON only where a script reads it.
//!
//! An answer is what the verb itself says, beside the step of history it made and what went wrong on the way. Its names are those of
//! the script's JSON and may not change: scripts read them. Owns no value that is not told; knows nothing of how it was found.

#![allow(missing_docs)] // fields: what they are called is what they say

use crate::document::command::answers_ask::{
    ContactSaid, FieldSaid, HistorySaid, PartsSaid, PickSaid, VisibilitySaid, VolumeSaid, VoxelSaid,
};
use crate::document::scene::focus::ViewFocus;
use crate::document::scene::own_looks::LookChange;
use crate::document::scene::past::PastOf;
use crate::document::scene::{Layer, Scene, SliceView, ViewLook, ViewName, Window};
use crate::explode::{Forces, PartId, PartPose, PartRecord};
use crate::math::Camera;
use serde::ser::{Error, SerializeStruct};
use serde::{Serialize, Serializer};
use serde_json::Value;

pub use crate::document::command::answers_annotations::*;
pub use crate::document::command::answers_files::*;
pub use crate::document::command::answers_paint::*;
pub use crate::document::command::answers_sub_volumes::*;

/// What a command answers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Answer {
    /// What the verb says.
    #[serde(flatten)]
    pub said: Said,
    /// Of a command that is done as a step of history: which. Strokes and groups say theirs themselves.
    #[serde(flatten)]
    pub step: Option<StepSaid>,
    /// What went wrong beside what went right, in sentences.
    #[serde(rename = "warning", skip_serializing_if = "Vec::is_empty", serialize_with = "joined")]
    pub trouble: Vec<String>,
}

fn joined<S: Serializer>(trouble: &[String], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&trouble.join("; "))
}

impl Answer {
    /// Everything that is to be told: of the files that were read or written, and of what went wrong beside.
    pub fn warnings(&self) -> impl Iterator<Item = &str> {
        let of_files: &[String] = match &self.said {
            Said::Opened(said) => &said.warnings,
            Said::Exported(said) => &said.warnings,
            Said::ExportedMesh(said) => &said.warnings,
            Said::Selected(said) => said.warnings.as_deref().unwrap_or_default(),
            Said::ImportedSegments(said) => &said.warnings,
            _ => &[],
        };
        self.trouble.iter().chain(of_files).map(String::as_str)
    }

    /// What an earlier end of the program had left in what was opened.
    pub fn recovered(&self) -> Option<&RecoveredSaid> {
        match &self.said {
            Said::Opened(said) => said.recovered.as_ref(),
            _ => None,
        }
    }

    /// Why a stroke came to nothing, in a sentence.
    pub fn nothing(&self) -> Option<&str> {
        match &self.said {
            Said::Painted(said) => said.nothing.as_deref(),
            Said::Component(said) => said.nothing,
            _ => None,
        }
    }

    /// The answer as scripts read it.
    ///
    /// # Errors
    /// If it holds what JSON has no word for, such as a file's name that is not UTF-8.
    pub fn to_json(&self) -> Result<Value, String> {
        serde_json::to_value(self)
            .map_err(|error| format!("the command is done, but its answer cannot be told: {error}"))
    }
}

impl From<Said> for Answer {
    fn from(said: Said) -> Self {
        Self { said, ..Self::default() }
    }
}

/// The step of history that a command made, `None` if it changed nothing that undo knows.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StepSaid {
    pub step: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxels_changed: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bricks_touched: Option<usize>,
}

/// What the verbs say.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Said {
    /// There was nothing to say.
    #[default]
    Nothing,
    Opened(Box<OpenedSaid>),
    Saved(SavedSaid),
    Lost(LostSaid),
    Forgotten(ForgottenSaid),
    Exported(ExportedSaid),
    ExportedMesh(ExportedMeshSaid),
    Transfer(TransferSaid),
    Camera(CameraSaid),
    View(ViewSaid),
    Slice(SliceSaid),
    Crosshair(CrosshairSaid),
    Look(LookSaid),
    Window(WindowSaid),
    Layers(LayersSaid),
    Focus(FocusSaid),
    Past(Box<PastSaid>),
    Brush(Box<BrushSaid>),
    Also(AlsoSaid),
    Painted(PaintedSaid),
    Extended(ExtendedSaid),
    Cancelled(CancelledSaid),
    Component(ComponentSaid),
    Selected(SelectedSaid),
    SelectionLook(SelectionLookSaid),
    Segment(SegmentSaid),
    ShownOnly(ShownOnlySaid),
    SegmentRemoved(SegmentRemovedSaid),
    ImportedSegments(ImportedSegmentsSaid),
    Split(SplitSaid),
    Part(Box<PartSaid>),
    Whole(WholeSaid),
    Degree(DegreeSaid),
    Forces(ForcesSaid),
    Seed(SeedSaid),
    Settled(SettledSaid),
    Moved(MovedSaid),
    Travelled(TravelledSaid),
    Budget(BudgetSaid),
    Group(GroupSaid),
    Volume(Box<VolumeSaid>),
    Added(Box<AddedSaid>),
    VolumeRemoved(VolumeRemovedSaid),
    VolumeSet(Box<VolumeSetSaid>),
    SubVolume(Box<SubVolumeSaid>),
    SubVolumes(SubVolumesSaid),
    Fit(Box<FitSaid>),
    Baked(BakedSaid),
    Scene(Box<SceneSaid>),
    Parts(PartsSaid),
    Voxel(Box<VoxelSaid>),
    Pick(PickSaid),
    Field(FieldSaid),
    Contact(ContactSaid),
    Visibility(VisibilitySaid),
    History(HistorySaid),
    Picture(PictureSaid),
    Annotation(Box<AnnotationSaid>),
    Annotations(AnnotationsSaid),
    Removed(RemovedSaid),
    Label(LabelSaid),
    Labelled(LabelledSaid),
    LabelStyle(LabelStyleSaid),
    Labels(PlacedLabelsSaid),
    Cutaway(Box<CutawaySaid>),
    Cutaways(CutawaysSaid),
}

impl Said {
    /// Whether parts are still on their way.
    pub fn is_moving(&self) -> bool {
        matches!(self, Self::Moved(moved) if moved.moving)
    }
}

/// Gives every answer its place among what can be said.
macro_rules! said {
    ($($variant:ident($answer:ty)),* $(,)?) => {
        $(impl From<$answer> for Said {
            fn from(answer: $answer) -> Self {
                Self::$variant(answer.into())
            }
        })*
    };
}

said! {
    Opened(OpenedSaid), Saved(SavedSaid), Lost(LostSaid), Forgotten(ForgottenSaid), Exported(ExportedSaid), ExportedMesh(ExportedMeshSaid),
    Transfer(TransferSaid), Camera(CameraSaid), View(ViewSaid), Slice(SliceSaid), Crosshair(CrosshairSaid),
    Look(LookSaid), Window(WindowSaid), Layers(LayersSaid), Focus(FocusSaid), Past(PastSaid), Brush(BrushSaid), Also(AlsoSaid),
    Painted(PaintedSaid), Extended(ExtendedSaid), Cancelled(CancelledSaid), Component(ComponentSaid), Selected(SelectedSaid),
    SelectionLook(SelectionLookSaid), Segment(SegmentSaid), ShownOnly(ShownOnlySaid),
    SegmentRemoved(SegmentRemovedSaid), ImportedSegments(ImportedSegmentsSaid), Split(SplitSaid), Part(PartSaid),
    Whole(WholeSaid), Degree(DegreeSaid), Forces(ForcesSaid), Seed(SeedSaid), Settled(SettledSaid), Moved(MovedSaid),
    Travelled(TravelledSaid), Budget(BudgetSaid), Group(GroupSaid), Volume(VolumeSaid), Added(AddedSaid),
    VolumeRemoved(VolumeRemovedSaid), VolumeSet(VolumeSetSaid), SubVolume(SubVolumeSaid),
    SubVolumes(SubVolumesSaid), Fit(FitSaid), Baked(BakedSaid), Scene(SceneSaid),
    Parts(PartsSaid), Voxel(VoxelSaid), Pick(PickSaid), Field(FieldSaid), Contact(ContactSaid), Visibility(VisibilitySaid),
    History(HistorySaid), Picture(PictureSaid), Annotation(AnnotationSaid), Annotations(AnnotationsSaid), Removed(RemovedSaid),
    Label(LabelSaid), Labelled(LabelledSaid), LabelStyle(LabelStyleSaid), Labels(PlacedLabelsSaid), Cutaway(CutawaySaid),
    Cutaways(CutawaysSaid),
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransferSaid {
    pub colour_points: usize,
    pub opacity_points: usize,
    pub domain: [f64; 2],
}

/// A move of the 3D view.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraSaid {
    pub camera: Camera,
}

/// The 3D view by its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewSaid {
    pub camera: Camera,
    pub size: [u32; 2],
}

/// A slice view by its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SliceSaid {
    pub slice: SliceView,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrosshairSaid {
    pub crosshair_mm: [f64; 3],
    pub index: [f64; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LookSaid {
    pub look: ViewLook,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WindowSaid {
    pub window: Window,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayersSaid {
    pub layers: Vec<Layer>,
}

/// `view.focus`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FocusSaid {
    pub focus: ViewFocus,
}

/// `view.back`, `view.forward`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PastSaid {
    pub moved: bool,
    pub of: Option<PastOf>,
    pub change: Option<String>,
    pub back: usize,
    pub forward: usize,
    pub camera: Camera,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SplitSaid {
    pub halves: Vec<[PartId; 2]>,
    pub parts: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartSaid {
    pub part: PartRecord,
    /// What is other about its look.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<LookChange>,
}

/// `part.reset`: how many parts there are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WholeSaid {
    pub parts: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DegreeSaid {
    pub degree: f64,
    /// What is missing where nothing can move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<&'static str>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForcesSaid {
    pub forces: Forces,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeedSaid {
    pub seed: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettledSaid {
    pub poses: Vec<PartPose>,
    pub gains: Vec<f64>,
    pub rounds: u32,
    pub steps: u32,
    pub at_rest: bool,
    pub visible: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<&'static str>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MovedSaid {
    pub poses: Vec<PartPose>,
    /// Whether more is to come.
    pub moving: bool,
    pub visible: Option<f64>,
}

/// `history.undo`, `history.redo`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TravelledSaid {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undone: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub redone: Option<Vec<String>>,
    /// How many can be taken back now.
    pub undo: usize,
    /// How many can be done again now.
    pub redo: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BudgetSaid {
    pub budget: u64,
    pub memory: u64,
    pub disk: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupSaid {
    pub group: GroupState,
    /// Of a group that is closed: its step, `None` if nothing changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<Option<String>>,
}

/// What became of a group of steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GroupState {
    Open,
    Closed,
    Cancelled,
}

/// The scene, its parts where they stand now.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSaid {
    pub scene: Scene,
    pub parts: Vec<PartRecord>,
}

impl Serialize for SceneSaid {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut scene = self.scene.said();
        scene["explosion"]["parts"] = serde_json::to_value(&self.parts).map_err(S::Error::custom)?;
        let mut said = to.serialize_struct("SceneSaid", 1)?;
        said.serialize_field("scene", &scene)?;
        said.end()
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureSaid {
    pub path: String,
    pub view: ViewName,
    pub size: [u32; 2],
    pub supersample: u32,
    /// Share of the pixels where anything is.
    pub covered: f64,
}
