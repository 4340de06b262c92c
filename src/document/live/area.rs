//! Rectangles of a picture, and what shows in them.

use crate::gpu::Frame;
use crate::math::{DVec2, DVec3, Projection};
use crate::volume::{BRICK, BrickIndex, Grid};

/// A rectangle of a picture, pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Area {
    pub(crate) lo: DVec2,
    pub(crate) hi: DVec2,
}

impl Area {
    pub(crate) fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    pub(crate) fn pixels(&self) -> f64 {
        let size = (self.hi - self.lo).max(DVec2::ZERO);
        size.x * size.y
    }

    fn meets(&self, other: &Self) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }

    /// Where a ball of the world shows; all of the picture if the eye is in it or close, `None` if it lies behind.
    pub(crate) fn of_ball(frame: &Frame, centre: DVec3, radius_mm: f64) -> Option<Self> {
        let size = DVec2::new(f64::from(frame.size[0]), f64::from(frame.size[1]));
        let camera = &frame.camera;
        let depth = (centre - camera.eye).dot(camera.forward());
        let perspective = matches!(camera.projection, Projection::Perspective { .. });
        if depth < -radius_mm {
            return None;
        }
        if perspective && depth < 2.0 * radius_mm {
            return Some(Area { lo: DVec2::ZERO, hi: size });
        }
        let (px, _) = camera.project(centre, frame.size)?;
        // A ball off the axis shows as an ellipse, longer by the angle's secant.
        let ray = camera.ray(px, frame.size).dir.dot(camera.forward()).max(0.1);
        let reach = radius_mm / camera.mm_per_pixel((depth - radius_mm).max(1e-300), frame.size[1]) / ray + 1.0;
        Some(Area { lo: px - reach, hi: px + reach })
    }

    /// Whether any of a brick, its apron included, may show in it, wherever bodies are moved to.
    pub(crate) fn shows_brick(&self, frame: &Frame, grid: &Grid, brick: BrickIndex) -> bool {
        let half = f64::from(BRICK) / 2.0;
        let centre = DVec3::from_array(brick.origin().map(f64::from)) + half - 0.5;
        let corners = (0..4).map(|i| DVec3::new(1.0, [1.0, -1.0][i & 1], [1.0, -1.0][i >> 1]));
        let radius_mm = corners
            .map(|corner| grid.world_from_index.transform_vector3(corner * (half + 1.0)).length())
            .fold(0.0, f64::max);
        let centre = grid.world_from_index.transform_point3(centre);
        let shown = |pose: &crate::math::Pose| Self::of_ball(frame, pose.apply(centre), radius_mm);
        frame.bodies.iter().filter_map(|body| shown(&body.pose)).any(|area| area.meets(self))
    }
}
