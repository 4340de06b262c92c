//! A lattice that grows on a surface from its centre.
//!
//! A lattice that is laid out at once folds where the surface bends; one that grows ring by ring and is relaxed after each never
//! meets more bend at a time than lies under one spacing. Owns the order of growth and where a new vertex begins.

use crate::annotate::relaxing::dirichlet::Factor;
use crate::annotate::relaxing::sheet::{Sheet, Vertex};
use crate::annotate::surface::Surface;
use glam::DVec3;

/// A place that found no vertex so often is given up.
const MOST_FAILURES: u8 = 3;

/// The most rounds of sliding after a ring.
const MOST_ROUNDS: usize = 8;

/// New vertices lie no farther from their neighbours than this, in spacings.
const FARTHEST: f64 = 3.0;

/// Lattices that reach farther from their centre, in spacings, are refined from one of twice the spacing.
const MOST_GROWN: usize = 24;

/// The lattice of 2·`half[0]` + 1 columns and 2·`half[1]` + 1 rows about the sheet's centre. `cancel` is asked before each ring; None
/// if it says so.
pub(crate) fn grown<'a, S: Surface + ?Sized>(
    seed: Sheet<'a, S>,
    half: [usize; 2],
    factor: &mut Factor,
    cancel: &dyn Fn() -> bool,
) -> Option<Sheet<'a, S>> {
    let mut sheet = seed;
    if half[0].max(half[1]) > MOST_GROWN {
        let spacing_mm = sheet.spacing_mm;
        sheet.spacing_mm = 2.0 * spacing_mm;
        sheet = grown(sheet, half.map(|half| half.div_ceil(2)), factor, cancel)?.refined(half);
        if cancel() {
            return None;
        }
        fill(&mut sheet);
        rest(&mut sheet, factor);
        return Some(sheet);
    }
    let mut rings = 1;
    while sheet.columns / 2 < half[0] || sheet.rows / 2 < half[1] {
        if cancel() {
            return None;
        }
        for _ in 0..rings {
            let wider = usize::from(sheet.columns / 2 < half[0]);
            let higher = usize::from(sheet.rows / 2 < half[1]);
            if wider + higher > 0 {
                sheet = sheet.widened(wider, higher);
                fill(&mut sheet);
            }
        }
        let first = rest(&mut sheet, factor);
        // Where the surface is smooth, more rings at a time.
        rings = if first < 0.15 {
            (rings + 1).min(4)
        } else if first < 0.4 {
            rings
        } else {
            1
        };
    }
    // What found no place at the border of a smaller lattice may find one among its neighbours.
    if sheet.vertices.iter().zip(&sheet.failures).any(|(vertex, failures)| vertex.is_none() && *failures < u8::MAX) {
        for failures in sheet.failures.iter_mut().filter(|failures| **failures < u8::MAX) {
            *failures = 0;
        }
        fill(&mut sheet);
        rest(&mut sheet, factor);
    }
    Some(sheet)
}

/// Slides a lattice that has grown until it nearly rests. Returns how far it was from that, in spacings.
fn rest<S: Surface + ?Sized>(sheet: &mut Sheet<'_, S>, factor: &mut Factor) -> f64 {
    let mut left = sheet.unfold(12);
    factor.holds = false;
    let (mut first, mut far, mut share) = (f64::INFINITY, f64::INFINITY, 1.0);
    for round in 0..MOST_ROUNDS {
        let next = sheet.slide(3, share, factor);
        if round == 0 {
            first = next;
        }
        if next > 0.7 * far {
            share = 0.5;
            factor.holds = false;
        }
        far = next;
        left = sheet.unfold(12);
        if far < 0.3 && left == 0 {
            break;
        }
    }
    if left > 0 {
        sheet.trim_folds();
    }
    first
}

/// Gives the lattice's empty places vertices, from those next to them.
fn fill<S: Surface + ?Sized>(sheet: &mut Sheet<'_, S>) {
    let before = sheet.vertices.clone();
    // Those that continue a line of the lattice first, then the corners, whose neighbours are among them.
    for corners in [false, true] {
        let old = sheet.vertices.clone();
        for (vertex, known) in old.iter().enumerate() {
            if known.is_none() && sheet.failures[vertex] < MOST_FAILURES {
                sheet.vertices[vertex] = begun(sheet, &old, vertex, corners);
            }
        }
    }
    for (vertex, known) in before.iter().enumerate() {
        if known.is_none() && sheet.vertices[vertex].is_none_or(|found| torn(sheet, vertex, found.point)) {
            sheet.vertices[vertex] = None;
            sheet.failures[vertex] = sheet.failures[vertex].saturating_add(1);
        }
    }
}

/// Whether a vertex that begins here is so far from a neighbour that the surface is torn between them.
fn torn<S: Surface + ?Sized>(sheet: &Sheet<'_, S>, vertex: usize, point: DVec3) -> bool {
    let (column, row) = ((vertex % sheet.columns) as isize, (vertex / sheet.columns) as isize);
    [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|&(right, down)| {
        let neighbour = sheet.index(column + right, row + down).and_then(|near| sheet.vertices[near]);
        neighbour.is_some_and(|near| near.point.distance(point) > FARTHEST * sheet.spacing_mm)
    })
}

fn begun<S: Surface + ?Sized>(
    sheet: &Sheet<'_, S>,
    old: &[Option<Vertex>],
    vertex: usize,
    corners: bool,
) -> Option<Vertex> {
    let (column, row) = ((vertex % sheet.columns) as isize, (vertex / sheet.columns) as isize);
    let near = |right: isize, down: isize| old[sheet.index(column + right, row + down)?];
    let (mut points, mut outward, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    let mut take = |found: Option<Vertex>| {
        if let Some(found) = found {
            points += found.point;
            outward += found.normal;
            count += 1.0;
        }
    };
    let axes = sheet.axes()?;
    for (right, down) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
        let Some(first) = near(right, down) else { continue };
        let way = match near(2 * right, 2 * down) {
            Some(second) => first.point - second.point,
            // The first ring has nothing to continue.
            None if old.iter().flatten().count() == 1 => {
                -(axes[0] * right as f64 + axes[1] * down as f64) * sheet.spacing_mm
            }
            None => continue,
        };
        let way = (way - first.normal * way.dot(first.normal)).normalize_or_zero() * sheet.spacing_mm;
        take(sheet.walked(first, way));
    }
    if corners {
        for (right, down) in [(1, 1), (-1, 1), (1, -1), (-1, -1)] {
            let (Some(inner), Some(one), Some(other)) = (near(right, down), near(right, 0), near(0, down)) else {
                continue;
            };
            take(sheet.walked(inner, one.point + other.point - 2.0 * inner.point));
        }
    }
    if count == 0.0 {
        return None;
    }
    sheet.lowered(points / count, outward.try_normalize()?, 1.0)
}
