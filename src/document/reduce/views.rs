//! What commands on cameras, slices and the crosshair do to the scene; see `reduce`.

use crate::document::command::Place;
use crate::document::command::answers::{CameraSaid, CrosshairSaid, Said, SliceSaid, ViewSaid};
use crate::document::command::views::ViewCommand;
use crate::document::error::DocumentError;
use crate::document::reduce::place::place_in;
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::check::{check_size, direction, finite, near, positive, safe_camera};
use crate::document::scene::slice_plane::SlicePlane;
use crate::document::scene::{Scene, ViewName};
use crate::math::{Aabb, Camera, DVec2, DVec3, Projection};
use crate::volume::Grid;

impl Scene {
    pub(crate) fn apply_view(&mut self, command: &ViewCommand, ground: &Ground<'_>) -> Result<Changed, DocumentError> {
        let bounds = ground.bounds;
        match command {
            ViewCommand::Camera { camera } => self.look_from("Camera", *camera, &bounds),
            ViewCommand::Frame { from, up, zoom } => {
                let zoom = positive("zoom", zoom.unwrap_or(1.0))?;
                let from = direction("from", *from)?;
                let up = up.map_or(Ok(up_for(from)), |up| direction("up", up))?;
                let framed = Camera::framing_in(&bounds, from, up, self.views.camera.projection);
                self.look_from("See from a side", framed.zoomed(zoom), &bounds)
            }
            ViewCommand::Fit { view } => {
                self.fit(*view, ground)?;
                Ok(Changed::new("Fit", self.view_said(*view)))
            }
            ViewCommand::Orbit { azimuth_deg, elevation_deg } => {
                let turned = [finite("azimuth_deg", *azimuth_deg)?, finite("elevation_deg", *elevation_deg)?];
                self.look_from("Turn", self.views.camera.orbited(turned[0], turned[1]), &bounds)
            }
            ViewCommand::Pan { view, px } => {
                self.pan(*view, DVec2::new(finite("px", px[0])?, finite("px", px[1])?), ground)?;
                Ok(Changed::new("Pan", self.view_said(*view)))
            }
            ViewCommand::Zoom { view, factor } => {
                let factor = positive("factor", *factor)?;
                match view.slice() {
                    None => self.views.camera = safe_camera(self.views.camera.zoomed(factor), &bounds)?,
                    Some(i) => {
                        let height = &mut self.views.slices[i].height_mm;
                        *height = slice_height(*height * factor, &bounds);
                    }
                }
                Ok(Changed::new("Zoom", self.view_said(*view)))
            }
            ViewCommand::Size { view, size } => {
                check_size(*size)?;
                match view.slice() {
                    None => self.views.size = *size,
                    Some(i) => self.views.slices[i].size = *size,
                }
                Ok(Changed::new("Size", self.view_said(*view)))
            }
            ViewCommand::Crosshair { at } => self.move_crosshair(*at, ground.grid),
            ViewCommand::Scroll { view, voxels } => {
                let grid = ground.grid;
                let plane = SlicePlane::new(grid, &self.views, *view)
                    .ok_or_else(|| DocumentError::invalid("view", "3d", "axial, coronal or sagittal"))?;
                let mut index = grid.index_from_world().transform_point3(self.views.crosshair);
                let last = f64::from(grid.dims[plane.axis] - 1);
                index[plane.axis] = (f64::from(plane.index) + f64::from(*voxels)).clamp(0.0, last);
                self.views.crosshair = grid.world_from_index.transform_point3(index);
                Ok(Changed::new("Slice", self.crosshair_said(grid)))
            }
            ViewCommand::Look { mode, shaded, lighting, step_voxels, refine, background } => {
                self.set_look((*mode, *shaded, *lighting, (*step_voxels, *refine), *background))
            }
            ViewCommand::Focus(change) => self.set_focus(change, ground),
            ViewCommand::Window { level, width, volume } => self.set_window(*volume, *level, *width),
            ViewCommand::Layer(layer) => self.set_layer(layer),
            // What was seen before is not the scene's to know.
            ViewCommand::Back { .. } | ViewCommand::Forward { .. } => Ok(Changed::default()),
        }
    }

    fn look_from(&mut self, name: &str, camera: Camera, bounds: &Aabb) -> Result<Changed, DocumentError> {
        let camera = safe_camera(camera, bounds)?;
        self.views.camera = camera;
        Ok(Changed::new(name, CameraSaid { camera }))
    }

    fn view_said(&self, view: ViewName) -> Said {
        match self.views.slice(view) {
            Some(slice) => SliceSaid { slice: *slice }.into(),
            None => ViewSaid { camera: self.views.camera, size: self.views.size }.into(),
        }
    }

    fn crosshair_said(&self, grid: &Grid) -> CrosshairSaid {
        let at = self.views.crosshair;
        let index = grid.index_from_world().transform_point3(at);
        CrosshairSaid { crosshair_mm: at.to_array(), index: index.to_array() }
    }

    fn move_crosshair(&mut self, at: Place, grid: &Grid) -> Result<Changed, DocumentError> {
        let world = place_in(at, self, grid)?.ok_or_else(|| DocumentError::of_picture("at"))?.position;
        let index = grid.index_from_world().transform_point3(world);
        let inside = grid.world_from_index.transform_point3(index.clamp(DVec3::ZERO, grid.dims_f64() - 1.0));
        if !inside.is_finite() {
            let expected = "a place that has a voxel nearest to it";
            return Err(DocumentError::invalid("at", format!("{world:?}"), expected));
        }
        self.views.crosshair = inside;
        Ok(Changed::new("Crosshair", self.crosshair_said(grid)))
    }

    fn pan(&mut self, view: ViewName, px: DVec2, ground: &Ground<'_>) -> Result<(), DocumentError> {
        let (grid, bounds) = (ground.grid, ground.bounds);
        match (view.slice(), SlicePlane::new(grid, &self.views, view)) {
            (Some(i), Some(plane)) => {
                let shift = (plane.right * px.x - plane.up * px.y) * plane.mm_per_px;
                self.views.slices[i].centre = near("px", self.views.slices[i].centre - shift, &bounds)?;
            }
            _ => self.views.camera = safe_camera(self.views.camera.panned(px, self.views.size[1]), &bounds)?,
        }
        Ok(())
    }

    /// All of a slice, or of what is shown in 3D, as large as the picture holds.
    fn fit(&mut self, view: ViewName, ground: &Ground<'_>) -> Result<(), DocumentError> {
        let (grid, bounds) = (ground.grid, ground.bounds);
        match (view.slice(), SlicePlane::new(grid, &self.views, view)) {
            (Some(i), Some(plane)) => {
                let [width, height] =
                    plane.in_plane.map(|a| f64::from(grid.dims[a]) * grid.world_from_index.matrix3.col(a).length());
                let slice = &mut self.views.slices[i];
                let [w, h] = slice.size.map(|s| f64::from(s.max(1)));
                slice.height_mm = slice_height(height.max(width * h / w), &bounds);
                slice.centre = grid.world_from_index.transform_point3((grid.dims_f64() - 1.0) * 0.5);
            }
            _ => {
                let shown = self.explosion.parts.iter().filter(|p| p.visible);
                let corners = shown.flat_map(|p| p.vertices.iter().map(|&v| ground.poses.of(p).apply(v)));
                let box_mm = Aabb::around(corners).unwrap_or(bounds);
                let (camera, size) = (self.views.camera, self.views.size);
                let framed = Camera::framing_in(&box_mm, -camera.forward(), camera.up, camera.projection);
                // A narrow picture shows as much across as a square one.
                let narrow = (f64::from(size[0].max(1)) / f64::from(size[1].max(1))).min(1.0);
                let further = match camera.projection {
                    Projection::Orthographic { .. } => 1.0 / narrow,
                    Projection::Perspective { fov_y_deg } => {
                        let half = (fov_y_deg * 0.5).to_radians();
                        half.sin() / (half.tan() * narrow).atan().sin()
                    }
                };
                self.views.camera = safe_camera(framed.zoomed(further), &bounds)?;
            }
        }
        Ok(())
    }
}

/// The height of a slice's picture, mm, within what shows anything of the volume.
fn slice_height(height_mm: f64, bounds: &Aabb) -> f64 {
    let reach = bounds.half_diagonal();
    height_mm.clamp(reach * 1e-8, reach * 1e8)
}

/// Upward in the picture when nobody says: superior, or anterior when looking along the body's axis.
fn up_for(from: DVec3) -> DVec3 {
    if from.normalize_or_zero().z.abs() > 0.999 { DVec3::Y } else { DVec3::Z }
}
