//! Sums of many numbers: to the last bits that `f64` has, and not lost where a part of them is beyond all numbers.

/// A sum with Neumaier's compensation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Total {
    sum: f64,
    lost: f64,
    /// Of numbers so large that a few of them leave `f64`, in units of [`HUGE`].
    huge: f64,
}

/// Summed apart: fewer than 2⁶³ of all others stay within `f64`.
const HUGE: f64 = 1e280;

impl Total {
    /// Adds a number.
    pub fn add(&mut self, x: f64) {
        if x.abs() >= HUGE {
            self.huge += x / HUGE;
            return;
        }
        let total = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() { (self.sum - total) + x } else { (x - total) + self.sum };
        self.sum = total;
    }

    /// Adds what another sum has.
    pub fn merge(&mut self, other: &Self) {
        self.add(other.sum);
        self.lost += other.lost;
        self.huge += other.huge;
    }

    /// The sum; infinite if it is beyond all numbers.
    pub fn value(&self) -> f64 {
        // Once the sum has left f64, the compensation is NaN and no help.
        let lost = if self.lost.is_nan() { 0.0 } else { self.lost };
        self.huge * HUGE + self.sum + lost
    }
}
