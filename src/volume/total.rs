//! Sums of many numbers: to the last bits that `f64` has, and not lost where a part of them is beyond all numbers.

/// A sum with Neumaier's compensation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Total {
    sum: f64,
    lost: f64,
    /// Of numbers so large that a few of them leave `f64`, in units of [`HUGE`].
    huge: f64,
    huge_lost: f64,
}

/// 2⁹³⁰. Summed apart: fewer than 2⁶³ of all others stay within `f64`.
const HUGE: f64 = f64::from_bits((1023 + 930) << 52);

impl Total {
    /// Adds a number.
    pub fn add(&mut self, x: f64) {
        if x.abs() >= HUGE {
            compensated(&mut self.huge, &mut self.huge_lost, x / HUGE);
        } else {
            compensated(&mut self.sum, &mut self.lost, x);
        }
    }

    /// Adds what another sum has.
    pub fn merge(&mut self, other: &Self) {
        self.add(other.sum);
        self.lost += other.lost;
        compensated(&mut self.huge, &mut self.huge_lost, other.huge);
        self.huge_lost += other.huge_lost;
    }

    /// The sum; infinite if it is beyond all numbers.
    pub fn value(&self) -> f64 {
        // Once the sum has left f64, the compensation is NaN and no help.
        let lost = if self.lost.is_nan() { 0.0 } else { self.lost };
        (self.huge + self.huge_lost) * HUGE + self.sum + lost
    }
}

/// Adds a number to a sum, and what rounding lost of it to what was lost.
fn compensated(sum: &mut f64, lost: &mut f64, x: f64) {
    let total = *sum + x;
    *lost += if sum.abs() >= x.abs() { (*sum - total) + x } else { (x - total) + *sum };
    *sum = total;
}
