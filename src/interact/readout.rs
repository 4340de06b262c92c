//! Numbers as a person reads them in passing: lengths of scale bars, values under the pointer.

/// The largest 1, 2 or 5 × 10ⁿ that is not longer.
pub fn round_length(mm: f64) -> f64 {
    let power = 10.0_f64.powf(mm.log10().floor());
    [5.0, 2.0].into_iter().map(|m| m * power).find(|&l| l <= mm).unwrap_or(power)
}

/// Six digits at most: a status line is read in passing.
pub fn short(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 {
        format!("{value:.0}")
    } else if (1e-3..1e6).contains(&value.abs()) {
        let decimals = (5 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.4e}")
    }
}
