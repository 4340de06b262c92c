//! What was kept is checked on opening by the rules of commands: what cannot be used is named, the rest opens, and quickly.

use super::keep_support::write_sealed;
use super::maker::{bytes, labelled, run};
use burin::document::Document;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn saved(dir: &Path) -> PathBuf {
    let project = dir.join("p");
    let mut document = labelled();
    run(&mut document, r#"{"part":{"split":{"by":{"plane":{"point":[0,0,0],"normal":[1,0,0]}}}}}"#).unwrap();
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    project
}

fn change(project: &Path, field: &str, value: &Value) {
    let path = project.join("generation-000001/generation.json");
    let mut manifest: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let place = manifest.pointer_mut(field).unwrap_or_else(|| panic!("{field}"));
    assert_ne!(place, value, "{field}");
    *place = value.clone();
    write_sealed(&path, &manifest);
}

fn open(project: &Path) -> Result<(Document, Value), String> {
    let mut document = Document::new();
    let line = json!({"project":{"open":{"path":project}}}).to_string();
    let answer = run(&mut document, &line).map_err(|e| e.to_string())?;
    Ok((document, answer))
}

#[test]
fn a_value_that_cannot_be_used_is_told_and_the_rest_opens() {
    let dir = tempfile::tempdir().unwrap();
    let project = saved(dir.path());
    let manifest = project.join("generation-000001/generation.json");
    let whole = std::fs::read(&manifest).unwrap();
    let labels = bytes(&open(&project).unwrap().0).0;
    let first: Value = serde_json::from_slice(&whole).unwrap();
    let segments = first["scene"]["volumes"]["all"]["0"]["segments"].as_array().unwrap().clone();
    let swapped = json!([segments[1], segments[0]]);
    let twice = json!([segments[0], segments[0], segments[1]]);
    let far = json!([[1e9, 0.0, 0.0], [0.0, 1e9, 0.0], [0.0, 0.0, 1e9], [0.0, 0.0, 0.0]]);
    for (field, value, words) in [
        ("/scene/volumes/all/0/segments", swapped, &["segments: 1 after 2 found, ids that rise expected"][..]),
        ("/scene/volumes/all/0/segments", twice, &["segments: 1 after 1 found"]),
        ("/scene/volumes/all/0/segments/0/id", json!(0), &["segments[0].id: 0 found"]),
        (
            "/scene/volumes/all/0/segments/1/colour",
            json!([2.0, 0.0, 0.0]),
            &["segments[1].colour: [2.0, 0.0, 0.0] found"],
        ),
        ("/scene/look/step_voxels", json!(1e-5), &["look.step_voxels: 0.00001 found, 0.05 to 16 voxels expected"]),
        ("/scene/look/background/1", json!(-1.0), &["look.background", "red, green and blue"]),
        ("/scene/look/lighting/power", json!(-3.0), &["look.lighting"]),
        ("/scene/shown/0/window/width", json!(0.0), &["window.width: 0 found"]),
        ("/scene/views/size", json!([100_000, 100_000]), &["views.size: [100000, 100000] found"]),
        ("/scene/views/slices/2/size", json!([0, 5]), &["views.size: [0, 5] found"]),
        ("/scene/views/slices/0/height_mm", json!(-1.0), &["views.slices.height_mm: -1 found"]),
        ("/scene/views/camera/eye", json!([1e30, 0.0, 0.0]), &["views.camera.eye"]),
        ("/scene/views/crosshair/0", json!(1e30), &["views.crosshair"]),
        ("/scene/layers/0/opacity", json!(7.0), &["layers[0].opacity: 7 found, 0 to 1 expected"]),
        ("/scene/brush/radius_mm", json!(-2.0), &["radius_mm"]),
        ("/scene/brush/spacing", json!(0.0), &["spacing"]),
        ("/scene/transfer/opacity", json!([]), &["transfer function: opacity: no point found"]),
        ("/scene/transfer/colour/1/0", json!(-1e9), &["transfer function: colour[1]"]),
        ("/scene/explosion/degree", json!(1e6), &["degree"]),
        ("/scene/explosion/forces/softening", json!(0.0), &["forces.softening"]),
        ("/scene/explosion/parts/0/pose/rotation", json!([9.0, 0.0, 0.0, 0.0]), &["parts[0].pose"]),
        ("/scene/explosion/parts/0/importance", json!(0.0), &["parts[0].importance"]),
        ("/scene/explosion/parts/1/id", json!(0), &["parts[1].id"]),
        ("/scene/explosion/parts/1/vertices", far, &["parts[1]."]),
        ("/scene/explosion/parts", json!([]), &["parts: none found"]),
        ("/scene/explosion/next_id", json!(4_294_967_295_u32), &["explosion.next_id"]),
    ] {
        change(&project, field, &value);
        let start = Instant::now();
        let (mut document, answer) = open(&project).unwrap_or_else(|e| panic!("{field}: {e}"));
        let told = answer["warnings"].to_string();
        for word in ["the project cannot be used as it was kept: "].iter().chain(words) {
            assert!(told.contains(word), "{field}: {word:?} not in {told}");
        }
        // Nothing else was lost, and what came in its place can be used and saved.
        assert!(bytes(&document).0 == labels, "{field}");
        document.state().unwrap().scene.check(&document.state().unwrap().bounds()).unwrap();
        run(&mut document, r#"{"part":{"split":{"by":{"plane":{"point":[1,0,0],"normal":[0,1,0]}}}}}"#).unwrap();
        assert!(start.elapsed() < Duration::from_secs(20), "{field}");
        document.leave_as_found().unwrap();
        std::fs::write(&manifest, &whole).unwrap();
    }
    let (_, answer) = open(&project).unwrap();
    assert_eq!(answer["warnings"], json!([]));
}

#[test]
fn numbers_of_the_volume_that_mean_nothing_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let project = saved(dir.path());
    let manifest = project.join("generation-000001/generation.json");
    let whole = std::fs::read(&manifest).unwrap();
    for (field, value, words) in [
        ("/volumes/0/scaling/0", json!(0.0), "volumes.0.scaling: [0, 0] found"),
        ("/volumes/0/histogram/bins", json!([]), "volumes.0.histogram: 0 bins"),
        ("/volumes/0/histogram/bins", json!([u64::MAX, 1]), "volumes.0.histogram: 2 bins"),
        ("/volumes/0/map/codes_per_unit", json!(-1.0), "volumes.0.map"),
        ("/volumes/0/world_from_index/0", json!([0.0, 0.0, 0.0, 0.0]), "volumes.0.world_from_index"),
        ("/volumes/0/voxel_type", json!("u12"), "JSON: volumes.0.voxel_type: unknown variant"),
        ("/scene/look/mode", json!("wet"), "JSON: scene.look.mode: unknown variant"),
    ] {
        change(&project, field, &value);
        let refused = open(&project).map(drop).unwrap_err();
        assert!(refused.contains("generation.json: ") && refused.contains(words), "{field}: {refused}");
        std::fs::write(&manifest, &whole).unwrap();
    }
}
