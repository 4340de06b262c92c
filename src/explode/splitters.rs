//! The three splitters: planes from a camera, pixels and what was hit; and which parts a line cuts.
//!
//! Exploded Views (2006), 3.1. Under perspective the axis splitter's normal comes from the viewing ray through the click, not
//! from the direction of sight, so that the plane stays edge-on where it was clicked. Planes are in the world as it is seen,
//! exploded or not; [`Explosion::split`] takes them back to rest.

use crate::explode::convex::ON_PLANE;
use crate::explode::error::ExplodeError;
use crate::explode::poses::Poses;
use crate::explode::state::{Axis, Cut, Explosion, Part, PartId};
use crate::math::convex::{diameter, section};
use crate::math::{Camera, DVec2, DVec3, Plane, Pose, Projection};

/// The plane of the axis splitter: through `hit` (world mm, seen through `px`), holding the viewing ray and a screen axis.
///
/// # Errors
/// If a number is not finite.
pub fn axis_plane(camera: &Camera, px: DVec2, size: [u32; 2], axis: Axis, hit: DVec3) -> Result<Plane, ExplodeError> {
    let (right, up) = camera.right_up();
    let screen = match axis {
        Axis::Horizontal => right,
        Axis::Vertical => up,
    };
    plane("axis", hit, camera.ray(px, size).dir.cross(screen), "give finite pixels, camera and hit point")
}

/// The plane of the depth splitter: through `hit` (world mm), parallel to the picture; its inner side is the nearer one.
///
/// # Errors
/// If a number is not finite.
pub fn depth_plane(camera: &Camera, hit: DVec3) -> Result<Plane, ExplodeError> {
    plane("depth", hit, camera.forward(), "give a finite camera and hit point")
}

/// The plane of the line splitter: through the eye (in orthographic projection: along the direction of sight) and the
/// segment between two pixels.
///
/// # Errors
/// If the segment has no length.
pub fn line_plane(camera: &Camera, from: DVec2, to: DVec2, size: [u32; 2]) -> Result<Plane, ExplodeError> {
    let (a, b) = (camera.ray(from, size), camera.ray(to, size));
    let normal = match camera.projection {
        Projection::Perspective { .. } => a.dir.cross(b.dir),
        Projection::Orthographic { .. } => (b.origin - a.origin).cross(camera.forward()),
    };
    let reason = "draw a line between two different pixels";
    if from.distance(to) < 1e-6 {
        return Err(ExplodeError::NoPlane { splitter: "line", reason });
    }
    plane("line", a.origin, normal, reason)
}

fn plane(splitter: &'static str, point: DVec3, normal: DVec3, reason: &'static str) -> Result<Plane, ExplodeError> {
    let plane = Plane::through(point, normal).filter(|p| p.normal.is_finite() && p.offset.is_finite());
    plane.ok_or(ExplodeError::NoPlane { splitter, reason })
}

impl Part {
    /// Whether the part's silhouette, where it stands in `pose`, meets the segment between two pixels; `plane` is theirs by
    /// [`line_plane`]. What lies behind the eye or the image plane has no silhouette.
    fn meets(&self, pose: &Pose, camera: &Camera, (from, to): (DVec2, DVec2), size: [u32; 2], plane: &Plane) -> bool {
        let vertices: Vec<DVec3> = self.vertices.iter().map(|&v| pose.apply(v)).collect();
        let distances: Vec<f64> = vertices.iter().map(|&v| plane.distance(v)).collect();
        // The segment's rays sweep a wedge of the plane; the silhouette meets the segment just where the part's section
        // with the plane meets this wedge.
        let (a, b) = (camera.ray(from, size), camera.ray(to, size));
        let side = |origin: DVec3, dir: DVec3, towards: DVec3| {
            let normal = plane.normal.cross(dir);
            let normal = if normal.dot(towards) > 0.0 { -normal } else { normal };
            Plane::through(origin, normal)
        };
        let across = match camera.projection {
            Projection::Perspective { .. } => b.dir - a.dir,
            Projection::Orthographic { .. } => b.origin - a.origin,
        };
        let before = Plane::through(camera.eye, -camera.forward());
        let Some(bounds) = [side(a.origin, a.dir, across), side(b.origin, b.dir, -across), before]
            .into_iter()
            .collect::<Option<Vec<Plane>>>()
        else {
            return false;
        };
        let near = ON_PLANE * diameter(&vertices);
        let mut ring = section(&vertices, &distances, plane, near);
        for bound in &bounds {
            ring = clip(&ring, bound);
        }
        !ring.is_empty()
    }
}

/// The part of a convex polygon inside a plane (Sutherland and Hodgman 1974).
fn clip(ring: &[DVec3], bound: &Plane) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(ring.len() + 1);
    for (i, &at) in ring.iter().enumerate() {
        let before = ring[(i + ring.len() - 1) % ring.len()];
        let (d0, d1) = (bound.distance(before), bound.distance(at));
        if (d0 < 0.0) != (d1 < 0.0) && d0 != d1 {
            out.push(before + (at - before) * (d0 / (d0 - d1)));
        }
        if d1 <= 0.0 {
            out.push(at);
        }
    }
    out
}

impl Explosion {
    /// The visible parts whose silhouettes, where they are now, meet the segment between two pixels.
    ///
    /// # Errors
    /// If the segment has no length.
    pub fn meeting(
        &self,
        poses: &Poses,
        camera: &Camera,
        from: DVec2,
        to: DVec2,
        size: [u32; 2],
    ) -> Result<Vec<PartId>, ExplodeError> {
        let plane = line_plane(camera, from, to, size)?;
        let meets = |p: &&Part| p.visible && p.meets(&poses.of(p), camera, (from, to), size, &plane);
        Ok(self.parts.iter().filter(meets).map(|p| p.id).collect())
    }

    /// The line splitter: where it cuts every part that [`Explosion::meeting`] names.
    ///
    /// # Errors
    /// If the segment has no length.
    pub fn line_cuts(
        &self,
        poses: &Poses,
        camera: &Camera,
        from: DVec2,
        to: DVec2,
        size: [u32; 2],
    ) -> Result<Vec<Cut>, ExplodeError> {
        let plane = line_plane(camera, from, to, size)?;
        let met = self.meeting(poses, camera, from, to, size)?;
        met.into_iter().map(|part| self.cut_of(part, poses, &plane)).collect()
    }

    /// Where a plane of the world cuts a part where it stands now, exploded or not.
    ///
    /// # Errors
    /// If there is no such part.
    pub fn cut_of(&self, part: PartId, poses: &Poses, world: &Plane) -> Result<Cut, ExplodeError> {
        Ok(Cut { part, plane: poses.of(self.part(part)?).unapply_plane(world) })
    }

    /// Cuts parts one after another; answers their halves, none for a part that a plane only grazes.
    ///
    /// # Errors
    /// If there is no such part; what was cut before stays cut.
    pub fn cut(&mut self, cuts: &[Cut]) -> Result<Vec<[PartId; 2]>, ExplodeError> {
        let mut halves = Vec::new();
        for Cut { part, plane } in cuts {
            halves.extend(self.split_at_rest(*part, plane)?);
        }
        Ok(halves)
    }
}
