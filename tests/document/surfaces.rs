//! `volume.export` of the surfaces of selections and segments: where the volume lies, at its resolution, refused with a reason.

use super::maker::{bytes, run, write_nrrd};
use burin::document::Document;
use burin::math::{DAffine3, DMat3, DVec3, Pose};
use burin::volume::{FieldKind, Grid, VolumeId};
use serde_json::{Value, json};
use std::path::Path;

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

const CENTRE: DVec3 = DVec3::new(10.2, 9.4, 8.8);

/// A moved, oblique, anisotropic volume with balls of 5 and 3 mm in index space, one selected, both labelled.
fn balls(folder: &Path) -> (Document, Grid) {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let matrix3 = turned * DMat3::from_diagonal(DVec3::new(0.8, 1.1, 1.7));
    let grid =
        Grid { dims: [40, 22, 20], world_from_index: DAffine3 { matrix3, translation: DVec3::new(9.0, -5.0, 7.0) } };
    let path = folder.join("a.nrrd");
    write_nrrd(&path, &grid, |_| 1.0);
    let mut document = Document::new();
    document.keep_unsaved_in(folder.join("unsaved"));
    say(&mut document, json!({"volume":{"open":{"path":path}}}));
    let pose = Pose { rotation: burin::math::DQuat::from_rotation_z(0.5), translation: DVec3::new(4.0, 13.0, 2.0) };
    say(&mut document, json!({"volume":{"set":{"volume":0,"pose":pose}}}));
    let mut state = document.state().unwrap().clone();
    let place = |v: [u32; 3]| DVec3::from_array(v.map(f64::from));
    let label = move |v: [u32; 3]| match place(v) {
        p if p.distance(CENTRE) <= 5.0 => 1,
        p if p.distance(DVec3::new(32.0, 10.0, 10.0)) <= 3.0 => 2,
        _ => 0,
    };
    let own = *state.volumes[&VolumeId(0)].grid();
    let volume = state.volume_mut(VolumeId(0)).unwrap();
    volume.labels = crate::common::volumes::painted(FieldKind::Labels, &own, |v| [label(v), 0, 0, 0]);
    let soft = |v: [u32; 3]| ((0.5 + (5.0 - place(v).distance(CENTRE)) / 4.0).clamp(0.0, 1.0) * 255.0).round() as u8;
    volume.selection = crate::common::volumes::painted(FieldKind::Selection, &own, |v| [soft(v), 0, 0, 0]);
    let lies = *state.at(None).unwrap().grid();
    document.adopt(state);
    for (id, name) in [(1, "liver"), (2, "spleen")] {
        say(&mut document, json!({"segment":{"set":{"id":id,"name":name}}}));
    }
    (document, lies)
}

/// The corners of an OBJ.
fn corners(path: &Path) -> Vec<DVec3> {
    let text = std::fs::read_to_string(path).unwrap();
    let place =
        |line: &str| DVec3::from_slice(&line.split(' ').skip(1).map(|n| n.parse().unwrap()).collect::<Vec<f64>>());
    text.lines().filter(|line| line.starts_with("v ")).map(place).collect()
}

#[test]
fn a_surface_lies_where_its_volume_lies_and_says_what_it_encloses() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, grid) = balls(folder.path());
    let before = bytes(&document);
    let voxel = grid.world_from_index.matrix3.determinant().abs();
    let path = folder.path().join("s.obj");
    for (field, label, far) in [("selection", None, 0.05), ("labels", Some(1), 0.6)] {
        let mut what = json!({"field":field,"path":path});
        if let Some(label) = label {
            what["label"] = json!(label);
        }
        let said = say(&mut document, json!({"volume":{"export":what}}));
        let exported = &said["exported"];
        assert_eq!(exported["closed"], true);
        let corners = corners(&path);
        assert_eq!(exported["vertices"], corners.len());
        for corner in &corners {
            let index = grid.index_from_world().transform_point3(*corner);
            assert!((index.distance(CENTRE) - 5.0).abs() < far, "{field}: {index}");
        }
        let volume = exported["volume_mm3"].as_f64().unwrap();
        let expected = 4.0 / 3.0 * std::f64::consts::PI * 125.0 * voxel;
        assert!((volume / expected - 1.0).abs() < 0.03, "{volume} {expected}");
    }
    assert!(bytes(&document) == before, "nothing is changed");
    assert_eq!(say(&mut document, json!({"ask":{"history":{}}}))["undo"].as_array().unwrap().len(), 2, "two segments");
    for ending in ["stl", "ply", "glb"] {
        let path = folder.path().join(format!("s.{ending}"));
        let said = say(&mut document, json!({"volume":{"export":{"field":"labels","label":2,"path":path,"volume":0}}}));
        assert_eq!(said["exported"]["bytes"], std::fs::metadata(&path).unwrap().len());
    }
    let glb = std::fs::read(folder.path().join("s.glb")).unwrap();
    assert!(String::from_utf8_lossy(&glb).contains("\"spleen\""), "segments keep their names");
}

#[test]
fn what_has_no_surface_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = balls(folder.path());
    let path = folder.path().join("s.stl");
    let voxels = folder.path().join("s.nrrd");
    for (what, words) in [
        (json!({"field":"density","path":path}), "field: density found, selection or labels"),
        (json!({"field":"colour","path":path}), "field: colour found, selection or labels"),
        (json!({"field":"labels","path":path}), "label: none found, a segment's id, one of [1, 2] expected"),
        (json!({"field":"labels","label":7,"path":path}), "label: 7 found, a segment's id, one of [1, 2] expected"),
        (json!({"field":"selection","label":1,"path":path}), "label: 1 found, nothing"),
        (json!({"field":"labels","label":1,"path":voxels}), "label: 1 found, nothing where voxels are written"),
        (json!({"field":"labels","label":1,"path":path,"volume":4}), "volume: 4 found"),
    ] {
        let line = json!({"volume":{"export":what}});
        let said = run(&mut document, &line.to_string()).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
        assert!(!path.exists() && !voxels.exists());
    }
    say(&mut document, json!({"segment":{"set":{"id":3,"name":"nothing yet"}}}));
    let line = json!({"volume":{"export":{"field":"labels","label":3,"path":path}}});
    let said = run(&mut document, &line.to_string()).unwrap_err().to_string();
    assert!(said.contains("nothing yet, which has no voxel"), "{said}");
    say(&mut document, json!({"selection":{"clear":{}}}));
    let line = json!({"volume":{"export":{"field":"selection","path":path}}});
    let said = run(&mut document, &line.to_string()).unwrap_err().to_string();
    assert!(said.contains("a selection that is a half nowhere"), "{said}");
    // The file that the volume is read from is not written over, whatever it is called.
    let own = folder.path().join("a.nrrd");
    let line = json!({"volume":{"export":{"field":"density","path":own}}});
    assert!(run(&mut document, &line.to_string()).is_err());
    // The only segment is meant where none is named.
    for id in [2, 3] {
        say(&mut document, json!({"segment":{"remove":{"id":id}}}));
    }
    assert_eq!(
        say(&mut document, json!({"volume":{"export":{"field":"labels","path":path}}}))["exported"]["closed"],
        true
    );
}
