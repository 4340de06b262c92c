//! Gestures on slices: crosshair, the grey window under the right button, and cuts that are seen as lines.

use crate::document::{
    Command, HistoryCommand, PartCommand, Place, Scene, SlicePlane, Splitter, ViewCommand, ViewName, Window,
};
use crate::explode::{Axis, Cut, Part, PartId, Poses};
use crate::math::{DVec2, DVec3, Plane, Ray};
use crate::volume::Grid;

/// A slice under a splitter: slices show the volume at rest, so cuts made there are cuts at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSlice {
    /// Where the slice's pixels are.
    pub plane: SlicePlane,
    /// Where the slice is seen along: a cut that is a line here goes on this way. World, any length.
    pub through: DVec3,
}

impl CutSlice {
    /// The slice of a view of `size` pixels; `None` for the 3D view.
    pub fn new(grid: &Grid, scene: &Scene, view: ViewName, size: [u32; 2]) -> Option<Self> {
        let mut views = scene.views.clone();
        views.slices[view.slice()?].size = size;
        let plane = SlicePlane::new(grid, &views, view)?;
        Some(Self { plane, through: grid.world_from_index.matrix3.col(plane.axis) })
    }

    /// The cut along a line of the picture; `None` if the line has no length.
    pub fn along(&self, from: DVec2, to: DVec2) -> Option<Plane> {
        let along = self.plane.world(to) - self.plane.world(from);
        Plane::through(self.plane.world(from), along.cross(self.through)).filter(|p| p.normal.is_finite())
    }

    /// The cut through a pixel, along the picture's width or height.
    pub fn across(&self, px: DVec2, axis: Axis) -> Option<Plane> {
        let step = match axis {
            Axis::Horizontal => DVec2::X,
            Axis::Vertical => DVec2::Y,
        };
        self.along(px, px + step)
    }

    /// The cut that is the slice itself.
    pub fn flat(&self) -> Option<Plane> {
        Plane::through(self.plane.centre, self.plane.right.cross(self.plane.up))
    }
}

/// What a click on a slice cuts: the part under it, along a plane.
pub(super) fn cuts_at(slice: &CutSlice, scene: &Scene, plane: Option<Plane>, px: DVec2) -> Vec<Cut> {
    let Some(plane) = plane else { return Vec::new() };
    let under = scene.explosion.holding(slice.plane.world(px));
    under.into_iter().map(|p| Cut { part: p.id, plane }).collect()
}

/// What a line on a slice cuts: every part that it crosses.
pub(super) fn cuts_along(slice: &CutSlice, scene: &Scene, from: DVec2, to: DVec2) -> Vec<Cut> {
    let Some(plane) = slice.along(from, to) else { return Vec::new() };
    let (a, b) = (slice.plane.world(from), slice.plane.world(to));
    scene.explosion.parts.iter().filter(|p| crosses(p, a, b)).map(|p| Cut { part: p.id, plane }).collect()
}

/// Cuts of parts as they stand along a plane of the world, as cuts at rest; none where there is no plane.
pub(super) fn cuts_of(
    (scene, poses): (&Scene, &Poses),
    parts: impl IntoIterator<Item = PartId>,
    plane: Option<Plane>,
) -> Vec<Cut> {
    let Some(plane) = plane else { return Vec::new() };
    let parts = parts.into_iter().filter_map(|id| scene.explosion.part(id).ok());
    parts.map(|p| Cut { part: p.id, plane: poses.of(p).unapply_plane(&plane) }).collect()
}

/// Whether a line from point to point goes through a part at rest.
fn crosses(part: &Part, a: DVec3, b: DVec3) -> bool {
    let planes: Vec<Plane> = part.faces.iter().map(|f| f.plane).collect();
    Ray { origin: a, dir: b - a }.clip(&planes, 0.0, 1.0).is_some()
}

/// Cuts as commands; several are one step of history.
pub(super) fn split(cuts: &[Cut]) -> Vec<Command> {
    let one = |cut: &Cut| {
        let point = (cut.plane.normal * cut.plane.offset).to_array();
        let by = Splitter::Plane { point, normal: cut.plane.normal.to_array(), part: Some(cut.part) };
        Command::Part(PartCommand::Split { by, size: None })
    };
    let mut commands: Vec<Command> = cuts.iter().map(one).collect();
    if commands.len() > 1 {
        commands.insert(0, Command::History(HistoryCommand::Begin {}));
        commands.push(Command::History(HistoryCommand::End {}));
    }
    commands
}

/// Moves the crosshair to a pixel of a view.
pub(super) fn crosshair(view: ViewName, px: DVec2, size: [u32; 2]) -> Command {
    let at = Place::Pixel { view, px: px.to_array(), size: Some(size) };
    Command::View(ViewCommand::Crosshair { at })
}

/// The grey window after a drag: right widens, down darkens. The picture's height is worth twice the width at the start, so that
/// the hand's measure follows the data's; digits that mean nothing are left out.
pub(super) fn windowed(start: Window, moved_px: DVec2, height_px: u32) -> Window {
    let share = moved_px / f64::from(height_px.max(1));
    let width = (start.width * (share.x * 2.0).exp2()).max(f64::MIN_POSITIVE);
    Window { level: start.level + share.y * start.width * 2.0, width }.rounded()
}

/// As a command.
pub(super) fn set_window(window: Window) -> Command {
    Command::View(ViewCommand::Window { level: window.level, width: window.width, volume: None })
}
