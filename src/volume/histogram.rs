//! Counts of a volume's values, and what they say of it: shares and two classes.

use crate::volume::voxels::Statistics;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Counts of values in equal bins over `[min, max]`; a few values far from all others, and those that stand where nothing was
/// measured, lie outside and are not counted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// Value at the lower edge of the first bin.
    pub min: f64,
    /// Value at the upper edge of the last bin.
    pub max: f64,
    /// Voxels per bin.
    pub bins: Vec<u64>,
    /// Of a label map its values, rising; otherwise empty.
    #[serde(default)]
    pub ids: Vec<f64>,
    /// Voxels below and above the range that stand where nothing was measured.
    #[serde(default)]
    pub voids: [u64; 2],
}

/// What is known of all values of a volume.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Ends, sum and what is no number.
    pub statistics: Statistics,
    /// Counts.
    pub histogram: Histogram,
}

/// The two classes of greatest distance (Otsu 1979).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Classes {
    /// First bin of the upper class.
    pub upper: usize,
    /// Mean of the lower class, in bins, and its standard deviation.
    pub lower: [f64; 2],
}

impl Histogram {
    /// Width of a bin; finite also where `max − min` is not.
    pub fn bin_width(&self) -> f64 {
        let bins = self.bins.len().max(1) as f64;
        self.max / bins - self.min / bins
    }

    /// The value that lies so many bins above the lower edge of the first.
    pub fn value_at(&self, bins: f64) -> f64 {
        let share = bins / self.bins.len().max(1) as f64;
        self.min * (1.0 - share) + self.max * share
    }

    /// The only value there is, or the middle of the only bin that holds any.
    pub fn constant(&self) -> Option<f64> {
        let mut held = self.bins.iter().enumerate().filter(|(_, n)| **n > 0).map(|(i, _)| i);
        let only = held.next().filter(|_| held.next().is_none())?;
        Some(self.value_at(only as f64 + 0.5))
    }

    /// How many bins above the lower edge of the first the value lies below which there is a share (0..1) of the counts of some
    /// bins.
    pub fn share_below(&self, bins: Range<usize>, share: f64) -> f64 {
        let total: u64 = self.bins[bins.clone()].iter().sum();
        let wanted = total as f64 * share;
        let mut seen = 0;
        for i in bins.clone() {
            let before = seen;
            seen += self.bins[i];
            if self.bins[i] > 0 && seen as f64 >= wanted {
                return i as f64 + ((wanted - before as f64) / self.bins[i] as f64).clamp(0.0, 1.0);
            }
        }
        bins.end as f64
    }

    /// The two classes; none of one value.
    pub fn classes(&self) -> Option<Classes> {
        let total: f64 = self.bins.iter().map(|&n| n as f64).sum();
        let mean: f64 = self.bins.iter().enumerate().map(|(i, &n)| i as f64 * n as f64).sum();
        let (mut below, mut below_mean, mut best, mut upper) = (0.0, 0.0, -1.0, 0);
        for (i, &n) in self.bins.iter().enumerate() {
            below += n as f64;
            below_mean += i as f64 * n as f64;
            let above = total - below;
            if below > 0.0 && above > 0.0 {
                let distance = below_mean / below - (mean - below_mean) / above;
                let score = below * above * distance * distance;
                // In the middle of a gap, which all of its bins divide alike.
                if score > best {
                    (best, upper) = (score, i + 1);
                }
            }
        }
        let gap = self.bins[upper..].iter().take_while(|n| **n == 0).count();
        let upper = upper + gap / 2;
        let lower = || self.bins[..upper].iter().enumerate().map(|(i, &n)| (i as f64 + 0.5, n as f64));
        let count: f64 = lower().map(|(_, n)| n).sum();
        let middle = lower().map(|(i, n)| i * n).sum::<f64>() / count;
        let variance = lower().map(|(i, n)| (i - middle) * (i - middle) * n).sum::<f64>() / count;
        (best > 0.0).then_some(Classes { upper, lower: [middle, variance.sqrt()] })
    }

    /// Where the background ends and matter begins, in bins above the lower edge of the first: between the edge of the lower class
    /// and the upper class. 0 if all is of one class.
    pub fn clear(&self) -> f64 {
        self.classes().map_or(0.0, |Classes { upper, lower: [mean, deviation] }| {
            0.5 * ((mean + 2.0 * deviation).min(upper as f64) + upper as f64)
        })
    }
}
