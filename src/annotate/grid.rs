//! A grid of vertices on a surface, and how far it is from flat.
//!
//! Owns the vertices of an annotation ("Direct Volume Editing", section 5: (2m+1)(2n+1) points about a centre) with what follows from
//! them alone: triangles, normals, turned-over triangles, and the distortion of the map between each triangle and its flat one
//! (symmetric Dirichlet energy, Smith and Schaefer 2015). It knows nothing of how the vertices came to lie where they do.

use crate::annotate::surface::{Surface, normal};
use glam::DVec3;

/// Vertices on a surface that are a plane's square lattice when laid flat.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceGrid {
    /// Number of vertices along u, odd.
    pub columns: usize,
    /// Number of vertices along v, odd.
    pub rows: usize,
    /// Distance between neighbours on the flat lattice, mm.
    pub spacing_mm: f64,
    /// World positions, mm, row major: u runs fastest, the centre is the middle one. None where the grid is trimmed.
    pub points: Vec<Option<DVec3>>,
}

/// How a grid's triangles differ from their flat ones. All are 0 or 1 for an isometric grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distortion {
    /// E/4 − 1, where E is the mean over the surface's area of |J|² + |J⁻¹|². 0 if there are no triangles, infinite if one of them
    /// has no area.
    pub excess: f64,
    /// The largest ratio of a triangle's area on the surface to its area on the flat lattice.
    pub most_area: f64,
    /// The smallest such ratio.
    pub least_area: f64,
    /// The largest stretch of a length, any direction, from flat to surface.
    pub most_length: f64,
    /// The smallest such stretch.
    pub least_length: f64,
}

impl SurfaceGrid {
    /// The indices of each triangle's vertices, counter-clockwise in (u, v), so seen from outside: both triangles of each quad whose
    /// four corners exist.
    pub fn triangles(&self) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(2 * self.columns * self.rows);
        for row in 1..self.rows {
            for column in 1..self.columns {
                let [a, b] = [(row - 1) * self.columns + column - 1, (row - 1) * self.columns + column];
                let [c, d] = [a + self.columns, b + self.columns];
                if [a, b, c, d].iter().all(|&corner| self.points[corner].is_some()) {
                    triangles.extend([[a, b, c], [d, c, b]]);
                }
            }
        }
        triangles
    }

    /// Index of the vertex in the middle.
    pub fn centre(&self) -> usize {
        (self.rows / 2) * self.columns + self.columns / 2
    }

    /// The number of trimmed vertices.
    pub fn trimmed(&self) -> usize {
        self.points.iter().filter(|point| point.is_none()).count()
    }

    /// The outward unit normals at the vertices (see [`normal`]); None where trimmed or where the surface has none.
    pub fn normals<S: Surface + ?Sized>(&self, surface: &S) -> Vec<Option<DVec3>> {
        self.points.iter().map(|point| normal(surface, (*point)?)).collect()
    }

    /// The number of triangles that are turned over: their normal points against the mean of the outward normals at their vertices,
    /// or they have no area.
    pub fn turned_over<S: Surface + ?Sized>(&self, surface: &S) -> usize {
        let normals = self.normals(surface);
        let facing = |triangle: &[usize; 3]| {
            let outward: DVec3 = triangle.iter().filter_map(|&vertex| normals[vertex]).sum();
            self.corners(triangle).is_some_and(|[a, b, c]| (b - a).cross(c - a).dot(outward) > 0.0)
        };
        self.triangles().iter().filter(|triangle| !facing(triangle)).count()
    }

    /// The distortion of the whole grid.
    pub fn distortion(&self) -> Distortion {
        let (mut sum, mut whole) = (0.0, 0.0);
        let mut found =
            Distortion { excess: 0.0, most_area: 1.0, least_area: 1.0, most_length: 1.0, least_length: 1.0 };
        for (index, triangle) in self.triangles().iter().enumerate() {
            let Some([a, b, c]) = self.corners(triangle) else { continue };
            // Both triangles of a quad are right-angled at their first vertex, with legs of one spacing.
            let [p, q] = [(b - a) / self.spacing_mm, (c - a) / self.spacing_mm];
            let [square, area] = [p.length_squared() + q.length_squared(), p.cross(q).length()];
            sum += area * square + square / area;
            whole += area;
            let gap = (square * square - 4.0 * area * area).max(0.0).sqrt();
            let [most, least] = [((square + gap) / 2.0).sqrt(), ((square - gap) / 2.0).max(0.0).sqrt()];
            if index == 0 {
                found =
                    Distortion { most_area: area, least_area: area, most_length: most, least_length: least, ..found };
            }
            found.most_area = found.most_area.max(area);
            found.least_area = found.least_area.min(area);
            found.most_length = found.most_length.max(most);
            found.least_length = found.least_length.min(least);
        }
        if whole > 0.0 {
            found.excess = sum / whole / 4.0 - 1.0;
        }
        found
    }

    fn corners(&self, triangle: &[usize; 3]) -> Option<[DVec3; 3]> {
        let [a, b, c] = triangle.map(|vertex| self.points[vertex]);
        Some([a?, b?, c?])
    }
}
