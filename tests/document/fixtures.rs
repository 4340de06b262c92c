//! Projects that earlier programs wrote open with everything in them; tests/fixtures/README.md says what that is.

use super::maker::run;
use burin::document::Document;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A copy of a fixture, since opening writes a lock and a journal.
fn fixture(name: &str, to: &Path) -> PathBuf {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
            let (from, to) = (entry.path(), to.join(entry.file_name()));
            if from.is_dir() { copy(&from, &to) } else { assert!(std::fs::copy(&from, &to).is_ok()) }
        }
    }
    let copied = to.join(name);
    copy(&crate::common::root().join("tests/fixtures").join(name), &copied);
    copied
}

fn ask(document: &mut Document, question: Value) -> Value {
    run(document, &json!({ "ask": question }).to_string()).unwrap()
}

/// What the program that wrote the projects said of them.
fn assert_is_the_ball(document: &mut Document) {
    let mut field = |kind: &str| ask(document, json!({"field": {"field": kind}}));
    assert_eq!(field("labels")["voxels_by_label"], json!({"3": 284, "5": 267}));
    assert_eq!(field("selection")["nonzero"], json!(871));
    assert!((field("selection")["sum"].as_f64().unwrap() - 209.5803921568629).abs() < 1e-9);
    assert_eq!((&field("colour")["nonzero"], &field("colour")["max"]), (&json!(493), &json!(0.8)));
    assert_eq!(field("density")["nonzero"], json!(48834));
    let mut voxel = |index: [u32; 3]| ask(document, json!({"voxel": {"at": {"index": index}}}));
    // 27 codes a unit: painted 1500.25 lies within half of one.
    assert!((voxel([10, 10, 10])["density"].as_f64().unwrap() - 1500.25).abs() < 0.5 / 26.0);
    assert_eq!(voxel([12, 22, 18])["density"], json!(466), "as it is in the source");
    assert_eq!(voxel([12, 22, 18])["segment"], json!("Capsule"));
    assert_eq!(voxel([30, 20, 16])["segment"], json!("After the save"), "from the journal");
    let scene = ask(document, json!({"scene": {}}))["scene"].take();
    assert_eq!((&scene["look"]["step_voxels"], &scene["look"]["mode"]), (&json!(0.75), &json!("dvr")));
    assert_eq!(scene["look"]["refine"], false, "its pictures stay those that were seen");
    let layer = document.state().unwrap().scene.layer(burin::volume::FieldKind::Labels);
    assert_eq!((layer.in_slices(), layer.in_3d()), (0.5, 0.5), "segments too");
    assert_eq!((&scene["window"]["level"], &scene["window"]["width"]), (&json!(300.0), &json!(900.0)));
    assert_eq!((&scene["segments"][0]["locked"], &scene["segments"][1]["locked"]), (&json!(true), &json!(false)));
    assert_eq!(scene["explosion"]["degree"], json!(0.6));
    assert_eq!(scene["views"]["camera"]["eye"][0], json!(91.98946483143978));
    let parts = ask(document, json!({"parts": {}}))["parts"].take();
    let names: Vec<_> = parts.as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Left upper", "Part 5", "Part 6", "Part 7"]);
    assert_eq!(parts[0]["pose"]["translation"][0], json!(-3.0398246332919827));
}

#[test]
fn a_project_of_the_first_format_opens_with_its_journal_and_is_saved_again() {
    let dir = tempfile::tempdir().unwrap();
    let project = fixture("first_format.burin", dir.path());
    let open = json!({"project": {"open": {"path": project}}}).to_string();
    let mut document = Document::new();
    run(&mut document, &open).unwrap();
    assert_is_the_ball(&mut document);
    run(&mut document, r#"{"project":{"save":{}}}"#).unwrap();
    drop(document);
    let mut document = Document::new();
    run(&mut document, &open).unwrap();
    assert_is_the_ball(&mut document);
}

#[test]
fn a_project_with_floats_foreign_ids_and_a_past_of_looks_opens_with_its_journal() {
    let dir = tempfile::tempdir().unwrap();
    let project = fixture("true_values.burin", dir.path());
    let mut document = Document::new();
    run(&mut document, &json!({"project": {"open": {"path": project}}}).to_string()).unwrap();
    for saved in [false, true] {
        if saved {
            run(&mut document, r#"{"view":{"forward":{"of":"looks"}}}"#).unwrap();
            run(&mut document, r#"{"project":{"save":{}}}"#).unwrap();
            document = Document::new();
            run(&mut document, &json!({"project": {"open": {"path": project}}}).to_string()).unwrap();
        }
        let labels = ask(&mut document, json!({"field": {"field": "labels"}}));
        assert_eq!(labels["voxels_by_label"], json!({"1": 120, "3": 285, "5": 757}));
        let voxel = ask(&mut document, json!({"voxel": {"at": {"index": [30, 10, 10]}}}));
        let added = voxel["density"].as_f64().unwrap() - 132.1;
        assert!(added.abs() <= voxel["half_step"].as_f64().unwrap() && added.abs() < 1e-4, "{voxel}");
        let scene = ask(&mut document, json!({"scene": {}}))["scene"].take();
        assert_eq!(
            (&scene["segments"][0]["name"], &scene["segments"][0]["source_value"]),
            (&json!("Cortex"), &json!(70000))
        );
        assert_eq!(
            (&scene["brush"]["erase_density"], &scene["brush"]["target"]),
            (&json!({"to": -5.0}), &json!({"label": 5}))
        );
        assert_eq!(scene["window"], json!({"level": 111.0, "width": 222.0}), "from the journal");
        run(&mut document, r#"{"view":{"back":{"of":"looks"}}}"#).unwrap();
        let scene = ask(&mut document, json!({"scene": {}}))["scene"].take();
        assert_eq!(scene["window"], json!({"level": 300.0, "width": 900.0}), "as it was before");
    }
}
