//! How far a brush's press reaches: to the rim, whatever the falloff.

use burin::interact::reach;
use burin::paint::{Brush, Falloff, Target};

#[test]
fn a_label_reaches_to_the_rim_if_it_is_strong_enough() {
    for falloff in [Falloff::Hard, Falloff::Linear, Falloff::Smooth] {
        for (strength, expected) in [(0.2_f32, 0.0), (0.499, 0.0), (0.5, 1.0), (0.75, 1.0), (1.0, 1.0)] {
            let brush = Brush { falloff, strength, target: Target::Label(3), ..Brush::default() };
            assert_eq!(reach(&brush), expected, "{falloff:?} {strength}");
            assert_eq!(reach(&Brush { target: Target::Selection(1.0), ..brush }), 1.0);
        }
    }
}
