//! A stroke over a surface that is looked at from one side: which looks it joins to a path, and where the path breaks.
//!
//! Whoever looks does so at every pixel along the pointer's way, and between two pixels so often that what is passed across the
//! line of sight is a quarter of a voxel or less. So the path follows the surface between two samples of the pointer, and breaks at
//! the same places however many there are. The rule for two pixels that follow each other:
//!
//! - one of them met nothing, or they met different parts: the path breaks;
//! - what they met lies at most [`CLOSE_VOXELS`] apart: the path goes on;
//! - it lies further apart, but by no more than a surface can fall back that is seen at 80° from its normal (tan 80° = 5.7 times
//!   what is passed), or than leaves every dab between within radius and a voxel of both: the path goes on along the looks between, if
//!   none of them met nothing, another part, or something further than [`CLOSE_VOXELS`] from the look before. A ball does not break;
//! - else, if it lies apart by no more than the brush's diameter and two voxels: the path ends a voxel beyond the first and begins
//!   again a voxel before the second, where both ends touch (stairs of voxels seen at a grazing angle stay one stroke);
//! - else the path breaks.
//!
//! So nothing is painted farther than radius and a voxel from what a pixel met. Knows neither pictures nor voxels but for their size.

use crate::math::DVec3;
use crate::paint::brush::Sample;

/// Most voxels between two looks on one surface.
pub const CLOSE_VOXELS: f64 = 2.0;
/// Voxels by which a sample may be off the line between its neighbours and is left out.
const STRAIGHT_VOXELS: f64 = 0.02;

/// Tangent of the angle up to which a surface that falls back goes on: 80° and what sampling adds.
const STEEP: f64 = 6.0;

/// What one look met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// World mm at rest.
    pub position: DVec3,
    /// The body.
    pub part: u32,
}

/// How a pixel's hit is joined to the one before.
enum Join {
    Near,
    /// By the looks between.
    Along,
    /// By this step beyond the one and before the other.
    Reach(DVec3),
    Break,
}

/// What the rule measures with.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceRule {
    /// The brush's radius, mm.
    pub radius_mm: f64,
    /// The smallest spacing, mm.
    pub voxel_mm: f64,
    /// What is passed from pixel to pixel across the line of sight, mm.
    pub pixel_mm: f64,
    /// Normal of the samples that come of it.
    pub normal: DVec3,
}

impl SurfaceRule {
    /// The samples of a stroke that was at `last` and went on along looks, each with its pressure. Every `per_pixel`-th look is a
    /// pixel's, and the last.
    pub fn follow(&self, last: Option<Seen>, looks: &[(Option<Seen>, f32)], per_pixel: usize) -> Vec<Sample> {
        let mut samples = Vec::new();
        let mut before = last;
        // The piece so far; one that goes on begins with the sample that is there already.
        let mut piece: Vec<Sample> = last.map(|s| self.sample(s.position, 1.0)).into_iter().collect();
        let mut goes_on = last.is_some();
        for between in looks.chunks(per_pixel.max(1)) {
            let Some(&(seen, pressure)) = between.last() else { continue };
            match self.join(before, between) {
                Join::Near => {}
                Join::Along => {
                    let along = between[..between.len() - 1].iter();
                    piece.extend(along.filter_map(|&(s, pressure)| Some(self.sample(s?.position, pressure))));
                }
                Join::Reach(step) => {
                    let ends = before.map(|s| s.position + step).into_iter();
                    piece.extend(ends.map(|p| self.sample(p, pressure)));
                    self.put(std::mem::take(&mut piece), goes_on, &mut samples);
                    goes_on = false;
                    piece.extend(seen.map(|s| self.sample(s.position - step, pressure)));
                }
                Join::Break => {
                    self.put(std::mem::take(&mut piece), goes_on, &mut samples);
                    goes_on = false;
                }
            }
            piece.extend(seen.map(|s| self.sample(s.position, pressure)));
            before = seen;
        }
        self.put(piece, goes_on, &mut samples);
        samples
    }

    fn join(&self, before: Option<Seen>, between: &[(Option<Seen>, f32)]) -> Join {
        let (Some(a), Some(&(Some(b), _))) = (before, between.last()) else { return Join::Break };
        let apart = a.position.distance(b.position);
        if a.part != b.part {
            return Join::Break;
        }
        if apart <= CLOSE_VOXELS * self.voxel_mm {
            return Join::Near;
        }
        // A dab halfway between two hits reaches sqrt(apart²/4 + radius²) from them beside the way, a little more where that is bent.
        let beside = 1.8 * (self.voxel_mm * (2.0 * self.radius_mm + self.voxel_mm)).sqrt();
        let goes_on = |(x, y): (Option<Seen>, Option<Seen>)| match (x, y) {
            (Some(x), Some(y)) => x.part == y.part && x.position.distance(y.position) <= CLOSE_VOXELS * self.voxel_mm,
            _ => false,
        };
        let looks = || between.iter().map(|look| look.0);
        if apart <= beside.max(STEEP * self.pixel_mm)
            && between.len() > 1
            && std::iter::once(before).chain(looks()).zip(looks()).all(goes_on)
        {
            return Join::Along;
        }
        if apart <= 2.0 * (self.radius_mm + self.voxel_mm) {
            return Join::Reach((b.position - a.position) / apart * self.voxel_mm);
        }
        Join::Break
    }

    fn sample(&self, position: DVec3, pressure: f32) -> Sample {
        Sample { position, normal: self.normal, pressure, breaks: false }
    }

    /// Adds a piece, without the samples that lie on the line between others and without its first if it was there.
    fn put(&self, mut piece: Vec<Sample>, goes_on: bool, samples: &mut Vec<Sample>) {
        if let (Some(first), false) = (piece.first_mut(), goes_on) {
            first.breaks = true;
        }
        let kept = straightened(&piece, STRAIGHT_VOXELS * self.voxel_mm);
        samples.extend(kept.into_iter().skip(usize::from(goes_on)).map(|i| piece[i]));
    }
}

/// Numbers of the samples that are left of a polyline, after Ramer 1972 and Douglas and Peucker 1973.
fn straightened(piece: &[Sample], off_mm: f64) -> Vec<usize> {
    let Some(last) = piece.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![0, last];
    let mut spans = vec![(0, last)];
    while let Some((a, b)) = spans.pop() {
        let (from, to) = (piece[a].position, piece[b].position);
        let way = to - from;
        let off = |i: &usize| {
            let p = piece[*i].position - from;
            let t = (p.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            p.distance(way * t)
        };
        let furthest = (a + 1..b).map(|i| (off(&i), i)).max_by(|x, y| x.0.total_cmp(&y.0));
        if let Some((_, i)) = furthest.filter(|(off, _)| *off > off_mm) {
            kept.push(i);
            spans.extend([(a, i), (i, b)]);
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}
