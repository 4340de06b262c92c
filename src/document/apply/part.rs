//! Splitters that name pixels: where they cut, found in the picture. What commands on parts do is the scene's.

use crate::document::Document;
use crate::document::command::parts::Splitter;
use crate::document::error::DocumentError;
use crate::document::place::nothing_there;
use crate::document::scene::check::check_size;
use crate::explode::{Cut, PartId, axis_plane, depth_plane};
use crate::math::{DVec2, DVec3};

impl Document {
    /// The splitter as cuts of single parts at rest; one that names no pixel stays as it is.
    ///
    /// # Errors
    /// If nothing shows at the pixel, or there is no GPU to look with.
    pub(crate) fn cuts_of(&mut self, by: Splitter, size: Option<[u32; 2]>) -> Result<Splitter, DocumentError> {
        let views = &self.open()?.scene.views;
        let camera = views.camera;
        let size = check_size(size.unwrap_or(views.size))?;
        let cuts = match by {
            Splitter::Plane { .. } | Splitter::Cuts { .. } => return Ok(by),
            Splitter::Line { from, to } => {
                let (from, to) = (DVec2::from_array(from), DVec2::from_array(to));
                self.open()?.scene.explosion.line_cuts(self.motion.poses(), &camera, from, to, size)?
            }
            Splitter::Axis { px, axis } => {
                let (part, hit) = self.part_under(px, size)?;
                vec![self.cut_of(part, &axis_plane(&camera, DVec2::from_array(px), size, axis, hit)?)?]
            }
            Splitter::Depth { px } => {
                let (part, hit) = self.part_under(px, size)?;
                vec![self.cut_of(part, &depth_plane(&camera, hit)?)?]
            }
        };
        Ok(Splitter::Cuts { cuts, name: Some(by.step_name().into()) })
    }

    fn cut_of(&self, part: PartId, plane: &crate::math::Plane) -> Result<Cut, DocumentError> {
        Ok(self.open()?.scene.explosion.cut_of(part, self.motion.poses(), plane)?)
    }

    /// The part that is hit first by a visible sample, and where, world mm as it is seen.
    fn part_under(&mut self, px: [f64; 2], size: [u32; 2]) -> Result<(PartId, DVec3), DocumentError> {
        let hit = self.pick(DVec2::from_array(px), Some(size))?.ok_or_else(|| nothing_there("px", px))?;
        Ok((self.open()?.part_at(hit.body, hit.rest)?, hit.world))
    }
}
