//! Falloffs that brushes are tried with.

use burin::paint::{Falloff, FalloffCurve};

/// Every falloff, one of them drawn.
pub fn falloffs() -> [Falloff; 5] {
    let curve = FalloffCurve::new(&DRAWN).unwrap();
    [Falloff::Hard, Falloff::Linear, Falloff::Smooth, Falloff::Gaussian, Falloff::Curve(curve)]
}

/// A falloff that rises and falls: x and F.
pub const DRAWN: [[f32; 2]; 4] = [[0.0, 0.4], [0.3, 1.0], [0.55, 0.2], [1.0, 0.7]];

/// F of it, between its points.
pub fn drawn(x: f64) -> f64 {
    let [a, b, c, d] = DRAWN.map(|p| p.map(f64::from));
    let along = |p: [f64; 2], q: [f64; 2]| p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1]);
    if x < b[0] {
        along(a, b)
    } else if x < c[0] {
        along(b, c)
    } else {
        along(c, d)
    }
}
