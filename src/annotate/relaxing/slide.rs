//! A lattice slides on its surface until it lies as its patch would lie flat.
//!
//! A round lays the patch flat with the least distortion, its border free, and sends every vertex to where the flat image has the
//! lattice's point, so that at rest the lattice is that image. Moving vertices and not the image keeps the lattice square. Owns one
//! round; when to end is its caller's to say.

use crate::annotate::relaxing::dirichlet::{Factor, Flat};
use crate::annotate::relaxing::sheet::{Sheet, Vertex};
use crate::annotate::surface::Surface;
use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

/// Vertices whose place is beyond the volume's border by less than this, in spacings, stay.
const LEAST_LEAVING: f64 = 0.05;

impl<S: Surface + ?Sized> Sheet<'_, S> {
    /// One round: `steps` Newton steps on the flat image of the patch as it lies, then every vertex goes this `share` of the way to
    /// where that image has the lattice's point. `factor` is that of the round before, or does not hold. Returns the longest way on
    /// the flat lattice, in spacings.
    pub(crate) fn slide(&mut self, steps: usize, share: f64, factor: &mut Factor) -> f64 {
        let grid = self.grid();
        let lattice: Vec<DVec2> = (0..self.vertices.len()).map(|vertex| self.lattice(vertex)).collect();
        let points: Vec<DVec3> = grid.points.iter().map(|point| point.unwrap_or_default() / self.spacing_mm).collect();
        let mut flat = Flat::new(self.columns, &points, &grid.triangles(), lattice);
        for _ in 0..steps {
            if flat.step(factor) < 3e-3 {
                break;
            }
        }
        let mut uv = self.aligned(flat.uv);
        let far = |uv: &[DVec2], vertex: usize| uv[vertex].distance(self.lattice(vertex));
        let longest = (0..uv.len())
            .filter(|&vertex| self.vertices[vertex].is_some())
            .map(|vertex| far(&uv, vertex))
            .fold(0.0, f64::max);
        for (vertex, at) in uv.iter_mut().enumerate() {
            *at = self.lattice(vertex).lerp(*at, share);
        }
        let frames = self.frames(&uv);
        let moved: Vec<Option<Vertex>> = (0..self.vertices.len())
            .into_par_iter()
            .with_min_len(64)
            .map(|vertex| {
                let stays = || {
                    self.vertices[vertex]
                        .filter(|old| !self.leaves(old, self.lattice(vertex) - uv[vertex], frames[vertex]))
                };
                self.moved(vertex, &uv, frames[vertex]).or_else(stays)
            })
            .collect();
        for (vertex, now) in moved.into_iter().enumerate() {
            match now {
                Some(_) => self.vertices[vertex] = now,
                None if self.vertices[vertex].is_some() => self.lose(vertex),
                None => (),
            }
        }
        longest
    }

    /// The flat image, moved so that the centre is the origin and turned so that the u axis there stays.
    fn aligned(&self, uv: Vec<DVec2>) -> Vec<DVec2> {
        let centre = self.centre();
        let neighbours = |flat: &[DVec2]| -> Option<(DVec2, DVec3)> {
            let [before, after] = [centre.checked_sub(1)?, centre + 1];
            let [first, last] = [self.vertices.get(before)?.as_ref()?, self.vertices.get(after)?.as_ref()?];
            Some((flat[after] - flat[before], last.point - first.point))
        };
        let turned = || {
            let (flat, real) = neighbours(&uv)?;
            let [along, across] = self.axes()?;
            let real = DVec2::new(real.dot(along), real.dot(across)).try_normalize()?;
            // R · flat ∥ real
            let flat = flat.try_normalize()?;
            Some(DMat2::from_cols(
                DVec2::new(flat.dot(real), flat.perp_dot(real)),
                DVec2::new(-flat.perp_dot(real), flat.dot(real)),
            ))
        };
        let turn = turned().unwrap_or(DMat2::IDENTITY);
        uv.iter().map(|&at| turn * (at - uv[centre])).collect()
    }

    /// At each vertex, how it moves in space (mm) as it moves by one spacing along u and v: the mean over its triangles.
    fn frames(&self, uv: &[DVec2]) -> Vec<[DVec3; 2]> {
        let mut frames = vec![([DVec3::ZERO; 2], 0.0); uv.len()];
        for triangle in self.grid().triangles() {
            let [Some(a), Some(b), Some(c)] = triangle.map(|vertex| self.vertices[vertex]) else { continue };
            let [p, q] = [b.point - a.point, c.point - a.point];
            let [s, t] = [uv[triangle[1]] - uv[triangle[0]], uv[triangle[2]] - uv[triangle[0]]];
            let det = s.perp_dot(t);
            if det <= 0.0 {
                continue;
            }
            // Weighted by flat area, so that the division by it falls away.
            let frame = [p * t.y - q * s.y, q * s.x - p * t.x];
            for vertex in triangle {
                let (sum, weight) = &mut frames[vertex];
                sum[0] += frame[0];
                sum[1] += frame[1];
                *weight += det;
            }
        }
        frames
            .iter()
            .map(|([u, v], weight)| if *weight > 0.0 { [*u / *weight, *v / *weight] } else { [DVec3::ZERO; 2] })
            .collect()
    }

    fn moved(&self, vertex: usize, uv: &[DVec2], frame: [DVec3; 2]) -> Option<Vertex> {
        let old = self.vertices[vertex]?;
        if vertex == self.centre() {
            return Some(old);
        }
        let target = self.lattice(vertex);
        if let Some((corners, weights)) = self.located(vertex, uv, target) {
            let (mut point, mut outward) = (DVec3::ZERO, DVec3::ZERO);
            for (corner, weight) in corners.into_iter().zip(weights) {
                let corner = self.vertices[corner]?;
                point += corner.point * weight;
                outward += corner.normal * weight;
            }
            return self.lowered(point, outward.try_normalize()?, 1.0);
        }
        let by = target - uv[vertex];
        self.walked(old, frame[0] * by.x + frame[1] * by.y)
    }

    /// Whether the volume ends before a vertex that moves `by` on the flat image.
    fn leaves(&self, vertex: &Vertex, by: DVec2, frame: [DVec3; 2]) -> bool {
        by.length() > LEAST_LEAVING && !self.holds(vertex.point + frame[0] * by.x + frame[1] * by.y)
    }

    /// The triangle of the flat image that holds `target`, with its weights there, found by walking from `vertex`. None beyond the
    /// border.
    fn located(&self, vertex: usize, uv: &[DVec2], target: DVec2) -> Option<([usize; 3], [f64; 3])> {
        let (column, row) = ((vertex % self.columns) as isize, (vertex / self.columns) as isize);
        let starts = [(0, 0, false), (-1, 0, true), (-1, 0, false), (0, -1, true), (0, -1, false), (-1, -1, true)];
        let (mut at, mut corners) = starts.iter().find_map(|&(right, up, second)| {
            let at = (column + right, row + up, second);
            Some((at, self.corners(at)?))
        })?;
        for _ in 0..200 {
            let [a, b, c] = corners.map(|corner| uv[corner]);
            let whole = (b - a).perp_dot(c - a);
            let weights = [
                (b - target).perp_dot(c - target),
                (c - target).perp_dot(a - target),
                (a - target).perp_dot(b - target),
            ]
            .map(|area| area / whole);
            let mut order = [0, 1, 2];
            order.sort_by(|&i, &j| weights[i].total_cmp(&weights[j]));
            if weights[order[0]] >= -1e-9 {
                return Some((corners, weights));
            }
            let step = order.iter().filter(|&&side| weights[side] < 0.0).find_map(|&side| {
                let (column, row, second) = at;
                let next = match (side, second) {
                    (0, _) => (column, row, !second),
                    (1, false) => (column - 1, row, true),
                    (_, false) => (column, row - 1, true),
                    (1, true) => (column + 1, row, false),
                    (_, true) => (column, row + 1, false),
                };
                Some((next, self.corners(next)?))
            })?;
            (at, corners) = step;
        }
        None
    }

    /// The vertices of the first or second triangle of the quad whose first corner is in this column and row, if all four exist.
    fn corners(&self, (column, row, second): (isize, isize, bool)) -> Option<[usize; 3]> {
        let a = self.index(column, row)?;
        let d = self.index(column + 1, row + 1)?;
        let [b, c] = [a + 1, d - 1];
        let quad = [a, b, c, d];
        quad.iter().all(|&corner| self.vertices[corner].is_some()).then_some(if second { [d, c, b] } else { [a, b, c] })
    }
}
