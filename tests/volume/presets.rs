//! Ready looks and the first surface: functions for any data, seen where they say.

use burin::volume::{Histogram, TransferFunction};

/// Counts of values by a density of our own over `[min, max]`.
fn histogram(min: f64, max: f64, count: impl Fn(f64) -> f64) -> Histogram {
    let at = |i: usize| min + (max - min) * (i as f64 + 0.5) / 512.0;
    Histogram { min, max, bins: (0..512).map(|i| count(at(i)) as u64).collect(), ..Histogram::default() }
}

fn peak(x: f64, centre: f64, width: f64) -> f64 {
    1e5 * (-((x - centre) / width).powi(2)).exp()
}

/// Air, fat, water, bone.
fn ct() -> Histogram {
    histogram(-1024.0, 3071.0, |x| {
        3.0 * peak(x, -1000.0, 30.0) + peak(x, -100.0, 40.0) + 2.0 * peak(x, 40.0, 60.0) + 0.2 * peak(x, 700.0, 400.0)
    })
}

/// Air, and matter about 100.
fn mr() -> Histogram {
    histogram(0.0, 255.0, |x| 4.0 * peak(x, 2.0, 5.0) + peak(x, 100.0, 30.0) + 0.1 * peak(x, 190.0, 30.0))
}

#[test]
fn ct_is_known_by_its_air_and_nothing_else_is_taken_for_it() {
    assert!(ct().is_hounsfield());
    // Padding below the scanner's circle is common.
    assert!(
        histogram(-3024.0, 3071.0, |x| peak(x, -3024.0, 5.0) + peak(x, -1000.0, 40.0) + peak(x, 40.0, 60.0))
            .is_hounsfield()
    );
    assert!(!mr().is_hounsfield());
    assert!(!histogram(0.0, 4095.0, |x| peak(x, 24.0, 30.0) + peak(x, 1064.0, 60.0)).is_hounsfield(), "not rescaled");
    assert!(!histogram(-1000.0, 1000.0, |x| peak(x, 0.0, 100.0)).is_hounsfield(), "differences about zero");
    assert!(!histogram(-32768.0, 32767.0, |x| peak(x, -1000.0, 50.0) + peak(x, 0.0, 50.0)).is_hounsfield());
}

#[test]
fn every_look_is_a_function_whatever_the_data_are() {
    let constant = |value: f64| Histogram { min: value, max: value, bins: vec![7], ..Histogram::default() };
    let odd = [
        ct(),
        mr(),
        constant(0.0),
        constant(-1000.0),
        constant(1e30),
        Histogram { min: 0.0, max: 1.0, bins: vec![5, 5], ..Histogram::default() },
        Histogram { min: 0.0, max: 1e-9, bins: vec![0; 64], ..Histogram::default() },
        Histogram { min: -1e30, max: 1e30, bins: vec![1; 512], ..Histogram::default() },
        Histogram { min: -1e308, max: 1.7e308, bins: vec![1; 512], ..Histogram::default() },
        Histogram { min: 1.6e308, max: f64::MAX, bins: vec![1; 512], ..Histogram::default() },
        Histogram { min: f64::MIN, max: f64::MAX, bins: vec![1; 512], ..Histogram::default() },
        Histogram { min: 0.0, max: 1e-310, bins: vec![1; 512], ..Histogram::default() },
        Histogram { min: 0.0, max: 5.0, bins: Vec::new(), ..Histogram::default() },
        histogram(-1024.0, 3071.0, |x| peak(x, -1000.0, 1.0)),
    ];
    for histogram in odd {
        let looks = TransferFunction::presets(&histogram, 0.5);
        assert!(looks.len() >= 4);
        for look in looks {
            look.function.check().unwrap_or_else(|e| panic!("{} of {histogram:?}: {e}", look.name));
            assert_eq!(look.function.unit_mm, 0.5);
            assert!(look.function.opacity.iter().any(|p| p.1 > 0.0), "{} shows nothing", look.name);
        }
        let first = TransferFunction::from_histogram(&histogram, 1.0).first_surface(&histogram);
        let reach = (histogram.max - histogram.min).max(1.0);
        assert!(
            first >= histogram.min - 1e-6 * reach && first <= histogram.max + 1e-6 * reach,
            "{first} of {histogram:?}"
        );
    }
}

#[test]
fn looks_of_ct_show_what_their_names_say() {
    let looks = TransferFunction::presets(&ct(), 1.0);
    let opacity = |name: &str, hu: f64| looks.iter().find(|l| l.name == name).unwrap().function.opacity_at(hu);
    // Air, lung, fat, muscle, spongy bone, compact bone (Hounsfield units).
    for (name, seen, clear) in [
        ("Skin", vec![-200.0, 50.0], vec![-1000.0, -500.0]),
        ("Soft tissue", vec![50.0], vec![-1000.0, -200.0]),
        ("Bone", vec![400.0, 1200.0], vec![-1000.0, -100.0, 50.0, 100.0]),
        ("Lung", vec![-800.0, -600.0], vec![-1000.0, -100.0, 50.0, 1000.0]),
        ("Bone in skin", vec![-100.0, 400.0], vec![-1000.0]),
    ] {
        seen.iter().for_each(|&hu| assert!(opacity(name, hu) > 0.01, "{name} at {hu}"));
        clear.iter().for_each(|&hu| assert_eq!(opacity(name, hu), 0.0, "{name} at {hu}"));
    }
    assert!(opacity("Bone in skin", 400.0) > 5.0 * opacity("Bone in skin", 0.0));
}

#[test]
fn looks_of_other_data_follow_how_the_values_are_spread() {
    for scale in [1.0, 257.0, 1e-4] {
        let small = mr();
        let histogram =
            Histogram { min: 0.0, max: small.max * scale, bins: small.bins.clone(), ..Histogram::default() };
        for look in TransferFunction::presets(&histogram, 1.0) {
            let at = |value: f64| look.function.opacity_at(value * scale);
            assert_eq!(at(2.0), 0.0, "{}: air is clear", look.name);
            assert!(at(240.0) > 0.0, "{}: the brightest is seen", look.name);
            assert_eq!(at(100.0) > 0.0, look.name != "Brightest", "{} in the middle", look.name);
        }
    }
}

#[test]
fn a_first_surface_lies_where_matter_begins_and_its_colour_is_light() {
    let luminance = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    for (histogram, begins, ends) in [(ct(), -700.0, 40.0), (mr(), 20.0, 120.0)] {
        let function = TransferFunction::from_histogram(&histogram, 1.0);
        let first = function.first_surface(&histogram);
        assert!((begins..ends).contains(&first), "{first}");
        let dark = function.opacity.iter().rfind(|p| p.1 <= 0.0).unwrap().0;
        assert!(
            luminance(function.colour_at(dark)) < luminance(function.colour_at(first)),
            "lighter than where opacity begins"
        );
        assert!(luminance(function.colour_at(first)) >= 0.33, "{:?}", function.colour_at(first));
    }
    // A function that begins almost black: its first surface lies as deep as it takes to be seen, and no deeper.
    let begins_dark = TransferFunction {
        colour: vec![(30.0, [0.2, 0.05, 0.05]), (110.0, [0.9, 0.8, 0.7])],
        opacity: vec![(30.0, 0.0), (110.0, 0.5)],
        unit_mm: 1.0,
    };
    let seen = luminance(begins_dark.colour_at(begins_dark.first_surface(&mr())));
    assert!((0.33..0.45).contains(&seen), "{seen}");
    let dark = TransferFunction {
        colour: vec![(0.0, [0.0; 3]), (255.0, [0.1; 3])],
        ..TransferFunction::from_histogram(&mr(), 1.0)
    };
    assert!((20.0..255.0).contains(&dark.first_surface(&mr())), "dark throughout: still within the matter");
}

#[test]
fn the_middle_and_the_top_of_a_look_are_the_least_edges_that_hold_their_share() {
    // Air in the first bin, and matter of which 1, 2, 3 or 4 stand in each of the others in turn.
    let mut bins: Vec<u64> = (0..512).map(|i| 100 * (i % 4 + 1)).collect();
    bins[0] = 1_000_000;
    for bins in [bins.clone(), bins.iter().map(|n| n.min(&1_000_000) / 100).collect()] {
        let histogram = Histogram { min: 0.0, max: 512.0, bins: bins.clone(), ..Histogram::default() };
        assert!(!histogram.is_hounsfield());
        let looks = TransferFunction::presets(&histogram, 1.0);
        let look = looks.iter().find(|l| l.name == "See-through").unwrap();
        let [clear, middle, top] = [0, 1, 2].map(|i| look.function.opacity[i].0);
        // Bin i ends at i + 1.
        let above = |limit: f64| {
            let counted = (0..512).filter(|&i| (i + 1) as f64 > clear && (i + 1) as f64 <= limit);
            counted.map(|i| bins[i]).sum::<u64>() as f64
        };
        let total = above(512.0);
        for (value, share) in [(middle, 0.5), (top, 0.99)] {
            assert!(above(value) >= total * share, "{value} holds {} of {total}", above(value));
            assert!(above(value - 1.0) < total * share, "{} would have done for {share}", value - 1.0);
            assert_eq!(value.fract(), 0.0, "an edge");
        }
    }
    // A share that falls on an edge ends there: a hundred bins of one, half of which lie below 51.
    let mut bins = vec![1; 101];
    bins[0] = 1_000_000;
    let histogram = Histogram { min: 0.0, max: 101.0, bins, ..Histogram::default() };
    let looks = TransferFunction::presets(&histogram, 1.0);
    let function = &looks.iter().find(|l| l.name == "See-through").unwrap().function;
    let clear = function.opacity[0].0;
    let first = (1..=101).find(|&edge| f64::from(edge) > clear).unwrap();
    let count = 101 - first + 1;
    let [middle, top] = [(count + 1) / 2, (count * 99 + 99) / 100].map(|n: i32| f64::from(first - 1 + n));
    // The edges of 101 bins are rounded.
    for (found, edge) in [(function.opacity[1].0, middle), (function.opacity[2].0, top)] {
        assert!((found - edge).abs() < 1e-9, "{found} for {edge}");
    }
}
