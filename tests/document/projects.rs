//! Commands on projects: saved, opened, crashed, thrown away.

use super::maker::{bytes, run, write_nrrd};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Grid;
use serde_json::{Value, json};
use std::path::Path;

fn open_volume(folder: &Path, unsaved_in: Option<&Path>) -> Document {
    let path = folder.join("v.nrrd");
    write_nrrd(&path, &Grid::aligned([40, 36, 5], DVec3::new(1.0, 2.0, 3.0), DVec3::splat(4.0)), |v| v[0] as f32);
    let mut document = Document::new();
    if let Some(folder) = unsaved_in {
        document.keep_unsaved_in(folder.to_owned());
    }
    run(&mut document, &json!({"volume":{"open":{"path":path}}}).to_string()).unwrap();
    document
}

fn select(document: &mut Document, folder: &Path) {
    let line = json!({"selection":{"import":{"path":folder.join("v.nrrd"),"threshold":20.0,"soften_mm":3.0}}});
    run(document, &line.to_string()).unwrap();
}

fn open(project: &Path) -> (Document, Value) {
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    (document, answer)
}

#[test]
fn what_was_saved_opens_again_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p");
    let mut document = open_volume(folder.path(), None);
    select(&mut document, folder.path());
    run(&mut document, r#"{"segment":{"set":{"id":7,"name":"jaw"}}}"#).unwrap();
    assert!(document.is_unsaved());
    let saved = run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    assert_eq!(saved["saved"]["generation"], 1);
    assert!(!document.is_unsaved());
    // Open in this process already: it is let go of and opened again.
    run(&mut document, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    let here = bytes(&document);
    drop(document);
    let (again, answer) = open(&project);
    assert_eq!(bytes(&again), here);
    assert_eq!(answer["recovered"], Value::Null);
}

#[test]
fn what_was_not_saved_comes_back_after_a_crash_and_not_after_it_was_thrown_away() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p");
    let mut document = open_volume(folder.path(), None);
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let saved = bytes(&document);
    select(&mut document, folder.path());
    run(&mut document, r#"{"view":{"window":{"level":3,"width":4}}}"#).unwrap();
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    let last = bytes(&document);
    drop(document);
    let (document, answer) = open(&project);
    assert_eq!(bytes(&document), last);
    assert_eq!(answer["recovered"]["steps"], 3);
    assert!(document.is_unsaved());
    document.discard_unsaved().unwrap();
    assert_eq!(bytes(&open(&project).0), saved);
}

#[test]
fn a_document_that_was_never_saved_is_found_after_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let states = folder.path().join("states");
    let mut document = open_volume(folder.path(), Some(&states));
    select(&mut document, folder.path());
    let last = bytes(&document);
    drop(document);
    let mut document = Document::new();
    document.keep_unsaved_in(states);
    let lost = run(&mut document, r#"{"project":{"lost":{}}}"#).unwrap();
    let id = lost["lost"][0]["id"].as_str().unwrap().to_owned();
    run(&mut document, &json!({"project":{"recover":{"id":id}}}).to_string()).unwrap();
    assert_eq!(bytes(&document), last);
    document.discard_unsaved().unwrap();
}

#[test]
fn a_project_that_cannot_be_opened_again_goes_on_being_kept() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p");
    let mut document = open_volume(folder.path(), None);
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let manifest = project.join("generation-000001/generation.json");
    let whole = std::fs::read(&manifest).unwrap();
    std::fs::write(&manifest, b"{").unwrap();
    let again = json!({"project":{"open":{"path":project}}}).to_string();
    run(&mut document, &again).unwrap_err();
    std::fs::write(&manifest, whole).unwrap();
    // Nobody else gets it, and what is done now is noted.
    let taken = run(&mut Document::new(), &again).unwrap_err().to_string();
    assert!(taken.contains("open"), "{taken}");
    select(&mut document, folder.path());
    let last = bytes(&document);
    drop(document);
    let (document, answer) = open(&project);
    assert_eq!((bytes(&document), &answer["recovered"]["steps"]), (last, &json!(1)));
}

#[test]
fn a_script_that_saves_nothing_leaves_what_a_crash_left() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p");
    let mut document = open_volume(folder.path(), None);
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let saved = bytes(&document);
    let window = |d: &mut Document| run(d, r#"{"view":{"window":{"level":3,"width":4}}}"#).unwrap();
    // Nothing was left: nothing is.
    window(&mut document);
    document.leave_as_found().unwrap();
    let (mut document, answer) = open(&project);
    assert_eq!((bytes(&document), &answer["recovered"]), (saved, &Value::Null));
    select(&mut document, folder.path());
    let crashed = bytes(&document);
    drop(document);
    for _ in 0..2 {
        let (mut document, answer) = open(&project);
        assert_eq!((bytes(&document), &answer["recovered"]["steps"]), (crashed.clone(), &json!(1)));
        window(&mut document);
        document.leave_as_found().unwrap();
    }
    // What was left is in what is saved.
    let (mut document, _) = open(&project);
    run(&mut document, r#"{"project":{"save":{}}}"#).unwrap();
    window(&mut document);
    document.leave_as_found().unwrap();
    let (document, answer) = open(&project);
    assert_eq!((bytes(&document), &answer["recovered"]), (crashed, &Value::Null));
}

#[test]
fn what_was_not_saved_before_another_was_opened_does_not_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let (states, project) = (folder.path().join("states"), folder.path().join("p"));
    let mut document = open_volume(folder.path(), Some(&states));
    let volume = json!({"volume":{"open":{"path":folder.path().join("v.nrrd")}}}).to_string();
    let lost = |d: &mut Document| run(d, r#"{"project":{"lost":{}}}"#).unwrap()["lost"].as_array().unwrap().len();
    select(&mut document, folder.path());
    run(&mut document, &volume).unwrap();
    assert_eq!(lost(&mut document), 0);
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let saved = bytes(&document);
    select(&mut document, folder.path());
    run(&mut document, &volume).unwrap();
    let (again, answer) = open(&project);
    assert_eq!((bytes(&again), &answer["recovered"]), (saved, &Value::Null));
    // What a crash had left is not for this program to throw away.
    drop(again);
    let (mut crashed, _) = open(&project);
    select(&mut crashed, folder.path());
    let left = bytes(&crashed);
    drop(crashed);
    run(&mut document, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    run(&mut document, &volume).unwrap();
    assert_eq!(bytes(&open(&project).0), left);
}

#[test]
fn a_stroke_that_was_cut_off_is_painted_once() {
    let Some(gpu) = crate::common::gpu::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p");
    let mut document = open_volume(folder.path(), None);
    document.use_gpu(gpu.clone());
    run(&mut document, r#"{"brush":{"set":{"radius_mm":5,"target":{"selection":1}}}}"#).unwrap();
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let points = json!([{"at":{"index":[10,9,2]}},{"at":{"index":[25,20,2]}}]);
    run(&mut document, &json!({"stroke":{"begin":{"points":points}}}).to_string()).unwrap();
    drop(document);
    let (document, answer) = open(&project);
    assert_eq!(answer["recovered"]["stroke"], "painted");
    let painted = bytes(&document);
    drop(document);
    let (document, answer) = open(&project);
    assert_eq!((&answer["recovered"]["stroke"], &answer["recovered"]["steps"]), (&json!("none"), &json!(1)));
    assert_eq!(bytes(&document), painted);
    // In one go it is the same stroke.
    let mut other = open_volume(folder.path(), None);
    other.use_gpu(gpu);
    run(&mut other, r#"{"brush":{"set":{"radius_mm":5,"target":{"selection":1}}}}"#).unwrap();
    run(&mut other, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap();
    assert_eq!(bytes(&other).0, painted.0);
}

#[test]
fn saving_without_a_place_or_into_a_full_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = open_volume(folder.path(), None);
    let error = run(&mut document, r#"{"project":{"save":{}}}"#).unwrap_err().to_string();
    assert!(error.contains("never saved"), "{error}");
    let error = run(&mut document, &json!({"project":{"save":{"path":folder.path()}}}).to_string()).unwrap_err();
    assert!(error.to_string().contains("v.nrrd"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "a refused folder is left as it was");
}
