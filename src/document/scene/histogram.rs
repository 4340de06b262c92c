//! From a source's values to the histogram that the first window and transfer function are made from.
//!
//! Its range leaves out what would squeeze all else together: values that are written where nothing was measured, and a few
//! voxels far from all others. Tells label maps from measurements. Costs one pass over the voxels, and one or two more where
//! something is left out. What is left out stays in the statistics, the map of texels and the voxels.

use crate::document::error::DocumentError;
use crate::document::scene::outliers::{Bucket, robust};
use crate::volume::{BrickSource, Histogram, Statistics, Value, unit};
use crate::with_voxels;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Most bins of a histogram.
const BINS: u64 = 1024;
/// Steps between integers that are counted one by one.
const MOST_STEPS: f64 = 9_007_199_254_740_992.0;
/// Voxels read at once.
const SLAB_VOXELS: u64 = 1 << 20;
/// Most different values of what is taken for a label map.
const MOST_IDS: usize = 256;
/// Of a range that shrinks to more than that it is not worth counting again.
const WORTH: f64 = 0.95;
/// Bins that all that matters fills at least, or too little is known of it.
const TELLING: usize = 16;

/// Counts of finite values. Integers lie in the middle of bins of equally many values each, so that no bin stands out for its
/// width.
///
/// # Errors
/// If the source fails or `progress` said no.
pub(crate) fn histogram(
    source: &dyn BrickSource,
    statistics: &Statistics,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Histogram, DocumentError> {
    let (min, max) = (statistics.min, statistics.max);
    if !(min.is_finite() && max.is_finite()) {
        return Ok(Histogram { min: 0.0, max: 1.0, bins: vec![0], ..Histogram::default() });
    }
    let passes = AtomicUsize::new(0);
    // Half of what is left for each pass: how many there will be is not known.
    let told = |x: f32| progress(1.0 - 0.5_f32.powi(passes.load(Ordering::Relaxed) as i32) * (1.0 - 0.5 * x));
    let mut bins = Bins::over(source, [min, max]);
    let mut tally = bins.count(source, min, &told)?;
    if let Some(ids) = tally.ids() {
        return Ok(Histogram { ids, ..bins.histogram(tally.counts) });
    }
    let mut buckets = bins.buckets(&tally.counts, [min, max]);
    let mut voids = [0; 2];
    while passes.fetch_add(1, Ordering::Relaxed) < 6 {
        let (mut kept, mut found) = robust(source, &buckets);
        if kept.len() < TELLING && buckets.len() > 1 && bins.half_width() > 0.0 {
            let inside = buckets[kept.start].lo..=buckets[kept.end - 1].hi;
            // Of the whole range only once; what is left out by now stays out.
            let within = if passes.load(Ordering::Relaxed) == 1 { min..=max } else { inside };
            buckets = sketch(source, &within, &told)?;
            (kept, found) = robust(source, &buckets);
            passes.fetch_add(1, Ordering::Relaxed);
        }
        (0..2).for_each(|end| voids[end] += found[end]);
        let next = Bins::over(source, [buckets[kept.start].lo, buckets[kept.end - 1].hi]);
        if next.half_width() > WORTH * bins.half_width() {
            break;
        }
        bins = next;
        tally = bins.count(source, min, &told)?;
        buckets = bins.buckets(&tally.counts, [bins.lo, bins.hi]);
    }
    Ok(Histogram { voids, ..bins.histogram(tally.counts) })
}

/// Equal bins over a range.
struct Bins {
    lo: f64,
    hi: f64,
    count: u64,
}

impl Bins {
    fn over(source: &dyn BrickSource, [min, max]: [f64; 2]) -> Self {
        // Where integers lie too far apart to be told one by one in f64, they are spread like numbers with a fraction.
        let unit = unit(source);
        let steps = unit.map(|unit| ((max - min) / unit).round()).filter(|&steps| steps < MOST_STEPS);
        match (unit, steps) {
            (Some(unit), Some(steps)) => {
                let values = steps as u64 + 1;
                let per_bin = values.div_ceil(BINS);
                let (lo, count) = (min - unit * 0.5, values.div_ceil(per_bin));
                Self { lo, hi: lo + unit * (per_bin * count) as f64, count }
            }
            _ if max > min => Self { lo: min, hi: max, count: BINS },
            _ => {
                // One value, in the middle of its bin.
                let half = (min.abs() * 1e-6).max(0.5);
                Self { lo: (min - half).max(f64::MIN), hi: (min + half).min(f64::MAX), count: 1 }
            }
        }
    }

    /// Half of the range: all of it may be beyond all numbers.
    fn half_width(&self) -> f64 {
        self.hi * 0.5 - self.lo * 0.5
    }

    /// Counts values inside the range, and looks whether they may be ids. `least` is the smallest of all.
    fn count(
        &self,
        source: &dyn BrickSource,
        least: f64,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Tally, DocumentError> {
        // Halves, since the distance of two numbers may be beyond all numbers; no less than f64 has a reciprocal of.
        let bins = self.count as f64;
        let half_bin = (self.hi / bins * 0.5 - self.lo / bins * 0.5).max(f64::MIN_POSITIVE);
        let (per_half, half_lo, last) = (1.0 / half_bin, self.lo * 0.5, self.count as usize - 1);
        let bin_of = |value: f64| {
            let inside = value >= self.lo && value <= self.hi;
            inside.then(|| (((value * 0.5 - half_lo) * per_half).max(0.0) as usize).min(last))
        };
        fn count<T: Value>(
            voxels: &[T],
            steps: [usize; 2],
            (slope, intercept): (f64, f64),
            bin_of: impl Fn(f64) -> Option<usize>,
            least: f64,
            tally: &mut Tally,
        ) {
            let value_of = |i: usize| voxels[i].to_f64() * slope + intercept;
            for i in 0..voxels.len() {
                let value = value_of(i);
                if let Some(bin) = bin_of(value) {
                    tally.counts[bin] += 1;
                }
                if tally.likely {
                    let before = |step: usize| if i >= step { value_of(i - step) } else { f64::NAN };
                    tally.look(value, steps.map(before), least);
                }
            }
        }
        // Neighbours along the first two axes that have any.
        let [nx, ny, _] = source.grid().dims.map(|n| n as usize);
        let long = [(nx, 1), (ny, nx), (2, nx * ny)].into_iter().filter(|(n, _)| *n > 1).map(|(_, step)| step);
        let long: Vec<usize> = long.collect();
        let steps = [long[0], long.get(1).copied().unwrap_or(long[0])];
        let empty = || Tally { counts: vec![0; self.count as usize], likely: true, ..Tally::default() };
        over_slabs(source, progress, empty, |tally, voxels| {
            with_voxels!(voxels, v => count(v, steps, source.scaling(), bin_of, least, tally));
        })
    }

    /// The bins that hold anything; the outer ends are those of the values, as far as they are known.
    fn buckets(&self, counts: &[u64], [min, max]: [f64; 2]) -> Vec<Bucket> {
        let edge = |i: usize| {
            let share = i as f64 / counts.len() as f64;
            (self.lo * (1.0 - share) + self.hi * share).clamp(min, max)
        };
        let held = counts.iter().enumerate().filter(|(_, n)| **n > 0);
        held.map(|(i, &count)| Bucket { lo: edge(i), hi: edge(i + 1), count }).collect()
    }

    fn histogram(&self, bins: Vec<u64>) -> Histogram {
        Histogram { min: self.lo, max: self.hi, bins, ..Histogram::default() }
    }
}

/// What one pass gathers.
#[derive(Default)]
struct Tally {
    counts: Vec<u64>,
    /// Whether all so far may be ids: whole numbers from 0 on, few different ones.
    likely: bool,
    /// Different values, rising.
    values: Vec<f64>,
    /// Neighbours along a row and across that are alike, but for the background; that differ; that differ by 1.
    same: [u64; 2],
    other: [u64; 2],
    next: [u64; 2],
}

impl Tally {
    fn look(&mut self, value: f64, neighbours: [f64; 2], least: f64) {
        // A value that is none is no id either, but a label map in floats may have it.
        if !value.is_finite() {
            return;
        }
        for (way, neighbour) in neighbours.into_iter().enumerate() {
            if neighbour == value {
                self.same[way] += u64::from(value != least);
            } else if neighbour.is_finite() {
                self.other[way] += 1;
                self.next[way] += u64::from((neighbour - value).abs() == 1.0);
            }
        }
        if neighbours[0] == value {
            return;
        }
        if let Err(at) = self.values.binary_search_by(|v| v.total_cmp(&value)) {
            self.values.insert(at, value);
        }
        self.likely = value >= 0.0 && value.fract() == 0.0 && self.values.len() <= MOST_IDS;
    }

    fn merge(mut self, other: Self) -> Self {
        self.counts.iter_mut().zip(other.counts).for_each(|(a, b)| *a += b);
        self.likely &= other.likely;
        self.values.extend(other.values);
        self.values.sort_unstable_by(f64::total_cmp);
        self.values.dedup();
        for way in 0..2 {
            self.same[way] += other.same[way];
            self.other[way] += other.other[way];
            self.next[way] += other.next[way];
        }
        self
    }

    /// The ids of a label map. Its values stand in runs, and jump where a run ends; in a smooth picture of few greys they go
    /// up and down by one.
    fn ids(&self) -> Option<Vec<f64>> {
        let count = self.values.len();
        let runs = (0..2).all(|way| self.same[way] as f64 >= 0.6 * (self.same[way] + self.other[way]) as f64);
        let jumps = (0..2).all(|way| self.next[way] as f64 <= 0.8 * self.other[way] as f64);
        let labels = count <= 2 || runs && (count <= 8 || jumps);
        (self.likely && (2..=MOST_IDS).contains(&count) && labels).then(|| self.values.clone())
    }
}

/// Counts in buckets a sixteenth of their values wide, with the smallest and the largest of each: near enough of numbers of
/// any size.
fn sketch(
    source: &dyn BrickSource,
    within: &std::ops::RangeInclusive<f64>,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Vec<Bucket>, DocumentError> {
    const EMPTY: Bucket = Bucket { lo: f64::INFINITY, hi: f64::NEG_INFINITY, count: 0 };
    fn count<T: Value>(
        voxels: &[T],
        (slope, intercept): (f64, f64),
        within: &std::ops::RangeInclusive<f64>,
        buckets: &mut [Bucket],
    ) {
        for v in voxels {
            let value = v.to_f64() * slope + intercept;
            if within.contains(&value) {
                // Sign, exponent and four digits, in the order of the numbers.
                let bits = value.to_bits();
                let key = if bits >> 63 == 1 { !bits } else { bits | 1 << 63 };
                let bucket = &mut buckets[(key >> 48) as usize];
                *bucket = Bucket { lo: bucket.lo.min(value), hi: bucket.hi.max(value), count: bucket.count + 1 };
            }
        }
    }
    let all = over_slabs(
        source,
        progress,
        || Sketch(vec![EMPTY; 1 << 16]),
        |sketch, voxels| {
            with_voxels!(voxels, v => count(v, source.scaling(), within, &mut sketch.0));
        },
    )?;
    Ok(all.0.into_iter().filter(|b| b.count > 0).collect())
}

struct Sketch(Vec<Bucket>);

/// What parts of a volume gather and a whole is made of.
trait Gathered: Send {
    fn with(self, other: Self) -> Self;
}

impl Gathered for Tally {
    fn with(self, other: Self) -> Self {
        self.merge(other)
    }
}

impl Gathered for Sketch {
    fn with(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = Bucket { lo: a.lo.min(b.lo), hi: a.hi.max(b.hi), count: a.count + b.count };
        }
        self
    }
}

/// One pass over the voxels, slab by slab on all threads.
fn over_slabs<T: Gathered>(
    source: &dyn BrickSource,
    progress: &(dyn Fn(f32) -> bool + Sync),
    empty: impl Fn() -> T + Sync + Send,
    take: impl Fn(&mut T, &crate::volume::Voxels) + Sync,
) -> Result<T, DocumentError> {
    let [nx, ny, nz] = source.grid().dims;
    let thick = (SLAB_VOXELS / (u64::from(nx) * u64::from(ny)).max(1)).clamp(1, u64::from(nz)) as u32;
    let slabs: Vec<u32> = (0..nz).step_by(thick as usize).collect();
    let done = AtomicUsize::new(0);
    slabs
        .par_iter()
        .try_fold(&empty, |mut gathered, &z| {
            if !progress(done.fetch_add(1, Ordering::Relaxed) as f32 / slabs.len() as f32) {
                return Err(DocumentError::Stopped);
            }
            take(&mut gathered, &source.read([0, 0, z], [nx, ny, thick.min(nz - z)])?);
            Ok(gathered)
        })
        .try_reduce(&empty, |a, b| Ok(a.with(b)))
}
