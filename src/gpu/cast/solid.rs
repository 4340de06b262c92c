//! Convex solids on the host: the volume's box cut by a body's planes.
//!
//! Owns their faces, corners and volume, and whether a face of one parts it from another. The tiles project the corners,
//! the order of sight asks for the parting faces. Knows nothing of voxels or shaders.

use crate::math::{DVec3, Plane, Pose};

/// A face: its plane (outward) and its corners in order around it.
#[derive(Clone, Debug)]
struct Face {
    plane: Plane,
    corners: Vec<DVec3>,
}

/// A closed convex polyhedron in whatever space its maker names.
#[derive(Clone, Debug)]
pub struct Solid {
    faces: Vec<Face>,
    corners: Vec<DVec3>,
    /// Length below which two points are one.
    slack: f64,
}

impl Solid {
    /// The hexahedron of eight corners, bit 0 of the index choosing the first axis, bit 1 the second, bit 2 the third.
    pub fn hexahedron(corners: &[DVec3; 8]) -> Self {
        let centre = corners.iter().sum::<DVec3>() / 8.0;
        let slack = 1e-9 * (corners[7] - corners[0]).length().max((corners[6] - corners[1]).length());
        let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        let faces = quads
            .iter()
            .filter_map(|quad| {
                let corners: Vec<DVec3> = quad.iter().map(|&i: &usize| corners[i]).collect();
                let plane = Plane::through(corners[0], (corners[2] - corners[0]).cross(corners[3] - corners[1]))?;
                Some(Face { plane: if plane.distance(centre) > 0.0 { plane.flipped() } else { plane }, corners })
            })
            .collect();
        Self { faces, corners: corners.to_vec(), slack }
    }

    /// What is left on the inner side of a plane; `None` if nothing of any thickness is.
    #[must_use]
    pub fn cut(self, plane: &Plane) -> Option<Self> {
        let distances = self.corners.iter().map(|&p| plane.distance(p));
        let (lo, hi) = distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), d| (lo.min(d), hi.max(d)));
        if hi <= self.slack {
            return Some(self);
        }
        if lo >= -self.slack {
            return None;
        }
        let mut rim = Vec::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        for face in self.faces {
            let mut kept = Vec::with_capacity(face.corners.len() + 1);
            for (i, &a) in face.corners.iter().enumerate() {
                let b = face.corners[(i + 1) % face.corners.len()];
                let (da, db) = (plane.distance(a), plane.distance(b));
                if da <= self.slack {
                    kept.push(a);
                    if da >= -self.slack {
                        rim.push(a);
                    }
                }
                if (da < -self.slack && db > self.slack) || (da > self.slack && db < -self.slack) {
                    let p = a + (b - a) * (da / (da - db));
                    kept.push(p);
                    rim.push(p);
                }
            }
            if kept.len() >= 3 {
                faces.push(Face { plane: face.plane, corners: kept });
            }
        }
        let rim = around(plane.normal, distinct(rim, self.slack));
        if rim.len() >= 3 {
            faces.push(Face { plane: *plane, corners: rim });
        }
        let corners = distinct(faces.iter().flat_map(|f| f.corners.iter().copied()).collect(), self.slack);
        (corners.len() >= 4).then_some(Self { faces, corners, slack: self.slack })
    }

    /// The same solid, moved.
    #[must_use]
    pub fn posed(&self, pose: &Pose) -> Self {
        let moved = |points: &[DVec3]| points.iter().map(|&p| pose.apply(p)).collect();
        Self {
            faces: self
                .faces
                .iter()
                .map(|f| Face { plane: pose.apply_plane(&f.plane), corners: moved(&f.corners) })
                .collect(),
            corners: moved(&self.corners),
            slack: self.slack,
        }
    }

    /// Its corners.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        let apex = self.corners[0];
        self.faces
            .iter()
            .flat_map(|f| f.corners[1..].windows(2).map(move |w| (f.corners[0], w[0], w[1])))
            .map(|(a, b, c)| (a - apex).dot((b - apex).cross(c - apex)).abs() / 6.0)
            .sum()
    }

    /// A face of this solid that has all of the other outside.
    pub fn face_before(&self, other: &Self) -> Option<Plane> {
        let outside = |plane: &Plane| other.corners.iter().all(|&p| plane.distance(p) >= -self.slack);
        self.faces.iter().map(|f| f.plane).find(outside)
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

fn distinct(points: Vec<DVec3>, slack: f64) -> Vec<DVec3> {
    let mut kept: Vec<DVec3> = Vec::with_capacity(points.len());
    for p in points {
        if kept.iter().all(|q| q.distance_squared(p) > 4.0 * slack * slack) {
            kept.push(p);
        }
    }
    kept
}

/// Points of a convex polygon in order around their middle.
fn around(normal: DVec3, mut points: Vec<DVec3>) -> Vec<DVec3> {
    let centre = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let (u, v) = normal.any_orthonormal_pair();
    let angle = |p: &DVec3| (*p - centre).dot(v).atan2((*p - centre).dot(u));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points
}
