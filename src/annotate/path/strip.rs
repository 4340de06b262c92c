//! Strips on a surface along a line: rulers, arrows and texts along a curve, and the edge band along a cutaway's rim.
//!
//! Owns [`SurfaceStrip`] and how its rows are traced sideways from the line, step by step on the surface. Knows no texture or picture.
//! Source: "Direct Volume Editing" (2008), section 5, eq. 5 as the errata have it: F = N×(O×N), B = N×F; each step is traced back
//! along the normal before it.

use crate::annotate::surface::{Surface, project};
use crate::annotate::window::patch::Patch;
use glam::{DVec2, DVec3};

/// How finely lines are laid on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracing {
    /// Longest step between two projections, mm; about a voxel serves. Above 0.
    pub step_mm: f64,
    /// How far from the iso-surface a point may stay, mm. Above 0 and well below the step.
    pub tolerance_mm: f64,
}

impl Tracing {
    /// Steps of one voxel of this size (mm), within a thousandth of it.
    pub fn of_voxel(voxel_mm: f64) -> Self {
        Self { step_mm: voxel_mm, tolerance_mm: 1e-3 * voxel_mm }
    }
}

/// A grid of vertices on a surface, columns along a line and rows across it, row major, columns fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceStrip {
    /// Vertices along the line.
    pub columns: usize,
    /// Vertices across it.
    pub rows: usize,
    /// World mm; `None` where the surface ends.
    pub points: Vec<Option<DVec3>>,
    /// Length along the line up to each column, mm.
    pub along_mm: Vec<f64>,
    /// Signed distance of each row from the line, mm, increasing; positive to the left of the line seen from outside.
    pub across_mm: Vec<f64>,
}

impl SurfaceStrip {
    /// The vertex of this column and row, world mm.
    pub fn point(&self, column: usize, row: usize) -> Option<DVec3> {
        self.points[row * self.columns + column]
    }

    /// Texture coordinates of a vertex: u in 0..1 along the line by length, v in 0..1 from the first row to the last.
    pub fn uv(&self, column: usize, row: usize) -> DVec2 {
        let share = |of: &[f64], at: usize| {
            let (first, last) = (of.first().copied().unwrap_or(0.0), of.last().copied().unwrap_or(0.0));
            if last > first { (of[at] - first) / (last - first) } else { 0.0 }
        };
        DVec2::new(share(&self.along_mm, column), share(&self.across_mm, row))
    }

    /// Cells whose four vertices are there, as vertex numbers counter-clockwise seen from outside.
    pub fn quads(&self) -> Vec<[u32; 4]> {
        let cells = (1..self.rows).flat_map(|row| (1..self.columns).map(move |column| row * self.columns + column));
        cells
            .map(|last| [last - self.columns - 1, last - self.columns, last, last - 1])
            .filter(|quad| quad.iter().all(|&i| self.points[i].is_some()))
            .map(|quad| quad.map(|i| i as u32))
            .collect()
    }

    /// How many vertices the surface did not have.
    pub fn trimmed(&self) -> usize {
        self.points.iter().filter(|p| p.is_none()).count()
    }

    /// Traces rows sideways from a line on the surface. `left` is, per point of the line, the direction to the left with a length that
    /// multiplies the distances (1 on a straight line, more at the outside of a mitred corner), `None` where the line is torn.
    pub(crate) fn beside(
        surface: &dyn Surface,
        line: &[DVec3],
        left: &[Option<DVec3>],
        along_mm: Vec<f64>,
        across_mm: Vec<f64>,
        tracing: &Tracing,
    ) -> Self {
        let (columns, rows) = (line.len(), across_mm.len());
        let mut points = vec![None; columns * rows];
        for column in 0..columns {
            let Some(side) = left[column] else { continue };
            for sign in [1.0, -1.0] {
                // Outward from the line, so that each row begins where the one before it ended.
                let mut on_side: Vec<usize> = (0..rows).filter(|&r| across_mm[r] * sign > 0.0).collect();
                on_side.sort_by(|&a, &b| across_mm[a].abs().total_cmp(&across_mm[b].abs()));
                let mut particle = Particle::at(surface, line[column], side * sign);
                let mut gone = 0.0;
                for row in on_side {
                    let goal = across_mm[row].abs() * side.length();
                    particle = particle.and_then(|p| p.moved(surface, goal - gone, tracing));
                    gone = goal;
                    points[row * columns + column] = particle.as_ref().map(|p| p.at);
                }
            }
            for row in (0..rows).filter(|&r| across_mm[r] == 0.0) {
                points[row * columns + column] = Some(line[column]);
            }
        }
        Self { columns, rows, points, along_mm, across_mm }
    }
}

/// Where rows lie, from `from_mm` to `to_mm`, evenly. At least two.
pub(crate) fn rows_across(from_mm: f64, to_mm: f64, rows: usize) -> Vec<f64> {
    let rows = rows.max(2);
    (0..rows).map(|r| from_mm + (to_mm - from_mm) * r as f64 / (rows - 1) as f64).collect()
}

/// The edge band of a window: one closed strip on the surface for each loop of the patch's border, from `inside_mm` within the patch to
/// `outside_mm` beyond it (both 0 or more), the last column on the first one's place. What the cutaway removes cannot be seen, so the
/// band that frames a window is the one outside. Rows: -`inside_mm` .. `outside_mm` turned so that rows increase to the left of the loop,
/// that is, from outside inward. At corners the band is mitred, at most to twice its width.
pub fn rim_bands(
    surface: &dyn Surface,
    patch: &Patch,
    inside_mm: f64,
    outside_mm: f64,
    rows: usize,
    tracing: &Tracing,
) -> Vec<SurfaceStrip> {
    let corner = |c: u32| patch.corners()[c as usize];
    let mut bands = Vec::new();
    for round in patch.border() {
        let count = round.len();
        let mut line: Vec<DVec3> = round.iter().map(|&c| corner(c)).collect();
        let mut left: Vec<Option<DVec3>> = (0..count)
            .map(|k| {
                let normal = outward(surface, line[k])?;
                let before = normal.cross(line[k] - line[(k + count - 1) % count]).try_normalize()?;
                let after = normal.cross(line[(k + 1) % count] - line[k]).try_normalize()?;
                let middle = (before + after).try_normalize().unwrap_or(after);
                Some(middle / middle.dot(after).max(0.5))
            })
            .collect();
        line.push(line[0]);
        left.push(left[0]);
        let across = rows_across(-outside_mm, inside_mm, rows);
        let along = lengths(&line);
        bands.push(SurfaceStrip::beside(surface, &line, &left, along, across, tracing));
    }
    bands
}

/// Length of a polyline up to each of its points, mm.
pub(crate) fn lengths(line: &[DVec3]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut before = line.first().copied().unwrap_or_default();
    line.iter()
        .map(|&p| {
            sum += before.distance(p);
            before = p;
            sum
        })
        .collect()
}

/// Outward unit normal at `p`, against the gradient; `None` outside the volume or where the field is flat.
pub(crate) fn outward(surface: &dyn Surface, p: DVec3) -> Option<DVec3> {
    (-surface.gradient(p)?).try_normalize()
}

/// A surface particle: a place on the surface, the normal there and the direction it moves in, a unit tangent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Particle {
    pub(crate) at: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) heading: DVec3,
}

impl Particle {
    /// Eq. 5: the heading is the part of `toward` that lies in the tangent plane.
    pub(crate) fn at(surface: &dyn Surface, at: DVec3, toward: DVec3) -> Option<Self> {
        let normal = outward(surface, at)?;
        Some(Self { at, normal, heading: toward.reject_from_normalized(normal).try_normalize()? })
    }

    /// `distance_mm` further on the surface, in steps of at most `tracing.step_mm`. Each step is shortened so that the chord to the
    /// place it is traced back to has the step's length: without it a strip on a curved surface would be too wide.
    pub(crate) fn moved(mut self, surface: &dyn Surface, distance_mm: f64, tracing: &Tracing) -> Option<Self> {
        let steps = (distance_mm / tracing.step_mm).ceil().max(1.0);
        let step = distance_mm / steps;
        if step <= 0.0 {
            return Some(self);
        }
        for _ in 0..steps as u64 {
            let traced =
                |length: f64| project(surface, self.at + self.heading * length, self.normal, tracing.tolerance_mm);
            let first = traced(step)?;
            let chord = first.distance(self.at);
            let at = if chord > step { traced(step * step / chord).unwrap_or(first) } else { first };
            self = Self::at(surface, at, self.heading)?;
        }
        Some(self)
    }
}
