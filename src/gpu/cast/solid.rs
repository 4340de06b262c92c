//! Convex solids on the host: the volume's box cut by a body's planes.
//!
//! Owns their planes and corners, and whether a face of one parts it from another. The tiles project the corners, the order of
//! sight asks for the parting faces. The cutting is `math::convex`'s. Knows nothing of voxels or shaders.

use crate::math::convex::{half, section, volume};
use crate::math::{DVec3, Plane, Pose};

/// A closed convex polyhedron in whatever space its maker names.
#[derive(Clone, Debug)]
pub struct Polyhedron {
    /// Outward.
    planes: Vec<Plane>,
    corners: Vec<DVec3>,
    /// Length below which two points are one.
    slack: f64,
}

impl Polyhedron {
    /// The hexahedron of eight corners, bit 0 of the index choosing the first axis, bit 1 the second, bit 2 the third.
    pub fn hexahedron(corners: &[DVec3; 8]) -> Self {
        let centre = corners.iter().sum::<DVec3>() / 8.0;
        let slack = 1e-9 * (corners[7] - corners[0]).length().max((corners[6] - corners[1]).length());
        let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        let plane = |quad: &[usize; 4]| {
            let [a, b, c, d] = quad.map(|i| corners[i]);
            let plane = Plane::through(a, (c - a).cross(d - b))?;
            Some(if plane.distance(centre) > 0.0 { plane.flipped() } else { plane })
        };
        Self { planes: quads.iter().filter_map(plane).collect(), corners: corners.to_vec(), slack }
    }

    /// What is left on the inner side of a plane; `None` if nothing of any thickness is.
    #[must_use]
    pub fn cut(self, plane: &Plane) -> Option<Self> {
        let distances: Vec<f64> = self.corners.iter().map(|&p| plane.distance(p)).collect();
        let lo = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let hi = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if hi <= self.slack {
            return Some(self);
        }
        if lo >= -self.slack {
            return None;
        }
        let section = section(&self.corners, &distances, plane, self.slack);
        let half = half(&self.planes, &self.corners, &distances, &section, -1.0, self.slack);
        let mut planes: Vec<Plane> = half.planes.iter().map(|&i| self.planes[i]).collect();
        planes.push(*plane);
        (half.corners.len() >= 4).then_some(Self { planes, corners: half.corners, slack: self.slack })
    }

    /// The same solid, moved.
    #[must_use]
    pub fn posed(&self, pose: &Pose) -> Self {
        Self {
            planes: self.planes.iter().map(|p| pose.apply_plane(p)).collect(),
            corners: self.corners.iter().map(|&p| pose.apply(p)).collect(),
            slack: self.slack,
        }
    }

    /// Its corners.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        volume(self.planes.iter().copied(), &self.corners)
    }

    /// A face of this solid that has all of the other outside.
    pub fn face_before(&self, other: &Self) -> Option<Plane> {
        let outside = |plane: &Plane| other.corners.iter().all(|&p| plane.distance(p) >= -self.slack);
        self.planes.iter().copied().find(outside)
    }

    /// Whether a face of either has the other outside.
    pub fn is_apart_from(&self, other: &Self) -> bool {
        self.face_before(other).is_some() || other.face_before(self).is_some()
    }

    /// Whether a plane leaves all of the solid inside.
    pub fn is_inside(&self, plane: &Plane) -> bool {
        self.corners.iter().all(|&p| plane.distance(p) <= self.slack)
    }
}
