//! Ray, axis-aligned box and plane, in whatever space their caller names.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A half-line `origin + t·dir`, `t ≥ 0`; `dir` has length 1 wherever `t` is said to be millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t = 0`.
    pub origin: DVec3,
    /// Direction.
    pub dir: DVec3,
}

impl Ray {
    /// The point at parameter `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.dir * t
    }

    /// The part of `[t0, t1]` on the inner side of every plane (signed distance ≤ 0), or `None` if nothing is left.
    pub fn clip(&self, planes: &[Plane], mut t0: f64, mut t1: f64) -> Option<(f64, f64)> {
        for plane in planes {
            let distance = plane.distance(self.origin);
            let slope = plane.normal.dot(self.dir);
            if slope == 0.0 {
                if distance > 0.0 {
                    return None;
                }
            } else {
                let t = -distance / slope;
                if slope > 0.0 { t1 = t1.min(t) } else { t0 = t0.max(t) }
            }
        }
        (t0 < t1).then_some((t0, t1))
    }
}

/// An axis-aligned box, closed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aabb {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The smallest box around the points; `None` for no point.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, p| {
            Some(bounds.map_or(Self { min: p, max: p }, |b| Self { min: b.min.min(p), max: b.max.max(p) }))
        })
    }

    /// Its centre.
    pub fn centre(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Half of its diagonal's length: the unit of length of the explosion's forces.
    pub fn half_diagonal(&self) -> f64 {
        (self.max - self.min).length() * 0.5
    }

    /// The eight corners; bit 0 of the index chooses x, bit 1 y, bit 2 z.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// Its six faces as planes with outward normals.
    pub fn planes(&self) -> [Plane; 6] {
        [
            Plane { normal: DVec3::NEG_X, offset: -self.min.x },
            Plane { normal: DVec3::X, offset: self.max.x },
            Plane { normal: DVec3::NEG_Y, offset: -self.min.y },
            Plane { normal: DVec3::Y, offset: self.max.y },
            Plane { normal: DVec3::NEG_Z, offset: -self.min.z },
            Plane { normal: DVec3::Z, offset: self.max.z },
        ]
    }
}

/// The half-space `normal·p ≤ offset`; `normal` has length 1 and points outward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Plane {
    /// Outward normal, length 1.
    #[schemars(with = "[f64; 3]")]
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with the given direction of normal, which need not have length 1; `None` if it has none.
    pub fn through(point: DVec3, normal: DVec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        Some(Self { normal, offset: normal.dot(point) })
    }

    /// Signed distance of a point, positive outside.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// The same plane with inside and outside exchanged.
    pub fn flipped(&self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }
}

/// How far a point is outside a convex region given by its planes, by the plane that it is furthest beyond; at most 0 inside. The
/// negative infinite of no plane, which is everywhere.
pub fn outside_by<'a>(planes: impl IntoIterator<Item = &'a Plane>, p: DVec3) -> f64 {
    planes.into_iter().map(|plane| plane.distance(p)).fold(f64::NEG_INFINITY, f64::max)
}

/// Which of these convex regions holds a point; of a point outside all of them the nearest by [`outside_by`]. `None` of none.
pub fn nearest_region<'a, R: IntoIterator<Item = &'a Plane>>(
    regions: impl IntoIterator<Item = R>,
    p: DVec3,
) -> Option<usize> {
    let all = regions.into_iter().map(|planes| outside_by(planes, p)).enumerate();
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}
