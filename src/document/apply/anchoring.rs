//! From pixels and places to what annotations, labels and cutaways keep of them: indices of a volume, and the value of the surface there.
//!
//! So that a command means the same whatever is seen when it is done again. Owns which surface a pick of matter without one is on.

use crate::annotate::surface::{Surface, normal};
use crate::document::Document;
use crate::document::command::annotations::{
    AnnotationChange, AnnotationCommand, CutawayChange, CutawayCommand, LabelChange, LabelCommand,
};
use crate::document::command::{Command, Place};
use crate::document::error::DocumentError;
use crate::document::live::drawings::decoded;
use crate::document::live::graphics::Graphics;
use crate::document::live::laid::traced;
use crate::document::live::spots::Spot;
use crate::document::live::voxel_surface::VoxelSurface;
use crate::document::live::windows::pose_at;
use crate::document::place::nothing_there;
use crate::document::reduce::place::place_in;
use crate::document::scene::ViewName;
use crate::document::scene::annotations::{Anchor, Content, MOST_IMAGE_BYTES, Tracing};
use crate::document::state::State;
use crate::io;
use crate::math::{DQuat, DVec2, DVec3, Projection};
use crate::volume::{Grid, Mode, VolumeId};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// How far before what a ray has met its surface is sought, and at what distances.
const REACH_VOXELS: f64 = 14.0;
const PACE_VOXELS: f64 = 0.25;

/// A place that is found on the surface of a volume that is not cut out of another.
#[derive(Clone, Copy, Debug)]
struct Found {
    root: VolumeId,
    /// World mm at rest.
    rest: DVec3,
    /// As it was said, if it was said so.
    index: Option<[f64; 3]>,
    selected: bool,
}

impl Found {
    /// To the last digit, where it is an index already.
    fn index(&self, grid: &Grid) -> Place {
        Place::Index(self.index.unwrap_or_else(|| grid.index_from_world().transform_point3(self.rest).to_array()))
    }
}

/// What of an anchor is said.
struct Placing {
    at: Option<Place>,
    toward: Option<Place>,
    turn_deg: Option<f64>,
    volume: Option<VolumeId>,
    value: Option<f64>,
    selected: Option<bool>,
}

/// The same in numbers of a volume.
struct Placed {
    at: Option<Place>,
    toward: Option<Place>,
    root: VolumeId,
    value: Option<f64>,
    selected: Option<bool>,
}

impl Document {
    /// The command with all places as indices of a volume and the value of its surface.
    ///
    /// # Errors
    /// If nothing shows at a pixel, there is no GPU to look with, or a file is no image.
    pub(crate) fn annotations_in_numbers(&mut self, command: Command) -> Result<Command, DocumentError> {
        Ok(match command {
            Command::Annotation(AnnotationCommand::Add(change)) => {
                Command::Annotation(AnnotationCommand::Add(self.annotation_in_numbers(change, None)?))
            }
            Command::Annotation(AnnotationCommand::Set(change)) => {
                let old = match change.id {
                    Some(id) => Some(self.open()?.scene.annotation(id)?.anchor),
                    None => None,
                };
                Command::Annotation(AnnotationCommand::Set(self.annotation_in_numbers(change, old)?))
            }
            Command::Label(LabelCommand::Add(change)) => {
                Command::Label(LabelCommand::Add(self.label_in_numbers(change)?))
            }
            Command::Label(LabelCommand::Set(change)) => {
                Command::Label(LabelCommand::Set(self.label_in_numbers(change)?))
            }
            Command::Label(LabelCommand::FromSegments { volume, segments: None }) => {
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let id = state.at(volume)?.id;
                let shown =
                    state.at(volume)?.segments().0.iter().filter(|s| s.visible).map(|s| s.id).collect::<Vec<_>>();
                let present = self.poles.present(state, id)?;
                let segments = Some(shown.into_iter().filter(|label| present.contains(label)).collect());
                Command::Label(LabelCommand::FromSegments { volume: Some(id), segments })
            }
            Command::Cutaway(CutawayCommand::Add(change)) => {
                Command::Cutaway(CutawayCommand::Add(self.cutaway_in_numbers(change, None)?))
            }
            Command::Cutaway(CutawayCommand::Set(change)) => {
                let old = match change.id {
                    Some(id) => Some(self.open()?.scene.cutaways.get(id)?.anchor),
                    None => None,
                };
                Command::Cutaway(CutawayCommand::Set(self.cutaway_in_numbers(change, old)?))
            }
            other => other,
        })
    }

    fn found(&mut self, field: &str, place: Place, volume: Option<VolumeId>) -> Result<Found, DocumentError> {
        let state = self.open()?;
        let subject = state.at(volume)?;
        let root = state.scene.root_of(subject.id);
        if let Some(sample) = place_in(place, subject.scene, subject.grid())? {
            let rest = sample.position;
            // That of a sub-volume is another one of its root.
            let index = match place {
                Place::Index(index) if root == subject.id => Some(index),
                _ => None,
            };
            return Ok(Found { root, rest, index, selected: is_selected(state, root, rest) });
        }
        let Place::Pixel { px, size, .. } = place else { return Err(nothing_there(field, place)) };
        let hit = self.pick(DVec2::from_array(px), size)?.ok_or_else(|| nothing_there(field, place))?;
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let root = hit.object.volume().map_or(root, |id| state.scene.root_of(id));
        let selected = hit.object.is_selected();
        let mut rest = hit.rest;
        if !matches!(state.scene.mode_of(root), Mode::Iso(_)) {
            let camera = &state.scene.views.camera;
            let eye = match camera.projection {
                Projection::Perspective { .. } => camera.eye,
                Projection::Orthographic { .. } => hit.world - camera.forward(),
            };
            let eye = pose_at(state, self.motion.poses(), rest, selected).unapply(eye);
            // The picked sample's own surface, if there is one that faces the eye: deep in matter that hardly changes there is none.
            if !bears(state, &mut self.graphics, root, rest, eye)? {
                for border in borders_before(state, root, rest, eye)? {
                    if bears(state, &mut self.graphics, root, border, eye)? {
                        rest = border;
                        break;
                    }
                }
            }
        }
        Ok(Found { root, rest, index: None, selected })
    }

    /// Centre and direction as indices, and whose surface they are on.
    fn anchor_in_numbers(&mut self, said: Placing, old: Option<Anchor>) -> Result<Placed, DocumentError> {
        let Placing { at, toward, turn_deg, volume, value, selected } = said;
        let meant = volume.or(old.map(|old| old.volume));
        let centre = at.map(|at| self.found("at", at, meant)).transpose()?;
        let root = match (&centre, volume) {
            (Some(found), None) => found.root,
            _ => self.open()?.scene.root_of(self.open()?.at(meant)?.id),
        };
        let way = toward.map(|toward| self.found("toward", toward, Some(root))).transpose()?;
        let state = self.open()?;
        let grid = *state.at(Some(root))?.grid();
        let value = match (value, &centre, &old) {
            (Some(value), ..) => Some(value),
            // What is moved stays at its value.
            (None, Some(_), Some(_)) => None,
            (None, Some(found), None) => Some(surface_value(state, root, found.rest)?),
            (None, None, _) => None,
        };
        let selected = selected.or(centre.map(|found| found.selected));
        // A new one goes to the right of the picture.
        let way = match (way, &centre, old.is_some()) {
            (Some(found), ..) => Some(found),
            (None, Some(found), false) => {
                let (right, _) = state.scene.views.camera.right_up();
                Some(Found { rest: found.rest + right * 10.0 * grid.voxel_mm(), index: None, ..*found })
            }
            (None, ..) => None,
        };
        let way = match (turn_deg, old) {
            (Some(turn), Some(old)) => {
                let anchor = Anchor { volume: root, ..old };
                let spot = Spot::of(state, &anchor)?;
                let surface = VoxelSurface::about(state, root, old.value, spot.centre, 4.0 * spot.voxel_mm)?;
                let axis = normal(&surface, spot.centre)
                    .ok_or_else(|| DocumentError::invalid("turn_deg", turn, "a centre on a surface"))?;
                let along = way.map_or(spot.along, |way| way.rest - spot.centre);
                let rest = spot.centre + DQuat::from_axis_angle(axis, turn.to_radians()) * along;
                Some(Found { root, rest, index: None, selected: false })
            }
            _ => way,
        };
        let index = |found: Option<Found>| found.map(|found| found.index(&grid));
        Ok(Placed { at: index(centre), toward: index(way), root, value, selected })
    }

    fn annotation_in_numbers(
        &mut self,
        change: AnnotationChange,
        old: Option<Anchor>,
    ) -> Result<AnnotationChange, DocumentError> {
        let said = Placing {
            at: change.at,
            toward: change.toward,
            turn_deg: change.turn_deg,
            volume: change.volume,
            value: change.value,
            selected: change.selected,
        };
        let Placed { at, toward, root, value, selected } = self.anchor_in_numbers(said, old)?;
        let to = match change.to {
            Some(to) => {
                let mut found = self.found("to", to, Some(root))?;
                let state = self.open()?;
                if let (Place::Pixel { view: ViewName::ThreeD, .. }, Some(value)) = (to, value.or(old.map(|o| o.value)))
                {
                    let pose = pose_at(state, self.motion.poses(), found.rest, found.selected);
                    let eye = pose.unapply(state.scene.views.camera.eye);
                    found.rest = crossing(state, root, value, found.rest, eye)?.unwrap_or(found.rest);
                }
                Some(found.index(self.open()?.at(Some(root))?.grid()))
            }
            None => None,
        };
        // A ruler begins toward its end.
        let toward = match (&to, change.toward, at) {
            (Some(to), None, Some(_)) => Some(*to),
            _ => toward,
        };
        let content = match change.content {
            Some(Content::Image { path, png: None }) => {
                let png = read_image(&path)?;
                Some(Content::Image { path, png: Some(png) })
            }
            content => content,
        };
        let volume = Some(root);
        Ok(AnnotationChange { at, toward, turn_deg: None, to, volume, value, selected, content, ..change })
    }

    fn label_in_numbers(&mut self, change: LabelChange) -> Result<LabelChange, DocumentError> {
        let Some(place) = change.at else { return Ok(change) };
        let found = self.found("at", place, change.volume)?;
        let at = Some(found.index(self.open()?.at(Some(found.root))?.grid()));
        let selected = Some(change.selected.unwrap_or(found.selected));
        Ok(LabelChange { at, volume: Some(found.root), selected, ..change })
    }

    fn cutaway_in_numbers(
        &mut self,
        mut change: CutawayChange,
        old: Option<Anchor>,
    ) -> Result<CutawayChange, DocumentError> {
        if let Some(id) = change.annotation.take() {
            let one = self.open()?.scene.annotation(id)?.clone();
            let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
            let size = self.laid.get(state, &mut self.graphics, id, false)?.said.size_mm;
            change.at = change.at.or(Some(Place::Index(one.anchor.centre)));
            change.toward = change.toward.or(Some(Place::Index(one.anchor.toward)));
            change.volume = Some(one.anchor.volume);
            change.value = change.value.or(Some(one.anchor.value));
            change.width_mm = change.width_mm.or(Some(size[0]));
            change.height_mm = change.height_mm.or(Some(size[1]));
        }
        let lasso = match change.lasso.take() {
            Some(places) => {
                let found = places.into_iter().enumerate();
                let found = found.map(|(i, place)| self.found(&format!("lasso[{i}]"), place, change.volume));
                Some(found.collect::<Result<Vec<_>, _>>()?)
            }
            None => None,
        };
        if let Some(found) = &lasso {
            let first = found.first().ok_or_else(|| DocumentError::invalid("lasso", "no place", "3 and more"))?;
            change.volume = Some(first.root);
            let middle = found.iter().map(|f| f.rest).sum::<DVec3>() / found.len() as f64;
            // The value is that of the line, the anchor the place of it that lies nearest to its middle.
            let near = found.iter().min_by(|a, b| a.rest.distance(middle).total_cmp(&b.rest.distance(middle)));
            let near = near.map_or(middle, |f| f.rest);
            let state = self.open()?;
            change.value = match change.value {
                Some(value) => Some(value),
                None => Some(surface_value(state, first.root, near)?),
            };
            change.at = Some(Place::Mm(middle.to_array()));
        }
        let said = Placing {
            at: change.at,
            toward: change.toward,
            turn_deg: None,
            volume: change.volume,
            value: change.value,
            selected: None,
        };
        let Placed { at, toward, root, value, .. } = self.anchor_in_numbers(said, old)?;
        let grid = *self.open()?.at(Some(root))?.grid();
        let lasso = lasso.map(|found| found.iter().map(|found| found.index(&grid)).collect());
        Ok(CutawayChange { at, toward, lasso, volume: Some(root), value, ..change })
    }
}

/// Whether the surface of a place's own value faces the eye there and goes on about it, so that something can be laid on it.
fn bears(
    state: &State,
    graphics: &mut Graphics,
    root: VolumeId,
    rest: DVec3,
    eye: DVec3,
) -> Result<bool, DocumentError> {
    const HALF_STEPS: u32 = 5;
    const STEP_VOXELS: f64 = 2.0;
    let voxel_mm = state.at(Some(root))?.grid().voxel_mm();
    let Ok(value) = surface_value(state, root, rest) else { return Ok(false) };
    let surface = VoxelSurface::about(state, root, value, rest, 4.0 * voxel_mm)?;
    let Some(outward) = normal(&surface, rest).filter(|n| n.dot(eye - rest) > 0.0) else { return Ok(false) };
    let index = |p: DVec3| Ok::<_, DocumentError>(state.at(Some(root))?.grid().index_from_world().transform_point3(p));
    let along = outward.any_orthonormal_vector() * voxel_mm;
    let anchor = Anchor {
        volume: root,
        centre: index(rest)?.to_array(),
        toward: index(rest + along)?.to_array(),
        value,
        selected: false,
    };
    let spot = Spot::of(state, &anchor)?;
    let lattice = ([HALF_STEPS; 2], STEP_VOXELS * voxel_mm);
    let grid = traced(state, graphics, &spot, lattice, &Tracing::default())?;
    Ok(grid.trimmed() == 0 && grid.distortion().most_area < 2.0)
}

/// Of the way from a place to the eye, as far as a few voxels before it, the places where matter that faces the eye begins: where most steeply,
/// then the others that are not much flatter, the nearest to the eye first.
fn borders_before(state: &State, root: VolumeId, rest: DVec3, eye: DVec3) -> Result<Vec<DVec3>, DocumentError> {
    const STEEP: f64 = 0.3;
    let voxel_mm = state.at(Some(root))?.grid().voxel_mm();
    let Some(back) = (eye - rest).try_normalize() else { return Ok(Vec::new()) };
    let surface = VoxelSurface::about(state, root, 0.0, rest, (REACH_VOXELS + 3.0) * voxel_mm)?;
    let slope = |p: DVec3| surface.gradient(p).map_or(0.0, |gradient| -gradient.dot(back));
    let steps = (REACH_VOXELS / PACE_VOXELS) as u32;
    let place = |i: u32| rest + back * (f64::from(i) * PACE_VOXELS * voxel_mm);
    let ways: Vec<(f64, DVec3)> = (0..=steps).rev().map(|i| (slope(place(i)), place(i))).collect();
    let steepest = ways.iter().copied().fold((0.0, rest), |best, one| if one.0 > best.0 { one } else { best });
    let others = ways.into_iter().filter(|one| one.0 > STEEP * steepest.0).map(|one| one.1);
    Ok(std::iter::once(steepest.1).chain(others).collect())
}

/// Where on the way from the eye to a place, and a little beyond, a volume first reaches a value; `None` if it does not near there.
fn crossing(
    state: &State,
    root: VolumeId,
    value: f64,
    rest: DVec3,
    eye: DVec3,
) -> Result<Option<DVec3>, DocumentError> {
    let voxel_mm = state.at(Some(root))?.grid().voxel_mm();
    let Some(ahead) = (rest - eye).try_normalize() else { return Ok(None) };
    let surface = VoxelSurface::about(state, root, value, rest, (REACH_VOXELS + 3.0) * voxel_mm)?;
    let steps = (REACH_VOXELS / PACE_VOXELS) as i32;
    let place = |i: i32| rest + ahead * (f64::from(i) * PACE_VOXELS * voxel_mm);
    let mut before: Option<(f64, DVec3)> = None;
    for p in (-steps..=steps / 2).map(place) {
        let Some(here) = surface.value(p) else { continue };
        if let Some((there, q)) = before.filter(|(there, _)| *there < 0.0 && here >= 0.0) {
            return Ok(Some(q.lerp(p, there / (there - here))));
        }
        before = Some((here, p));
    }
    Ok(None)
}

/// Whether the matter of a volume at a place is selected.
fn is_selected(state: &State, root: VolumeId, rest: DVec3) -> bool {
    let told = || {
        let subject = state.at(Some(root)).ok()?;
        let voxel = subject.grid().voxel_at(subject.grid().index_from_world().transform_point3(rest))?;
        subject.volume.selection.value(voxel).ok()
    };
    told().is_some_and(|selection| selection >= 0.5)
}

/// The value of the surface that a place is on: that of the iso-surface where one is shown, else the value there.
fn surface_value(state: &State, root: VolumeId, rest: DVec3) -> Result<f64, DocumentError> {
    if let Mode::Iso(value) = state.scene.mode_of(root) {
        return Ok(value);
    }
    let voxel_mm = state.at(Some(root))?.grid().voxel_mm();
    // The trilinear field minus nothing.
    let surface = VoxelSurface::about(state, root, 0.0, rest, 3.0 * voxel_mm)?;
    surface.number(rest).ok_or_else(|| {
        let found = format!("{:.1?}, outside of the volume", rest.to_array());
        DocumentError::invalid("at", found, "a place on a surface of the volume")
    })
}

fn read_image(path: &str) -> Result<std::sync::Arc<str>, DocumentError> {
    let file = std::path::Path::new(path);
    let bytes = io::read_regular(file, MOST_IMAGE_BYTES as u64)
        .map_err(|e| DocumentError::invalid("path", format!("{path}: {e}"), "a PNG image"))?;
    let png: std::sync::Arc<str> = STANDARD.encode(bytes).into();
    decoded(path, &png)?;
    Ok(png)
}
