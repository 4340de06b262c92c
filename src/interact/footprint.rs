//! The outline of a dab before it is painted: where its form meets a slice, and its silhouette in the 3D view.
//!
//! A form is an ellipsoid: a ball, a ball flattened along the surface's normal, a disc as one that is as thin as its layer. Limits of the brush
//! are left out. Pure geometry in the world, mm; whoever draws turns it into pixels.

use crate::math::{DMat2, DVec2, DVec3, Plane};
use crate::paint::{Brush, Shape, image};

/// Corners of an outline.
const CORNERS: usize = 64;

/// A dab's form about a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Its middle, world mm.
    pub centre: DVec3,
    /// mm across the normal.
    pub radius_mm: f64,
    /// Unit normal.
    pub normal: DVec3,
    /// How far it reaches along the normal, over the radius.
    pub ratio: f64,
}

impl Form {
    /// Of a brush at a place; `normal` is that of the surface there, if it is known, `slice` that of the slice it would be painted on, and
    /// half the thickness of its layer, mm.
    pub fn of(brush: &Brush, centre: DVec3, normal: Option<DVec3>, slice: (DVec3, f64)) -> Self {
        let radius_mm = brush.radius_mm;
        let (normal, ratio) = match (brush.shape, normal) {
            (Shape::Disc, _) => (slice.0, (slice.1 / radius_mm.max(f64::MIN_POSITIVE)).min(1.0)),
            (Shape::Ellipsoid, Some(normal)) => (normal, brush.ratio),
            (Shape::Ellipsoid, None) | (Shape::Sphere, _) => (DVec3::Z, 1.0),
        };
        Self { centre, radius_mm, normal, ratio }
    }

    /// Its image across a plane.
    #[must_use]
    pub fn image(&self, plane: &Plane) -> Self {
        let normal = self.normal - plane.normal * (2.0 * plane.normal.dot(self.normal));
        Self { centre: image(plane, self.centre), normal, ..*self }
    }

    /// xᵀAy for the form {x: xᵀAx ≤ r²} about its centre.
    fn product(&self, x: DVec3, y: DVec3) -> f64 {
        let stretch = 1.0 / (self.ratio * self.ratio) - 1.0;
        x.dot(y) + stretch * x.dot(self.normal) * y.dot(self.normal)
    }

    /// Where it meets the plane through `at` along `right` and `up`: corners in mm from `at` along both; none if it does not.
    pub fn meets(&self, at: DVec3, right: DVec3, up: DVec3) -> Vec<DVec2> {
        let normal = right.cross(up).normalize_or_zero();
        let lift = normal * normal.dot(at - self.centre);
        let m = DMat2::from_cols(
            DVec2::new(self.product(right, right), self.product(right, up)),
            DVec2::new(self.product(right, up), self.product(up, up)),
        );
        let g = DVec2::new(self.product(right, lift), self.product(up, lift));
        let middle = -(m.inverse() * g);
        let size = self.radius_mm * self.radius_mm - self.product(lift, lift) - g.dot(middle);
        let foot = self.centre + lift - at;
        ellipse(&m, size, middle + DVec2::new(foot.dot(right), foot.dot(up)))
    }

    /// Its silhouette seen along a direction: corners in mm from its centre along `right` and `up`, which are normal to it.
    pub fn silhouette(&self, sight: DVec3, right: DVec3, up: DVec3) -> Vec<DVec2> {
        let depth = self.product(sight, sight);
        let [a, b] = [right, up].map(|axis| self.product(axis, sight));
        let m = DMat2::from_cols(
            DVec2::new(self.product(right, right) - a * a / depth, self.product(right, up) - a * b / depth),
            DVec2::new(self.product(right, up) - a * b / depth, self.product(up, up) - b * b / depth),
        );
        ellipse(&m, self.radius_mm * self.radius_mm, DVec2::ZERO)
    }
}

/// Corners of {middle + x: xᵀMx = size}.
fn ellipse(m: &DMat2, size: f64, middle: DVec2) -> Vec<DVec2> {
    if !(size > 0.0 && middle.is_finite()) {
        return Vec::new();
    }
    let corner = |i: usize| {
        let direction = DVec2::from_angle(i as f64 / CORNERS as f64 * std::f64::consts::TAU);
        middle + direction * (size / direction.dot(*m * direction)).sqrt()
    };
    (0..CORNERS).map(corner).collect()
}
