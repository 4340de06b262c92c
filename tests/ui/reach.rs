//! How far a brush's press reaches, against the falloffs themselves.

use burin::interact::reach;
use burin::paint::{Brush, Falloff, Target};

#[test]
fn a_label_reaches_to_where_coverage_is_a_half() {
    for falloff in [Falloff::Hard, Falloff::Linear, Falloff::Smooth] {
        let coverage = |x: f64| match falloff {
            Falloff::Hard => 1.0,
            Falloff::Linear => 1.0 - x,
            Falloff::Smooth => (1.0 - x * x).powi(2),
        };
        for strength in [0.2_f32, 0.5, 0.75, 1.0] {
            let brush = Brush { falloff, strength, target: Target::Label(3), ..Brush::default() };
            let takes = |x: f64| coverage(x) * f64::from(strength) >= 0.5;
            let farthest = (0..=10_000).map(|i| f64::from(i) / 10_000.0).filter(|&x| takes(x)).fold(0.0, f64::max);
            assert!((reach(&brush) - farthest).abs() < 2e-4, "{falloff:?} {strength}: {} {farthest}", reach(&brush));
            let soft = Brush { target: Target::Selection(1.0), ..brush };
            assert_eq!(reach(&soft), 1.0);
        }
    }
}
