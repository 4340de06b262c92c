//! Windowed cutaways: a piece of surface, its copy displaced against the centre normal, and walls that close the two along the border.
//!
//! Owns the closed mesh and what is inside it: where the winding of this one mesh is not 0. Windings of several cutaways are never
//! added, opposite sheets would cancel: ask each, a point is cut away if any of them holds it. Knows no field, picture or document.
//! Source: "Direct Volume Editing" (2008), 5.2; solid angles after van Oosterom and Strackee (1983).

use crate::annotate::window::patch::{Patch, PatchError};
use glam::DVec3;
use std::f64::consts::TAU;

/// Why nothing can be cut away.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutawayError {
    /// A direction without length.
    #[error("the centre normal is {found}; a finite vector with a length expected")]
    Direction {
        /// As given.
        found: DVec3,
    },
    /// A length that is none.
    #[error("{field} is {found} mm; {expected}")]
    Length {
        /// Name of the argument.
        field: &'static str,
        /// As given.
        found: f64,
        /// What would do.
        expected: &'static str,
    },
    /// No patch to begin with, or one that lies along the centre normal.
    #[error(transparent)]
    Patch(#[from] PatchError),
}

/// What a triangle of a cutaway is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CutPart {
    /// The outer side, on the surface or lifted above it.
    Sheet,
    /// The inner side, displaced into the volume.
    Floor,
    /// What joins the two.
    Wall,
}

/// A closed mesh in world mm. Every edge is in exactly two triangles, with opposite directions; seen from outside the corners of a
/// triangle go round counter-clockwise where the mesh does not pass through itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutaway {
    corners: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Triangles of the sheet; as many of the floor follow, then the walls.
    sheet: usize,
    rim: Vec<Vec<DVec3>>,
    low: DVec3,
    high: DVec3,
}

impl Cutaway {
    /// Cuts `patch` out, `depth_mm` deep against `outward`, the outward normal at the patch's centre (any length), beginning `lift_mm`
    /// above the patch. A lift of about a voxel takes along what noise and interpolation leave in front of the surface; without it a
    /// film of matter may stay before the window.
    ///
    /// A triangle of the patch with a border edge along `outward` encloses nothing when displaced and is left out. A patch that faces
    /// away from `outward` on the whole is turned.
    ///
    /// # Errors
    /// [`CutawayError`]: `outward` without length, `depth_mm` not above 0, `lift_mm` below 0, or a patch wholly along `outward`.
    pub fn new(patch: &Patch, outward: DVec3, depth_mm: f64, lift_mm: f64) -> Result<Self, CutawayError> {
        let direction = outward.try_normalize().ok_or(CutawayError::Direction { found: outward })?;
        if !(depth_mm > 0.0 && depth_mm.is_finite()) {
            return Err(CutawayError::Length { field: "depth_mm", found: depth_mm, expected: "more than 0 expected" });
        }
        if !(lift_mm >= 0.0 && lift_mm.is_finite()) {
            return Err(CutawayError::Length { field: "lift_mm", found: lift_mm, expected: "0 or more expected" });
        }
        let patch = patch.without_border_along(direction)?.facing(direction);
        let count = patch.corners().len() as u32;
        let outer = patch.corners().iter().map(|&c| c + direction * lift_mm);
        let inner = patch.corners().iter().map(|&c| c - direction * depth_mm);
        let corners: Vec<DVec3> = outer.chain(inner).collect();
        let sheet = patch.triangles().len();
        let mut triangles = patch.triangles().to_vec();
        triangles.extend(patch.triangles().iter().map(|&[a, b, c]| [c + count, b + count, a + count]));
        let border = patch.border();
        for round in &border {
            for (k, &a) in round.iter().enumerate() {
                let b = round[(k + 1) % round.len()];
                triangles.extend([[b, a, a + count], [b, a + count, b + count]]);
            }
        }
        let rim = border.iter().map(|round| round.iter().map(|&c| patch.corners()[c as usize]).collect()).collect();
        let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        Ok(Self { corners, triangles, sheet, rim, low, high })
    }

    /// Corners, world mm: those of the outer sheet, then as many of the floor in the same order.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Triples of corner numbers: the sheet's triangles, the floor's, the walls'.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// What the triangle of this number is part of.
    pub fn part(&self, triangle: usize) -> CutPart {
        match triangle / self.sheet.max(1) {
            0 => CutPart::Sheet,
            1 => CutPart::Floor,
            _ => CutPart::Wall,
        }
    }

    /// The sheet's border as it lies on the surface, not lifted: closed polylines in world mm, the first point not repeated,
    /// counter-clockwise from outside around the window and clockwise around its holes.
    pub fn rim(&self) -> &[Vec<DVec3>] {
        &self.rim
    }

    /// The least box around it: its low and high corner, world mm.
    pub fn bounds(&self) -> [DVec3; 2] {
        [self.low, self.high]
    }

    /// How often the mesh winds around `p` (world mm): 1 inside where it is simple, 0 outside, whole but for rounding, any whole
    /// number where the sheet folds; on the mesh itself in between.
    pub fn winding(&self, p: DVec3) -> f64 {
        let outside = p.cmplt(self.low).any() || p.cmpgt(self.high).any();
        if outside { 0.0 } else { winding(&self.corners, &self.triangles, p) }
    }

    /// Whether `p` (world mm) is cut away: the winding, rounded, is not 0.
    pub fn contains(&self, p: DVec3) -> bool {
        self.winding(p).round() != 0.0
    }
}

/// How often triangles wind around `p`: the sum of their signed solid angles over 4π, positive where their counter-clockwise sides
/// look away from `p`. A whole number but for rounding if the mesh is closed and `p` not on it. Triangles name corners that exist.
///
/// Source: van Oosterom and Strackee (1983), tan(Ω/2) = a·(b×c) / (abc + (a·b)c + (b·c)a + (c·a)b).
pub fn winding(corners: &[DVec3], triangles: &[[u32; 3]], p: DVec3) -> f64 {
    let half: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| corners[i as usize] - p);
            let [la, lb, lc] = [a, b, c].map(DVec3::length);
            let volume = a.dot(b.cross(c));
            let facing = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            volume.atan2(facing)
        })
        .sum();
    half / TAU
}
