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
fn saving_without_a_place_or_into_a_full_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = open_volume(folder.path(), None);
    let error = run(&mut document, r#"{"project":{"save":{}}}"#).unwrap_err().to_string();
    assert!(error.contains("never saved"), "{error}");
    let error = run(&mut document, &json!({"project":{"save":{"path":folder.path()}}}).to_string()).unwrap_err();
    assert!(error.to_string().contains("v.nrrd"), "{error}");
}
