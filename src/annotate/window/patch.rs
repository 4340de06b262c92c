//! Pieces of surface as triangles that have a clean border: what cutaways are extruded from and rims run along.
//!
//! Owns [`Patch`], in which every edge is shared by two triangles of opposite direction or lies on the border, and every border corner
//! has one border edge that arrives and one that leaves: so each border is a set of closed loops, also around holes and where trimming
//! left two pieces that touch in a point (the point is then there once for each). Knows no field, depth or picture.
//! Source: "Direct Volume Editing" (2008), 5.1 and 5.2: a grid on the surface whose copy is joined with it along the border.

use crate::annotate::grid::SurfaceGrid;
use glam::DVec3;
use std::collections::HashMap;

/// Edges and heights of triangles below this share of the patch's extent count as nothing.
const NOTHING: f64 = 1e-9;

/// Why corners and triangles are no patch.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PatchError {
    /// A triangle of corners that do not exist.
    #[error("triangle {triangle} names corner {corner}, there are {corners}; number them from 0 on")]
    NoSuchCorner {
        /// Place in the list of triangles.
        triangle: usize,
        /// As given.
        corner: u32,
        /// Number of corners.
        corners: usize,
    },
    /// A corner that is no place.
    #[error("corner {corner} is not finite; three lengths in mm expected")]
    NotAPlace {
        /// Place in the list of corners.
        corner: usize,
    },
    /// A grid whose list of points has another length than rows times columns.
    #[error("the grid has {points} points, {columns} columns by {rows} rows expected")]
    NotAGrid {
        /// As given.
        columns: usize,
        /// As given.
        rows: usize,
        /// As given.
        points: usize,
    },
    /// Nothing that has an area.
    #[error("the patch has no triangle with an area; it is trimmed away or lies in a line")]
    Empty,
}

/// Triangles with a clean border, in world mm. Seen from outside the surface the corners of a triangle go round counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    corners: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Patch {
    /// Of corners in world mm and consistently turned triangles, counter-clockwise from outside. Triangles without area are taken out:
    /// edges of no length are collapsed, and a corner that lies on the opposite edge is joined to the triangle beyond that edge.
    ///
    /// # Errors
    /// [`PatchError`], also if nothing is left.
    pub fn new(corners: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, PatchError> {
        if let Some(corner) = corners.iter().position(|c| !c.is_finite()) {
            return Err(PatchError::NotAPlace { corner });
        }
        for (triangle, named) in triangles.iter().enumerate() {
            if let Some(&corner) = named.iter().find(|&&c| c as usize >= corners.len()) {
                return Err(PatchError::NoSuchCorner { triangle, corner, corners: corners.len() });
            }
        }
        let nothing_mm = NOTHING * extent(corners, triangles);
        let welded = without_short_edges(corners, triangles, nothing_mm);
        let sound = without_caps(corners, welded, nothing_mm);
        Self::split_at_pinches(corners, &sound)
    }

    /// Of a grid on a surface: two triangles to a cell whose four vertices are there, cut along the shorter diagonal, one if one vertex
    /// is trimmed, none otherwise. `outward` points away from dense matter at the grid's centre (any length); the patch is turned so
    /// that it faces there on the whole. Vertices that are not finite count as trimmed.
    ///
    /// # Errors
    /// [`PatchError`].
    pub fn from_grid(grid: &SurfaceGrid, outward: DVec3) -> Result<Self, PatchError> {
        let (columns, rows) = (grid.columns, grid.rows);
        if columns.checked_mul(rows) != Some(grid.points.len()) {
            return Err(PatchError::NotAGrid { columns, rows, points: grid.points.len() });
        }
        let present: Vec<bool> = grid.points.iter().map(|p| p.is_some_and(|p| p.is_finite())).collect();
        let corners: Vec<DVec3> = grid.points.iter().map(|p| p.filter(|p| p.is_finite()).unwrap_or_default()).collect();
        let mut triangles = Vec::new();
        for row in 1..rows {
            for column in 1..columns {
                let last = row * columns + column;
                let around = [last - columns - 1, last - columns, last, last - 1];
                let there: Vec<u32> = around.into_iter().filter(|&i| present[i]).map(|i| i as u32).collect();
                let distance = |i: usize, k: usize| corners[around[i]].distance_squared(corners[around[k]]);
                match there[..] {
                    [a, b, c] => triangles.push([a, b, c]),
                    [a, b, c, d] if distance(0, 2) <= distance(1, 3) => triangles.extend([[a, b, c], [a, c, d]]),
                    [a, b, c, d] => triangles.extend([[a, b, d], [b, c, d]]),
                    _ => {}
                }
            }
        }
        Ok(Self::new(&corners, &triangles)?.facing(outward))
    }

    /// The same patch, turned if it faces away from `outward` on the whole (area-weighted).
    pub fn facing(mut self, outward: DVec3) -> Self {
        let faces: f64 = self.triangles.iter().map(|t| self.area_normal(t).dot(outward)).sum();
        if faces < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Corners, world mm. Each is one of those given; a corner where pieces touch is there once for each.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Triples of corner numbers, counter-clockwise from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Area, mm².
    pub fn area_mm2(&self) -> f64 {
        self.triangles.iter().map(|t| self.area_normal(t).length()).sum()
    }

    /// The border as closed loops of corner numbers, the first not repeated. The patch lies to the left seen from outside: loops run
    /// counter-clockwise around the patch and clockwise around its holes.
    pub fn border(&self) -> Vec<Vec<u32>> {
        let edges = border_edges(&self.triangles);
        let mut next = vec![None; self.corners.len()];
        edges.iter().for_each(|&(a, b)| next[a as usize] = Some(b));
        let mut done = vec![false; self.corners.len()];
        let mut loops = Vec::new();
        for &(first, _) in &edges {
            let mut round = Vec::new();
            let mut at = first;
            while !done[at as usize] {
                done[at as usize] = true;
                round.push(at);
                at = next[at as usize].unwrap_or(first);
            }
            if !round.is_empty() {
                loops.push(round);
            }
        }
        loops
    }

    /// The patch without triangles that have a border edge along `direction`, until none is left: displaced along it they enclose
    /// nothing, and their walls would have no area.
    ///
    /// # Errors
    /// [`PatchError::Empty`] if the whole patch lies along it.
    pub(crate) fn without_border_along(&self, direction: DVec3) -> Result<Self, PatchError> {
        let direction = direction.normalize_or_zero();
        let nothing_mm = NOTHING * extent(&self.corners, &self.triangles);
        let mut patch = self.clone();
        loop {
            let along: Vec<(u32, u32)> = border_edges(&patch.triangles)
                .into_iter()
                .filter(|&(a, b)| {
                    let edge = patch.corners[b as usize] - patch.corners[a as usize];
                    edge.cross(direction).length() <= nothing_mm
                })
                .collect();
            if along.is_empty() {
                return Ok(patch);
            }
            let kept: Vec<_> =
                patch.triangles.iter().filter(|t| !edges_of(t).iter().any(|e| along.contains(e))).copied().collect();
            patch = Self::split_at_pinches(&patch.corners, &kept)?;
        }
    }

    fn area_normal(&self, t: &[u32; 3]) -> DVec3 {
        area_normal(&self.corners, t)
    }

    /// Gives every fan of triangles around a corner a corner of its own, and leaves out corners that no triangle names.
    ///
    /// A fan that does not close has one border edge that leaves and one that arrives, whatever the triangles given: so afterwards no
    /// edge is in two triangles of the same direction.
    fn split_at_pinches(corners: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, PatchError> {
        let mut fans = Sets::new(triangles.len() * 3);
        let edges = Edges::of(triangles);
        for (t, triangle) in triangles.iter().enumerate() {
            for (k, (a, b)) in edges_of(triangle).into_iter().enumerate() {
                if let ([_], &[(_, other)]) = (edges.between(a, b), edges.between(b, a)) {
                    // At the edge's other end they are joined when the opposite edge's turn comes.
                    fans.join(3 * t + k, 3 * other + triangles[other].iter().position(|&c| c == a).unwrap_or(0));
                }
            }
        }
        let mut number = vec![None; triangles.len() * 3];
        let mut patch = Self { corners: Vec::new(), triangles: Vec::with_capacity(triangles.len()) };
        for (t, triangle) in triangles.iter().enumerate() {
            let mut named = [0; 3];
            for k in 0..3 {
                named[k] = *number[fans.of(3 * t + k)].get_or_insert_with(|| {
                    patch.corners.push(corners[triangle[k] as usize]);
                    (patch.corners.len() - 1) as u32
                });
            }
            patch.triangles.push(named);
        }
        if patch.triangles.is_empty() { Err(PatchError::Empty) } else { Ok(patch) }
    }
}

fn edges_of(&[a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

fn area_normal(corners: &[DVec3], &[a, b, c]: &[u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|i| corners[i as usize]);
    0.5 * (b - a).cross(c - a)
}

/// Edges without an opposite one, in the order of the triangles.
fn border_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let edges = Edges::of(triangles);
    triangles.iter().flat_map(edges_of).filter(|&(a, b)| edges.between(b, a).is_empty()).collect()
}

/// Directed edges with the triangles that have them, sorted.
struct Edges(Vec<((u32, u32), usize)>);

impl Edges {
    fn of(triangles: &[[u32; 3]]) -> Self {
        let mut edges: Vec<_> =
            triangles.iter().enumerate().flat_map(|(t, triangle)| edges_of(triangle).map(|e| (e, t))).collect();
        edges.sort_unstable();
        Self(edges)
    }

    fn between(&self, a: u32, b: u32) -> &[((u32, u32), usize)] {
        let first = self.0.partition_point(|e| e.0 < (a, b));
        let count = self.0[first..].iter().take_while(|e| e.0 == (a, b)).count();
        &self.0[first..first + count]
    }
}

/// Diagonal of the box of the corners that triangles name, mm.
fn extent(corners: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let named = || triangles.iter().flatten().map(|&c| corners[c as usize]);
    let low = named().fold(DVec3::INFINITY, DVec3::min);
    let high = named().fold(DVec3::NEG_INFINITY, DVec3::max);
    if low.x <= high.x { low.distance(high) } else { 0.0 }
}

/// Collapses edges of no length.
fn without_short_edges(corners: &[DVec3], triangles: &[[u32; 3]], nothing_mm: f64) -> Vec<[u32; 3]> {
    let mut same = Sets::new(corners.len());
    for (a, b) in triangles.iter().flat_map(edges_of) {
        if corners[a as usize].distance(corners[b as usize]) <= nothing_mm {
            same.join(a as usize, b as usize);
        }
    }
    let named = triangles.iter().map(|t| t.map(|c| same.of(c as usize) as u32));
    named.filter(|&[a, b, c]| a != b && b != c && c != a).collect()
}

fn owners(triangles: &[[u32; 3]]) -> HashMap<(u32, u32), Vec<usize>> {
    let mut owners: HashMap<(u32, u32), Vec<usize>> = HashMap::with_capacity(3 * triangles.len());
    for (t, triangle) in triangles.iter().enumerate() {
        edges_of(triangle).into_iter().for_each(|e| owners.entry(e).or_default().push(t));
    }
    owners
}

/// Takes out triangles whose apex lies on the opposite edge. Where another triangle lies beyond that edge, the apex becomes a corner of
/// it, so that no slit is left in the patch; elsewhere the border runs through the apex.
fn without_caps(corners: &[DVec3], mut triangles: Vec<[u32; 3]>, nothing_mm: f64) -> Vec<[u32; 3]> {
    // Height over the longest edge, and the triangle turned so that this edge is the first.
    let cap = |t: &[u32; 3]| {
        let longest = edges_of(t).map(|(a, b)| corners[a as usize].distance(corners[b as usize]));
        let k = (0..3).fold(0, |best, k| if longest[k] > longest[best] { k } else { best });
        let height = 2.0 * area_normal(corners, t).length() / longest[k].max(f64::MIN_POSITIVE);
        (height <= nothing_mm).then(|| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]])
    };
    let mut caps: Vec<usize> = (0..triangles.len()).filter(|&t| cap(&triangles[t]).is_some()).collect();
    if caps.is_empty() {
        return triangles;
    }
    let mut owners = owners(&triangles);
    loop {
        let before = caps.len();
        caps.retain(|&t| {
            let Some([x, y, apex]) = cap(&triangles[t]) else { return false };
            let Some(&[other]) = owners.get(&(y, x)).map(|o| &o[..]) else { return true };
            let far = triangles[other].into_iter().find(|&c| c != x && c != y).unwrap_or(apex);
            let pair = [[x, far, apex], [far, y, apex]];
            let taken = [(apex, far), (far, apex)].iter().any(|e| owners.get(e).is_some_and(|o| !o.is_empty()));
            if far == apex || taken || cap(&triangles[other]).is_some() || pair.iter().any(|t| cap(t).is_some()) {
                return true;
            }
            for (place, new) in [t, other].into_iter().zip(pair) {
                edges_of(&triangles[place]).iter().for_each(|e| owners.entry(*e).or_default().retain(|&o| o != place));
                triangles[place] = new;
            }
            for (place, new) in [t, other].into_iter().zip(pair) {
                edges_of(&new).iter().for_each(|e| owners.entry(*e).or_default().push(place));
            }
            false
        });
        if caps.len() == before {
            break;
        }
    }
    let mut left = Vec::with_capacity(triangles.len());
    left.extend(triangles.iter().enumerate().filter(|(t, _)| caps.binary_search(t).is_err()).map(|(_, t)| *t));
    left
}

/// Disjoint sets of numbers; a set is named by its least member, so that the order of joining leaves no trace.
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn of(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}
