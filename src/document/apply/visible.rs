//! What of the voxels under dabs is the visible surface, for strokes that keep to it.
//!
//! The picture is looked at under the dabs, more finely than in voxels, and every ray tells where it meets something first. The
//! eight voxels whose values are mixed there are the surface, but for those that the look itself hides: nothing behind it is one of
//! them, and a surface seen at a grazing angle has no holes. Colour goes to all eight, since the colour that shows is mixed of theirs. Each body is looked at where it stands, so that parts that were
//! moved show what they show. The cost follows the dabs.

use crate::document::Document;
use crate::document::error::DocumentError;
use crate::document::live::area::Area;
use crate::document::subject::Subject;
use crate::gpu::Frame;
use crate::math::{DVec2, DVec3};
use crate::paint::{Dab, VoxelSet};
use crate::volume::VolumeId;

/// Rays lie this share of a voxel apart, across the line of sight.
const RAYS_VOXELS: f64 = 1.0 / 3.0;
/// Most rays of one look; beyond it they lie further apart.
const MOST_RAYS: f64 = 262_144.0;
/// Dabs are looked at together while that takes no more than so many times the rays of one.
const TOGETHER: f64 = 4.0;

impl Document {
    /// Adds the voxels of the visible surface that lie under dabs, or so near to them, mm; with `all_mixed` those too that the look
    /// hides, whose values are mixed into what shows.
    ///
    /// # Errors
    /// If the device or the source fails.
    pub(crate) fn see(
        &mut self,
        volume: VolumeId,
        dabs: &[Dab],
        near_mm: f64,
        all_mixed: bool,
        seen: &mut VoxelSet,
    ) -> Result<(), DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let views = &state.scene.views;
        let mut frame = state.looking(&[volume], self.motion.poses(), &views.camera, views.size);
        self.lay_out(&mut frame.layers, false, true);
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let subject = state.at(Some(volume))?;
        let mut areas: Vec<Area> = Vec::new();
        for body in frame.bodies.iter().filter(|body| body.volume == volume) {
            // Consecutive dabs that lie close together are one look; each body has its own.
            let mut open: Option<(Area, f64)> = None;
            for dab in dabs {
                let radius_mm = dab.radius_mm + near_mm;
                if body.region.iter().any(|plane| plane.distance(dab.centre) > radius_mm) {
                    continue;
                }
                let reach = radius_mm + 2.0 * subject.grid().spacing().max_element();
                let Some(area) = Area::of_ball(&frame, body.pose.apply(dab.centre), reach) else { continue };
                open = Some(match open {
                    Some((all, one)) if all.union(area).pixels() <= TOGETHER * one.max(area.pixels()) => {
                        (all.union(area), one.max(area.pixels()))
                    }
                    Some((all, _)) => {
                        areas.push(all);
                        (area, area.pixels())
                    }
                    None => (area, area.pixels()),
                });
            }
            areas.extend(open.map(|(area, _)| area));
        }
        let mut hidden = VoxelSet::default();
        for area in areas {
            self.see_area(volume, &frame, area, all_mixed, seen, &mut hidden)?;
        }
        Ok(())
    }

    fn see_area(
        &mut self,
        volume: VolumeId,
        frame: &Frame,
        area: Area,
        all_mixed: bool,
        seen: &mut VoxelSet,
        hidden: &mut VoxelSet,
    ) -> Result<(), DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let subject = state.at(Some(volume))?;
        let (grid, dims) = (subject.grid(), subject.grid().dims);
        // The picture in so many more pixels that rays lie close enough where what is drawn ends.
        let fine = crate::document::apply::trail::pixel_mm(frame, &subject) / (RAYS_VOXELS * grid.voxel_mm());
        let most = (MOST_RAYS / area.pixels().max(1.0)).sqrt();
        let scale = fine.clamp(1.0, most.max(1.0)).ceil();
        let size = frame.size.map(|s| (f64::from(s) * scale).min(f64::from(u32::MAX)) as u32);
        let frame = Frame { size, ..frame.clone() };
        let lo = (area.lo * scale).floor().max(DVec2::ZERO);
        let hi = (area.hi * scale).ceil().min(DVec2::new(f64::from(size[0]), f64::from(size[1])));
        if !lo.cmplt(hi).all() {
            return Ok(());
        }
        let (corner, extent) = ([lo.x as u32, lo.y as u32], [(hi - lo).x as u32, (hi - lo).y as u32]);
        let image = self.graphics.part_at_start(state, &frame, corner, extent)?;
        let index_from_world = grid.index_from_world();
        for (i, (&depth, &object)) in image.depth_mm.iter().zip(&image.object).enumerate() {
            // What another volume shows hides this one.
            let own = depth.is_finite() && object.volume() == Some(volume);
            let Some(id) = object.body().filter(|_| own) else { continue };
            let at = DVec2::new((i as u32 % extent[0]) as f64, (i as u32 / extent[0]) as f64);
            let world = frame.camera.ray(lo + at + 0.5, size).at(f64::from(depth));
            let rest = frame.bodies.iter().find(|b| b.id == id).map_or(world, |b| b.pose.unapply(world));
            let base = index_from_world.transform_point3(rest).floor();
            for corner in 0..8_u32 {
                let step = DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2));
                let place = (base + step).clamp(DVec3::ZERO, grid.dims_f64() - 1.0);
                let voxel = place.to_array().map(|v| v as u32);
                debug_assert!((0..3).all(|a| voxel[a] < dims[a]));
                if seen.contains(voxel) || hidden.contains(voxel) {
                    continue;
                }
                match all_mixed || shows(&subject, voxel)? {
                    true => seen.insert(voxel),
                    false => hidden.insert(voxel),
                };
            }
        }
        Ok(())
    }
}

/// Whether the 3D view's looks show a voxel at all.
fn shows(subject: &Subject<'_>, voxel: [u32; 3]) -> Result<bool, DocumentError> {
    let (value, label) = (subject.density.value(voxel)?, subject.labels.value(voxel)?);
    Ok(subject.shows(f64::from(value), label as u16))
}
