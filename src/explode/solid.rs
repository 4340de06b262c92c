//! A part as forces see it: about its centre, lengths in half-diagonals of the volume's box; and its nearest point.
//!
//! The nearest point of a convex body to a point outside lies on a face that the point is outside of, so only these few are
//! asked. All in `f64` and in the order of faces: the same input gives the same bits.

use crate::explode::bodies::exp;
use crate::explode::error::ExplodeError;
use crate::explode::state::Part;
use crate::math::DVec3;
use crate::math::convex::polygon;

#[derive(Clone, Debug)]
struct Side {
    normal: DVec3,
    offset: f64,
    cut: bool,
    /// Counter-clockwise seen from outside.
    ring: Vec<DVec3>,
}

/// A convex body by its corners and faces, in half-diagonals of the volume's box about the part's centre.
#[derive(Clone, Debug)]
pub struct PartShape {
    centre_mm: DVec3,
    corners: Vec<DVec3>,
    sides: Vec<Side>,
}

/// Where a point is, seen from a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nearest {
    /// The solid's nearest point.
    Outside(DVec3),
    /// The way by which the solid leaves the point soonest, length 1; `None` if it has no cut face.
    Inside(Option<DVec3>),
}

/// Depth, in half-diagonals, over which a cut face's pull on the direction inside fades.
const DEPTH: f64 = 0.05;
/// Distance, in half-diagonals, under which a direction from a point means nothing.
const TOUCHING: f64 = 1e-12;

impl PartShape {
    /// A part, with `unit_mm` the half-diagonal.
    ///
    /// # Errors
    /// If the part has no corners or the unit is not positive.
    pub fn of(part: &Part, unit_mm: f64) -> Result<Self, ExplodeError> {
        if part.vertices.is_empty() || !(unit_mm.is_finite() && unit_mm > 0.0) {
            let found = format!("{} corners, unit {unit_mm} mm", part.vertices.len());
            return Err(ExplodeError::Invalid {
                field: format!("part {}", part.id.0),
                found,
                expected: "corners and a volume with an extent",
            });
        }
        let centre_mm = part.centre();
        let local = |v: DVec3| (v - centre_mm) / unit_mm;
        let sides = part.faces.iter().map(|f| Side {
            normal: f.plane.normal,
            offset: -f.plane.distance(centre_mm) / unit_mm,
            cut: f.cut,
            ring: polygon(&f.plane, &part.vertices).into_iter().map(local).collect(),
        });
        Ok(Self { centre_mm, corners: part.vertices.iter().map(|&v| local(v)).collect(), sides: sides.collect() })
    }

    /// The part's centre at rest, world mm.
    pub fn centre_mm(&self) -> DVec3 {
        self.centre_mm
    }

    /// Corners about the centre.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Where a point about the centre is.
    pub fn nearest(&self, p: DVec3) -> Nearest {
        let mut best = (f64::INFINITY, DVec3::ZERO);
        for side in &self.sides {
            let height = side.normal.dot(p) - side.offset;
            if height > TOUCHING && height < best.0 {
                let (q, foot) = side.nearest(p, height);
                if foot {
                    return Nearest::Outside(q);
                }
                let distance = p.distance(q);
                if distance < best.0 {
                    best = (distance, q);
                }
            }
        }
        if best.0.is_finite() { Nearest::Outside(best.1) } else { Nearest::Inside(self.way_out(p)) }
    }

    /// `−Σ n_k·exp(−d_k/0.05)` over the cut faces, normalised. Factoring out the nearest face's weight changes nothing but
    /// keeps the sum above zero far inside.
    fn way_out(&self, p: DVec3) -> Option<DVec3> {
        let depth = |s: &Side| (s.offset - s.normal.dot(p)).max(0.0);
        let least = self.sides.iter().filter(|s| s.cut).map(depth).fold(f64::INFINITY, f64::min);
        let weight = |s: &Side| exp(-(depth(s) - least) / DEPTH);
        let sum: DVec3 = self.sides.iter().filter(|s| s.cut).map(|s| -s.normal * weight(s)).sum();
        // Between equal and opposite cuts no way is better; the first cut face decides.
        let first = self.sides.iter().find(|s| s.cut).map(|s| -s.normal);
        if sum.length() > 1e-9 { Some(sum.normalize()) } else { first }
    }
}

impl Side {
    /// Nearest point of the face to a point `height` above its plane, and whether it is the foot of the perpendicular: then
    /// no other point of the solid is nearer, since all of it lies beyond the plane.
    fn nearest(&self, p: DVec3, height: f64) -> (DVec3, bool) {
        let foot = p - self.normal * height;
        let mut best = (f64::INFINITY, foot);
        let mut inside = true;
        for (i, &a) in self.ring.iter().enumerate() {
            let b = self.ring[(i + 1) % self.ring.len()];
            let along = b - a;
            if self.normal.cross(along).dot(foot - a) < 0.0 {
                inside = false;
                let t = (foot - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
                let q = a + along * t.clamp(0.0, 1.0);
                let d = foot.distance_squared(q);
                if d < best.0 {
                    best = (d, q);
                }
            }
        }
        if inside { (foot, true) } else { (best.1, false) }
    }
}
