//! Which values say nothing of the others: those that are written where nothing was measured, and a few far from all.
//!
//! Judges counts of values, as fine as they are; knows the source for its type alone.

use crate::volume::BrickSource;
use std::ops::Range;

/// Voxels far from all others that are few: one of so many, or so many in all.
const FEW: (u64, u64) = (10_000, 8);
/// How far is far, in distances between the first and the last hundredth of the values.
const FAR: f64 = 2.0;
/// Share of the variance that lies between two classes of values where there are two; of one normal class it is 0.64.
const TWO_CLASSES: f64 = 0.75;
/// Values beyond are no measurements.
const BEYOND: f64 = 1e18;

/// Values near one another.
#[derive(Clone, Copy)]
pub(crate) struct Bucket {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
    pub(crate) count: u64,
}

/// The buckets that matter: without those at the ends that stand for nothing measured, or hold a few values far from all others;
/// and how many values below and above stand for nothing.
pub(crate) fn robust(source: &dyn BrickSource, buckets: &[Bucket]) -> (Range<usize>, [u64; 2]) {
    let mut kept = 0..buckets.len();
    let mut voids = [0; 2];
    while kept.len() > 1 {
        let (first, last) = (kept.start, kept.end - 1);
        // Among the others may be what stands for nothing at the other end.
        let [without_first, without_last] = match kept.len() {
            2 => [last..kept.end, first..last],
            _ => [first + 1..last, first + 1..last],
        };
        let below = buckets[first + 1].lo - buckets[first].hi;
        let above = buckets[last].lo - buckets[last - 1].hi;
        if is_nothing(source, buckets[first].lo, below, &buckets[without_first]) {
            voids[0] += buckets[first].count;
            kept.start += 1;
        } else if is_nothing(source, buckets[last].hi, above, &buckets[without_last]) {
            voids[1] += buckets[last].count;
            kept.end -= 1;
        } else {
            break;
        }
    }
    let all = &buckets[kept.clone()];
    let width = spread(all);
    if width > 0.0 {
        let [lo, hi] = ends(all, None);
        let few = (all.iter().map(|b| b.count).sum::<u64>() / FEW.0).max(FEW.1);
        let outer = |beyond: &dyn Fn(&Bucket) -> bool, mut buckets: Box<dyn Iterator<Item = &Bucket> + '_>| {
            let (mut buckets_beyond, mut values) = (0, 0);
            while let Some(bucket) = buckets.next().filter(|b| beyond(b)) {
                buckets_beyond += 1;
                values += bucket.count;
            }
            if values <= few { buckets_beyond } else { 0 }
        };
        kept.start += outer(&|b| b.hi < lo - FAR * width, Box::new(all.iter()));
        kept.end -= outer(&|b| b.lo > hi + FAR * width, Box::new(all.iter().rev()));
    }
    (kept, voids)
}

/// Whether an extreme value stands where nothing was measured: it is one that programs write for that, or beyond all measure,
/// and further from all others than these lie apart. 0 may be a value like any other; it is none where two classes of values
/// lie far above it, as air and matter do.
fn is_nothing(source: &dyn BrickSource, value: f64, gap: f64, others: &[Bucket]) -> bool {
    const WRITTEN: [f64; 6] = [-32_768.0, -999.0, -9999.0, -99_999.0, -999_999.0, -2_147_483_648.0];
    let spread = spread(others);
    if value.abs() >= BEYOND {
        return gap > 1e3 * spread.max(1.0);
    }
    let voxel_type = source.voxel_type();
    if voxel_type.bytes() == 1 || gap <= spread {
        return false;
    }
    let (slope, intercept) = source.scaling();
    let is = |end: f64| end != 0.0 && ((end * slope + intercept) - value).abs() <= slope.abs() * 0.5;
    let is_end = voxel_type.limits().is_some_and(|ends| ends.into_iter().any(is));
    let far = spread > 0.0 && gap > 1e6 * spread;
    is_end || far || WRITTEN.contains(&value) || (value == 0.0 && between_classes(others) > TWO_CLASSES)
}

/// Share of the values' variance that lies between the two classes of greatest distance (Otsu 1979).
fn between_classes(buckets: &[Bucket]) -> f64 {
    let at = |b: &Bucket| b.lo * 0.5 + b.hi * 0.5;
    let total: f64 = buckets.iter().map(|b| b.count as f64).sum();
    let mean = buckets.iter().map(|b| at(b) * (b.count as f64 / total)).sum::<f64>();
    let variance = buckets.iter().map(|b| (at(b) - mean).powi(2) * (b.count as f64 / total)).sum::<f64>();
    let (mut below, mut moment, mut most) = (0.0, 0.0, 0.0_f64);
    for bucket in buckets {
        below += bucket.count as f64 / total;
        moment += (at(bucket) - mean) * (bucket.count as f64 / total);
        if below > 0.0 && below < 1.0 {
            most = most.max(moment * moment / (below * (1.0 - below)));
        }
    }
    if variance > 0.0 { most / variance } else { 0.0 }
}

/// How far apart the values lie, the outer hundredths left aside; also of those that are not the commonest, if these are not few.
fn spread(buckets: &[Bucket]) -> f64 {
    let width = |[lo, hi]: [f64; 2]| hi - lo;
    let total: u64 = buckets.iter().map(|b| b.count).sum();
    let commonest = (0..buckets.len()).max_by_key(|&i| buckets[i].count);
    let others = commonest.filter(|&i| total - buckets[i].count > (total / FEW.0).max(FEW.1));
    width(ends(buckets, None)).max(others.map_or(0.0, |i| width(ends(buckets, Some(i)))))
}

/// The values at the first and the last hundredth, one bucket left out.
fn ends(buckets: &[Bucket], without: Option<usize>) -> [f64; 2] {
    let held = || buckets.iter().enumerate().filter(|(i, _)| Some(*i) != without).map(|(_, b)| b);
    let total: u64 = held().map(|b| b.count).sum();
    let at = |share: f64| {
        let mut seen = 0;
        held().find(|b| {
            seen += b.count;
            seen as f64 >= total as f64 * share
        })
    };
    [at(0.01).map_or(0.0, |b| b.lo), at(0.99).map_or(0.0, |b| b.hi)]
}
