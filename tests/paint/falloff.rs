use super::*;

fn read(json: &str) -> Result<Falloff, String> {
    serde_json::from_str(json).map_err(|error| error.to_string())
}

#[test]
fn a_bell_is_one_in_the_middle_and_nothing_at_the_rim() {
    assert_eq!(Falloff::Gaussian.at(0.0, 7.0), 1.0);
    assert!(Falloff::Gaussian.at(7.0, 7.0).abs() < 1e-15, "it does not jump at the support");
    assert_eq!(Falloff::Gaussian.at(7.1, 7.0), 0.0);
    // e^(−4.5) as ERRATA has it; the plain bell has 0.0111 left at the rim.
    let half = ((-1.125_f64).exp() - (-4.5_f64).exp()) / (1.0 - (-4.5_f64).exp());
    assert!((Falloff::Gaussian.at(3.5, 7.0) - half).abs() < 1e-15);
}

#[test]
fn a_drawn_falloff_is_written_and_read_as_its_points() {
    let json = r#"{"curve":[[0.0,1.0],[0.25,0.3],[1.0,0.0]]}"#;
    let falloff = read(json).unwrap();
    assert_eq!(serde_json::to_string(&falloff).unwrap(), json);
    assert!((falloff.at(0.125, 1.0) - (1.0 + 0.3_f32 as f64) / 2.0).abs() < 1e-7);
    assert_eq!(read("\"gaussian\"").unwrap(), Falloff::Gaussian);
    assert_eq!(read("\"smooth\"").unwrap(), Falloff::Smooth);
}

#[test]
fn a_curve_that_is_none_is_refused_by_name() {
    for (curve, said) in [
        ("[]", "2 to 12 points"),
        ("[[0,1]]", "2 to 12 points"),
        ("[[0,1],[0.5,1.2],[1,0]]", "[0.5, 1.2]"),
        ("[[0,1],[0.5,-0.1],[1,0]]", "[0.5, -0.1]"),
        ("[[0,1],[0.5,0.5],[0.5,0.2],[1,0]]", "x = 0.5 followed by x = 0.5"),
        ("[[0,1],[0.7,0.5],[0.4,0.2],[1,0]]", "x = 0.7 followed by x = 0.4"),
        ("[[0.1,1],[1,0]]", "x from 0.1 to 1"),
        ("[[0,1],[0.9,0]]", "x from 0 to 0.9"),
        ("[[0,1],[1e40,0]]", ""),
    ] {
        let error = read(&format!("{{\"curve\":{curve}}}")).unwrap_err();
        assert!(error.contains(said), "{curve}: {error}");
        assert!(said.is_empty() || error.contains("falloff.curve"), "{curve}: {error}");
    }
    let many: Vec<[f32; 2]> = (0..13).map(|i| [i as f32 / 12.0, 0.5]).collect();
    assert!(FalloffCurve::new(&many).is_err());
    assert!(FalloffCurve::new(&many[..12]).is_err(), "it ends before the rim");
    assert!(FalloffCurve::new(&(0..12).map(|i| [i as f32 / 11.0, 0.5]).collect::<Vec<_>>()).is_ok());
}

#[test]
fn a_hand_keeps_a_curve_a_curve() {
    let curve = FalloffCurve::new(&DRAWN).unwrap();
    let moved = curve.moved(1, [0.9, 3.0]);
    assert!(moved.points()[1][0] < 0.55 && moved.points()[1][1] == 1.0);
    assert_eq!(curve.moved(0, [0.4, 0.1]).points()[0], [0.0, 0.1]);
    assert_eq!(curve.moved(3, [0.4, 0.1]).points()[3], [1.0, 0.1]);
    assert_eq!(curve.with([0.8, 0.5]).without(3), curve);
    assert_eq!(curve.without(0), curve);
    assert_eq!(curve.with([0.3, 0.9]), curve, "one stands there");
    let mut full = curve;
    for i in 0..40 {
        full = full.with([0.015 * i as f32, 0.5]);
        assert!(FalloffCurve::new(full.points()).is_ok());
    }
    assert_eq!(full.points().len(), CURVE_POINTS);
    for falloff in falloffs() {
        assert!(FalloffCurve::new(FalloffCurve::of(falloff).points()).is_ok());
    }
}
