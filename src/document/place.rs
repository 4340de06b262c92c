//! From what a command says of a place to a point of the volume at rest.

use super::{Document, DocumentError, Place, SlicePlane, ViewName};
use crate::math::{DVec2, DVec3};
use crate::paint::Sample;

impl Document {
    /// A place as a sample of pressure 1. The normal is that of the slice under a pixel, otherwise of the axial slice.
    ///
    /// # Errors
    /// If numbers are not finite, or a pixel of the 3D view shows nothing.
    pub(super) fn resolve(&mut self, place: Place) -> Result<Sample, DocumentError> {
        let state = self.open()?;
        let normal = |view: ViewName| {
            SlicePlane::new(state.grid(), &state.scene.views, view).map_or(DVec3::Z, |p| p.towards_viewer)
        };
        let sample = |position: DVec3, normal: DVec3| Sample { position, normal, pressure: 1.0 };
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
                Ok(sample(world, normal(ViewName::Axial)))
            }
            Place::Pixel { view, px, size } => {
                finite("px", &px)?;
                let mut views = state.scene.views.clone();
                if let (Some(size), Some(i)) = (size, view.slice()) {
                    views.slices[i].size = check_size(size)?;
                }
                match SlicePlane::new(state.grid(), &views, view) {
                    Some(plane) => Ok(sample(plane.world(DVec2::from_array(px)), plane.towards_viewer)),
                    None => self.resolve_pixel(px, size),
                }
            }
        }
    }

    fn resolve_pixel(&mut self, _px: [f64; 2], _size: Option<[u32; 2]>) -> Result<Sample, DocumentError> {
        Err(DocumentError::NoGpu { what: "a pixel of the 3D view", reason: "this build has no caster".into() })
    }
}

/// A picture's size that can be drawn.
pub(super) fn check_size(size: [u32; 2]) -> Result<[u32; 2], DocumentError> {
    if size.iter().all(|s| (1..=16_384).contains(s)) {
        Ok(size)
    } else {
        Err(DocumentError::invalid("size", format!("{size:?}"), "1 to 16384 pixels either way"))
    }
}
