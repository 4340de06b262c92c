//! Commands on cameras, slices, looks and layers.

use crate::document::Document;
use crate::document::command::views::ViewCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::place::check_size;
use crate::document::scene::past::PastGroup;
use crate::document::scene::past::PastOf;
use crate::document::scene::slice_plane::SlicePlane;
use crate::document::scene::{Layer, ViewName, Views, Window};
use crate::document::state::State;
use crate::explode::Poses;
use crate::math::{Aabb, Camera, DVec2, DVec3, Projection};
use crate::volume::{Lighting, Mode};
use serde_json::{Value, json};

impl ViewCommand {
    /// Whether it changes what is looked at (and `view.back` can take it back).
    pub(crate) fn moves_view(&self) -> bool {
        matches!(
            self,
            Self::Camera { .. }
                | Self::Frame { .. }
                | Self::Fit { .. }
                | Self::Orbit { .. }
                | Self::Pan { .. }
                | Self::Zoom { .. }
                | Self::Crosshair { .. }
                | Self::Scroll { .. }
        )
    }

    /// What a change of what is looked at is called.
    pub(crate) fn change_name(&self) -> &'static str {
        match self {
            Self::Frame { .. } => "See from a side",
            Self::Fit { .. } => "Fit",
            Self::Orbit { .. } => "Turn",
            Self::Pan { .. } => "Pan",
            Self::Zoom { .. } => "Zoom",
            Self::Crosshair { .. } => "Crosshair",
            Self::Scroll { .. } => "Slice",
            _ => "Camera",
        }
    }
}

impl Document {
    pub(crate) fn view(&mut self, command: ViewCommand, edit: &mut Edit) -> Result<Value, DocumentError> {
        if let ViewCommand::Crosshair { at } = command {
            let world = self.resolve(at)?.ok_or_else(|| nothing_there("at", at))?.position;
            let state = self.open_mut()?;
            let inside = clamp_to_volume(state, world);
            if !inside.is_finite() {
                return Err(DocumentError::invalid(
                    "at",
                    format!("{world:?}"),
                    "a place that has a voxel nearest to it",
                ));
            }
            state.scene.views.crosshair = inside;
            return Ok(crosshair(state));
        }
        if let ViewCommand::Back { of } | ViewCommand::Forward { of } = command {
            return self.walk_past(of, matches!(command, ViewCommand::Back { .. }));
        }
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        let bounds = state.grid().world_bounds();
        let views = &mut state.scene.views;
        match command {
            ViewCommand::Camera { camera } => {
                views.camera = checked(camera, &bounds)?;
                Ok(json!({ "camera": views.camera }))
            }
            ViewCommand::Frame { from, up, zoom } => {
                let zoom = positive("zoom", zoom.unwrap_or(1.0))?;
                let from = direction("from", from)?;
                let up = up.map_or(Ok(up_for(from)), |up| direction("up", up))?;
                let framed = Camera::framing_in(&bounds, from, up, views.camera.projection);
                views.camera = checked(framed.zoomed(zoom), &bounds)?;
                Ok(json!({ "camera": views.camera }))
            }
            ViewCommand::Fit { view } => {
                fit(state, self.motion.poses(), view)?;
                Ok(view_answer(&state.scene.views, view))
            }
            ViewCommand::Orbit { azimuth_deg, elevation_deg } => {
                let (azimuth, elevation) =
                    (finite("azimuth_deg", azimuth_deg)?, finite("elevation_deg", elevation_deg)?);
                views.camera = checked(views.camera.orbited(azimuth, elevation), &bounds)?;
                Ok(json!({ "camera": views.camera }))
            }
            ViewCommand::Pan { view, px } => {
                let px = DVec2::new(finite("px", px[0])?, finite("px", px[1])?);
                pan(state, view, px)?;
                Ok(view_answer(&state.scene.views, view))
            }
            ViewCommand::Zoom { view, factor } => {
                let factor = positive("factor", factor)?;
                match view.slice() {
                    None => views.camera = checked(views.camera.zoomed(factor), &bounds)?,
                    Some(i) => {
                        let height = &mut views.slices[i].height_mm;
                        *height = slice_height(*height * factor, &bounds);
                    }
                }
                Ok(view_answer(views, view))
            }
            ViewCommand::Size { view, size } => {
                check_size(size)?;
                match view.slice() {
                    None => views.size = size,
                    Some(i) => views.slices[i].size = size,
                }
                Ok(view_answer(views, view))
            }
            ViewCommand::Scroll { view, voxels } => {
                let grid = *state.grid();
                let plane = SlicePlane::new(&grid, &state.scene.views, view)
                    .ok_or_else(|| DocumentError::invalid("view", "3d", "axial, coronal or sagittal"))?;
                let mut index = grid.index_from_world().transform_point3(state.scene.views.crosshair);
                let last = f64::from(grid.dims[plane.axis] - 1);
                index[plane.axis] = (f64::from(plane.index) + f64::from(voxels)).clamp(0.0, last);
                state.scene.views.crosshair = grid.world_from_index.transform_point3(index);
                Ok(crosshair(state))
            }
            ViewCommand::Look { mode, shaded, lighting, step_voxels, background } => {
                edit.name(match (&mode, shaded, background) {
                    (Some(Mode::Dvr), ..) => "Look: volume",
                    (Some(Mode::Iso(_)), ..) => "Look: surface",
                    (Some(Mode::Mip), ..) => "Look: maximum",
                    (None, Some(true), _) => "Headlight on",
                    (None, Some(false), _) => "Headlight off",
                    (None, None, Some(_)) => "Background",
                    _ => "Look",
                });
                let mut look = state.scene.look;
                look.mode = mode.unwrap_or(look.mode);
                if shaded == Some(false) && lighting.is_some() {
                    return Err(DocumentError::invalid("lighting", "given with shaded: false", "one of the two"));
                }
                look.lighting = lighting.or(look.lighting);
                match shaded {
                    Some(false) => look.lighting = None,
                    Some(true) if look.lighting.is_none() => look.lighting = Some(Lighting::default()),
                    _ => {}
                }
                look.step_voxels = step_voxels.unwrap_or(look.step_voxels);
                look.background = background.unwrap_or(look.background);
                look.check()?;
                state.scene.look = look;
                Ok(json!({ "look": look }))
            }
            ViewCommand::Window { level, width } => {
                edit.name("Window");
                let window = Window { level, width };
                window.check()?;
                state.scene.window = window;
                Ok(json!({ "window": state.scene.window }))
            }
            ViewCommand::Layer(layer) => {
                edit.name(format!("Layer {}", layer.field.name()));
                set_layer(state, layer)?;
                Ok(json!({ "layers": state.scene.layers }))
            }
            ViewCommand::Crosshair { .. } | ViewCommand::Back { .. } | ViewCommand::Forward { .. } => Ok(json!({})),
        }
    }

    /// Shows what was seen before, or again what comes after it.
    fn walk_past(&mut self, of: Option<PastOf>, back: bool) -> Result<Value, DocumentError> {
        let State { scene, past, .. } = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        // What the open group changed is behind or ahead now: the rest of it is a change of its own.
        self.past_group = PastGroup::default();
        let walked = past.travel(scene, of, back);
        let (behind, ahead) = past.counts(of);
        let (kind, name) = walked.unzip();
        Ok(json!({
            "moved": kind.is_some(),
            "of": kind,
            "change": name,
            "back": behind,
            "forward": ahead,
            "camera": scene.views.camera,
        }))
    }
}

/// What a command says that needs a surface where there is none.
pub(crate) fn nothing_there(field: &str, at: impl serde::Serialize) -> DocumentError {
    let at = json!(at);
    DocumentError::invalid(field, format!("{at}, where nothing is visible"), "a pixel on a visible surface")
}

fn set_layer(state: &mut State, layer: Layer) -> Result<(), DocumentError> {
    layer.check()?;
    match state.scene.layers.iter_mut().find(|l| l.field == layer.field) {
        Some(known) => *known = layer,
        None => state.scene.layers.push(layer),
    }
    Ok(())
}

fn pan(state: &mut State, view: ViewName, px: DVec2) -> Result<(), DocumentError> {
    let grid = *state.grid();
    let bounds = grid.world_bounds();
    let views = &mut state.scene.views;
    match (view.slice(), SlicePlane::new(&grid, views, view)) {
        (Some(i), Some(plane)) => {
            let shift = (plane.right * px.x - plane.up * px.y) * plane.mm_per_px;
            views.slices[i].centre = near("px", views.slices[i].centre - shift, &bounds)?;
        }
        _ => views.camera = checked(views.camera.panned(px, views.size[1]), &bounds)?,
    }
    Ok(())
}

/// The height of a slice's picture, mm, within what shows anything of the volume.
fn slice_height(height_mm: f64, bounds: &Aabb) -> f64 {
    let reach = bounds.half_diagonal();
    height_mm.clamp(reach * 1e-8, reach * 1e8)
}

/// All of a slice, or of what is shown in 3D, as large as the picture holds.
fn fit(state: &mut State, poses: &Poses, view: ViewName) -> Result<(), DocumentError> {
    let grid = *state.grid();
    let bounds = grid.world_bounds();
    let views = &state.scene.views;
    match (view.slice(), SlicePlane::new(&grid, views, view)) {
        (Some(i), Some(plane)) => {
            let [width, height] =
                plane.in_plane.map(|a| f64::from(grid.dims[a]) * grid.world_from_index.matrix3.col(a).length());
            let [w, h] = views.slices[i].size.map(|s| f64::from(s.max(1)));
            let slice = &mut state.scene.views.slices[i];
            slice.height_mm = slice_height(height.max(width * h / w), &bounds);
            slice.centre = grid.world_from_index.transform_point3((grid.dims_f64() - 1.0) * 0.5);
        }
        _ => {
            let shown = state.scene.explosion.parts.iter().filter(|p| p.visible);
            let corners = shown.flat_map(|p| p.vertices.iter().map(|&v| poses.of(p).apply(v)));
            let box_mm = Aabb::around(corners).unwrap_or(bounds);
            let camera = views.camera;
            let framed = Camera::framing_in(&box_mm, -camera.forward(), camera.up, camera.projection);
            // A narrow picture shows as much across as a square one.
            let narrow = (f64::from(views.size[0].max(1)) / f64::from(views.size[1].max(1))).min(1.0);
            let further = match camera.projection {
                Projection::Orthographic { .. } => 1.0 / narrow,
                Projection::Perspective { fov_y_deg } => {
                    let half = (fov_y_deg * 0.5).to_radians();
                    half.sin() / (half.tan() * narrow).atan().sin()
                }
            };
            state.scene.views.camera = checked(framed.zoomed(further), &bounds)?;
        }
    }
    Ok(())
}

/// Diagonals of the volume from its centre within which there is something to see: further out, samples along a ray can no
/// longer be told apart.
const REACH: f64 = 1e4;

/// A point that is not lost in space.
pub(crate) fn near(field: &str, point: DVec3, bounds: &Aabb) -> Result<DVec3, DocumentError> {
    let reach = REACH * 2.0 * bounds.half_diagonal();
    let away = point.distance(bounds.centre());
    // Whoever is as far from zero as numbers go has no distance.
    if away <= reach {
        return Ok(point);
    }
    Err(DocumentError::invalid(field, format!("a point {away:e} mm from the volume"), format!("at most {reach:e} mm")))
}

/// Upward in the picture when nobody says: superior, or anterior when looking along the body's axis.
fn up_for(from: DVec3) -> DVec3 {
    if from.normalize_or_zero().z.abs() > 0.999 { DVec3::Y } else { DVec3::Z }
}

fn clamp_to_volume(state: &State, world: DVec3) -> DVec3 {
    let grid = state.grid();
    let index = grid.index_from_world().transform_point3(world);
    grid.world_from_index.transform_point3(index.clamp(DVec3::ZERO, grid.dims_f64() - 1.0))
}

fn crosshair(state: &State) -> Value {
    let at = state.scene.views.crosshair;
    let index = state.grid().index_from_world().transform_point3(at);
    json!({ "crosshair_mm": at.to_array(), "index": index.to_array() })
}

fn view_answer(views: &Views, view: ViewName) -> Value {
    match views.slice(view) {
        Some(slice) => json!({ "slice": slice }),
        None => json!({ "camera": views.camera, "size": views.size }),
    }
}

pub(crate) fn checked(camera: Camera, bounds: &Aabb) -> Result<Camera, DocumentError> {
    let invalid = |field: &str, found: String, expected: &str| Err(DocumentError::invalid(field, found, expected));
    for (name, v) in [("camera.eye", camera.eye), ("camera.target", camera.target), ("camera.up", camera.up)] {
        if !v.is_finite() {
            return invalid(name, format!("{v}"), "three finite numbers");
        }
    }
    near("camera.eye", camera.eye, bounds)?;
    near("camera.target", camera.target, bounds)?;
    if camera.eye == camera.target {
        return invalid("camera.target", format!("{} as the eye", camera.target), "another point than the eye");
    }
    match camera.projection {
        Projection::Perspective { fov_y_deg } if !(fov_y_deg > 0.0 && fov_y_deg < 180.0) => {
            invalid("camera.projection.fov_y_deg", fov_y_deg.to_string(), "between 0 and 180 degrees")
        }
        Projection::Orthographic { height_mm } if !(height_mm.is_finite() && height_mm > 0.0) => {
            invalid("camera.projection.height_mm", height_mm.to_string(), "a positive length")
        }
        _ => Ok(camera),
    }
}

pub(crate) fn checked_colour(field: &str, colour: [f32; 3]) -> Result<[f32; 3], DocumentError> {
    if colour.iter().all(|c| (0.0..=1.0).contains(c)) {
        Ok(colour)
    } else {
        Err(DocumentError::invalid(field, format!("{colour:?}"), "red, green and blue of 0 to 1"))
    }
}

pub(crate) fn finite(field: &str, value: f64) -> Result<f64, DocumentError> {
    if value.is_finite() { Ok(value) } else { Err(DocumentError::invalid(field, value, "a finite number")) }
}

pub(crate) fn positive(field: &str, value: f64) -> Result<f64, DocumentError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(DocumentError::invalid(field, value, "a positive number"))
    }
}

fn direction(field: &str, v: [f64; 3]) -> Result<DVec3, DocumentError> {
    DVec3::from_array(v)
        .try_normalize()
        .ok_or_else(|| DocumentError::invalid(field, format!("{v:?}"), "a direction other than zero"))
}
