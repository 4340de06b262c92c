//! A turning scene, and counts of what goes wrong in it, written from the demands and not from the code.

use burin::annotate::labels::*;
use glam::{DVec2, DVec3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

pub const SIZE: DVec2 = DVec2::new(1280.0, 800.0);

/// How much time a step of the turn gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// One frame of 16 ms.
    OneFrame,
    /// Frames of 16 ms until all is settled.
    Finish,
    /// Sixty frames of 16 ms.
    Second,
}

/// What a turn showed.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    pub frames: usize,
    pub settled: usize,
    pub overlaps: usize,
    pub crossings: usize,
    pub outside: usize,
    /// Most events of one label in a quarter turn, and the mean over labels and quarters.
    pub most_events: usize,
    pub mean_events: f64,
    /// Of these, order relations of a pair on one side that changed.
    pub mean_inversions: f64,
    /// Greatest move in a step that was no event, px.
    pub greatest_move: f64,
    pub mean_leader: f64,
    pub mean_bends: f64,
    pub least_clearance: f64,
    pub left_out: usize,
    /// Share of labels whose point is past the middle by a tenth of half the object's width.
    pub late: f64,
    /// Frames said to be settled in which a label of a scene without hidden points is not.
    pub restless: usize,
    /// Leaders that do not go onward in x.
    pub repeated: usize,
    /// The most frames in a row in which a hidden point's label was still there.
    pub hidden_shown: usize,
}

impl Sums {
    pub fn line(&self) -> String {
        format!(
            "settled {:.2}, overlaps {}, crossings {}, most events {}, mean {:.2} ({:.2} of them exchanges), move {:.1} px, \
             leader {:.0} px, bends {:.2}, clearance {:.5} px, past the middle {:.3}, left out {}",
            self.settled as f64 / self.frames as f64,
            self.overlaps,
            self.crossings,
            self.most_events,
            self.mean_events,
            self.mean_inversions,
            self.greatest_move,
            self.mean_leader,
            self.mean_bends,
            self.least_clearance,
            self.late,
            self.left_out
        )
    }
}

/// How points lie in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// At random in an ellipsoid.
    Ellipsoid,
    /// On a lattice, so that many cover each other at some angles.
    Lattice,
    /// In mirrored pairs and on the plane between, as an atlas's centroids are.
    Mirrored,
    /// On the surface of a long ellipsoid whose middle is not the turn's.
    Long,
}

pub struct Scene {
    pub points: Vec<DVec3>,
    pub sizes: Vec<DVec2>,
    pub axes: DVec3,
    pub middle: DVec3,
}

impl Scene {
    pub fn new(seed: u64, count: usize) -> Self {
        Self::of(Kind::Ellipsoid, seed, count)
    }

    pub fn of(kind: Kind, seed: u64, count: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut axis = |low: f64| random.random_range(low..100.0);
        let axes = if kind == Kind::Long {
            DVec3::new(100.0, 30.0, 50.0)
        } else {
            DVec3::new(axis(70.0), axis(70.0), axis(60.0))
        };
        let mut points = Vec::new();
        while points.len() < count {
            let p = DVec3::new(
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
            );
            let n = points.len();
            if kind == Kind::Lattice {
                let at = DVec3::new((n % 4) as f64, (n / 4 % 4) as f64, (n / 16) as f64);
                points.push((at - 1.5) * 35.0);
            } else if p.length() <= 1.0 {
                points.push(match kind {
                    Kind::Long => p.normalize_or_zero() * axes + DVec3::new(12.0, 5.0, 0.0),
                    Kind::Mirrored if n % 3 == 1 => points[n - 1] * DVec3::new(1.0, -1.0, 1.0),
                    Kind::Mirrored if n % 3 == 2 => p * axes * DVec3::new(1.0, 0.0, 1.0),
                    _ => p * axes,
                });
            }
        }
        let sizes = (0..count).map(|_| DVec2::new(random.random_range(40.0..160.0), 17.0)).collect();
        let middle = if kind == Kind::Long { DVec3::new(12.0, 5.0, 0.0) } else { DVec3::ZERO };
        Self { points, sizes, axes, middle }
    }

    /// (screen px, depth) of a point; z is up.
    pub fn project(&self, p: DVec3, degrees: f64, elevation: f64, perspective: bool) -> (DVec2, f64) {
        let (sa, ca) = degrees.to_radians().sin_cos();
        let (se, ce) = elevation.to_radians().sin_cos();
        let right = DVec3::new(-sa, ca, 0.0);
        let back = DVec3::new(ca * ce, sa * ce, se);
        let up = back.cross(right);
        let distance = 400.0;
        let depth = distance - p.dot(back);
        let scale = if perspective { 3.4 * distance / depth } else { 3.4 };
        (SIZE / 2.0 + DVec2::new(p.dot(right), -p.dot(up)) * scale, depth)
    }

    pub fn labels(&self, degrees: f64, elevation: f64, perspective: bool, hidden: bool) -> Vec<Label> {
        self.points
            .iter()
            .zip(&self.sizes)
            .enumerate()
            .map(|(n, (&p, &size))| {
                let (anchor, depth) = self.project(p, degrees, elevation, perspective);
                let visible = !hidden || depth < 400.0 + 20.0;
                Label { id: 1000 + n as u64, anchor, depth, visible, size, priority: (n % 5) as f64 }
            })
            .collect()
    }

    pub fn viewport(&self, degrees: f64, elevation: f64, perspective: bool) -> Viewport {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for a in 0..64 {
            for b in 0..33 {
                let (u, v) = (a as f64 / 64.0 * std::f64::consts::TAU, b as f64 / 32.0 * std::f64::consts::PI);
                let p = DVec3::new(u.cos() * v.sin(), u.sin() * v.sin(), v.cos()) * self.axes + self.middle;
                let at = self.project(p, degrees, elevation, perspective).0;
                (low, high) = (low.min(at), high.max(at));
            }
        }
        Viewport { size: SIZE, outline: vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)] }
    }
}

fn turn_of(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether two segments have a point in common.
pub fn meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    if a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any() {
        return false;
    }
    turn_of(a, b, c) * turn_of(a, b, d) <= 0.0 && turn_of(c, d, a) * turn_of(c, d, b) <= 0.0
}

/// Whether a segment has a point in a rectangle.
pub fn in_rect(rect: &Rect, a: DVec2, b: DVec2) -> bool {
    let inside = |p: DVec2| p.cmpge(rect.min).all() && p.cmple(rect.max).all();
    let (l, h) = (rect.min, rect.max);
    let corners = [l, DVec2::new(h.x, l.y), h, DVec2::new(l.x, h.y)];
    inside(a) || inside(b) || (0..4).any(|n| meet(a, b, corners[n], corners[(n + 1) % 4]))
}

/// (overlaps of rectangles, crossings of leaders with leaders and with others' rectangles, labels not in the picture).
pub fn faults(frame: &Frame) -> (usize, usize, usize) {
    let (mut overlaps, mut crossings, mut outside) = (0, 0, 0);
    let spans: Vec<Rect> = frame.labels.iter().map(|label| span(&label.leader)).collect();
    for (n, a) in frame.labels.iter().enumerate() {
        outside += usize::from(a.rect.min.min_element() < 0.0 || a.rect.max.cmpgt(SIZE).any());
        for (m, b) in frame.labels.iter().enumerate() {
            if m == n {
                continue;
            }
            if m < n {
                overlaps += usize::from(a.rect.min.cmplt(b.rect.max).all() && b.rect.min.cmplt(a.rect.max).all());
                let met = !apart(&spans[n], &spans[m])
                    && a.leader.windows(2).any(|p| b.leader.windows(2).any(|q| meet(p[0], p[1], q[0], q[1])));
                crossings += usize::from(met);
            }
            crossings +=
                usize::from(!apart(&spans[n], &b.rect) && a.leader.windows(2).any(|p| in_rect(&b.rect, p[0], p[1])));
        }
    }
    (overlaps, crossings, outside)
}

fn point_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-12)).clamp(0.0, 1.0);
    p.distance(a + (b - a) * t)
}

/// Boxes of a leader's segments as one.
fn span(leader: &[DVec2]) -> Rect {
    let fold = |join: fn(DVec2, DVec2) -> DVec2| leader.iter().copied().reduce(join).unwrap_or(DVec2::NAN);
    Rect { min: fold(DVec2::min), max: fold(DVec2::max) }
}

fn apart(a: &Rect, b: &Rect) -> bool {
    a.max.cmplt(b.min).any() || b.max.cmplt(a.min).any()
}

pub fn turn(scene: &Scene, perspective: bool, elevation: f64, pace: Pace, hidden: bool, steps: usize) -> Sums {
    let mut memory = Memory::default();
    let mut sums = Sums { least_clearance: f64::INFINITY, ..Sums::default() };
    let mut events: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    let mut inversions = 0;
    let mut before: Option<Frame> = None;
    let mut shown: BTreeMap<u64, usize> = BTreeMap::new();
    let (mut leaders, mut bends) = (0.0, 0.0);
    let mut count = 0.0;
    let mut late = 0.0;
    for step in 0..=steps {
        let degrees = step as f64;
        let labels = scene.labels(degrees, elevation, perspective, hidden);
        let viewport = scene.viewport(degrees, elevation, perspective);
        let mut frame = None;
        let frames = match pace {
            Pace::OneFrame => 1,
            Pace::Second => 60,
            Pace::Finish => 1000,
        };
        for _ in 0..frames {
            let next = place(&viewport, &Style::default(), &labels, &mut memory, 0.016);
            sums.frames += 1;
            let (overlaps, crossings, outside) = faults(&next);
            sums.overlaps += overlaps;
            sums.crossings += crossings;
            sums.outside += outside;
            if next.settled {
                sums.settled += 1;
                let rests = next.labels.iter().all(|label| label.settled && label.opacity == 1.0);
                sums.restless += usize::from(!hidden && !rests);
            }
            for label in &next.labels {
                let way = if label.side == Side::Left { -1.0 } else { 1.0 };
                sums.repeated += usize::from(label.leader.windows(2).any(|p| (p[1].x - p[0].x) * way <= 0.0));
                let hidden = !labels[(label.id - 1000) as usize].visible;
                let run = shown.entry(label.id).or_default();
                *run = if hidden { *run + 1 } else { 0 };
                sums.hidden_shown = sums.hidden_shown.max(*run);
            }
            for label in labels.iter().filter(|label| next.labels.iter().all(|placed| placed.id != label.id)) {
                shown.remove(&label.id);
            }
            let done = pace == Pace::Finish && next.settled;
            frame = Some(next);
            if done {
                break;
            }
        }
        let Some(frame) = frame else { continue };
        sums.left_out += frame.left_out.len();
        for (n, label) in frame.labels.iter().enumerate() {
            leaders += label.leader.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
            bends += (label.leader.len() - 2) as f64;
            count += 1.0;
            let (low, high) = (viewport.outline[0].x, viewport.outline[2].x);
            let past = (label.leader[0].x - (low + high) / 2.0) * if label.side == Side::Left { 1.0 } else { -1.0 };
            late += f64::from(past > 0.05 * (high - low));
            for other in frame.labels.iter().enumerate().filter(|(m, _)| *m != n).map(|(_, o)| o) {
                for p in other.leader.windows(2) {
                    let end = label.leader[0];
                    sums.least_clearance = sums.least_clearance.min(point_segment(end, p[0], p[1]));
                }
            }
        }
        if let Some(before) = &before {
            let old: BTreeMap<u64, &Placed> = before.labels.iter().map(|l| (l.id, l)).collect();
            let pairs: Vec<(&Placed, &Placed)> =
                frame.labels.iter().filter_map(|l| Some((*old.get(&l.id)?, l))).collect();
            let mut inverted: BTreeMap<u64, usize> = BTreeMap::new();
            for (n, (a0, a1)) in pairs.iter().enumerate() {
                for (b0, b1) in &pairs[..n] {
                    let same = a0.side == b0.side && a1.side == b1.side && a0.side == a1.side;
                    if same && (a0.rect.min.y < b0.rect.min.y) != (a1.rect.min.y < b1.rect.min.y) {
                        *inverted.entry(a0.id).or_default() += 1;
                        *inverted.entry(b0.id).or_default() += 1;
                    }
                }
            }
            for (a, b) in &pairs {
                let crossed = a.side != b.side;
                let swaps = inverted.get(&a.id).copied().unwrap_or(0);
                inversions += swaps;
                events.entry(a.id).or_default().extend(std::iter::repeat_n(step, usize::from(crossed) + swaps));
                if !crossed && swaps == 0 && a.opacity > 0.0 {
                    // The near edge: a label's width never changes.
                    sums.greatest_move = sums.greatest_move.max(a.rect.min.distance(b.rect.min));
                }
            }
        }
        before = Some(frame);
    }
    // In every quarter turn, wherever it begins.
    let within =
        |steps: &Vec<usize>, first: usize| steps.iter().filter(|&&step| step >= first && step < first + 90).count();
    sums.most_events = events
        .values()
        .map(|at| (0..=steps.saturating_sub(90)).map(|first| within(at, first)).max().unwrap_or(0))
        .max()
        .unwrap_or(0);
    sums.mean_events = events.values().map(Vec::len).sum::<usize>() as f64 / (60.0 * steps as f64 / 90.0);
    sums.mean_inversions = inversions as f64 / (60.0 * steps as f64 / 90.0);
    sums.mean_leader = leaders / count;
    sums.mean_bends = bends / count;
    sums.late = late / count;
    sums
}
