//! Triangle meshes, as arrays: what a picture draws before its rays or cuts away along them, and the surfaces of fields.
//!
//! Owns [`TriangleMesh`], whose triangles are sure to name corners that exist, and how selections and labels become closed ones. Knows
//! no picture, document or file.

mod cell;
mod march;
mod of_field;
mod smooth;

pub use of_field::{label_surface, selection_surface};

use crate::math::{Aabb, DVec3};
use rayon::prelude::*;

/// Why arrays are no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A triangle of corners that do not exist.
    #[error("triangle {triangle} has corner {corner}, the mesh has {corners} corners; number them from 0 on")]
    NoSuchCorner {
        /// Place in the list of triangles.
        triangle: usize,
        /// As given.
        corner: u32,
        /// Number of corners.
        corners: usize,
    },
    /// A place that is none.
    #[error("corner {corner} lies at {at:?}; three finite lengths in mm expected")]
    NotAPlace {
        /// Place in the list of corners.
        corner: usize,
        /// As given.
        at: [f32; 3],
    },
}

/// Triangles over shared corners. Seen from outside the corners of a triangle go round counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    corners: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    radius_mm: f64,
}

impl TriangleMesh {
    /// Of corners in mm of the mesh's own space, and triples of their numbers.
    ///
    /// # Errors
    /// [`MeshError`] names the first corner or triangle that cannot be.
    pub fn new(corners: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if let Some(corner) = corners.iter().position(|c| !c.iter().all(|x| x.is_finite())) {
            return Err(MeshError::NotAPlace { corner, at: corners[corner] });
        }
        for (triangle, named) in triangles.iter().enumerate() {
            if let Some(&corner) = named.iter().find(|&&c| c as usize >= corners.len()) {
                return Err(MeshError::NoSuchCorner { triangle, corner, corners: corners.len() });
            }
        }
        Ok(Self::checked(corners, triangles))
    }

    /// A closed box.
    pub fn cuboid(bounds: &Aabb) -> Self {
        let corners = bounds.corners().map(|c: DVec3| c.as_vec3().to_array()).to_vec();
        // By faces: bit 0 of a corner's number chooses the end along the first axis, bit 1 along the second, bit 2 along the third.
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self::checked(corners, triangles)
    }

    fn checked(corners: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        let length = |c: &[f32; 3]| DVec3::from_array(c.map(f64::from)).length();
        let radius_mm = corners.iter().map(length).fold(0.0, f64::max);
        Self { corners, triangles, radius_mm }
    }

    /// Corners in mm of the mesh's own space.
    pub fn corners(&self) -> &[[f32; 3]] {
        &self.corners
    }

    /// No corner is farther from the origin of the mesh's own space.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Whether every edge is of two triangles that go along it either way: then there is an inside.
    pub fn is_closed(&self) -> bool {
        // Edges that are gone along from their lower to their higher corner, and those that are gone along the other way.
        let mut ways = [Vec::new(), Vec::new()];
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                ways[usize::from(from > to)].push(u64::from(from.min(to)) << 32 | u64::from(from.max(to)));
            }
        }
        ways.par_iter_mut().for_each(|way| way.par_sort_unstable());
        let [up, down] = ways;
        up == down && up.windows(2).all(|pair| pair[0] != pair[1])
    }

    /// The volume that a closed mesh encloses in mm³, what is hollow taken off.
    pub fn volume_mm3(&self) -> f64 {
        let place = |corner: u32| DVec3::from_array(self.corners[corner as usize].map(f64::from));
        // About a corner of its own: far from the origin, volumes of the tetrahedra would lose their digits.
        let about = if self.corners.is_empty() { DVec3::ZERO } else { place(0) };
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|corner| place(corner) - about);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// Numbers of corners, three a triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}
