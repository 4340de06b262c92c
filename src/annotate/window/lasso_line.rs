//! The line of a lasso: resampled at even steps with its corners kept, and as an outline in a plane with what it winds around.
//!
//! Knows no field and no triangulation. Sources: Douglas and Peucker (1973) for the corners; the winding by crossings of a half-line.

use crate::annotate::path::strip::lengths;
use crate::annotate::path::surface_path::resampled;
use glam::{DVec2, DVec3};

/// Corners that the line would pass by more than this share of an edge without are kept.
const OFF: f64 = 0.25;

/// A point of a resampled line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinePoint {
    /// World mm.
    pub(crate) at: DVec3,
    /// Whether a point that was drawn lies within an edge along the line, so that this one is near the surface.
    pub(crate) picked: bool,
}

/// A closed line at steps of about `edge_mm` between its corners; fewer than 3 points if it has no extent.
pub(crate) fn resampled_loop(line: &[DVec3], edge_mm: f64) -> Vec<LinePoint> {
    let mut points: Vec<DVec3> = Vec::with_capacity(line.len() + 1);
    for &p in line {
        if points.last().is_none_or(|&last| last != p) {
            points.push(p);
        }
    }
    if points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    if points.len() < 3 {
        return points.into_iter().map(|at| LinePoint { at, picked: true }).collect();
    }
    points.push(points[0]);
    let knots = knots(&points, OFF * edge_mm);
    let mut found = Vec::new();
    for pair in knots.windows(2) {
        let piece = &points[pair[0]..=pair[1]];
        let along = lengths(piece);
        let length = along.last().copied().unwrap_or(0.0);
        let steps = (length / edge_mm).round().max(1.0) as usize;
        for (k, at) in resampled(piece, steps + 1).into_iter().take(steps).enumerate() {
            let here = length * k as f64 / steps as f64;
            let after = along.partition_point(|&a| a < here);
            let gap = |i: usize| along.get(i).map_or(f64::INFINITY, |a| (a - here).abs());
            found.push(LinePoint { at, picked: gap(after).min(gap(after.wrapping_sub(1))) <= edge_mm });
        }
    }
    found
}

/// Numbers of the points between which a closed line (first point repeated) is straight within `off_mm`, the first and last included.
fn knots(points: &[DVec3], off_mm: f64) -> Vec<usize> {
    let last = points.len() - 1;
    let farthest = (1..last).fold(1, |best, k| {
        if points[k].distance_squared(points[0]) > points[best].distance_squared(points[0]) { k } else { best }
    });
    let mut keep = vec![false; points.len()];
    let mut spans = vec![(0, farthest), (farthest, last)];
    while let Some((a, b)) = spans.pop() {
        keep[a] = true;
        keep[b] = true;
        let off = |k: usize| {
            let way = points[b] - points[a];
            let share =
                ((points[k] - points[a]).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            points[k].distance(points[a] + way * share)
        };
        let worst =
            (a + 1..b).map(|k| (off(k), k)).fold((off_mm, 0), |best, this| if this.0 > best.0 { this } else { best });
        if worst.1 > 0 {
            spans.extend([(a, worst.1), (worst.1, b)]);
        }
    }
    (0..points.len()).filter(|&k| keep[k]).collect()
}

/// A closed line in a plane, in edge lengths.
pub(crate) struct Outline {
    points: Vec<DVec2>,
}

impl Outline {
    pub(crate) fn new(points: Vec<DVec2>) -> Self {
        Self { points }
    }

    pub(crate) fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Low and high corner of the least box around it.
    pub(crate) fn bounds(&self) -> [DVec2; 2] {
        let low = self.points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        [low, self.points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max)]
    }

    /// How often it winds around `p`, counter-clockwise.
    pub(crate) fn winding(&self, p: DVec2) -> i32 {
        winding(self.edges(), p)
    }

    /// Points of a triangular lattice of edge 1 that it winds around and that keep `clear` away from it.
    pub(crate) fn lattice_inside(&self, clear: f64) -> Vec<DVec2> {
        let [low, high] = self.bounds();
        let height = 0.75_f64.sqrt();
        let mut found = Vec::new();
        for row in 0..((high.y - low.y) / height).ceil() as usize {
            let y = low.y + (row as f64 + 0.5) * height;
            let near: Vec<[DVec2; 2]> =
                self.edges().filter(|[a, b]| a.y.min(b.y) <= y + clear && a.y.max(b.y) >= y - clear).collect();
            let shift = if row % 2 == 0 { 0.25 } else { 0.75 };
            for column in 0..(high.x - low.x).ceil() as usize {
                let p = DVec2::new(low.x + column as f64 + shift, y);
                let away = || near.iter().all(|&[a, b]| distance_to_edge(p, a, b) >= clear);
                if winding(near.iter().copied(), p) != 0 && away() {
                    found.push(p);
                }
            }
        }
        found
    }

    fn edges(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        (0..self.points.len()).map(|k| [self.points[k], self.points[(k + 1) % self.points.len()]])
    }
}

/// Of edges that hold at least all those that the half-line from `p` along +x crosses.
fn winding(edges: impl Iterator<Item = [DVec2; 2]>, p: DVec2) -> i32 {
    edges
        .filter(|[a, b]| (a.y > p.y) != (b.y > p.y))
        .map(|[a, b]| {
            let up = b.y > a.y;
            let left = (b - a).perp_dot(p - a) > 0.0;
            if up && left {
                1
            } else if !up && !left {
                -1
            } else {
                0
            }
        })
        .sum()
}

fn distance_to_edge(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let way = b - a;
    let share = ((p - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + way * share)
}
