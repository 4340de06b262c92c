//! The command line: answers, exit codes, words on stderr.

use super::maker::write_nrrd;
use burin::math::DVec3;
use burin::volume::Grid;
use std::path::Path;
use std::process::{Command, Output};

fn burin(folder: &Path, arguments: &[&str]) -> Output {
    let grid = Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&folder.join("v.nrrd"), &grid, |v| (v[0] + v[1]) as f32);
    Command::new(env!("CARGO_BIN_EXE_burin")).current_dir(folder).args(arguments).output().unwrap()
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
