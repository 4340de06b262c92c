//! Folds of a lattice on a surface, and their end.
//!
//! A triangle is folded if it faces against the surface's normals at its vertices. Folds are few, where the surface has creases
//! sharper than the lattice; drawing their vertices together undoes them, and what stays is trimmed. Owns these; it knows nothing of
//! distortion.

use crate::annotate::relaxing::sheet::{Sheet, Vertex};
use crate::annotate::surface::Surface;
use glam::DVec3;

impl<S: Surface + ?Sized> Sheet<'_, S> {
    /// Triangles that are turned over, or so steep to the normals at their vertices that they soon will be.
    fn folded(&self, least: f64) -> Vec<[usize; 3]> {
        let folded = |triangle: &[usize; 3]| {
            let [Some(a), Some(b), Some(c)] = triangle.map(|vertex| self.vertices[vertex]) else { return false };
            let area = (b.point - a.point).cross(c.point - a.point);
            let outward = (a.normal + b.normal + c.normal).normalize_or_zero();
            // A sliver counts as well.
            area.dot(outward) <= least * area.length().max(0.05 * self.spacing_mm * self.spacing_mm)
        };
        let mut triangles = self.grid().triangles();
        triangles.retain(folded);
        triangles
    }

    /// Draws the vertices of folded triangles, and their neighbours, toward the middle of their own neighbours, until none is folded.
    /// Returns how many are left.
    pub(crate) fn unfold(&mut self, rounds: usize) -> usize {
        for round in 0..rounds {
            let folded = self.folded(0.1);
            if folded.is_empty() {
                return 0;
            }
            let centre = self.centre();
            let mut drawn = vec![false; self.vertices.len()];
            for vertex in folded.into_iter().flatten() {
                let (column, row) = ((vertex % self.columns) as isize, (vertex / self.columns) as isize);
                let reach = (round / 4) as isize;
                for down in -reach..=reach {
                    for right in -reach..=reach {
                        if let Some(near) = self.index(column + right, row + down) {
                            drawn[near] = near != centre;
                        }
                    }
                }
            }
            let next: Vec<Option<Vertex>> =
                (0..self.vertices.len())
                    .map(|vertex| {
                        if drawn[vertex] { self.drawn(vertex).or(self.vertices[vertex]) } else { self.vertices[vertex] }
                    })
                    .collect();
            self.vertices = next;
        }
        self.folded(0.0).len()
    }

    /// The vertex on its way to the middle of its neighbours.
    fn drawn(&self, vertex: usize) -> Option<Vertex> {
        let old = self.vertices[vertex]?;
        let (column, row) = ((vertex % self.columns) as isize, (vertex / self.columns) as isize);
        let near = |right, down| self.vertices[self.index(column + right, row + down)?];
        let (mut sum, mut outward, mut count) = (DVec3::ZERO, old.normal, 0.0);
        for (right, down) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            // At the border the missing neighbour is where the opposite one and this vertex would have it.
            let point = match (near(right, down), near(-right, -down)) {
                (Some(neighbour), _) => neighbour,
                (None, Some(opposite)) => Vertex { point: 2.0 * old.point - opposite.point, normal: opposite.normal },
                (None, None) => continue,
            };
            sum += point.point;
            outward += point.normal;
            count += 1.0;
        }
        let way = (sum / count - old.point) * 0.7;
        self.lowered(old.point + way, outward.try_normalize()?, 1.0)
    }

    /// Trims one vertex of each triangle that is still turned over.
    pub(crate) fn trim_folds(&mut self) {
        for triangle in self.folded(0.0) {
            if triangle.iter().any(|&vertex| self.vertices[vertex].is_none()) {
                continue;
            }
            let farthest =
                triangle.into_iter().max_by(|&a, &b| self.lattice(a).length().total_cmp(&self.lattice(b).length()));
            if let Some(vertex) = farthest {
                self.lose(vertex);
            }
        }
    }

    /// Trims a vertex, for good.
    pub(crate) fn lose(&mut self, vertex: usize) {
        self.vertices[vertex] = None;
        self.failures[vertex] = u8::MAX;
    }
}
