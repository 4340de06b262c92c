//! The camera: pixels to rays and back.
//!
//! Pixel (0, 0) is the top-left corner of the picture; the centre of the first pixel is (0.5, 0.5). Samples of a picture
//! lie at `t = k·step` along the unit ray from the eye, or from the image plane in orthographic projection.

use crate::math::shapes::{Aabb, Ray};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// How the world reaches the image plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Vertical angle of view in degrees.
    Perspective {
        /// Degrees, in (0, 180).
        fov_y_deg: f64,
    },
    /// Height of the picture in millimetres.
    Orthographic {
        /// Millimetres, positive.
        height_mm: f64,
    },
}

/// Where one looks from and to, in world millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Camera {
    /// The eye; in orthographic projection the centre of the image plane.
    #[schemars(with = "[f64; 3]")]
    pub eye: DVec3,
    /// The point in the picture's centre.
    #[schemars(with = "[f64; 3]")]
    pub target: DVec3,
    /// Upward in the picture; need not be orthogonal to the direction of sight.
    #[schemars(with = "[f64; 3]")]
    pub up: DVec3,
    /// Projection.
    pub projection: Projection,
}

impl Camera {
    /// Looks at a box from `direction` (from the box towards the eye) so that its bounding sphere fills the picture.
    pub fn framing(bounds: &Aabb, direction: DVec3, up: DVec3) -> Self {
        Self::framing_in(bounds, direction, up, Projection::Perspective { fov_y_deg: 30.0 })
    }

    /// The same in a projection: its angle is kept, the height of an orthographic picture becomes the sphere's.
    pub fn framing_in(bounds: &Aabb, direction: DVec3, up: DVec3, projection: Projection) -> Self {
        // A point is looked at as if it were something.
        let radius = Some(bounds.half_diagonal()).filter(|r| *r > 0.0).unwrap_or(1e-6);
        let away = |fov_y_deg: f64| radius / (fov_y_deg.to_radians() * 0.5).sin();
        let (distance, projection) = match projection {
            Projection::Perspective { fov_y_deg } => (away(fov_y_deg), projection),
            Projection::Orthographic { .. } => (away(30.0), Projection::Orthographic { height_mm: radius * 2.0 }),
        };
        let towards_eye = direction.try_normalize().unwrap_or(DVec3::Y);
        Self { eye: bounds.centre() + towards_eye * distance, target: bounds.centre(), up, projection }
    }

    /// Unit direction of sight.
    pub fn forward(&self) -> DVec3 {
        (self.target - self.eye).try_normalize().unwrap_or(DVec3::NEG_Y)
    }

    /// Unit right and up of the picture.
    pub fn right_up(&self) -> (DVec3, DVec3) {
        let forward = self.forward();
        let right = forward.cross(self.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        (right, right.cross(forward))
    }

    /// View space: x right, y up, looking along −z, millimetres.
    pub fn view_from_world(&self) -> DAffine3 {
        let (right, up) = self.right_up();
        let rows = DMat3::from_cols(right, up, -self.forward()).transpose();
        DAffine3 { matrix3: rows, translation: -(rows * self.eye) }
    }

    /// Half the picture's height: at distance 1 in perspective, in millimetres in orthographic projection.
    pub fn half_height(&self) -> f64 {
        match self.projection {
            Projection::Perspective { fov_y_deg } => (fov_y_deg.to_radians() * 0.5).tan(),
            Projection::Orthographic { height_mm } => height_mm * 0.5,
        }
    }

    /// The unit ray through a point of a picture of `size` pixels.
    pub fn ray(&self, px: DVec2, size: [u32; 2]) -> Ray {
        let (right, up) = self.right_up();
        let half = self.half_height();
        let (w, h) = (f64::from(size[0]), f64::from(size[1]));
        let x = (2.0 * px.x - w) / h * half;
        let y = (1.0 - 2.0 * px.y / h) * half;
        match self.projection {
            Projection::Perspective { .. } => {
                Ray { origin: self.eye, dir: (self.forward() + right * x + up * y).normalize() }
            }
            Projection::Orthographic { .. } => Ray { origin: self.eye + right * x + up * y, dir: self.forward() },
        }
    }

    /// Pixel of a world point and its distance in mm along the direction of sight; `None` at or behind a perspective eye.
    pub fn project(&self, world: DVec3, size: [u32; 2]) -> Option<(DVec2, f64)> {
        let v = self.view_from_world().transform_point3(world);
        let (w, h) = (f64::from(size[0]), f64::from(size[1]));
        let scale = match self.projection {
            Projection::Perspective { .. } if -v.z <= 1e-9 * v.length() => return None,
            Projection::Perspective { .. } => self.half_height() * -v.z,
            Projection::Orthographic { .. } => self.half_height(),
        };
        Some((DVec2::new((v.x / scale * h + w) * 0.5, (1.0 - v.y / scale) * 0.5 * h), -v.z))
    }

    /// Size of a pixel in mm at a distance (mm along the direction of sight).
    pub fn mm_per_pixel(&self, distance_mm: f64, height_px: u32) -> f64 {
        let half = match self.projection {
            Projection::Perspective { .. } => self.half_height() * distance_mm,
            Projection::Orthographic { .. } => self.half_height(),
        };
        2.0 * half / f64::from(height_px.max(1))
    }

    /// Turns the eye about the target: `azimuth` about the world's z axis, `elevation` towards it, both in degrees.
    /// Elevation stops short of the poles.
    #[must_use]
    pub fn orbited(&self, azimuth_deg: f64, elevation_deg: f64) -> Self {
        let offset = self.eye - self.target;
        let turned = DQuat::from_rotation_z(azimuth_deg.to_radians()) * offset;
        let length = turned.length().max(f64::MIN_POSITIVE);
        let old = (turned.z / length).clamp(-1.0, 1.0).asin();
        let limit = 89.5_f64.to_radians();
        let new = (old + elevation_deg.to_radians()).clamp(-limit, limit);
        let flat = DVec3::new(turned.x, turned.y, 0.0).try_normalize().unwrap_or(DVec3::NEG_Y);
        Self { eye: self.target + (flat * new.cos() + DVec3::Z * new.sin()) * length, up: DVec3::Z, ..*self }
    }

    /// Moves eye and target together by pixels of a picture of the given height.
    #[must_use]
    pub fn panned(&self, delta_px: DVec2, height_px: u32) -> Self {
        let (right, up) = self.right_up();
        let mm = self.mm_per_pixel((self.target - self.eye).length(), height_px);
        let shift = -right * (delta_px.x * mm) + up * (delta_px.y * mm);
        Self { eye: self.eye + shift, target: self.target + shift, ..*self }
    }

    /// Nearer (`factor` < 1) or further. Orthographic projection scales the height alone: its image plane would come into what is
    /// looked at, and cut off what lies before it.
    #[must_use]
    pub fn zoomed(&self, factor: f64) -> Self {
        let factor = factor.clamp(1e-3, 1e3);
        match self.projection {
            Projection::Orthographic { height_mm } => {
                Self { projection: Projection::Orthographic { height_mm: height_mm * factor }, ..*self }
            }
            Projection::Perspective { .. } => Self { eye: self.target + (self.eye - self.target) * factor, ..*self },
        }
    }
}
