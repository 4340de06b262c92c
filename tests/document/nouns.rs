//! What each command does and says.

use super::maker::{labelled, run, state};
use crate::common::one::One;
use burin::document::{Document, DocumentError};
use burin::volume::FieldKind;

#[test]
fn nothing_open_is_said_and_not_a_crash() {
    let mut document = Document::new();
    for line in [
        r#"{"transfer":{"reset":{}}}"#,
        r#"{"view":{"orbit":{"azimuth_deg":1,"elevation_deg":0}}}"#,
        r#"{"brush":{"set":{"radius_mm":2}}}"#,
        r#"{"segment":{"set":{"id":1}}}"#,
        r#"{"selection":{"clear":{}}}"#,
        r#"{"history":{"undo":{}}}"#,
        r#"{"ask":{"volume":{}}}"#,
    ] {
        assert!(matches!(run(&mut document, line), Err(DocumentError::NothingOpen)), "{line}");
    }
}

#[test]
fn a_refused_command_names_field_found_and_expected() {
    let mut document = labelled();
    let said = |document: &mut Document, line: &str| run(document, line).unwrap_err().to_string();
    let before = document.state().unwrap().scene.clone();
    for (line, text) in [
        (r#"{"brush":{"set":{"radius_mm":-1}}}"#, "brush.radius_mm is -1; expected a finite length in mm, 0 or more"),
        (
            r#"{"brush":{"set":{"spacing":0.5}}}"#,
            "brush.spacing is 0.5; expected a share of the radius above 0 and at most 0.25",
        ),
        (r#"{"segment":{"set":{"id":0}}}"#, "id: 0 found, 1 to 65535; label 0 is unlabelled matter expected"),
        (r#"{"segment":{"remove":{"id":9}}}"#, "id: 9 found, a segment's id, one of [1, 2] expected"),
        (r#"{"view":{"window":{"level":1,"width":0}}}"#, "width: 0 found, a positive number expected"),
        (r#"{"view":{"scroll":{"view":"3d","voxels":1}}}"#, "view: 3d found, axial, coronal or sagittal expected"),
        (
            r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0.5]],"unit_mm":0}}}}"#,
            "transfer function: unit_mm: 0 found, a positive length expected",
        ),
    ] {
        assert_eq!(said(&mut document, line), text);
    }
    assert_eq!(document.state().unwrap().scene, before);
    assert_eq!(document.history().undo_names().len(), 0);
}

#[test]
fn removing_a_segment_empties_its_voxels_and_says_how_many() {
    let mut document = labelled();
    let count = |document: &mut Document| {
        run(document, r#"{"ask":{"field":{"field":"labels"}}}"#).unwrap()["voxels_by_label"].clone()
    };
    let before = count(&mut document);
    let answer = run(&mut document, r#"{"segment":{"remove":{"id":1}}}"#).unwrap();
    assert_eq!(answer["voxels_changed"], before["1"]);
    assert_eq!(answer["bricks_touched"], 1);
    assert_eq!(answer["step"], "Remove segment Segment 1");
    let after = count(&mut document);
    assert_eq!((&after["1"], &after["2"]), (&serde_json::Value::Null, &before["2"]));
    // A brick that holds nothing any more is no edit.
    assert_eq!(document.state().unwrap().one().field(FieldKind::Labels).edits().len(), 1);
}

#[test]
fn a_label_becomes_the_selection_and_nothing_else() {
    let mut document = labelled();
    run(&mut document, r#"{"selection":{"from_label":{"label":1}}}"#).unwrap();
    let labels = run(&mut document, r#"{"ask":{"field":{"field":"labels"}}}"#).unwrap();
    let selection = |d: &mut Document| run(d, r#"{"ask":{"field":{"field":"selection"}}}"#).unwrap();
    assert_eq!(selection(&mut document)["nonzero"], labels["voxels_by_label"]["1"]);
    run(&mut document, r#"{"selection":{"from_label":{"label":2}}}"#).unwrap();
    assert_eq!(selection(&mut document)["nonzero"], labels["voxels_by_label"]["2"]);
    run(&mut document, r#"{"selection":{"clear":{}}}"#).unwrap();
    assert_eq!(selection(&mut document)["nonzero"], 0);
}

#[test]
fn a_voxel_answers_with_its_own_numbers() {
    let mut document = labelled();
    let answer = run(&mut document, r#"{"ask":{"voxel":{"at":{"index":[40,3,2]}}}}"#).unwrap();
    assert_eq!(answer["density"], 3.0 * 40.0 + 5.0 * 3.0 + 7.0 * 2.0);
    assert_eq!(answer["voxel"], serde_json::json!([40, 3, 2]));
    let outside = run(&mut document, r#"{"ask":{"voxel":{"at":{"index":[-1,0,0]}}}}"#).unwrap();
    assert_eq!(outside["inside"], false);
    let sum = run(&mut document, r#"{"ask":{"field":{"field":"density"}}}"#).unwrap();
    assert_eq!(sum["sum"].as_f64().unwrap(), document.state().unwrap().one().statistics.sum);
}

#[test]
fn the_view_goes_back_by_its_own_past_and_undo_leaves_it_alone() {
    let mut document = Document::new();
    document.adopt(state());
    let camera = |d: &Document| d.state().unwrap().scene.views.camera;
    let start = camera(&document);
    run(&mut document, r#"{"history":{"begin":{}}}"#).unwrap();
    for _ in 0..3 {
        run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":10,"elevation_deg":0}}}"#).unwrap();
    }
    let end = run(&mut document, r#"{"history":{"end":{}}}"#).unwrap();
    assert_eq!(end["step"], serde_json::Value::Null);
    let turned = camera(&document);
    assert_ne!(turned, start);
    run(&mut document, r#"{"history":{"undo":{"steps":9}}}"#).unwrap();
    assert_eq!(camera(&document), turned);
    run(&mut document, r#"{"view":{"back":{}}}"#).unwrap();
    assert_eq!(camera(&document), start);
    run(&mut document, r#"{"view":{"forward":{}}}"#).unwrap();
    assert_eq!(camera(&document), turned);
}

#[test]
fn nothing_gets_lost_in_space() {
    let mut document = labelled();
    let scene = |d: &Document| d.state().unwrap().scene.clone();
    let before = scene(&document);
    let camera = |eye: &str, target: &str| {
        format!(
            r#"{{"view":{{"camera":{{"camera":{{"eye":{eye},"target":{target},"up":[0,0,1],"projection":{{"orthographic":{{"height_mm":9}}}}}}}}}}}}"#
        )
    };
    for (line, field) in [
        (camera("[1,2,1e30]", "[0,0,0]"), "camera.eye"),
        (camera("[1,2,3]", "[1e9,0,0]"), "camera.target"),
        (r#"{"view":{"pan":{"view":"3d","px":[1e308,0]}}}"#.into(), "camera.eye"),
        (r#"{"view":{"pan":{"view":"coronal","px":[1e30,0]}}}"#.into(), "px"),
        (r#"{"view":{"crosshair":{"at":{"index":[1e308,1e308,-1e308]}}}}"#.into(), "index"),
        (
            r#"{"part":{"move":{"id":1,"pose":{"rotation":[0,0,0,1],"translation":[100000,0,0]}}}}"#.into(),
            "pose: a part moved by 1e5 mm",
        ),
    ] {
        let text = run(&mut document, &line).unwrap_err().to_string();
        assert!(text.contains(field) && text.contains("expected"), "{line}: {text}");
        assert_eq!(scene(&document), before, "{line}");
    }
    for size in ["[0,9]", "[16385,1]", "[16384,16384]"] {
        let line = format!(r#"{{"view":{{"size":{{"view":"3d","size":{size}}}}}}}"#);
        let text = run(&mut document, &line).unwrap_err().to_string();
        assert!(text.contains("size: ") && text.contains("67108864 in all"), "{text}");
    }
    // Away, but in sight of itself: as far as it goes.
    let mut zoomed = 0;
    while run(&mut document, r#"{"view":{"zoom":{"view":"3d","factor":10}}}"#).is_ok() {
        zoomed += 1;
    }
    assert!((3..6).contains(&zoomed), "{zoomed}");
}
