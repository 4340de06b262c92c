//! Splitting a part: its two halves, each with the cut among its faces.
//!
//! The geometry is `math::convex`'s; owned here is how thin a part may be. Knows nothing of poses and forces.

use crate::explode::state::Face;
use crate::math::convex::{half, section, volume};
use crate::math::{DVec3, Plane};

/// Planes and corners of one half.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hull {
    pub faces: Vec<Face>,
    pub vertices: Vec<DVec3>,
}

/// How near, as a share of the whole's diameter, a corner counts as on the splitting plane: well above the rounding of
/// coordinates, and below what counts as on a face of the smallest half.
pub(super) const ON_PLANE: f64 = 1e-10;
/// How far, as a share of the whole's diameter, both halves must reach beyond the plane: a twentieth of a voxel at 256³.
const THINNEST: f64 = 2e-4;

/// The halves inside (first) and outside of a plane; `None` if either would be empty or too thin. `whole` is the diameter of
/// the volume that all splits began with, so that their tolerances agree.
pub(super) fn split(faces: &[Face], vertices: &[DVec3], plane: &Plane, whole: f64) -> Option<[Hull; 2]> {
    let distances: Vec<f64> = vertices.iter().map(|&v| plane.distance(v)).collect();
    let (on, thin) = (ON_PLANE * whole, THINNEST * whole);
    let lowest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !(lowest < -thin && highest > thin) {
        return None;
    }
    let section = section(vertices, &distances, plane, on);
    let planes: Vec<Plane> = faces.iter().map(|f| f.plane).collect();
    let hull = |side: f64, cut: Plane| {
        let half = half(&planes, vertices, &distances, &section, side, on);
        let mut faces: Vec<Face> = half.planes.iter().map(|&i| faces[i]).collect();
        faces.push(Face { plane: cut, cut: true });
        let hull = Hull { faces, vertices: half.corners };
        let bulk = || volume(hull.faces.iter().map(|f| f.plane), &hull.vertices);
        (hull.faces.len() >= 4 && hull.vertices.len() >= 4 && bulk() > 0.0).then_some(hull)
    };
    Some([hull(-1.0, *plane)?, hull(1.0, plane.flipped())?])
}
