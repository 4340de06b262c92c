//! A document whose volumes are all gone: it answers, shows its background, is saved, and undo brings back what was there.

use super::maker::{run, write_nrrd};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::{FieldKind, Grid};
use serde_json::{Value, json};
use std::path::Path;

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// An atlas with one region selected, and then no volume any more. The second answer is the bytes that were there.
fn emptied(dir: &Path) -> (Document, Vec<Vec<u8>>) {
    let path = dir.join("atlas.nrrd");
    let grid = Grid::aligned([12, 10, 8], DVec3::splat(1.5), DVec3::new(-3.0, 2.0, 1.0));
    write_nrrd(&path, &grid, |[x, y, z]| ((x + 2 * y + 3 * z) % 4) as f32);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    say(&mut document, json!({"volume": {"open": {"path": path, "as": "labels"}}}));
    say(&mut document, json!({"selection": {"from_label": {"label": 2}}}));
    let there = bytes(&document);
    let said = say(&mut document, json!({"volume": {"remove": {"volume": 0}}}));
    assert_eq!((&said["removed"], &said["active"]), (&json!(0), &Value::Null), "{said}");
    (document, there)
}

fn bytes(document: &Document) -> Vec<Vec<u8>> {
    let volumes = &document.state().unwrap().volumes;
    let fields = volumes.values().flat_map(|volume| FieldKind::ALL.map(|kind| volume.field(kind)));
    fields.map(|field| field.read(0, [0; 3], field.dims(0)).unwrap()).collect()
}

#[test]
fn cameras_and_the_brush_work_without_a_volume_and_what_needs_one_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let (mut document, _) = emptied(dir.path());
    let before = document.state().unwrap().scene.views.camera;
    for line in [
        json!({"brush": {"set": {"radius_mm": 7.0}}}),
        json!({"view": {"orbit": {"azimuth_deg": 30.0, "elevation_deg": 10.0}}}),
        json!({"view": {"pan": {"view": "3d", "px": [10.0, 5.0]}}}),
        json!({"view": {"zoom": {"view": "axial", "factor": 2.0}}}),
        json!({"view": {"frame": {"from": [1.0, 0.0, 0.0]}}}),
        json!({"view": {"fit": {"view": "3d"}}}),
        json!({"view": {"fit": {"view": "coronal"}}}),
        json!({"view": {"scroll": {"view": "sagittal", "voxels": 2}}}),
        json!({"view": {"crosshair": {"at": {"mm": [1.0, 2.0, 3.0]}}}}),
        json!({"view": {"size": {"view": "3d", "size": [64, 48]}}}),
        json!({"view": {"look": {"background": [0.1, 0.2, 0.3]}}}),
        json!({"view": {"back": {}}}),
        json!({"view": {"forward": {}}}),
    ] {
        say(&mut document, line);
    }
    let scene = &document.state().unwrap().scene;
    assert_eq!(scene.brush.radius_mm, 7.0);
    assert_ne!(scene.views.camera, before);
    assert!(scene.views.crosshair.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-9);
    let after = serde_json::to_value(scene).unwrap();
    for line in [
        json!({"ask": {"volume": {}}}),
        json!({"ask": {"field": {"field": "density"}}}),
        json!({"stroke": {"paint": {"points": [{"at": {"mm": [1.0, 2.0, 3.0]}}]}}}),
        json!({"selection": {"clear": {}}}),
        json!({"segment": {"remove": {"id": 1}}}),
        json!({"transfer": {"reset": {}}}),
        json!({"view": {"window": {"level": 1.0, "width": 2.0}}}),
        json!({"volume": {"set": {"volume": 0, "visible": false}}}),
        json!({"volume": {"remove": {"volume": 0}}}),
        json!({"volume": {"export": {"field": "labels", "path": dir.path().join("x.nrrd")}}}),
        json!({"explosion": {"settle": {}}}),
    ] {
        let refused = run(&mut document, &line.to_string()).expect_err(&line.to_string()).to_string();
        assert!(refused.contains("holds no volume") && refused.contains("volume.add"), "{line}: {refused}");
    }
    assert_eq!(
        serde_json::to_value(&document.state().unwrap().scene).unwrap(),
        after,
        "what is refused changes nothing"
    );
}

#[test]
fn undo_a_crash_and_a_save_keep_a_document_without_volumes_and_what_was_there_comes_back() {
    let dir = tempfile::tempdir().unwrap();
    let (mut document, there) = emptied(dir.path());
    say(&mut document, json!({"history": {"undo": {}}}));
    assert_eq!(bytes(&document), there);
    say(&mut document, json!({"history": {"redo": {}}}));
    assert_eq!(bytes(&document).len(), 0);
    // A program that ends without a word.
    std::mem::drop(document);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("unsaved"));
    let lost = say(&mut document, json!({"project": {"lost": {}}}))["lost"].clone();
    say(&mut document, json!({"project": {"recover": {"id": lost[0]["id"]}}}));
    assert_eq!(bytes(&document).len(), 0, "after a crash");
    let (mut document, there) = emptied(dir.path());
    let project = dir.path().join("p");
    say(&mut document, json!({"project": {"save": {"path": project}}}));
    say(&mut document, json!({"history": {"undo": {}}}));
    assert_eq!(bytes(&document), there, "after a save without it");
    say(&mut document, json!({"history": {"redo": {}}}));
    drop(document);
    let mut document = Document::new();
    say(&mut document, json!({"project": {"open": {"path": project}}}));
    let scene = say(&mut document, json!({"ask": {"scene": {}}}));
    assert_eq!(scene["scene"]["volumes"]["all"], json!({}), "{scene}");
    let added = say(&mut document, json!({"volume": {"add": {"path": dir.path().join("atlas.nrrd")}}}));
    assert_eq!(added["volume"], 1, "no number is given twice: {added}");
    say(&mut document, json!({"history": {"undo": {}}}));
    assert_eq!(bytes(&document).len(), 0);
}

#[test]
fn pictures_of_no_volume_are_the_background() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let (mut document, _) = emptied(dir.path());
    say(&mut document, json!({"view": {"look": {"background": [1.0, 0.5, 0.0]}}}));
    for view in ["3d", "axial", "coronal", "sagittal"] {
        let path = dir.path().join("none.png");
        let said = say(&mut document, json!({"render": {"image": {"path": path, "view": view, "size": [9, 7]}}}));
        assert_eq!(said["covered"], 0.0, "{said}");
        let picture = image::open(&path).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (9, 7));
        assert!(picture.pixels().all(|p| p.0 == [255, 128, 0]), "{view}: {:?}", picture.get_pixel(4, 3));
    }
    say(&mut document, json!({"render": {"image": {"path": dir.path().join("none.exr"), "size": [9, 7]}}}));
    let seen = say(&mut document, json!({"ask": {"visibility": {}}}));
    assert_eq!((&seen["selected"], &seen["visible"]), (&json!(0), &json!(0)), "{seen}");
    let picked = say(&mut document, json!({"ask": {"pick": {"px": [4.0, 3.0]}}}));
    assert_eq!(picked, json!({"hit": null}));
}
