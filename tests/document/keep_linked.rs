//! A project that names its source means the very bytes that were opened, header and voxels, and finds them again.

use super::maker::{bytes, run};
use crate::common::one::One;
use burin::document::{Document, DocumentError, KeepError};
use burin::volume::VolumeId;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const SIDE: usize = 20;

/// A detached volume, its voxels from a seed; gzip if told so.
fn detached(dir: &Path, name: &str, seed: u8) -> PathBuf {
    std::fs::create_dir_all(dir).unwrap();
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nencoding: raw\ndata file: {name}.raw\n\n"
    );
    let path = dir.join(format!("{name}.nhdr"));
    std::fs::write(&path, header).unwrap();
    std::fs::write(dir.join(format!("{name}.raw")), voxels(seed)).unwrap();
    path
}

fn voxels(seed: u8) -> Vec<u8> {
    (0..SIDE.pow(3)).map(|i| (i as u8).wrapping_mul(7).wrapping_add(seed)).collect()
}

fn opened(volume: &Path) -> Document {
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
    document
}

fn save(document: &mut Document, project: &Path, density: &str) -> Result<Value, String> {
    let line = json!({"project":{"save":{"path":project,"density":density}}}).to_string();
    run(document, &line).map_err(|e| e.to_string())
}

fn save_again(document: &mut Document, density: &str) -> Result<Value, String> {
    run(document, &json!({"project":{"save":{"density":density}}}).to_string()).map_err(|e| e.to_string())
}

fn open(project: &Path) -> Result<(Document, Value), String> {
    open_with(&json!({"path":project}))
}

fn open_with(what: &Value) -> Result<(Document, Value), String> {
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"project":{"open":what}}).to_string()).map_err(|e| e.to_string())?;
    Ok((document, answer))
}

fn step(document: &mut Document) {
    run(document, r#"{"segment":{"set":{"id":7,"name":"jaw"}}}"#).unwrap();
}

/// The stored values of the document's source.
fn stored(document: &Document) -> Vec<u8> {
    let source = &document.state().unwrap().one().source;
    source.read([0; 3], source.grid().dims).unwrap().as_bytes().to_vec()
}

/// The hash is taken behind what is done.
fn wait_for_hash(document: &Document) {
    while document.state().unwrap().files[&VolumeId::FIRST].is_pending() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Other bytes of the same length, as of the same moment.
fn change(path: &Path, seed: u8) {
    let time = std::fs::metadata(path).unwrap().modified().unwrap();
    std::fs::write(path, voxels(seed)).unwrap();
    std::fs::File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
}

#[test]
fn a_linked_save_of_a_file_that_changed_since_it_was_opened_says_so_and_offers_to_embed() {
    let dir = tempfile::tempdir().unwrap();
    let volume = detached(dir.path(), "v", 1);
    // Another file in its place, of the same length and time: the one that was opened is still read.
    let mut document = opened(&volume);
    step(&mut document);
    let (raw, project) = (dir.path().join("v.raw"), dir.path().join("p"));
    let other = dir.path().join("other");
    std::fs::write(&other, voxels(2)).unwrap();
    let time = std::fs::metadata(&raw).unwrap().modified().unwrap();
    std::fs::File::options().write(true).open(&other).unwrap().set_modified(time).unwrap();
    std::fs::rename(&other, &raw).unwrap();
    let refused = save(&mut document, &project, "linked").unwrap_err();
    assert!(refused.contains("v.raw") && refused.contains("density \"whole\""), "{refused}");
    assert!(!project.exists());
    save(&mut document, &project, "whole").unwrap();
    drop(document);
    assert_eq!(stored(&open(&project).unwrap().0), voxels(1));
    // A file that was written to in place, time put back.
    let mut document = opened(&volume);
    wait_for_hash(&document);
    change(&raw, 3);
    let refused = save(&mut document, &dir.path().join("q"), "linked").unwrap_err();
    assert!(refused.contains("v.raw") && refused.contains("density \"whole\""), "{refused}");
    // The header counts as well; and a file that is gone.
    let mut document = opened(&volume);
    wait_for_hash(&document);
    std::fs::rename(&volume, dir.path().join("w.nhdr")).unwrap();
    let refused = save(&mut document, &dir.path().join("q"), "linked").unwrap_err();
    assert!(refused.contains("v.nhdr") && refused.contains("density \"whole\""), "{refused}");
    // Back again with all its bytes, and with other rights: it is the same.
    std::fs::copy(dir.path().join("w.nhdr"), &volume).unwrap();
    save(&mut document, &dir.path().join("q"), "linked").unwrap();
    drop(document);
    assert_eq!(stored(&open(&dir.path().join("q")).unwrap().0), voxels(3));
}

#[test]
fn a_linked_project_shows_its_picture_at_once_and_a_save_waits_for_the_hash() {
    let dir = tempfile::tempdir().unwrap();
    let volume = detached(dir.path(), "v", 1);
    let project = dir.path().join("p");
    let mut document = opened(&volume);
    step(&mut document);
    save(&mut document, &project, "linked").unwrap();
    assert!(!project.join("generation-000001/volumes/0/density").exists());
    drop(document);
    let (mut document, answer) = open(&project).unwrap();
    assert_eq!((&answer["warnings"], document.source_trouble(true)), (&json!([]), None));
    assert!(!document.is_comparing());
    save_again(&mut document, "linked").unwrap();
    drop(document);
    // Only the voxels' file is another: its hash is in the link too.
    change(&dir.path().join("v.raw"), 9);
    let (mut document, _) = open(&project).unwrap();
    let refused = run(&mut document, r#"{"project":{"save":{}}}"#).unwrap_err().to_string();
    assert!(refused.contains("v.raw: blake3: ") && refused.contains("density \"whole\""), "{refused}");
    assert_eq!(document.source_trouble(false), Some(refused));
    // What is shown may be kept, if that is what is wanted.
    save_again(&mut document, "whole").unwrap();
    assert_eq!(stored(&document), voxels(9));
    drop(document);
    std::fs::remove_file(dir.path().join("v.raw")).unwrap();
    assert_eq!(stored(&open(&project).unwrap().0), voxels(9));
}

#[test]
fn a_project_that_holds_its_volume_links_to_nothing_but_the_same_voxels() {
    let dir = tempfile::tempdir().unwrap();
    let volume = detached(dir.path(), "v", 1);
    let project = dir.path().join("p");
    let mut document = opened(&volume);
    step(&mut document);
    save(&mut document, &project, "whole").unwrap();
    drop(document);
    for gone in [true, false] {
        if gone {
            std::fs::remove_file(&volume).unwrap();
        } else {
            detached(dir.path(), "v", 2);
        }
        let (mut document, _) = open(&project).unwrap();
        let refused = save_again(&mut document, "linked").unwrap_err();
        assert!(refused.contains("v.nhdr") && refused.contains("density \"whole\""), "{refused}");
        save_again(&mut document, "whole").unwrap();
        assert_eq!(stored(&document), voxels(1));
        drop(document);
        assert_eq!(stored(&open(&project).unwrap().0), voxels(1));
    }
    // The same voxels again: now it may, and goes on reading right when the generation that held them is gone.
    detached(dir.path(), "v", 1);
    let (mut document, _) = open(&project).unwrap();
    for _ in 0..3 {
        save_again(&mut document, "linked").unwrap();
        step(&mut document);
        assert_eq!(stored(&document), voxels(1));
    }
    let here = bytes(&document).0;
    drop(document);
    let (mut document, _) = open(&project).unwrap();
    assert_eq!((stored(&document), bytes(&document).0), (voxels(1), here));
    save_again(&mut document, "whole").unwrap();
    drop(document);
    std::fs::remove_file(&volume).unwrap();
    assert_eq!(stored(&open(&project).unwrap().0), voxels(1));
}

#[test]
fn a_project_finds_its_source_where_both_were_moved_and_asks_for_it_by_hash_where_not() {
    let dir = tempfile::tempdir().unwrap();
    let (here, there) = (dir.path().join("here"), dir.path().join("there"));
    let volume = detached(&here.join("data"), "v", 1);
    let mut document = opened(&volume);
    step(&mut document);
    save(&mut document, &here.join("projects/p"), "linked").unwrap();
    drop(document);
    std::fs::rename(&here, &there).unwrap();
    let project = there.join("projects/p");
    let (mut document, _) = open(&project).unwrap();
    assert_eq!(stored(&document), voxels(1));
    assert_eq!(document.source_trouble(true), None);
    save_again(&mut document, "linked").unwrap();
    drop(document);
    // Another volume lies where it was: its length is right, its hash is not.
    detached(&here.join("data"), "v", 5);
    assert_eq!(stored(&open(&project).unwrap().0), voxels(1));
    // Taken apart.
    let moved = dir.path().join("elsewhere.burin");
    std::fs::rename(&project, &moved).unwrap();
    std::fs::rename(there.join("data"), dir.path().join("attic")).unwrap();
    let refused = open(&moved).unwrap_err();
    let header = std::fs::read(dir.path().join("attic/v.nhdr")).unwrap();
    let hash = blake3::hash(&header).to_hex().to_string();
    for part in ["v.nhdr", &hash, &format!("{} bytes", header.len()), "project.open source"] {
        assert!(refused.contains(part), "{part}: {refused}");
    }
    let wrong = detached(&dir.path().join("wrong"), "v", 4);
    let refused = open_with(&json!({"path":moved,"source":wrong})).unwrap_err();
    assert!(refused.contains("v.raw: blake3: "), "{refused}");
    let given = json!({"path":moved,"source":dir.path().join("attic/v.nhdr")});
    let (mut document, _) = open_with(&given).unwrap();
    assert_eq!(stored(&document), voxels(1));
    save_again(&mut document, "linked").unwrap();
    drop(document);
    assert_eq!(stored(&open(&moved).unwrap().0), voxels(1));
}

#[test]
fn unsaved_work_on_a_detached_volume_comes_back_only_over_the_voxels_that_it_was_done_on() {
    let dir = tempfile::tempdir().unwrap();
    let volume = detached(dir.path(), "v", 1);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("states"));
    run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
    step(&mut document);
    drop(document);
    std::fs::write(dir.path().join("v.raw"), voxels(2)).unwrap();
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("states"));
    let lost = run(&mut document, r#"{"project":{"lost":{}}}"#).unwrap();
    let recover = json!({"project":{"recover":{"id":lost["lost"][0]["id"]}}}).to_string();
    let refused = run(&mut document, &recover).unwrap_err().to_string();
    assert!(refused.contains("v.raw: modified_ns: "), "{refused}");
}

#[test]
fn a_source_that_is_another_is_told_from_one_that_is_gone() {
    let dir = tempfile::tempdir().unwrap();
    let volume = detached(dir.path(), "v", 1);
    let project = dir.path().join("p");
    let mut document = opened(&volume);
    step(&mut document);
    save(&mut document, &project, "linked").unwrap();
    drop(document);
    let refused = || {
        let line = json!({"project":{"open":{"path":project}}}).to_string();
        run(&mut Document::new(), &line).unwrap_err()
    };
    let raw = dir.path().join("v.raw");
    std::fs::write(&raw, &voxels(1)[1..]).unwrap();
    let error = refused();
    assert!(
        matches!(&error, DocumentError::Keep(KeepError::SourceChanged { path, found, .. })
            if path.ends_with("v.nhdr") && found.contains("7999 bytes")),
        "{error:?}"
    );
    std::fs::remove_file(&volume).unwrap();
    let error = refused();
    assert!(
        matches!(&error, DocumentError::Keep(KeepError::SourceMissing { path, .. }) if path.ends_with("v.nhdr")),
        "{error:?}"
    );
}
