//! The sides that separate inside from outside.
//!
//! Joined Arabic letters, stacked marks and composite glyphs overlap; the parts of their contours that lie inside the union must not count
//! as edges, or a seam is drawn through the ink. Owns: cutting sides where they meet, and keeping the pieces that have winding 0 on exactly
//! one hand. Knows no texel.

use crate::annotate::picture::outline::{Outline, Rect};
use glam::DVec2;

/// A straight piece of the boundary between its two ends, mm.
pub type Side = [DVec2; 2];

/// Share of the outline's extent below which two points are one.
const SAME: f64 = 1e-9;

/// Share of the outline's extent that a point beside a side is off it.
const BESIDE: f64 = 1e-7;

/// The boundary of what is inside an outline under the non-zero rule. Pieces shorter than 1e-7 of its extent are left out.
pub fn boundary(outline: &Outline) -> Vec<Side> {
    let Some(bounds) = outline.bounds() else { return Vec::new() };
    let extent = bounds.size().max_element();
    if !(extent > 0.0 && extent.is_finite()) {
        return Vec::new();
    }
    let sides: Vec<Side> = sides_of(outline).filter(|[a, b]| a.distance(*b) > SAME * extent).collect();
    let winding = Winding::new(&sides, bounds);
    let cuts = meetings(&sides, bounds, SAME * extent);
    let mut kept = Vec::with_capacity(sides.len());
    for (side, mut cut) in sides.iter().zip(cuts) {
        let [a, b] = *side;
        cut.extend([0.0, 1.0]);
        cut.sort_by(f64::total_cmp);
        for pair in cut.windows(2) {
            let piece = [a.lerp(b, pair[0]), a.lerp(b, pair[1])];
            let length = piece[0].distance(piece[1]);
            if length <= BESIDE * extent {
                continue;
            }
            let off = (piece[1] - piece[0]).perp() / length * (BESIDE * extent);
            let middle = piece[0].midpoint(piece[1]);
            if (winding.at(middle + off) != 0) != (winding.at(middle - off) != 0) {
                kept.push(piece);
            }
        }
    }
    kept
}

/// The sides of all contours, with their closing ones.
pub fn sides_of(outline: &Outline) -> impl Iterator<Item = Side> + '_ {
    outline.contours.iter().flat_map(|c| (0..c.len()).map(move |i| [c[i], c[(i + 1) % c.len()]]))
}

/// For each side, where others meet it, as shares of its length within (0, 1).
fn meetings(sides: &[Side], bounds: Rect, same: f64) -> Vec<Vec<f64>> {
    let along = usize::from(bounds.size().y > bounds.size().x);
    let span = |i: usize, axis: usize| {
        let [a, b] = sides[i];
        (a[axis].min(b[axis]) - same, a[axis].max(b[axis]) + same)
    };
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by(|&i, &j| span(i, along).0.total_cmp(&span(j, along).0));
    let mut cuts = vec![Vec::new(); sides.len()];
    for (n, &i) in order.iter().enumerate() {
        let (end, across) = (span(i, along).1, span(i, 1 - along));
        for &j in &order[n + 1..] {
            if span(j, along).0 > end {
                break;
            }
            let other = span(j, 1 - along);
            if other.0 <= across.1 && across.0 <= other.1 {
                meet(sides, i, j, same, &mut cuts);
            }
        }
    }
    cuts
}

fn meet(sides: &[Side], i: usize, j: usize, same: f64, cuts: &mut [Vec<f64>]) {
    let ([a, b], [c, d]) = (sides[i], sides[j]);
    let (u, v) = (b - a, d - c);
    let (lu, lv) = (u.length(), v.length());
    let mut cut = |side: usize, t: f64, length: f64| {
        if t * length > same && (1.0 - t) * length > same {
            cuts[side].push(t);
        }
    };
    let turn = u.perp_dot(v);
    // Where parallel ones run along each other, it is the sides behind their corners that cut.
    if turn.abs() <= 1e-12 * lu * lv {
        return;
    }
    let (t, s) = ((c - a).perp_dot(v) / turn, (c - a).perp_dot(u) / turn);
    let within = |t: f64, length: f64| t * length >= -same && (t - 1.0) * length <= same;
    if within(t, lu) && within(s, lv) {
        cut(i, t, lu);
        cut(j, s, lv);
    }
}

/// Winding numbers, by rays across the outline's shorter extent.
struct Winding<'a> {
    sides: &'a [Side],
    along: usize,
    from: f64,
    per_mm: f64,
    buckets: Vec<Vec<u32>>,
}

impl<'a> Winding<'a> {
    fn new(sides: &'a [Side], bounds: Rect) -> Self {
        let along = usize::from(bounds.size().y > bounds.size().x);
        let count = (sides.len() / 2).clamp(1, 1 << 14);
        let (from, per_mm) = (bounds.min[along], count as f64 / bounds.size()[along]);
        let mut it = Self { sides, along, from, per_mm, buckets: vec![Vec::new(); count] };
        for (n, [a, b]) in sides.iter().enumerate() {
            let (low, high) = (it.bucket(a[along].min(b[along])), it.bucket(a[along].max(b[along])));
            it.buckets[low..=high].iter_mut().for_each(|bucket| bucket.push(n as u32));
        }
        it
    }

    fn bucket(&self, at: f64) -> usize {
        (((at - self.from) * self.per_mm) as usize).min(self.buckets.len() - 1)
    }

    fn at(&self, p: DVec2) -> i32 {
        let (k, m) = (self.along, 1 - self.along);
        let mut winding = 0;
        for &n in &self.buckets[self.bucket(p[k])] {
            let [a, b] = self.sides[n as usize];
            let (before, after) = (a[k] <= p[k], b[k] <= p[k]);
            if before != after && a[m] + (p[k] - a[k]) / (b[k] - a[k]) * (b[m] - a[m]) < p[m] {
                winding += if before { 1 } else { -1 };
            }
        }
        winding
    }
}
