//! A lattice of vertices while it is being laid on a surface.
//!
//! Owns the vertices with their normals, the way along the surface and back onto it, and the finer lattice between the vertices of a
//! coarser one. What a relaxation does to it is in `slide` and `unfold`, how it came to be in `growth`. The centre vertex and the u
//! axis there stay what they were at the start.

use crate::annotate::grid::SurfaceGrid;
use crate::annotate::surface::{Surface, normal, project_within};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// How near to the surface vertices are brought, in spacings.
const TOLERANCE: f64 = 1e-3;

/// A vertex on the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// World position, mm.
    pub(crate) point: DVec3,
    /// Outward unit normal.
    pub(crate) normal: DVec3,
}

/// A lattice on a surface.
pub(crate) struct Sheet<'a, S: ?Sized> {
    surface: &'a S,
    /// Number of vertices along u, odd.
    pub(crate) columns: usize,
    /// Number of vertices along v, odd.
    pub(crate) rows: usize,
    /// Distance between neighbours on the flat lattice, mm.
    pub(crate) spacing_mm: f64,
    /// The u axis at the centre: a unit vector.
    axis: DVec3,
    /// Row by row, as in a [`SurfaceGrid`].
    pub(crate) vertices: Vec<Option<Vertex>>,
    /// How often each was sought in vain; the most of the type if it was lost for good.
    pub(crate) failures: Vec<u8>,
}

impl<S: Surface + ?Sized> Clone for Sheet<'_, S> {
    fn clone(&self) -> Self {
        Self { vertices: self.vertices.clone(), failures: self.failures.clone(), ..*self }
    }
}

impl<'a, S: Surface + ?Sized> Sheet<'a, S> {
    /// The single vertex in which the line through `centre` along the normal there meets the surface, and `orientation` laid into its
    /// tangent plane (equation 5). None if there is no such point, or `orientation` is along its normal.
    pub(crate) fn of_centre(surface: &'a S, centre: DVec3, orientation: DVec3, spacing_mm: f64) -> Option<Self> {
        let point = project_within(surface, centre, normal(surface, centre)?, TOLERANCE * spacing_mm, f64::INFINITY)?;
        let normal = normal(surface, point)?;
        let axis = (orientation - normal * orientation.dot(normal)).try_normalize()?;
        let vertices = vec![Some(Vertex { point, normal })];
        Some(Self { surface, columns: 1, rows: 1, spacing_mm, axis, vertices, failures: vec![0] })
    }

    /// The lattice of a grid about the same centre.
    pub(crate) fn of_grid(&self, grid: &SurfaceGrid) -> Self {
        let vertices = grid.points.iter().map(|point| self.vertex((*point)?)).collect();
        let failures = vec![0; grid.points.len()];
        Self { columns: grid.columns, rows: grid.rows, spacing_mm: grid.spacing_mm, vertices, failures, ..*self }
    }

    /// The vertices as a grid.
    pub(crate) fn grid(&self) -> SurfaceGrid {
        let points = self.vertices.iter().map(|vertex| Some((*vertex)?.point)).collect();
        SurfaceGrid { columns: self.columns, rows: self.rows, spacing_mm: self.spacing_mm, points }
    }

    /// The lattice with `wider` more columns and `higher` more rows at either side, without vertices yet.
    pub(crate) fn widened(&self, wider: usize, higher: usize) -> Self {
        let (columns, rows) = (self.columns + 2 * wider, self.rows + 2 * higher);
        let (mut vertices, mut failures) = (vec![None; columns * rows], vec![0; columns * rows]);
        for row in 0..self.rows {
            let old = row * self.columns..(row + 1) * self.columns;
            let new = (row + higher) * columns + wider..(row + higher) * columns + wider + self.columns;
            vertices[new.clone()].copy_from_slice(&self.vertices[old.clone()]);
            failures[new].copy_from_slice(&self.failures[old]);
        }
        Self { columns, rows, vertices, failures, ..*self }
    }

    /// The lattice of half the spacing, `half` columns and rows to either side of the centre, as far as this one reaches: each new
    /// vertex between four on a line, brought to the surface.
    pub(crate) fn refined(&self, half: [usize; 2]) -> Self {
        let [columns, rows] = half.map(|half| 2 * half + 1);
        let mut fine = Self {
            columns,
            rows,
            spacing_mm: 0.5 * self.spacing_mm,
            vertices: vec![None; columns * rows],
            failures: vec![0; columns * rows],
            ..*self
        };
        // Places of the finer lattice relative to the centre, by how many of their two coordinates are odd.
        let place = |vertex: usize| {
            [(vertex % columns) as isize - half[0] as isize, (vertex / columns) as isize - half[1] as isize]
        };
        for odd in 0..3 {
            let found: Vec<Option<Vertex>> = (0..columns * rows)
                .into_par_iter()
                .with_min_len(64)
                .map(|vertex| {
                    let [x, y] = place(vertex);
                    if x.rem_euclid(2) + y.rem_euclid(2) != odd {
                        return fine.vertices[vertex];
                    }
                    let (column, row) = (x + half[0] as isize, y + half[1] as isize);
                    if odd == 0 {
                        let [i, j] = [x / 2 + (self.columns / 2) as isize, y / 2 + (self.rows / 2) as isize];
                        return self.vertices[self.index(i, j)?];
                    }
                    let (mut point, mut outward, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
                    for (right, down) in [(x.rem_euclid(2), 0), (0, y.rem_euclid(2))] {
                        let near =
                            |steps: isize| fine.vertices[fine.index(column + steps * right, row + steps * down)?];
                        let (true, Some(a), Some(b)) = (right + down > 0, near(-1), near(1)) else { continue };
                        let ends = near(-3).zip(near(3)).map(|(c, d)| (a.point + b.point - c.point - d.point) / 16.0);
                        point += 0.5 * (a.point + b.point) + ends.unwrap_or_default();
                        outward += a.normal + b.normal;
                        count += 1.0;
                    }
                    fine.lowered(point / count, outward.try_normalize()?, 2.0)
                })
                .collect();
            fine.vertices = found;
        }
        fine
    }

    /// Index of the vertex in the middle, which never moves.
    pub(crate) fn centre(&self) -> usize {
        (self.rows / 2) * self.columns + self.columns / 2
    }

    /// The u and v axes at the centre: unit vectors in its tangent plane, v = N×u.
    pub(crate) fn axes(&self) -> Option<[DVec3; 2]> {
        let normal = self.vertices[self.centre()]?.normal;
        Some([self.axis, normal.cross(self.axis)])
    }

    /// Index of the vertex in this column and row, if both are in the lattice.
    pub(crate) fn index(&self, column: isize, row: isize) -> Option<usize> {
        let inside = (0..self.columns as isize).contains(&column) && (0..self.rows as isize).contains(&row);
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// Whether a point is in the volume.
    pub(crate) fn holds(&self, point: DVec3) -> bool {
        self.surface.value(point).is_some()
    }

    /// The vertex at a point on the surface.
    fn vertex(&self, point: DVec3) -> Option<Vertex> {
        Some(Vertex { point, normal: normal(self.surface, point)? })
    }

    /// The point in which the line through `point` along `outward` meets the surface within `reach` spacings.
    pub(crate) fn lowered(&self, point: DVec3, outward: DVec3, reach: f64) -> Option<Vertex> {
        let tolerance = TOLERANCE * self.spacing_mm;
        let found = self.vertex(project_within(self.surface, point, outward, tolerance, reach * self.spacing_mm)?)?;
        (found.normal.dot(outward) > 0.0).then_some(found)
    }

    /// Where a particle comes to that sets out along `way` (mm) and is brought back to the surface after each quarter of a spacing.
    pub(crate) fn walked(&self, from: Vertex, way: DVec3) -> Option<Vertex> {
        let length = way.length();
        let steps = (4.0 * length / self.spacing_mm).ceil().clamp(1.0, 16.0);
        let (mut at, mut way) = (from, way);
        for _ in 0..steps as usize {
            way = (way - at.normal * way.dot(at.normal)).normalize_or_zero();
            let step = length / steps;
            at = self.lowered(at.point + way * step, at.normal, 1.5 * step / self.spacing_mm)?;
        }
        Some(at)
    }

    /// The lattice's own flat image: the vertex's place about the centre, in spacings.
    pub(crate) fn lattice(&self, vertex: usize) -> DVec2 {
        let [column, row] = [vertex % self.columns, vertex / self.columns];
        DVec2::new(column as f64 - (self.columns / 2) as f64, row as f64 - (self.rows / 2) as f64)
    }
}
