//! Opening volumes.

use super::maker::{run, write_nrrd};
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::{Grid, TexelFormat};
use serde_json::{Value, json};

fn open(value: impl Fn([u32; 3]) -> f32, extra: Value) -> (Document, Result<Value, String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nrrd");
    write_nrrd(&path, &Grid::aligned([20, 10, 5], DVec3::new(1.0, 2.0, 3.0), DVec3::splat(4.0)), value);
    let mut command = json!({ "path": path });
    for (key, value) in extra.as_object().unwrap() {
        command[key] = value.clone();
    }
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"volume":{"open":command}}).to_string()).map_err(|e| e.to_string());
    (document, answer)
}

#[test]
fn an_opened_volume_is_framed_and_seen_from_the_front() {
    let (document, answer) = open(|v| v[0] as f32, json!({}));
    let answer = answer.unwrap();
    assert_eq!(answer["dims"], json!([20, 10, 5]));
    assert_eq!((answer["min"].as_f64(), answer["max"].as_f64()), (Some(0.0), Some(19.0)));
    assert_eq!(answer["sum"].as_f64(), Some(190.0 * 50.0));
    let scene = &document.state().unwrap().scene;
    let bounds = document.state().unwrap().one().grid().world_bounds();
    assert_eq!(scene.views.crosshair, bounds.centre());
    assert!(scene.views.camera.forward().distance(DVec3::NEG_Y) < 1e-12);
    for corner in bounds.corners() {
        let (px, _) = scene.views.camera.project(corner, [512; 2]).unwrap();
        assert!(px.cmpge(burin::math::DVec2::ZERO).all() && px.cmple(burin::math::DVec2::splat(512.0)).all());
    }
    scene.transfer.check().unwrap();
    let histogram = &document.state().unwrap().one().histogram;
    assert_eq!(histogram.bins.iter().sum::<u64>(), 1000);
    assert_eq!(document.history().undo_names().len(), 0);
}

#[test]
fn a_density_keeps_codes_where_they_suffice_and_floats_where_not() {
    let format = |d: &Document| d.state().unwrap().one().density.format();
    assert_eq!(format(&open(|v| v[0] as f32 * 0.37, json!({})).0), TexelFormat::R16Unorm);
    // NaN has no code.
    assert_eq!(format(&open(|v| if v[0] == 3 { f32::NAN } else { 1.0 }, json!({})).0), TexelFormat::R32Float);
    // One outlier far away leaves a few codes for all the others.
    let outlier = |v: [u32; 3]| if v == [1, 1, 1] { 1e9 } else { v[0] as f32 * 0.1 };
    assert_eq!(format(&open(outlier, json!({})).0), TexelFormat::R32Float);
    let (document, answer) = open(outlier, json!({ "range": [0.0, 2.0] }));
    answer.unwrap();
    assert_eq!(document.state().unwrap().one().density.map().lo, 0.0);
}

#[test]
fn volumes_without_a_finite_value_or_of_one_value_open() {
    for value in [f32::NAN, f32::INFINITY, 7.5] {
        let (document, answer) = open(|_| value, json!({}));
        answer.unwrap();
        let scene = &document.state().unwrap().scene;
        scene.transfer.check().unwrap();
        assert!(scene.window().width > 0.0 && scene.window().level.is_finite());
        serde_json::from_str::<burin::document::Scene>(&serde_json::to_string(scene).unwrap()).unwrap();
    }
}

#[test]
fn a_range_or_component_that_is_none_is_refused_and_what_was_open_stays() {
    for (extra, text) in [
        (json!({ "range": [2.0, 1.0] }), "range: [2, 1] found, two finite values, the smaller first expected"),
        (json!({ "component": 1 }), "components"),
        (json!({ "frame": 9 }), "frames"),
    ] {
        let (document, answer) = open(|v| v[1] as f32, extra);
        assert!(answer.unwrap_err().contains(text));
        assert!(document.state().is_none());
    }
}

#[test]
fn an_export_leaves_the_file_it_came_from_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nrrd");
    write_nrrd(&path, &Grid::aligned([6, 5, 4], DVec3::ONE, DVec3::ZERO), |v| v[0] as f32);
    let bytes = std::fs::read(&path).unwrap();
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":path}}}).to_string()).unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    for name in ["v.nrrd", "sub/../v.nrrd"] {
        let export = json!({"volume":{"export":{"field":"labels","path":folder.path().join(name)}}});
        let error = run(&mut document, &export.to_string()).unwrap_err().to_string();
        assert!(error.contains("which the volume is read from"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }
    let beside = json!({"volume":{"export":{"field":"labels","path":folder.path().join("w.nrrd")}}});
    run(&mut document, &beside.to_string()).unwrap();
}
