//! The window's line to the document, which lives on a thread of its own so that no command and no picture ever holds the window.
//!
//! Requests go one way, reports come back; both ends are plain channels, so that a test can stand at the other end. Every request has
//! a serial; a snapshot says which was the last that it knows of.

use crate::document::answers::Answer;
use crate::document::answers_ask::VoxelSaid;
use crate::document::{Aim, Command, Ground, LabelAnchor, RenderCommand, Scene, ViewName};
use crate::explode::Poses;
use crate::gpu::ObjectId;
use crate::interact::Written;
use crate::interact::boxes::BoxCorners;
use crate::math::{Camera, DVec2, DVec3};
use crate::ui::thread::stop::Stop;
use crate::volume::{Grid, Histogram, Statistics, VolumeId, VoxelType};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// What the window asks for.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a change of the brush is made by hand, one at a time")]
pub enum Request {
    /// To be done in the order sent.
    Apply(Command),
    /// What is under the pointer; only the last one asked is answered.
    Probe {
        /// View.
        view: ViewName,
        /// Pixel of it.
        px: DVec2,
        /// Its size in pixels.
        size: [u32; 2],
    },
    /// The views that are on the screen.
    Show(Vec<ViewName>),
    /// The view that something is held in: pictures may be coarse meanwhile, and this one comes first.
    Held(Option<ViewName>),
    /// Where the brush is: pictures with a focus follow it.
    Aim(Option<Aim>),
    /// A small picture that shows what a large one will be; its path is not looked at.
    Sketch(RenderCommand),
    /// The window is closed in order; what is not saved may be thrown away.
    Quit,
}

/// What the window shows.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Serial of the last request that this knows of.
    pub serial: u64,
    /// What is open.
    pub open: Option<OpenDocument>,
    /// Steps that undo takes back, the oldest first.
    pub undo: Vec<String>,
    /// Steps that redo does again, the next first.
    pub redo: Vec<String>,
    /// The project's folder, once saved.
    pub project: Option<PathBuf>,
    /// Whether there is something to lose.
    pub unsaved: bool,
    /// The GPU's name, or why there is none.
    pub gpu: Option<Result<String, String>>,
    /// Whether parts are still on their way.
    pub moving: bool,
    /// Whether anything is selected, for parts to make way for.
    pub selected: bool,
    /// The change of views or looks that `view.back` takes back.
    pub back: Option<String>,
    /// The one that `view.forward` brings again.
    pub forward: Option<String>,
}

impl Snapshot {
    /// Where what is open is kept: its project, or the file that it began with.
    pub fn place<'a>(&'a self, open: &'a OpenDocument) -> &'a Path {
        let file = || open.scene.origin().map_or(Path::new(""), |origin| &origin.path);
        self.project.as_deref().unwrap_or_else(file)
    }
}

/// The open volume.
#[derive(Clone, Debug)]
pub struct OpenDocument {
    /// Another number for each document that was opened.
    pub opening: u64,
    /// Everything but voxels.
    pub scene: Arc<Scene>,
    /// Where its parts stand.
    pub poses: Arc<Poses>,
    /// Its lattice.
    pub grid: Grid,
    /// The middle of every volume where its file puts it, world mm.
    pub centres: BTreeMap<VolumeId, DVec3>,
    /// Corners of the sub-volumes that pictures show, where they lie, world mm.
    pub boxes: Arc<BoxCorners>,
    /// Where what is written on surfaces has its middle, and where leaders of labels end, world mm as posed.
    pub written: BTreeMap<Written, DVec3>,
    /// What the labels that are shown name.
    pub labels: Arc<Vec<LabelAnchor>>,
    /// Bytes that an edited sample takes in each volume.
    pub sample_bytes: BTreeMap<VolumeId, u64>,
    /// The source's numeric type.
    pub voxel_type: VoxelType,
    /// Of the source's values.
    pub statistics: Statistics,
    /// Of the active volume's values; the same as long as it is active, and no longer.
    pub histogram: Arc<Histogram>,
}

impl OpenDocument {
    /// What reducers are given beside the scene.
    pub fn ground(&self) -> Ground<'_> {
        Ground { grid: &self.grid, bounds: self.grid.world_bounds(), histogram: &self.histogram, poses: &self.poses }
    }

    /// The smallest and the largest value; of a volume without any the ends of its histogram.
    pub fn ends(&self) -> [f64; 2] {
        let Statistics { min, max, .. } = self.statistics;
        if min <= max { [min, max] } else { [self.histogram.min, self.histogram.max] }
    }
}

/// A picture of a view.
#[derive(Clone, Debug)]
pub struct Picture {
    /// View.
    pub view: ViewName,
    /// Pixels; may be fewer than the view has.
    pub size: [u32; 2],
    /// Display-referred r, g, b, a.
    pub rgba: Vec<u8>,
    /// Only of the 3D view: mm along each pixel's ray, infinite where nothing is.
    pub depth_mm: Vec<f32>,
    /// Only of the 3D view: body id + 1, 0 where nothing is.
    pub object: Vec<ObjectId>,
    /// The camera that drew it.
    pub camera: Camera,
    /// Serial of the last request that it shows.
    pub serial: u64,
}

/// How grave a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something was done that took a while.
    Note,
    /// Done, but.
    Warning,
    /// Not done.
    Error,
}

/// What the user can do about something that went wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Offer {
    /// What it is about, in some words.
    pub title: String,
    /// What went wrong.
    pub text: String,
    /// What puts it right.
    pub then: Then,
}

/// See [`Offer::then`].
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
pub enum Then {
    /// A command, and what its button says.
    Do(String, Command),
    /// The file of this project's volume has to be named.
    FindSource(PathBuf),
}

/// What comes back.
#[derive(Clone, Debug)]
pub enum Report {
    /// The document changed.
    Snapshot(Arc<Snapshot>),
    /// What was asked for by [`Request::Sketch`]: pixels and display-referred r, g, b, a, or why not.
    Sketch(RenderCommand, Result<([u32; 2], Vec<u8>), String>),
    /// A view was drawn.
    Picture(Box<Picture>),
    /// The voxel under the pointer; `None` if nobody can tell.
    Probe(Option<VoxelSaid>),
    /// Whether the 3D view is to be drawn anew, or finer.
    Refining(bool),
    /// Something was done and came to nothing: a sentence for where the hand is.
    Nothing(String),
    /// Something began that takes its time.
    Started(String),
    /// Percent of it that is done; what tells this can be stopped.
    Progress(u32),
    /// It ended.
    Finished,
    /// For the user.
    Message(Severity, String),
    /// Something went wrong that the user can put right.
    Offer(Box<Offer>),
    /// A command was done; its answer.
    Done(Box<Command>, Box<Answer>),
    /// A command was not done; why.
    Refused(Box<Command>, String),
    /// Something else was not done, by a name of its own; why.
    Complaint(String, String),
    /// What was refused before, as `noun.verb`, has now worked.
    Mended(String),
}

/// The window's end.
#[derive(Debug)]
pub struct Session {
    requests: Sender<(u64, Request)>,
    reports: Receiver<Report>,
    serial: u64,
    stop: Stop,
}

/// The other end.
#[derive(Debug)]
pub struct WorkerEnd {
    /// Requests with their serials.
    pub requests: Receiver<(u64, Request)>,
    /// Back to the window.
    pub reports: Sender<Report>,
    /// Whether what runs shall stop.
    pub stop: Stop,
}

impl Session {
    /// Both ends.
    pub fn pair() -> (Self, WorkerEnd) {
        let (to_worker, requests) = channel();
        let (reports, from_worker) = channel();
        let stop = Stop::default();
        let near = Self { requests: to_worker, reports: from_worker, serial: 0, stop: stop.clone() };
        (near, WorkerEnd { requests, reports, stop })
    }

    /// Sends a request; `false` if nobody is there any more.
    pub fn send(&mut self, request: Request) -> bool {
        // Only commands count: a snapshot need not wait for the pointer's last move.
        self.serial += u64::from(matches!(request, Request::Apply(_)));
        self.requests.send((self.serial, request)).is_ok()
    }

    /// Asks whatever runs now to stop; what cannot be stopped goes on.
    pub fn stop(&self) {
        self.stop.set(true);
    }

    /// Serial of the last request.
    pub(crate) fn serial(&self) -> u64 {
        self.serial
    }

    /// What came since the last time.
    pub fn reports(&self) -> Vec<Report> {
        self.reports.try_iter().collect()
    }
}
