//! What a held button is doing, from its press to its release.

use crate::document::{
    Command, HistoryCommand, PartCommand, Place, Scene, Splitter, StrokeCommand, StrokePoint, ViewCommand, ViewName,
    Window,
};
use crate::explode::{Axis, PartId};
use crate::interact::brush::set_erase;
use crate::interact::event::{Hit, PointerEvent};
use crate::interact::slices::{CutSlice, crosshair, cuts_on, set_window, split as split_slice, windowed};
use crate::interact::tool::Tool;
use crate::math::{Camera, DQuat, DVec2, DVec3, Pose};

/// A press this close to its release, in pixels, is a click; a hand that lets go of key and button moves no further between.
const CLICK_PX: f64 = 4.0;
/// Degrees that a drag across the picture's height turns.
const DEGREES_PER_HEIGHT: f64 = 180.0;

/// What a held button does. Positions are pixels of the view where it began.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // fields: the variant's own text says what they are
pub enum Gesture {
    /// Turns the camera; one change of view, as pan, zoom and crosshair are. `start` comes back on abort.
    Orbit { start: Camera, last: DVec2 },
    /// Shifts a view.
    Pan { view: ViewName, start: DVec2, last: DVec2 },
    /// Zooms a view.
    Zoom { view: ViewName, start: DVec2, last: DVec2 },
    /// Grey window of the slices; one step of history.
    Window { start: Window, from: DVec2 },
    /// Crosshair follows; `start` comes back on abort.
    Crosshair { view: ViewName, start: DVec3 },
    /// A stroke. `erase`: the brush is set to take away for as long as the key is held; `fixed`: it takes away anyway.
    Stroke { view: ViewName, last: PointerEvent, erase: bool, fixed: bool },
    /// A splitter that waits for its click to end; on a slice with where that lies.
    Click { tool: Tool, from: DVec2, axis: Axis, slice: Option<CutSlice> },
    /// The line splitter's line.
    Line { view: ViewName, from: DVec2, to: DVec2, slice: Option<CutSlice> },
    /// A part under the hand; one step of history.
    Part { id: PartId, start: Pose, from: DVec2, hit: Hit, turn: bool, centre: DVec3, moved: bool },
}

impl Gesture {
    /// Commands of its start.
    pub(super) fn start(&self, e: &PointerEvent) -> Vec<Command> {
        match self {
            Self::Crosshair { view, .. } => {
                vec![Command::History(HistoryCommand::Begin {}), crosshair(*view, e.px, e.size)]
            }
            Self::Stroke { erase, .. } => {
                let begin = Command::Stroke(StrokeCommand::Begin { points: vec![stroke_point(e)], volume: None });
                if *erase { vec![set_erase(true), begin] } else { vec![begin] }
            }
            Self::Window { .. } | Self::Part { .. } | Self::Orbit { .. } | Self::Pan { .. } | Self::Zoom { .. } => {
                vec![Command::History(HistoryCommand::Begin {})]
            }
            Self::Click { .. } | Self::Line { .. } => Vec::new(),
        }
    }

    /// The pointer moved.
    pub(super) fn drag(&mut self, e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        let height = e.size[1].max(1);
        match self {
            Self::Orbit { last, .. } => {
                let d = (e.px - *last) / f64::from(height) * DEGREES_PER_HEIGHT;
                *last = e.px;
                vec![Command::View(ViewCommand::Orbit { azimuth_deg: -d.x, elevation_deg: d.y })]
            }
            Self::Pan { view, last, .. } => {
                let px = (e.px - *last).to_array();
                *last = e.px;
                vec![Command::View(ViewCommand::Pan { view: *view, px })]
            }
            Self::Zoom { view, last, .. } => {
                let factor = zoom_factor(*last, e.px, height);
                *last = e.px;
                vec![Command::View(ViewCommand::Zoom { view: *view, factor })]
            }
            Self::Window { start, from } => vec![set_window(windowed(*start, e.px - *from, height))],
            Self::Crosshair { view, .. } => vec![crosshair(*view, e.px, e.size)],
            Self::Stroke { last, erase, fixed, .. } => {
                let switch = !*fixed && e.modifiers.erase != *erase;
                if e.px == last.px || switch && e.px.distance(last.px) <= CLICK_PX {
                    return Vec::new();
                }
                let mut commands = Vec::new();
                if switch {
                    // From where the key changed on it is another stroke.
                    *erase = e.modifiers.erase;
                    let begin = StrokeCommand::Begin { points: vec![stroke_point(last)], volume: None };
                    commands.push(Command::Stroke(StrokeCommand::End {}));
                    commands.extend([set_erase(*erase), Command::Stroke(begin)]);
                }
                *last = *e;
                commands.push(Command::Stroke(StrokeCommand::Extend { points: vec![stroke_point(e)] }));
                commands
            }
            Self::Click { .. } => Vec::new(),
            Self::Line { to, .. } => {
                *to = e.px;
                Vec::new()
            }
            Self::Part { id, start, from, hit, turn, centre, moved } => {
                // A click alone must not pin the part.
                *moved |= e.px != *from;
                if !*moved {
                    return Vec::new();
                }
                let pose = pose_of_drag(&scene.views.camera, *start, *from, e, hit, *turn, *centre);
                vec![Command::Part(PartCommand::Move { id: *id, pose })]
            }
        }
    }

    /// The button went up.
    pub(super) fn commit(self, e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        let split = |by| vec![Command::Part(PartCommand::Split { by, size: Some(e.size) })];
        match self {
            Self::Stroke { erase, .. } => {
                let end = Command::Stroke(StrokeCommand::End {});
                if erase { vec![end, set_erase(false)] } else { vec![end] }
            }
            Self::Click { tool, from, axis, slice: Some(slice) } if from.distance(e.px) <= CLICK_PX => {
                split_slice(&cuts_on(&slice, scene, tool, (from, from), axis))
            }
            Self::Line { from, to, slice: Some(slice), .. } if from.distance(to) > CLICK_PX => {
                split_slice(&cuts_on(&slice, scene, Tool::LineSplit, (from, to), Axis::Horizontal))
            }
            Self::Click { tool, from, axis, .. } if from.distance(e.px) <= CLICK_PX => match tool {
                Tool::DepthSplit => split(Splitter::Depth { px: from.to_array() }),
                _ => split(Splitter::Axis { px: from.to_array(), axis }),
            },
            Self::Line { from, to, .. } if from.distance(to) > CLICK_PX => {
                split(Splitter::Line { from: from.to_array(), to: to.to_array() })
            }
            Self::Click { .. } | Self::Line { .. } => Vec::new(),
            _ => vec![Command::History(HistoryCommand::End {})],
        }
    }

    /// Everything as it was at the start.
    pub(super) fn abort(self, height: u32) -> Vec<Command> {
        let end = Command::History(HistoryCommand::End {});
        match self {
            Self::Orbit { start, .. } => vec![Command::View(ViewCommand::Camera { camera: start }), end],
            Self::Pan { view, start, last } => {
                vec![Command::View(ViewCommand::Pan { view, px: (start - last).to_array() }), end]
            }
            Self::Zoom { view, start, last } => {
                vec![Command::View(ViewCommand::Zoom { view, factor: zoom_factor(last, start, height.max(1)) }), end]
            }
            Self::Crosshair { start, .. } => {
                vec![Command::View(ViewCommand::Crosshair { at: Place::Mm(start.to_array()) }), end]
            }
            Self::Stroke { erase, .. } => {
                let cancel = Command::Stroke(StrokeCommand::Cancel {});
                if erase { vec![cancel, set_erase(false)] } else { vec![cancel] }
            }
            Self::Window { .. } | Self::Part { .. } => vec![Command::History(HistoryCommand::Cancel {})],
            Self::Click { .. } | Self::Line { .. } => Vec::new(),
        }
    }
}

fn stroke_point(e: &PointerEvent) -> StrokePoint {
    let at = Place::Pixel { view: e.view, px: e.px.to_array(), size: Some(e.size) };
    StrokePoint { at, pressure: e.pressure, breaks: false, normal: None }
}

fn zoom_factor(from: DVec2, to: DVec2, height: u32) -> f64 {
    ((to.y - from.y) / f64::from(height) * 3.0).exp2()
}

/// Where a part is after a drag: shifted in the plane of the picture at the depth where it was taken, or turned about its centre.
fn pose_of_drag(
    camera: &Camera,
    start: Pose,
    from: DVec2,
    e: &PointerEvent,
    hit: &Hit,
    turn: bool,
    centre: DVec3,
) -> Pose {
    let d = e.px - from;
    let (right, up) = camera.right_up();
    if turn {
        let angle = d / f64::from(e.size[1].max(1)) * DEGREES_PER_HEIGHT.to_radians();
        let rotation = DQuat::from_axis_angle(up, angle.x) * DQuat::from_axis_angle(right, angle.y);
        let about = Pose::about(start.apply(centre), rotation, DVec3::ZERO);
        return Pose { rotation: rotation * start.rotation, translation: about.apply(start.translation) };
    }
    let mm = camera.mm_per_pixel(hit.depth_mm, e.size[1]);
    Pose { translation: start.translation + right * (d.x * mm) - up * (d.y * mm), ..start }
}
