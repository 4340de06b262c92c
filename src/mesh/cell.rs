//! The surface in one cell of a lattice: eight samples, in or out, and the loops in which the surface leaves through its faces.
//!
//! Marching cubes without a table (Lorensen, Cline 1987): every face of a cell is crossed from where one walks in to where one walks out. A
//! face whose corners alternate is decided by its saddle (Nielson, Hamann 1991: "The asymptotic decider"), which both cells of the
//! face reckon alike, in integers: so surfaces are closed whatever the samples. Loops become triangles of which no inner edge lies on
//! a face of the cell, since the neighbour could have the same one: every edge is of two triangles. Knows no field.

/// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2).
pub(super) const CORNERS: usize = 8;

/// An edge of a cell, from a corner along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellEdge {
    pub(super) corner: u8,
    pub(super) axis: u8,
}

/// The longest loop there is has 12 edges.
const MOST: usize = 12;

/// A loop of a surface in a cell.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    /// Edges that it crosses, round about it as seen from outside.
    pub(super) edges: Vec<CellEdge>,
    /// How it is divided into triangles, by places among the edges; `None` if every way has an edge on a face of the cell: then it needs
    /// a corner of its own inside.
    pub(super) triangles: Option<Vec<[usize; 3]>>,
}

/// Which corners of a cell are inside, a bit each, and of which faces those that alternate are one piece.
#[derive(Clone, Copy)]
struct Case {
    inside: u8,
    joined: u8,
}

/// The loops of every case that was met.
pub(super) struct Cases(Vec<Option<Vec<Ring>>>);

impl Cases {
    pub(super) fn new() -> Self {
        Self(vec![None; 1 << (8 + 6)])
    }

    /// The loops of the surface between samples above 0, which are inside, and below; none is 0.
    pub(super) fn loops(&mut self, samples: &[i32; CORNERS]) -> &[Ring] {
        let case = Case::of(samples);
        let at = usize::from(case.inside) << 6 | usize::from(case.joined);
        self.0[at].get_or_insert_with(|| loops(case).iter().map(|edges| ring(edges)).collect())
    }
}

fn ring(edges: &[u8]) -> Ring {
    Ring { edges: edges.iter().map(|&e| edge(e)).collect(), triangles: triangles(edges) }
}

/// How a loop is divided into triangles; see [`Ring`].
fn triangles(edges: &[u8]) -> Option<Vec<[usize; 3]>> {
    let n = edges.len();
    // Whether the part of the loop from i to j can be divided, and by which corner between.
    let mut by = [[0_usize; MOST]; MOST];
    let joined = |i: usize, j: usize| i + 1 == j || (i == 0 && j == n - 1) || !share_face(edges[i], edges[j]);
    for width in 2..n {
        for i in 0..n - width {
            let j = i + width;
            let can = |i: usize, j: usize, by: &[[usize; MOST]; MOST]| j == i + 1 || by[i][j] != 0;
            // From the middle on: triangles about as large as each other.
            let mut between: Vec<usize> = (i + 1..j).collect();
            between.sort_by_key(|k| (2 * k).abs_diff(i + j));
            let k = between.into_iter().find(|&k| joined(i, k) && joined(k, j) && can(i, k, &by) && can(k, j, &by));
            by[i][j] = k.unwrap_or(0);
        }
    }
    if n > 2 && by[0][n - 1] == 0 {
        return None;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut open = vec![(0, n - 1)];
    while let Some((i, j)) = open.pop() {
        if j > i + 1 {
            let k = by[i][j];
            triangles.push([i, k, j]);
            open.extend([(i, k), (k, j)]);
        }
    }
    Some(triangles)
}

/// Number of an edge: four along each axis, by the other two coordinates of their corner.
fn number(corner: u8, axis: u8) -> u8 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    axis * 4 + (corner >> u & 1) + 2 * (corner >> v & 1)
}

fn edge(number: u8) -> CellEdge {
    let axis = number / 4;
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    CellEdge { corner: (number & 1) << u | (number >> 1 & 1) << v, axis }
}

/// The edge between two corners beside each other.
fn between(a: u8, b: u8) -> u8 {
    number(a & b, (a ^ b).trailing_zeros() as u8)
}

/// Whether two edges lie on one face of the cell.
fn share_face(a: u8, b: u8) -> bool {
    let ends = |e: CellEdge| [e.corner, e.corner | 1 << e.axis];
    let (a, b) = (ends(edge(a)), ends(edge(b)));
    (0..3).any(|axis| {
        let side = a[0] >> axis & 1;
        [a[1], b[0], b[1]].iter().all(|corner| corner >> axis & 1 == side)
    })
}

/// The corners of a face, round about it as seen from outside of the cell.
fn face(axis: u8, far: bool) -> [u8; 4] {
    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let base = u8::from(far) << axis;
    if far { [base, base | u, base | u | v, base | v] } else { [base, base | v, base | u | v, base | u] }
}

/// Whether the corners of a face are in and out by turns.
fn alternates(corners: &[u8; 4], inside: u8) -> bool {
    let is_in = |i: usize| inside >> corners[i] & 1 == 1;
    is_in(0) == is_in(2) && is_in(1) == is_in(3) && is_in(0) != is_in(1)
}

/// All faces of a cell in order.
fn faces() -> impl Iterator<Item = [u8; 4]> {
    (0..3).flat_map(|axis| [face(axis, false), face(axis, true)])
}

impl Case {
    fn of(samples: &[i32; CORNERS]) -> Self {
        let inside = (0..CORNERS).fold(0, |bits, c| bits | u8::from(samples[c] > 0) << c);
        let is_joined = |corners: &[u8; 4]| {
            let value = |i: usize| i64::from(samples[usize::from(corners[i])]);
            let (across, other) = (value(0) * value(2), value(1) * value(3));
            // Those inside are one piece if the saddle between them is inside. Where it is neither they are two.
            alternates(corners, inside) && if value(0) > 0 { across > other } else { other > across }
        };
        let joined = faces().enumerate().fold(0, |bits, (i, corners)| bits | u8::from(is_joined(&corners)) << i);
        Self { inside, joined }
    }
}

/// The loops of a case, as numbers of edges.
fn loops(case: Case) -> Vec<Vec<u8>> {
    const NONE: u8 = u8::MAX;
    let mut next = [NONE; 12];
    let is_in = |corner: u8| case.inside >> corner & 1 == 1;
    for (number, corners) in faces().enumerate() {
        let crossed = |i: usize| between(corners[i], corners[(i + 1) % 4]);
        let enters = |i: usize| !is_in(corners[i]) && is_in(corners[(i + 1) % 4]);
        let leaves = |i: usize| is_in(corners[i]) && !is_in(corners[(i + 1) % 4]);
        let alternate = alternates(&corners, case.inside);
        for i in (0..4).filter(|&i| enters(i)) {
            let out = match alternate {
                // About the corner that was left, or about the one that is walked into.
                true if case.joined >> number & 1 == 1 => (i + 3) % 4,
                true => (i + 1) % 4,
                false => (0..4).find(|&k| leaves(k)).unwrap_or(i),
            };
            next[usize::from(crossed(i))] = crossed(out);
        }
    }
    let mut loops = Vec::new();
    for start in 0..12_u8 {
        let (mut edges, mut at) = (Vec::new(), start);
        while next[usize::from(at)] != NONE {
            edges.push(at);
            at = std::mem::replace(&mut next[usize::from(at)], NONE);
        }
        if !edges.is_empty() {
            loops.push(edges);
        }
    }
    loops
}
