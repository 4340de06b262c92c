//! Lassos: a closed line drawn on a surface becomes the piece of surface that it encircles.
//!
//! Owns the resampling of the line, its triangulation in the plane across a mean normal (constrained Delaunay), and how heights over
//! that plane spread from the line inward, so that the patch stays on the layer that was drawn on. A line that crosses itself is resolved:
//! what it winds around is inside, whichever way round. Knows no picture or pointer. Source: "Direct Volume Editing" (2008), 5.2, whose
//! grid it stands in for; points are traced to the iso-surface as in section 5.

use crate::annotate::path::strip::outward;
use crate::annotate::surface::{Surface, project};
use crate::annotate::window::lasso_line::{Outline, resampled_loop};
use crate::annotate::window::patch::{Patch, PatchError};
use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation, mitigate_underflow};

/// The most vertices of a patch.
pub const MAX_LASSO_VERTICES: usize = 1 << 17;

/// Vertices inside keep this share of an edge from the line.
const CLEAR: f64 = 0.6;

/// A vertex that is found this many edges from where its neighbours' tangent planes have it lies on another layer.
const JUMP: f64 = 3.0;

/// Neighbours further away than this many edges predict no height: beyond the line the triangulation bridges its bays.
const FAR: f64 = 2.5;

/// A tangent plane that leans more than this (cosine) predicts no height.
const STEEP: f64 = 0.15;

/// Why a lasso encircles nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LassoError {
    /// A point that is none.
    #[error("point {index} of the lasso is {found}; three finite lengths in mm expected")]
    NotAPlace {
        /// Place in the line.
        index: usize,
        /// As given.
        found: DVec3,
    },
    /// Too few points.
    #[error("the lasso has {points} different points; 3 or more expected")]
    TooFewPoints {
        /// Points that differ from the one before.
        points: usize,
    },
    /// A direction without length.
    #[error("the mean normal is {found}; a finite vector with a length expected")]
    Direction {
        /// As given.
        found: DVec3,
    },
    /// An edge length that is none.
    #[error("edge_mm is {found}; more than 0 expected")]
    Edge {
        /// As given.
        found: f64,
    },
    /// More vertices than [`MAX_LASSO_VERTICES`].
    #[error(
        "the lasso would take about {vertices:.0} vertices at edges of {edge_mm} mm, at most {MAX_LASSO_VERTICES}; make edge_mm larger"
    )]
    TooFine {
        /// About how many.
        vertices: f64,
        /// As given.
        edge_mm: f64,
    },
    /// Nothing inside, or no surface there.
    #[error("the lasso encircles no surface: {0}")]
    Nothing(#[from] PatchError),
}

/// The piece of surface within a lasso.
#[derive(Clone, Debug, PartialEq)]
pub struct LassoPatch {
    /// Triangles on the surface, facing the mean normal.
    pub patch: Patch,
    /// How many vertices were left out because there is no surface, or only another layer of it.
    pub trimmed: usize,
    /// How many times the lasso crosses itself, seen along the mean normal.
    pub crossings: usize,
}

struct Corner {
    at: Point2<f64>,
    inside: bool,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

type Plane = ConstrainedDelaunayTriangulation<Corner>;

/// The patch that a lasso encircles. `line` is a closed polyline of points on the surface, world mm (the first may be repeated at the
/// end, either way round); `outward` the mean outward normal or the direction toward the viewer (any length), along which the surface
/// must not fold; `edge_mm` the length of edges seen along it. The border keeps within a quarter edge of the line and keeps its corners;
/// vertices lie within `tolerance_mm` of the iso-surface. Where the line crosses itself, everything that it winds around is inside.
///
/// # Errors
/// [`LassoError`].
pub fn lasso_patch(
    surface: &dyn Surface,
    line: &[DVec3],
    outward: DVec3,
    edge_mm: f64,
    tolerance_mm: f64,
) -> Result<LassoPatch, LassoError> {
    if let Some((index, &found)) = line.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        return Err(LassoError::NotAPlace { index, found });
    }
    let direction = outward.try_normalize().ok_or(LassoError::Direction { found: outward })?;
    if !(edge_mm > 0.0 && edge_mm.is_finite()) {
        return Err(LassoError::Edge { found: edge_mm });
    }
    let frame = Frame::new(direction, line.first().copied().unwrap_or_default(), edge_mm);
    let longest = line.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>() / edge_mm;
    too_fine(longest, edge_mm)?;
    let picked = resampled_loop(line, edge_mm);
    if picked.len() < 3 {
        return Err(LassoError::TooFewPoints { points: picked.len() });
    }
    let outline = Outline::new(picked.iter().map(|p| frame.flat(p.at)).collect());
    let [low, high] = outline.bounds();
    too_fine((high - low).element_product() * (4.0 / 3.0_f64).sqrt() + longest, edge_mm)?;

    let mut plane = Plane::new();
    let mut seeds = Vec::new();
    let mut handles = Vec::with_capacity(picked.len());
    for (at, point) in outline.points().iter().zip(&picked) {
        let handle = insert(&mut plane, *at, false).ok_or(LassoError::NotAPlace { index: 0, found: point.at })?;
        handles.push(handle);
        if point.picked {
            seeds.push((handle.index(), frame.height(point.at)));
        }
    }
    let met = self_crossings(outline.points());
    let crossings = met.iter().map(Vec::len).sum::<usize>() / 2;
    for (k, met) in met.iter().enumerate() {
        let mut from = handles[k];
        let along: Vec<_> = met.iter().filter_map(|(_, at)| insert(&mut plane, *at, false)).collect();
        for to in along.into_iter().chain([handles[(k + 1) % handles.len()]]) {
            // Where a piece would still cross another by rounding it is left out: which triangles are inside is asked of the line itself.
            if from != to && plane.can_add_constraint(from, to) {
                plane.add_constraint(from, to);
            }
            from = to;
        }
    }
    for at in outline.lattice_inside(CLEAR) {
        insert(&mut plane, at, true);
    }
    let heights = Spread::over(surface, &plane, &frame, tolerance_mm).from(&seeds);
    Ok(LassoPatch {
        patch: inside(&plane, &outline, &heights)?,
        trimmed: heights.iter().filter(|h| h.is_none()).count(),
        crossings,
    })
}

/// Where each side of a closed polygon is crossed by its others, in order along it: share of the side, and place.
fn self_crossings(points: &[DVec2]) -> Vec<Vec<(f64, DVec2)>> {
    let n = points.len();
    let side = |k: usize| (points[k], points[(k + 1) % n]);
    let mut met = vec![Vec::new(); n];
    for i in 0..n {
        let (a, b) = side(i);
        // Neighbours share an end.
        for j in (i + 2)..n - usize::from(i == 0) {
            let (c, d) = side(j);
            if a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any() {
                continue;
            }
            let (p, q) = (b - a, d - c);
            let wide = p.perp_dot(q);
            let (s, t) = ((c - a).perp_dot(q) / wide, (c - a).perp_dot(p) / wide);
            if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
                let at = a + p * s;
                met[i].push((s, at));
                met[j].push((t, at));
            }
        }
    }
    met.iter_mut().for_each(|met| met.sort_by(|a, b| a.0.total_cmp(&b.0)));
    met
}

fn too_fine(vertices: f64, edge_mm: f64) -> Result<(), LassoError> {
    if vertices <= MAX_LASSO_VERTICES as f64 { Ok(()) } else { Err(LassoError::TooFine { vertices, edge_mm }) }
}

fn insert(plane: &mut Plane, at: DVec2, inside: bool) -> Option<spade::handles::FixedVertexHandle> {
    plane.insert(Corner { at: mitigate_underflow(Point2::new(at.x, at.y)), inside }).ok()
}

/// Triangles within the outline whose vertices are all on the surface.
fn inside(plane: &Plane, outline: &Outline, heights: &[Option<DVec3>]) -> Result<Patch, PatchError> {
    let mut triangles = Vec::new();
    for face in plane.inner_faces() {
        let corners = face.vertices();
        // The line is all edges, so a triangle lies on one side of it, and on the inner one if one of its corners does.
        let within = corners.iter().any(|c| c.data().inside) || {
            let middle = corners.iter().map(|c| flat(c.position())).sum::<DVec2>() / 3.0;
            outline.winding(middle) != 0
        };
        let named = corners.map(|c| c.fix().index());
        if within && named.iter().all(|&c| heights[c].is_some()) {
            triangles.push(named.map(|c| c as u32));
        }
    }
    let corners: Vec<DVec3> = heights.iter().map(|h| h.unwrap_or_default()).collect();
    Patch::new(&corners, &triangles)
}

fn flat(p: Point2<f64>) -> DVec2 {
    DVec2::new(p.x, p.y)
}

/// The plane across the mean normal, in edge lengths.
struct Frame {
    origin: DVec3,
    axes: [DVec3; 2],
    direction: DVec3,
    edge_mm: f64,
}

impl Frame {
    fn new(direction: DVec3, origin: DVec3, edge_mm: f64) -> Self {
        let first = direction.any_orthonormal_vector();
        Self { origin, axes: [first, direction.cross(first)], direction, edge_mm }
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        let q = (p - self.origin) / self.edge_mm;
        DVec2::new(q.dot(self.axes[0]), q.dot(self.axes[1]))
    }

    /// Over the plane, mm.
    fn height(&self, p: DVec3) -> f64 {
        (p - self.origin).dot(self.direction)
    }

    fn place(&self, at: DVec2, height_mm: f64) -> DVec3 {
        self.origin + (self.axes[0] * at.x + self.axes[1] * at.y) * self.edge_mm + self.direction * height_mm
    }
}

/// What is known of a vertex.
#[derive(Clone, Copy)]
enum Known {
    Not,
    Waiting,
    Missing,
    At(DVec3, DVec3),
}

/// Heights that spread over the plane from where they are known, each predicted by the tangent planes of the neighbours found before.
struct Spread<'a> {
    surface: &'a dyn Surface,
    plane: &'a Plane,
    frame: &'a Frame,
    tolerance_mm: f64,
    known: Vec<Known>,
}

impl<'a> Spread<'a> {
    fn over(surface: &'a dyn Surface, plane: &'a Plane, frame: &'a Frame, tolerance_mm: f64) -> Self {
        Self { surface, plane, frame, tolerance_mm, known: vec![Known::Not; plane.num_vertices()] }
    }

    fn from(mut self, seeds: &[(usize, f64)]) -> Vec<Option<DVec3>> {
        let positions: Vec<DVec2> = self.plane.vertices().map(|v| flat(v.position())).collect();
        let mut front = Vec::new();
        for &(vertex, height) in seeds {
            self.known[vertex] = self.found(positions[vertex], height);
            front.push(vertex);
        }
        while !front.is_empty() {
            let mut next = Vec::new();
            for &vertex in &front {
                if !matches!(self.known[vertex], Known::At(..)) {
                    continue;
                }
                for beside in self.beside(vertex) {
                    // What was missed from one side may be found from another.
                    if matches!(self.known[beside], Known::Not | Known::Missing) {
                        self.known[beside] = Known::Waiting;
                        next.push(beside);
                    }
                }
            }
            // All from the front before, so that the order within a front leaves no trace.
            let found: Vec<Known> = next.iter().map(|&v| self.predicted(v, positions[v])).collect();
            next.iter().zip(found).for_each(|(&v, known)| self.known[v] = known);
            front = next;
        }
        let place = |known| if let Known::At(p, _) = known { Some(p) } else { None };
        self.known.into_iter().map(place).collect()
    }

    fn beside(&self, vertex: usize) -> Vec<usize> {
        let handle = spade::handles::FixedVertexHandle::from_index(vertex);
        let edges = self.plane.vertex(handle).out_edges();
        edges.filter(|e| e.length_2() <= FAR * FAR).map(|e| e.to().fix().index()).collect()
    }

    fn predicted(&self, vertex: usize, at: DVec2) -> Known {
        let (mut sum, mut weight) = (0.0, 0.0);
        for beside in self.beside(vertex) {
            let Known::At(p, normal) = self.known[beside] else { continue };
            let level = self.frame.place(at, self.frame.height(p));
            let facing = normal.dot(self.frame.direction);
            let rise = if facing > STEEP { -(level - p).dot(normal) / facing } else { 0.0 };
            let share = 1.0 / level.distance_squared(p).max(1e-12);
            sum += share * (self.frame.height(p) + rise);
            weight += share;
        }
        if weight > 0.0 { self.found(at, sum / weight) } else { Known::Missing }
    }

    fn found(&self, at: DVec2, height_mm: f64) -> Known {
        let guess = self.frame.place(at, height_mm);
        let found = project(self.surface, guess, self.frame.direction, self.tolerance_mm)
            .filter(|p| p.distance(guess) <= JUMP * self.frame.edge_mm)
            .and_then(|p| Some((p, outward(self.surface, p)?)))
            .filter(|(_, normal)| normal.dot(self.frame.direction) > 0.0);
        found.map_or(Known::Missing, |(p, normal)| Known::At(p, normal))
    }
}
