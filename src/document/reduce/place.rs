//! Where a place of a command is, as far as the scene tells it: in mm, in index, or a pixel of a slice.

use crate::document::command::Place;
use crate::document::error::DocumentError;
use crate::document::scene::check::check_size;
use crate::document::scene::slice_plane::SlicePlane;
use crate::document::scene::{Scene, ViewName, Views};
use crate::math::{DVec2, DVec3};
use crate::paint::Sample;
use crate::volume::Grid;

/// The normal of a slice view.
pub(crate) fn normal_in(grid: &Grid, views: &Views, view: ViewName) -> DVec3 {
    SlicePlane::new(grid, views, view).map_or(DVec3::Z, |p| p.towards_viewer)
}

/// A place as a sample of pressure 1, as far as the scene tells it; `None` if it is a pixel of the 3D view, which a picture tells. The
/// normal is that of the slice under a pixel, otherwise of the axial slice.
///
/// # Errors
/// If numbers are not finite.
pub(crate) fn place_in(place: Place, scene: &Scene, grid: &Grid) -> Result<Option<Sample>, DocumentError> {
    let finite = |field: &str, v: &[f64]| {
        if v.iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(DocumentError::invalid(field, format!("{v:?}"), "finite numbers"))
        }
    };
    let (position, normal) = match place {
        Place::Mm(at) => {
            finite("mm", &at)?;
            (DVec3::from_array(at), normal_in(grid, &scene.views, ViewName::Axial))
        }
        Place::Index(at) => {
            finite("index", &at)?;
            let world = grid.world_from_index.transform_point3(DVec3::from_array(at));
            finite("index", &world.to_array())?;
            (world, normal_in(grid, &scene.views, ViewName::Axial))
        }
        Place::Pixel { view, px, size } => {
            finite("px", &px)?;
            let mut views = scene.views.clone();
            if let (Some(size), Some(i)) = (size, view.slice()) {
                views.slices[i].size = check_size(size)?;
            }
            let Some(plane) = SlicePlane::new(grid, &views, view) else { return Ok(None) };
            let world = plane.world(DVec2::from_array(px));
            finite("px", &world.to_array())?;
            (world, plane.towards_viewer)
        }
    };
    Ok(Some(Sample { position, normal, pressure: 1.0, breaks: false }))
}
