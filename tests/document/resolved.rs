//! A step keeps the command that made it, so that it can be done again: pixels as places, strokes with their brush, files by hash.

use super::maker::{bytes, labelled, run, write_nrrd};
use super::maker_gpu::block;
use crate::common::one::One;
use burin::document::{Document, FileRead, ResolvedCommand};
use burin::math::DVec3;
use burin::volume::Grid;
use serde_json::{Value, json};

fn say(document: &mut Document, line: &Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// The commands of the steps, the newest first.
fn kept(document: &mut Document, of: &str) -> Vec<Vec<ResolvedCommand>> {
    let answer = say(document, &json!({"ask":{"history":{"commands":true}}}));
    serde_json::from_value(answer[of].clone()).unwrap_or_else(|e| panic!("{answer}: {e}"))
}

/// Does what a step keeps in another document.
fn again(document: &mut Document, command: &ResolvedCommand) {
    if let Some(brush) = &command.brush {
        let mut set = serde_json::to_value(brush).unwrap();
        let set = set.as_object_mut().unwrap();
        set.remove("falloff_before_labels");
        set.insert("any_value".into(), json!(brush.range.is_none()));
        say(document, &json!({"brush":{"set":set}}));
    }
    if let Some(camera) = &command.camera {
        say(document, &json!({"view":{"camera":{"camera":camera}}}));
    }
    document.apply(command.command.clone()).unwrap();
}

#[test]
fn a_file_that_was_read_is_kept_by_its_hash() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = labelled();
    let grid: Grid = *document.state().unwrap().one().grid();
    let path = folder.path().join("l.nrrd");
    write_nrrd(&path, &grid, |[x, ..]| (x / 30) as f32);
    say(&mut document, &json!({"segment":{"import":{"path":path}}}));
    say(&mut document, &json!({"selection":{"import":{"path":path,"threshold":0.5}}}));
    let content = std::fs::read(&path).unwrap();
    let read = FileRead {
        path: path.clone(),
        bytes: content.len() as u64,
        blake3: blake3::hash(&content).to_hex().to_string(),
    };
    say(&mut document, &json!({"volume":{"add":{"path":path,"as":"labels"}}}));
    say(&mut document, &json!({"volume":{"add":{"path":path}}}));
    let steps = kept(&mut document, "undo_commands");
    assert_eq!(steps.len(), 4);
    for step in &steps {
        assert_eq!(step.len(), 1);
        assert_eq!(step[0].files, std::slice::from_ref(&read));
    }
    // On disk and taken back it is the same.
    say(&mut document, &json!({"history":{"budget":{"bytes":0}}}));
    assert_eq!(kept(&mut document, "undo_commands"), steps);
    say(&mut document, &json!({"history":{"undo":{"steps":4}}}));
    assert_eq!(kept(&mut document, "redo_commands"), steps.iter().rev().cloned().collect::<Vec<_>>());
    assert_eq!(kept(&mut document, "undo_commands"), [] as [Vec<ResolvedCommand>; 0]);
    // Whoever does not ask is not told.
    assert!(say(&mut document, &json!({"ask":{"history":{}}})).get("undo_commands").is_none());
}

#[test]
fn a_volume_of_several_files_is_kept_by_the_hashes_of_all_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let [path, voxels] = ["v.nhdr", "v.raw"].map(|name| folder.path().join(name));
    std::fs::write(&path, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: v.raw\n\n")
        .unwrap();
    std::fs::write(&voxels, (0..24).collect::<Vec<u8>>()).unwrap();
    let mut document = labelled();
    say(&mut document, &json!({"volume":{"add":{"path":path}}}));
    let mut found: Vec<_> = kept(&mut document, "undo_commands")[0][0]
        .files
        .iter()
        .map(|file| (file.path.clone(), file.bytes, file.blake3.clone()))
        .collect();
    found.sort();
    let wanted = [path, voxels].map(|path| {
        let content = std::fs::read(&path).unwrap();
        (path, content.len() as u64, blake3::hash(&content).to_hex().to_string())
    });
    assert_eq!(found, wanted);
}

#[test]
fn a_group_keeps_what_counts_of_it_and_does_the_same_again() {
    let mut document = labelled();
    say(&mut document, &json!({"history":{"begin":{}}}));
    for value in [0.1, 0.2, 0.3] {
        say(&mut document, &json!({"explosion":{"degree":{"value":value}}}));
    }
    say(&mut document, &json!({"segment":{"set":{"id":1,"name":"jaw"}}}));
    say(&mut document, &json!({"segment":{"set":{"id":1,"colour":[1,0,0]}}}));
    say(&mut document, &json!({"explosion":{"degree":{"value":0.5}}}));
    say(&mut document, &json!({"history":{"end":{}}}));
    let steps = kept(&mut document, "undo_commands");
    let said: Vec<Value> = steps[0].iter().map(|c| serde_json::to_value(&c.command).unwrap()).collect();
    assert_eq!(said.len(), 4, "{said:?}");
    assert_eq!(said[0], json!({"explosion":{"degree":{"value":0.3}}}), "of a drag where it ends");
    assert_eq!(said[3], json!({"explosion":{"degree":{"value":0.5}}}));
    let mut other = labelled();
    steps[0].iter().for_each(|command| again(&mut other, command));
    assert!(bytes(&other) == bytes(&document));
}

#[test]
fn pixels_are_kept_as_places_and_cut_and_paint_the_same_whatever_is_seen_then() {
    let (Some(mut document), Some(mut other)) = (block(), block()) else { return };
    let disc = json!({"shape":"disc","radius_mm":6,"falloff":"hard","target":{"selection":1}});
    let slice = |x: f64| json!({"at":{"pixel":{"view":"coronal","px":[x,30],"size":[64,64]}}});
    let seen = |x: f64| json!({"at":{"pixel":{"view":"3d","px":[x,32],"size":[64,64]}}});
    for line in [
        json!({"view":{"size":{"view":"3d","size":[64,64]}}}),
        json!({"brush":{"set":disc}}),
        json!({"stroke":{"paint":{"points":[slice(20.0), slice(40.0)]}}}),
        json!({"brush":{"set":{"shape":"sphere","target":{"colour":[1,0,0,1]},"visible_only":true}}}),
        json!({"stroke":{"paint":{"points":[seen(24.0), seen(36.0)]}}}),
        json!({"part":{"split":{"by":{"depth":{"px":[32,32]}}}}}),
        json!({"part":{"split":{"by":{"line":{"from":[0,20],"to":[64,44]}}}}}),
        json!({"part":{"split":{"by":{"axis":{"px":[30,34],"axis":"vertical"}}}}}),
    ] {
        say(&mut document, &line);
    }
    let steps = kept(&mut document, "undo_commands");
    let said = serde_json::to_string(&steps).unwrap();
    assert!(!said.contains("pixel") && !said.contains("\"px\""), "{said}");
    assert_eq!(steps.iter().map(Vec::len).collect::<Vec<_>>(), [1; 5]);
    // Seen from elsewhere, in another size.
    say(&mut other, &json!({"view":{"size":{"view":"coronal","size":[200,90]}}}));
    say(&mut other, &json!({"view":{"frame":{"from":[1,1,1]}}}));
    say(&mut other, &json!({"view":{"size":{"view":"3d","size":[64,64]}}}));
    for step in steps.iter().rev() {
        again(&mut other, &step[0]);
    }
    assert!(bytes(&other) == bytes(&document));
    // A disc lies in its slice: without that it would have been painted another way.
    let first = serde_json::to_value(&steps[4][0]).unwrap();
    let normal = &first["command"]["stroke"]["paint"]["points"][0]["normal"];
    let normal: DVec3 = serde_json::from_value(normal.clone()).unwrap();
    assert!((normal.length() - 1.0).abs() < 1e-9 && normal.z.abs() < 0.5, "{normal}");
}
