//! The command line: answers, exit codes, words on stderr.

use super::maker::write_nrrd;
use burin::math::DVec3;
use burin::volume::Grid;
use std::path::Path;
use std::process::{Command, Output};

fn burin(folder: &Path, arguments: &[&str]) -> Output {
    let grid = Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&folder.join("v.nrrd"), &grid, |v| (v[0] + v[1]) as f32);
    Command::new(crate::common::program()).current_dir(folder).args(arguments).output().unwrap()
}

#[test]
fn what_goes_wrong_is_said_on_stderr_with_code_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.jsonl"), "{\"history\":{\"undo\":{}}}\n").unwrap();
    for (arguments, words) in [
        (&["run", "nowhere.jsonl"][..], "nowhere.jsonl"),
        (&["run", "bad.jsonl"], "1 of 1 commands failed"),
        (&["info", "nowhere.nii"], "nowhere.nii"),
        (&["render", "v.nrrd", "-o", "x.png", "--camera", "1,2"], "--camera: 1,2 found"),
        (&["render", "v.nrrd", "-o", "x.png", "--size", "9"], "WIDTHxHEIGHT expected"),
        (&["render", "v.nrrd", "-o", "x.png", "--degree", "nan"], "nan found, a number expected"),
        (&["render", "v.nrrd", "-o", "x.png", "--degree", "-1"], "a number from 0 to 10 expected"),
        (&["render", "v.nrrd", "-o", "x.png", "--view", "top"], "[possible values: 3d, axial, coronal, sagittal]"),
        (&["render", "v.nrrd", "-o", "x.png", "--view", "axial", "--camera", "1,0,0"], "one for the axial view found"),
        (&["render", "v.nrrd", "-o", "x.png", "--supersample", "9"], "supersample: 9 found, 1 to 8 expected"),
        (&["render", "v.nrrd", "-o", "x.png", "--frame", "1"], "v.nrrd: frames: found 1; asked for number 1"),
        (&["render", "v.nrrd", "-o", "x.png", "--component", "3"], "v.nrrd: components: found 1; asked for number 3"),
        (&["render", "v.nrrd", "-o", "x.png", "--background", "red"], "#rrggbb or r,g,b of 0 to 1 expected"),
        (&["render", "v.nrrd", "-o", "x.png", "--background", "0,1,0", "--transparent"], "cannot be used with"),
        (&["render", ".", "-o", "x.png", "--frame", "0"], "--frame: 0 found for a project"),
        (&["no-such-command", "x"], "cannot be used"),
    ] {
        let output = burin(folder.path(), arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
    }
}

#[test]
fn info_schema_and_scripts_answer_on_stdout() {
    let folder = tempfile::tempdir().unwrap();
    let info = burin(folder.path(), &["info", "v.nrrd", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&info["dims"], &info["max"]), (&serde_json::json!([12, 10, 8]), &20.0.into()));
    let schema = burin(folder.path(), &["schema"]);
    assert!(serde_json::from_slice::<serde_json::Value>(&schema.stdout).unwrap()["oneOf"].is_array());
    let script = "{\"volume\":{\"open\":{\"path\":\"v.nrrd\"}}}\n{\"project\":{\"save\":{}}}\n";
    std::fs::write(folder.path().join("s.jsonl"), script).unwrap();
    let run = burin(folder.path(), &["run", "s.jsonl", "--project", "p"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(String::from_utf8(run.stdout).unwrap().lines().count(), 2);
    assert!(folder.path().join("p/project.json").exists());
}

/// Two frames of two components, 8 × 6 × 4 voxels: frame f of component c is 10 + 60·c + 120·f in its left half, 0 in the other.
fn series(path: &Path) {
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 5\nspace: right-anterior-superior\nsizes: 2 8 6 4 2\n\
        space directions: none (1,0,0) (0,1,0) (0,0,1) none\nkinds: vector domain domain domain time\n\
        encoding: raw\n\n"
        .to_vec();
    for i in 0..2 * 8 * 6 * 4 * 2 {
        let (component, x, frame) = (i % 2, i / 2 % 8, i / (2 * 8 * 6 * 4));
        bytes.push(if x < 4 { 10 + 60 * component + 120 * frame } else { 0 } as u8);
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_picture_is_of_the_frame_and_component_that_are_asked_for() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    series(&folder.path().join("s.nrrd"));
    for (frame, component) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let (f, c) = (frame.to_string(), component.to_string());
        let out = ["render", "s.nrrd", "-o", "x.exr", "--view", "axial", "--size", "64x64", "--supersample", "2"];
        let output = burin(folder.path(), &[&out[..], &["--frame", &f, "--component", &c]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((&said["view"], &said["supersample"]), (&"axial".into(), &2.into()));
        // The same by a script that opens the same.
        let open = format!(r#"{{"volume":{{"open":{{"path":"s.nrrd","frame":{frame},"component":{component}}}}}}}"#);
        let image = r#"{"render":{"image":{"path":"y.exr","view":"axial","size":[64,64],"supersample":2}}}"#;
        let ask = r#"{"ask":{"voxel":{"at":{"index":[1,1,1]}}}}"#;
        std::fs::write(folder.path().join("s.jsonl"), [&open, image, ask].join("\n")).unwrap();
        let run = burin(folder.path(), &["run", "s.jsonl"]);
        let text = String::from_utf8(run.stdout).unwrap();
        let voxel: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        assert_eq!(voxel["ok"]["density"].as_f64(), Some(f64::from(10 + 60 * component + 120 * frame)), "{text}");
        let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
        assert!(bytes("x.exr") == bytes("y.exr"), "{frame} {component}");
    }
}

#[test]
fn a_picture_lies_on_the_background_that_is_asked_for() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (arguments, corner) in [
        (&["--background", "#ff8000"][..], [255, 128, 0, 255]),
        (&["--background", "0, 1, 0.2"], [0, 255, 51, 255]),
        (&["--transparent"], [0; 4]),
        (&[], [0, 0, 0, 255]),
    ] {
        for view in ["3d", "sagittal"] {
            let out = ["render", "v.nrrd", "-o", "x.png", "--size", "32x24", "--view", view];
            let output = burin(folder.path(), &[&out[..], arguments].concat());
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let picture = image::open(folder.path().join("x.png")).unwrap().to_rgba8();
            assert_eq!(picture.get_pixel(0, 0).0, corner, "{view} {arguments:?}");
        }
    }
}
