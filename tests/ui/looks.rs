//! What is read: contrast of the theme, lengths and values as text.

use burin::interact::readout::{LengthUnit, field, fixed, length, place, round_length, short};
use burin::ui::style::theme::{
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

#[test]
fn lengths_are_told_in_the_unit_of_the_voxels() {
    for (voxel, at, text) in [
        (1.0, [-90.5, 0.0, 1234.25], "  -90.5     0.0  1234.2 mm"),
        (0.957, [1.0, 2.0, 3.0], "    1.0     2.0     3.0 mm"),
        (0.3, [1.0, -2.125, 3.0], "    1.00    -2.12     3.00 mm"),
        (0.03, [0.015, 0.0, 0.0], "    0.015     0.000     0.000 mm"),
        (1e-3, [1.5e-3, 0.25, 0.0], "    1.5   250.0     0.0 µm"),
        (4e-6, [1.6e-5, 0.0, -4e-6], "   16.0     0.0    -4.0 nm"),
        (1000.0, [2000.0, 0.0, -500.0], "    2.0     0.0    -0.5 m"),
    ] {
        assert_eq!(place(at.into(), voxel), text, "voxels of {voxel} mm");
    }
    for power in -12..8 {
        let voxel = 10_f64.powi(power);
        let LengthUnit { per_mm, decimals, .. } = LengthUnit::of(voxel);
        let tenth = format!("{:.1$}", voxel * per_mm / 10.0, decimals).parse::<f64>().unwrap();
        assert!(tenth > 0.0 || power < -11, "a tenth of a voxel of {voxel} mm is told from none");
    }
}

#[test]
fn a_number_of_a_field_has_room_in_it_and_keeps_what_matters() {
    let shown =
        [(10.0, 1, 7), (1234.5, 1, 7), (1_234_567.8, 1, 7), (0.001, 1, 7), (-12_345_678.0, 0, 7), (1e-20, 2, 5)];
    assert_eq!(shown.map(|(x, d, n)| fixed(x, d, n)), ["10.0", "1234.5", "1234568", "0.0", "-1.23e7", "0.00"]);
    // A value, the span of the data, the room.
    for (value, span, chars, text) in [
        (89.0, 254.0, 7, "89"),
        (0.1, 254.0, 7, "0.1"),
        (169.5, 4000.0, 7, "169.5"),
        (0.123_456_7, 1.0, 9, "0.12346"),
        (2e-5, 1e-4, 9, "0.00002"),
        (-1024.0, 4095.0, 5, "-1024"),
        (1.5e9, 1e9, 6, "1.50e9"),
        (4.83e-7, 1e-6, 7, "4.83e-7"),
        (4.83e-7, 1e-6, 11, "0.000000483"),
        (0.000_05, 1e-4, 6, "5.0e-5"),
        (f64::INFINITY, f64::NAN, 6, "inf"),
    ] {
        assert_eq!(field(value, span, chars), text, "{value} of {span}");
    }
    for value in [1.0 / 3.0, -123_456.789, 1e-7, 65_535.0, 1e300, -1e-300] {
        for chars in 5..12 {
            assert!(
                field(value, 1.0, chars).chars().count() <= chars.max(6),
                "{value} in {chars}: {}",
                field(value, 1.0, chars)
            );
        }
    }
}

#[test]
fn a_length_is_said_in_its_own_unit() {
    for (mm, text) in [
        (2000.0, "2 m"),
        (50.0, "5 cm"),
        (2.0, "2 mm"),
        (0.5, "0.5 mm"),
        (0.05, "50 µm"),
        (0.000_5, "0.5 µm"),
        (0.000_02, "20 nm"),
    ] {
        assert_eq!(length(mm), text);
    }
}
