//! How dabs lie along a surface: their normals are those of density where they are, toward lower values.
//!
//! The normal is the direction in which the values about a dab fall off, as the first of the stroke's volumes was at its start; where they do
//! not, it stays what the point said. Every volume gets the same dabs. The cost follows the dabs.

use crate::document::Document;
use crate::document::apply::painting::Laid;
use crate::document::error::DocumentError;
use crate::document::subject::Subject;
use crate::math::DVec3;
use crate::paint::Block;
use crate::volume::SourceError;

/// The ball that is looked at: this share of the brush's radius, but of so many voxels at least and at most.
const SHARE: f64 = 0.5;
const VOXELS: [f64; 2] = [2.0, 6.0];

impl Document {
    /// Turns dabs that lie along the surface.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn lay_along(&self, dabs: &mut Laid) -> Result<(), DocumentError> {
        let (Some(running), Some(state)) = (&self.running, &self.state) else { return Ok(()) };
        // A contour lies in its own plane.
        if !running.brush.lies_along() || running.contour.is_some() {
            return Ok(());
        }
        let first = state.at(running.volumes().first().copied())?;
        for dab in dabs.iter_mut().flat_map(|(_, dabs)| dabs) {
            dab.normal = normal_at(&first, dab.centre, dab.radius_mm)?.unwrap_or(dab.normal);
        }
        Ok(())
    }
}

/// Toward lower values: the first moment of the values in a ball, about its middle.
fn normal_at(subject: &Subject<'_>, centre: DVec3, radius_mm: f64) -> Result<Option<DVec3>, SourceError> {
    let grid = subject.grid();
    let spacing = grid.spacing();
    let [least, most] = VOXELS.map(|v| v * spacing.max_element());
    let radius = (SHARE * radius_mm).clamp(least, most);
    let middle = grid.index_from_world().transform_point3(centre);
    if !middle.is_finite() || middle.abs().max_element() > 1e9 {
        return Ok(None);
    }
    let rows = grid.index_from_world().matrix3.transpose();
    let far = DVec3::from_array([0, 1, 2].map(|a| rows.col(a).length() * radius));
    let (lo, hi) = ((middle - far).ceil(), (middle + far).floor());
    let size = (hi - lo + 1.0).max(DVec3::ONE).to_array().map(|s| s as usize);
    let block = Block::read(&subject.density, lo.to_array().map(|v| v as i64), size)?;
    let (mut moment, mut places, mut sum, mut weight) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for (i, &value) in block.values.iter().enumerate().filter(|(_, v)| !v.is_nan()) {
        let step = DVec3::new((i % size[0]) as f64, (i / size[0] % size[1]) as f64, (i / (size[0] * size[1])) as f64);
        let offset = grid.world_from_index.transform_vector3(lo + step - middle);
        let x = offset.length() / radius;
        if x < 1.0 {
            let w = (1.0 - x * x) * (1.0 - x * x);
            moment += offset * w * f64::from(value);
            places += offset * w;
            sum += w * f64::from(value);
            weight += w;
        }
    }
    let fall = if weight > 0.0 { places * (sum / weight) - moment } else { DVec3::ZERO };
    Ok(fall.try_normalize())
}
