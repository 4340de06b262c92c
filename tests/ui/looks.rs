//! What is read: contrast of the theme, lengths and values as text.

use burin::interact::readout::{round_length, short};
use burin::ui::theme::{
    ACCENT, ACCENT_FILL, BAR, CONTROL, CONTROL_HOVER, DEEP, ERROR, PANEL, TEXT, TEXT_WEAK, WARNING,
};
use egui::Color32;

fn luminance(c: Color32) -> f64 {
    let linear = |b: u8| {
        let x = f64::from(b) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(c.r()) + 0.7152 * linear(c.g()) + 0.0722 * linear(c.b())
}

fn contrast(a: Color32, b: Color32) -> f64 {
    let (hi, lo) = (luminance(a).max(luminance(b)), luminance(a).min(luminance(b)));
    (hi + 0.05) / (lo + 0.05)
}

#[test]
fn text_stands_out_from_whatever_it_stands_on() {
    assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 0.01, "the formula's own fixed point");
    for ground in [PANEL, BAR, DEEP, CONTROL, CONTROL_HOVER] {
        for text in [TEXT, TEXT_WEAK] {
            let found = contrast(text, ground);
            // Weak text never stands on a hovered control.
            if !(text == TEXT_WEAK && ground == CONTROL_HOVER) {
                assert!(found >= 4.5, "{text:?} on {ground:?}: {found:.2}");
            }
        }
    }
    for text in [ERROR, WARNING, ACCENT] {
        assert!(contrast(text, PANEL) >= 4.5 && contrast(text, BAR) >= 4.5, "{text:?}");
    }
    assert!(contrast(Color32::WHITE, ACCENT_FILL) >= 4.5);
}

#[test]
fn scale_bars_are_one_two_or_five() {
    for (mm, bar) in [(90.0, 50.0), (49.0, 20.0), (10.0, 10.0), (0.7, 0.5), (1999.0, 1000.0), (2000.0, 2000.0)] {
        assert!((round_length(mm) - bar).abs() < 1e-9, "{mm}: {}", round_length(mm));
    }
}

#[test]
fn values_are_short_and_keep_six_digits() {
    let shown = [0.0, 255.0, -1024.0, 0.125, 1234.5678, 0.000_012, 12_345_678.9].map(short);
    assert_eq!(shown, ["0", "255", "-1024", "0.125000", "1234.57", "1.2000e-5", "1.2346e7"]);
}
