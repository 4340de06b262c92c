//! From what a command says of a place to a point of the volume at rest.

use crate::document::Document;
use crate::document::command::Place;
use crate::document::error::DocumentError;
use crate::document::scene::ViewName;
use crate::document::scene::slice_plane::SlicePlane;
use crate::document::state::State;
use crate::gpu::Hit;
use crate::math::{DVec2, DVec3};
use crate::paint::Sample;

impl Document {
    /// A place as a sample of pressure 1; `None` if it is a pixel of the 3D view that shows nothing. The normal is that of the slice
    /// under a pixel, otherwise of the axial slice.
    ///
    /// # Errors
    /// If numbers are not finite, or there is no GPU to look at the 3D view with.
    pub(super) fn resolve(&mut self, place: Place) -> Result<Option<Sample>, DocumentError> {
        let state = self.open()?;
        let normal = |view: ViewName| normal_of(state, view);
        let sample = |position: DVec3, normal: DVec3| Some(Sample { position, normal, pressure: 1.0, breaks: false });
        let finite = |field: &str, v: &[f64]| {
            if v.iter().all(|x| x.is_finite()) {
                Ok(())
            } else {
                Err(DocumentError::invalid(field, format!("{v:?}"), "finite numbers"))
            }
        };
        match place {
            Place::Mm(at) => {
                finite("mm", &at)?;
                Ok(sample(DVec3::from_array(at), normal(ViewName::Axial)))
            }
            Place::Index(at) => {
                finite("index", &at)?;
                let world = state.grid().world_from_index.transform_point3(DVec3::from_array(at));
                finite("index", &world.to_array())?;
                Ok(sample(world, normal(ViewName::Axial)))
            }
            Place::Pixel { view, px, size } => {
                finite("px", &px)?;
                let mut views = state.scene.views.clone();
                if let (Some(size), Some(i)) = (size, view.slice()) {
                    views.slices[i].size = check_size(size)?;
                }
                match SlicePlane::new(state.grid(), &views, view) {
                    Some(plane) => {
                        let world = plane.world(DVec2::from_array(px));
                        finite("px", &world.to_array())?;
                        Ok(sample(world, plane.towards_viewer))
                    }
                    None => {
                        let normal = normal(ViewName::Axial);
                        let hit = self.pick(DVec2::from_array(px), size)?;
                        Ok(hit.and_then(|hit| sample(hit.rest, normal)))
                    }
                }
            }
        }
    }

    /// The first visible surface under a pixel of the 3D view as it is drawn now, running stroke included.
    ///
    /// # Errors
    /// Without a GPU, or whatever the GPU or the source fails with.
    pub fn pick(&mut self, px: DVec2, size: Option<[u32; 2]>) -> Result<Option<Hit>, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let size = check_size(size.unwrap_or(state.scene.views.size))?;
        if !px.is_finite() {
            return Err(DocumentError::invalid("px", px, "two finite numbers"));
        }
        let frame = state.looking(self.motion.poses(), &state.scene.views.camera, size);
        self.graphics.pick(state, &frame, px)
    }
}

/// The normal of a slice view.
pub(super) fn normal_of(state: &State, view: ViewName) -> DVec3 {
    SlicePlane::new(state.grid(), &state.scene.views, view).map_or(DVec3::Z, |p| p.towards_viewer)
}

/// Most pixels of a picture: with depth and object each takes 24 bytes on the host alone.
const MAX_PIXELS: u64 = 1 << 26;

/// A picture's size that can be drawn.
pub(super) fn check_size(size: [u32; 2]) -> Result<[u32; 2], DocumentError> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if size.iter().all(|s| (1..=16_384).contains(s)) && pixels <= MAX_PIXELS {
        Ok(size)
    } else {
        let expected = "1 to 16384 pixels either way, 67108864 in all";
        Err(DocumentError::invalid("size", format!("{size:?}"), expected))
    }
}
