//! Smallest, largest, sum and NaN count of values, in one pass and in exact or compensated sums.

use crate::io::error::IoError;
use crate::io::progress::Progress;
use crate::volume::{BrickSource, Statistics, Total, Value, Voxels};
use crate::with_voxels;
use rayon::prelude::*;

/// Of one component of one frame, after slope and intercept; read slab by slab.
///
/// # Errors
/// If the source fails, or `progress` said no.
pub fn statistics(source: &dyn BrickSource, progress: Progress<'_>) -> Result<Statistics, IoError> {
    let [nx, ny, nz] = source.grid().dims;
    let thick = (SLAB_VOXELS / (u64::from(nx) * u64::from(ny))).clamp(1, u64::from(nz)) as u32;
    let slabs: Vec<u32> = (0..nz).step_by(thick as usize).collect();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let scaling = source.scaling();
    let parts = slabs
        .par_iter()
        .map(|&z| {
            let before = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if !progress(before as f32 / slabs.len() as f32) {
                return Err(IoError::Cancelled { file: source.name().into() });
            }
            let mut sum = Accumulator::new(scaling);
            sum.add(&source.read([0, 0, z], [nx, ny, thick.min(nz - z)])?);
            Ok(sum)
        })
        .collect::<Result<Vec<_>, IoError>>()?;
    let mut all = Accumulator::new(scaling);
    parts.iter().for_each(|p| all.merge(p));
    Ok(all.finish())
}

/// Voxels read at once.
const SLAB_VOXELS: u64 = 1 << 21;

/// Voxels whose sum as f64 is exact for integers of up to 32 bits: 2¹⁸ · 2³² < 2⁵³.
const EXACT_RUN: usize = 1 << 18;

/// Gathers stored voxels of one type. Integers are summed as such and scaled at the end; fractions are scaled first and
/// summed with compensation, and so are integers whose scaled values `f64` may not hold.
#[derive(Debug)]
pub(super) struct Accumulator {
    scaling: (f64, f64),
    min: f64,
    max: f64,
    integers: i128,
    /// Least and greatest of 64-bit integers.
    long: Option<[i128; 2]>,
    count: u64,
    sum: Total,
    nan_count: u64,
    infinite_count: u64,
}

impl Accumulator {
    pub(super) fn new(scaling: (f64, f64)) -> Self {
        Self {
            scaling,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            integers: 0,
            long: None,
            count: 0,
            sum: Total::default(),
            nan_count: 0,
            infinite_count: 0,
        }
    }

    pub(super) fn add(&mut self, voxels: &Voxels) {
        let (slope, intercept) = self.scaling;
        let fits = |limits: [f64; 2]| limits.iter().all(|stored| (stored * slope + intercept).is_finite());
        match voxels {
            other if !other.voxel_type().limits().is_some_and(fits) => with_voxels!(other, v => self.add_fractions(v)),
            Voxels::U64(v) => self.add_long(v.iter().map(|&x| i128::from(x))),
            Voxels::I64(v) => self.add_long(v.iter().map(|&x| i128::from(x))),
            integers => with_voxels!(integers, v => self.add_integers(v)),
        }
    }

    fn add_integers<T: Value>(&mut self, voxels: &[T]) {
        for run in voxels.chunks(EXACT_RUN) {
            let (mut min, mut max, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
            for x in run {
                let x = x.to_f64();
                min = if x < min { x } else { min };
                max = if x > max { x } else { max };
                sum += x;
            }
            self.min = self.min.min(min);
            self.max = self.max.max(max);
            self.integers += sum as i128;
            self.count += run.len() as u64;
        }
    }

    fn add_long(&mut self, voxels: impl Iterator<Item = i128>) {
        for x in voxels {
            let [min, max] = self.long.unwrap_or([x, x]);
            self.long = Some([min.min(x), max.max(x)]);
            self.integers += x;
            self.count += 1;
        }
    }

    fn add_fractions<T: Value>(&mut self, voxels: &[T]) {
        let (slope, intercept) = self.scaling;
        for x in voxels {
            let x = x.to_f64() * slope + intercept;
            if x.is_finite() {
                self.min = if x < self.min { x } else { self.min };
                self.max = if x > self.max { x } else { self.max };
                self.sum.add(x);
            } else {
                self.nan_count += u64::from(x.is_nan());
                self.infinite_count += u64::from(x.is_infinite());
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        self.integers += other.integers;
        self.long = match (self.long, other.long) {
            (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
            (a, b) => a.or(b),
        };
        self.count += other.count;
        self.sum.merge(&other.sum);
        self.nan_count += other.nan_count;
        self.infinite_count += other.infinite_count;
    }

    pub(super) fn finish(&self) -> Statistics {
        // Integers are still unscaled, fractions are not; a file has one or the other.
        let (slope, intercept) = if self.count > 0 { self.scaling } else { (1.0, 0.0) };
        let [least, greatest] = self.long.map_or([self.min, self.max], |ends| ends.map(|n| n as f64));
        let (a, b) = (least * slope + intercept, greatest * slope + intercept);
        let (min, max) = if least > greatest { (f64::NAN, f64::NAN) } else { (a.min(b), a.max(b)) };
        let integers = self.integers as f64 * slope + intercept * self.count as f64;
        let exact = self.long.filter(|_| self.scaling == (1.0, 0.0)).map(|[min, max]| [min, max, self.integers]);
        Statistics {
            min,
            max,
            sum: integers + self.sum.value(),
            nan_count: self.nan_count,
            infinite_count: self.infinite_count,
            exact,
        }
    }
}
