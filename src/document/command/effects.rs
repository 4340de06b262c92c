//! What a command means for everything around what it does: one exhaustive match, read by all who ask.
//!
//! The document asks what ends a running stroke and what is a change of view; the journal what it notes; the window which pictures
//! are drawn anew, and what it says while it waits. Owns these answers; knows commands, and neither the
//! document nor what a command does. A new verb does not compile until it has said all of it here.

use crate::document::command::annotations::{AnnotationCommand, CutawayCommand, LabelCommand};
use crate::document::command::brush::{BrushCommand, StrokeCommand};
use crate::document::command::component::ComponentCommand;
use crate::document::command::files::{ProjectCommand, RenderCommand, VolumeCommand};
use crate::document::command::parts::{ExplosionCommand, PartCommand};
use crate::document::command::sub_volumes::SubVolumeCommand;
use crate::document::command::views::{TransferCommand, ViewCommand};
use crate::document::command::{Command, HistoryCommand, Question, SegmentCommand, SelectionCommand};

/// What one command means for journal, past, pictures and whoever waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effects {
    /// `noun.verb`, as scripts have it.
    pub name: &'static str,
    /// A stroke that runs is ended first, as `stroke.end` would.
    pub ends_stroke: bool,
    /// What the past of views and looks makes of it.
    pub past: Remembered,
    /// Pictures that may be other ones afterwards.
    pub redraws: Redraws,
    /// Another document is open afterwards.
    pub opens: bool,
    /// How long it may take.
    pub lasts: Lasts,
    /// What the journal makes of it.
    pub journal: Noted,
    /// Somebody waits for its answer.
    pub is_awaited: bool,
}

/// Pictures that a command may change, beside those whose camera or plane it moves: these tell it themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redraws {
    /// The 3D view.
    pub three_d: bool,
    /// All slices.
    pub slices: bool,
}

/// What `view.back` can take back of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remembered {
    /// Looks, if it changed any.
    Looks,
    /// That another thing is looked at, too.
    View,
    /// Nothing: it walks there itself.
    Nothing,
}

/// How long a command may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lasts {
    /// Not long enough to be told.
    AtOnce,
    /// Over a tenth of a second: what is done meanwhile, in words.
    AWhile(&'static str),
    /// The same with a file or folder whose name follows.
    AWhileWith(&'static str),
}

/// What the journal makes of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noted {
    /// Nothing.
    Never,
    /// What it changed, as a step of work.
    Step,
    /// The same, and samples of the stroke that ran are done with.
    Stroke,
    /// What a file was opened as: it is read again from the file, and is no step of work.
    Opening,
}

impl Redraws {
    /// No picture.
    pub const NONE: Self = Self { three_d: false, slices: false };
    /// All slices.
    pub const SLICES: Self = Self { three_d: false, slices: true };
    /// The 3D view.
    pub const THREE_D: Self = Self { three_d: true, slices: false };
    /// Every picture.
    pub const ALL: Self = Self { three_d: true, slices: true };
}

impl Effects {
    /// A question: nothing is changed.
    const fn question(name: &'static str) -> Self {
        Self {
            name,
            ends_stroke: false,
            past: Remembered::Looks,
            redraws: Redraws::NONE,
            opens: false,
            lasts: Lasts::AtOnce,
            journal: Noted::Never,
            is_awaited: false,
        }
    }

    /// The disk: what is open stays as it is.
    const fn of_files(name: &'static str) -> Self {
        Self { ends_stroke: true, is_awaited: true, ..Self::question(name) }
    }

    /// Another document.
    const fn opening(name: &'static str) -> Self {
        Self { opens: true, redraws: Redraws::ALL, ..Self::of_files(name) }
    }

    /// A change that is noted; without a word on what it changes it may be anything.
    const fn change(name: &'static str) -> Self {
        Self { ends_stroke: true, redraws: Redraws::ALL, journal: Noted::Step, ..Self::question(name) }
    }

    /// A move of a view: who paints may look about.
    const fn of_view(name: &'static str) -> Self {
        Self { ends_stroke: false, past: Remembered::View, redraws: Redraws::NONE, ..Self::change(name) }
    }

    /// A change of parts or forces: slices show the volume at rest.
    const fn of_parts(name: &'static str) -> Self {
        Self { redraws: Redraws::THREE_D, ..Self::change(name) }
    }

    const fn awaited(self) -> Self {
        Self { is_awaited: true, ..self }
    }

    const fn lasting(self, lasts: Lasts) -> Self {
        Self { lasts, is_awaited: true, ..self }
    }
}

impl Command {
    /// What it means for everything around it.
    pub fn effects(&self) -> Effects {
        match self {
            Self::Project(command) => command.effects(),
            Self::Volume(command) => command.effects(),
            Self::SubVolume(command) => command.effects(),
            Self::Transfer(command) => command.effects(),
            Self::View(command) => command.effects(),
            Self::Brush(command) => command.effects(),
            Self::Stroke(command) => command.effects(),
            Self::Component(command) => command.effects(),
            Self::Selection(command) => command.effects(),
            Self::Segment(command) => command.effects(),
            Self::Part(command) => command.effects(),
            Self::Explosion(command) => command.effects(),
            Self::Annotation(command) => command.effects(),
            Self::Label(command) => command.effects(),
            Self::Cutaway(command) => command.effects(),
            Self::History(command) => command.effects(),
            Self::Ask(question) => question.effects(),
            Self::Render(command) => command.effects(),
        }
    }
}

impl ProjectCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Open { .. } => Effects::opening("project.open").lasting(Lasts::AWhileWith("Opening")),
            Self::Recover { .. } => Effects::opening("project.recover").lasting(Lasts::AWhile("Recovering")),
            Self::Save { .. } => Effects::of_files("project.save").lasting(Lasts::AWhile("Saving")),
            Self::Lost {} => Effects::of_files("project.lost"),
            Self::Forget { .. } => Effects::of_files("project.forget"),
        }
    }
}

impl VolumeCommand {
    fn effects(&self) -> Effects {
        // How volumes are shown goes with their step.
        let undone = |name| Effects { past: Remembered::Nothing, ..Effects::change(name) };
        match self {
            Self::Open { .. } => Effects {
                journal: Noted::Opening,
                ..Effects::opening("volume.open").lasting(Lasts::AWhileWith("Opening"))
            },
            Self::Add { .. } => undone("volume.add").lasting(Lasts::AWhileWith("Opening")),
            Self::Remove { .. } => undone("volume.remove"),
            Self::Set { .. } => undone("volume.set"),
            Self::Export { .. } => Effects::of_files("volume.export").lasting(Lasts::AWhileWith("Exporting")),
        }
    }
}

impl SubVolumeCommand {
    fn effects(&self) -> Effects {
        let undone = |name| Effects { past: Remembered::Nothing, ..Effects::change(name) };
        match self {
            Self::Add { .. } => undone("sub_volume.add").lasting(Lasts::AWhile("Making a sub-volume")),
            Self::Set { .. } => undone("sub_volume.set").lasting(Lasts::AWhile("Changing a sub-volume")),
            Self::Remove { .. } => undone("sub_volume.remove").lasting(Lasts::AWhile("Removing a sub-volume")),
            Self::Bake { .. } => undone("sub_volume.bake").lasting(Lasts::AWhile("Baking a sub-volume")),
            Self::Export { .. } => Effects::of_files("sub_volume.export").lasting(Lasts::AWhileWith("Exporting")),
        }
    }
}

impl TransferCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Set { .. } => Effects::change("transfer.set"),
            Self::Reset { .. } => Effects::change("transfer.reset"),
        }
    }
}

impl ViewCommand {
    fn effects(&self) -> Effects {
        let walks = |name| Effects { past: Remembered::Nothing, ..Effects::change(name) };
        match self {
            Self::Camera { .. } => Effects::of_view("view.camera"),
            Self::Frame { .. } => Effects::of_view("view.frame"),
            Self::Fit { .. } => Effects::of_view("view.fit"),
            Self::Orbit { .. } => Effects::of_view("view.orbit"),
            Self::Pan { .. } => Effects::of_view("view.pan"),
            Self::Zoom { .. } => Effects::of_view("view.zoom"),
            Self::Crosshair { .. } => Effects::of_view("view.crosshair"),
            Self::Scroll { .. } => Effects::of_view("view.scroll"),
            // The window's size is nobody's change of view.
            Self::Size { .. } => Effects { past: Remembered::Looks, ..Effects::of_view("view.size") },
            Self::Look { .. } => Effects { redraws: Redraws::THREE_D, ..Effects::change("view.look") },
            Self::Focus(_) => Effects { redraws: Redraws::THREE_D, ..Effects::change("view.focus") },
            Self::Window { .. } => Effects { redraws: Redraws::SLICES, ..Effects::change("view.window") },
            Self::Layer(_) => Effects::change("view.layer"),
            Self::Back { .. } => walks("view.back"),
            Self::Forward { .. } => walks("view.forward"),
        }
    }
}

impl BrushCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Set(_) => Effects { redraws: Redraws::NONE, ..Effects::change("brush.set") },
            Self::Also { .. } => Effects { redraws: Redraws::NONE, ..Effects::change("brush.also") },
        }
    }
}

impl StrokeCommand {
    fn effects(&self) -> Effects {
        let paints = |name| Effects {
            // It knows itself whether one runs.
            ends_stroke: false,
            journal: Noted::Never,
            ..Effects::change(name)
        };
        // Samples are noted as they come; the end is noted as the whole stroke.
        let ends = |name| Effects { journal: Noted::Stroke, ..paints(name) };
        match self {
            Self::Paint { .. } => ends("stroke.paint"),
            Self::Lasso(_) => ends("stroke.lasso"),
            Self::Begin { .. } => paints("stroke.begin"),
            Self::Extend { .. } => paints("stroke.extend"),
            Self::End {} => ends("stroke.end"),
            Self::Cancel {} => paints("stroke.cancel"),
        }
    }
}

impl ComponentCommand {
    fn effects(&self) -> Effects {
        let (name, doing) = match self {
            Self::Keep(_) => ("component.keep", "Isolating"),
            Self::Remove(_) => ("component.remove", "Removing"),
            Self::Select(_) => ("component.select", "Selecting"),
            Self::Label(_) => ("component.label", "Labelling"),
        };
        Effects::change(name).lasting(Lasts::AWhile(doing))
    }
}

impl SelectionCommand {
    fn effects(&self) -> Effects {
        Effects::change(match self {
            Self::Import { .. } => "selection.import",
            Self::FromLabel { .. } => "selection.from_label",
            Self::Clear { .. } => "selection.clear",
            Self::Set { .. } => return Effects { redraws: Redraws::THREE_D, ..Effects::change("selection.set") },
        })
        .lasting(Lasts::AWhile("Selecting"))
    }
}

impl SegmentCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Set { .. } => Effects::change("segment.set"),
            Self::ShowOnly { .. } => Effects { redraws: Redraws::THREE_D, ..Effects::change("segment.show_only") },
            Self::Remove { .. } => Effects::change("segment.remove").lasting(Lasts::AWhile("Removing a segment")),
            Self::Import { .. } => Effects::change("segment.import").lasting(Lasts::AWhile("Importing segments")),
        }
    }
}

impl PartCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Split { .. } => Effects::of_parts("part.split"),
            Self::Set { .. } => Effects::of_parts("part.set"),
            Self::Move { .. } => Effects::of_parts("part.move"),
            Self::Reset {} => Effects::of_parts("part.reset"),
        }
    }
}

impl ExplosionCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Degree { .. } => Effects::of_parts("explosion.degree"),
            Self::Forces { .. } => Effects::of_parts("explosion.forces"),
            Self::Seed { .. } => Effects::of_parts("explosion.seed"),
            // Where parts come to stand was decided by nobody.
            Self::Settle {} => Effects {
                journal: Noted::Never,
                ..Effects::of_parts("explosion.settle").lasting(Lasts::AWhile("Settling parts"))
            },
            Self::Step { .. } => {
                Effects { ends_stroke: false, journal: Noted::Never, ..Effects::of_parts("explosion.step") }
            }
        }
    }
}

impl AnnotationCommand {
    fn effects(&self) -> Effects {
        // Slices show the volume without them.
        match self {
            Self::Add(_) => Effects::of_parts("annotation.add").lasting(Lasts::AWhile("Laying an annotation")),
            Self::Set(_) => Effects::of_parts("annotation.set").awaited(),
            Self::Remove { .. } => Effects::of_parts("annotation.remove"),
        }
    }
}

impl LabelCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Add(_) => Effects::of_parts("label.add").awaited(),
            Self::Set(_) => Effects::of_parts("label.set"),
            Self::Remove { .. } => Effects::of_parts("label.remove"),
            Self::FromSegments { .. } => {
                Effects::of_parts("label.from_segments").lasting(Lasts::AWhile("Labelling segments"))
            }
            Self::Style { .. } => Effects::of_parts("label.style"),
        }
    }
}

impl CutawayCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Add(_) => Effects::of_parts("cutaway.add").lasting(Lasts::AWhile("Opening a window")),
            Self::Set(_) => Effects::of_parts("cutaway.set").awaited(),
            Self::Remove { .. } => Effects::of_parts("cutaway.remove"),
        }
    }
}

impl HistoryCommand {
    fn effects(&self) -> Effects {
        let keeps = |name| Effects { ends_stroke: true, ..Effects::question(name) };
        match self {
            Self::Undo { .. } => Effects::change("history.undo").lasting(Lasts::AWhile("Undoing")),
            Self::Redo { .. } => Effects::change("history.redo").lasting(Lasts::AWhile("Redoing")),
            Self::Cancel {} => Effects::change("history.cancel"),
            Self::Begin {} => keeps("history.begin"),
            Self::End {} => keeps("history.end"),
            Self::Budget { .. } => keeps("history.budget"),
        }
    }
}

impl Question {
    fn effects(&self) -> Effects {
        Effects::question(match self {
            Self::Volume { .. } => "ask.volume",
            Self::SubVolumes { .. } => "ask.sub_volumes",
            Self::SubVolumeFit { .. } => "ask.sub_volume_fit",
            Self::Scene {} => "ask.scene",
            Self::Parts {} => "ask.parts",
            Self::Voxel { .. } => "ask.voxel",
            Self::Pick { .. } => "ask.pick",
            Self::Field { .. } => "ask.field",
            Self::Contact { .. } => "ask.contact",
            Self::Visibility { .. } => "ask.visibility",
            Self::Annotations { .. } => "ask.annotations",
            Self::Labels { .. } => "ask.labels",
            Self::Cutaways { .. } => "ask.cutaways",
            Self::History { .. } => "ask.history",
        })
    }
}

impl RenderCommand {
    fn effects(&self) -> Effects {
        match self {
            Self::Image { .. } => Effects::of_files("render.image").lasting(Lasts::AWhile("Drawing a picture")),
        }
    }
}
