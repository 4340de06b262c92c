//! The four forces, each a pure function; lengths in half-diagonals of the volume's box.
//!
//! Exploded Views (2006), 3.2. As printed, equation 1 is −∞ at rest and repels below 1, equations 3 and 4 have poles at 0, and
//! equation 2 has no direction for a point inside a part, where at rest every point is. These forms keep finite and keep the
//! intent: c_r·ln(1 + r/ℓ_r); c_e·exp(−r/λ_e), inside at r = 0 along the cut faces; c_v/(r + ε); c_s/(r² + ε²).

use crate::explode::bodies::{exp, ln_1p};
use crate::explode::solid::{Nearest, PartShape};
use crate::math::{Camera, DVec3, Projection, Ray};

/// A force and where it is applied, about the part's centre in the part's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Point of application.
    pub at: DVec3,
    /// The force.
    pub force: DVec3,
}

/// Distance under which a vector has no direction.
const NOWHERE: f64 = 1e-12;

/// Equation 1 for one corner: towards its place at rest, which lies at `home` from where it is.
pub fn return_force(home: DVec3, constant: f64, length: f64) -> DVec3 {
    let r = home.length();
    if r < NOWHERE { DVec3::ZERO } else { home * (constant * ln_1p(r / length) / r) }
}

/// Equation 2 for one explosion point, given about the part's centre in the part's own frame: from the point to the part's
/// nearest point, applied there. `None` if the point is inside a part without cut faces.
pub fn explosion_force(solid: &PartShape, point: DVec3, constant: f64, length: f64) -> Option<Push> {
    match solid.nearest(point) {
        Nearest::Outside(at) => {
            let away = at - point;
            let r = away.length();
            Some(Push { at, force: away * (constant * exp(-r / length) / r) })
        }
        Nearest::Inside(way) => way.map(|way| Push { at: point, force: way * constant }),
    }
}

/// Equation 3 for one explosion point: `away` leads from the nearest point of its viewing ray to the part's centre.
pub fn viewing_force(away: DVec3, constant: f64, softening: f64, fallback: DVec3) -> DVec3 {
    let r = away.length();
    let direction = if r < NOWHERE { fallback } else { away / r };
    direction * (constant / (r + softening))
}

/// Equation 4 for one other part: `away` leads from its centre to this part's.
pub fn spacing_force(away: DVec3, constant: f64, softening: f64, fallback: DVec3) -> DVec3 {
    let r = away.length();
    let direction = if r < NOWHERE { fallback } else { away / r };
    direction * (constant / (r * r + softening * softening))
}

/// The viewing ray through a point. It begins at the eye, in orthographic projection at the image plane.
pub fn viewing_ray(camera: &Camera, point: DVec3) -> Ray {
    let forward = camera.forward();
    match camera.projection {
        Projection::Perspective { .. } => Ray { origin: camera.eye, dir: (point - camera.eye).normalize_or(forward) },
        Projection::Orthographic { .. } => {
            Ray { origin: point - forward * forward.dot(point - camera.eye), dir: forward }
        }
    }
}

/// From the nearest point of a ray of unit direction to `centre`.
pub fn from_ray(ray: &Ray, centre: DVec3) -> DVec3 {
    centre - ray.at(ray.dir.dot(centre - ray.origin).max(0.0))
}
