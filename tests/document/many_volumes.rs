//! Volumes beside each other: added, set, removed, taken back byte for byte, killed, saved and opened again.

use super::maker::{run, write_nrrd};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::{FieldKind, Grid, VolumeId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn file(dir: &Path, name: &str, dims: [u32; 3], spacing: f64) -> PathBuf {
    let path = dir.join(name);
    let grid = Grid::aligned(dims, DVec3::splat(spacing), DVec3::new(-3.0, 2.0, 1.0));
    write_nrrd(&path, &grid, |[x, y, z]| ((x + 2 * y + 3 * z) % 7) as f32);
    path
}

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// Every byte of every field of every volume, and what was decided about them.
fn all(document: &Document) -> (Vec<(VolumeId, Vec<u8>)>, String) {
    let state = document.state().unwrap();
    let mut bytes = Vec::new();
    for (id, volume) in &state.volumes {
        for kind in FieldKind::ALL {
            let field = volume.field(kind);
            bytes.push((*id, field.read(0, [0; 3], field.dims(0)).unwrap()));
        }
    }
    let scene = &state.scene;
    let said = (&scene.volumes, &scene.shown, &scene.own_looks, &scene.explosion.parts);
    (bytes, serde_json::to_string(&said).unwrap())
}

fn three(dir: &Path) -> Document {
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    say(&mut document, json!({"volume": {"open": {"path": file(dir, "a.nrrd", [40, 20, 10], 1.0)}}}));
    let b = say(&mut document, json!({"volume": {"add": {"path": file(dir, "b.nrrd", [12, 35, 9], 2.0)}}}));
    let path = file(dir, "c.nrrd", [33, 8, 8], 0.5);
    let c = say(&mut document, json!({"volume": {"add": {"path": path, "as": "labels", "name": "Atlas"}}}));
    assert_eq!((&b["volume"], &c["volume"], &c["segments"].as_array().unwrap().len()), (&json!(1), &json!(2), &6));
    document
}

#[test]
fn a_volume_is_laid_over_others_as_strongly_as_is_said_and_labels_show_each_id_alike() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let path = file(dir.path(), "d.nrrd", [8, 8, 8], 1.0);
    let before = all(&document);
    let too_much = json!({"volume": {"add": {"path": path, "opacity": 1.5}}});
    assert!(run(&mut document, &too_much.to_string()).unwrap_err().to_string().contains("opacity"));
    assert_eq!(all(&document), before);
    say(&mut document, json!({"volume": {"add": {"path": path, "opacity": 0.25}}}));
    let opacities = [1, 3].map(|id| document.state().unwrap().scene.volumes.all[&VolumeId(id)].opacity);
    assert_eq!(opacities, [1.0, 0.25]);
    // Ids 0 to 6: clear at 0, then of one colour and strength.
    let state = document.state().unwrap();
    let transfer = state.scene.transfer_of(VolumeId(2));
    let strength = transfer.opacity_at(1.0);
    assert!(transfer.opacity_at(0.0) == 0.0 && strength > 0.0);
    for id in 1..=6 {
        let id = f64::from(id);
        assert_eq!((transfer.opacity_at(id), transfer.colour_at(id)), (strength, transfer.colour_at(1.0)), "id {id}");
    }
}

#[test]
fn volumes_that_are_added_set_and_removed_come_back_byte_for_byte_each_way() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let turn = json!({"rotation": [0.0, 0.0, 0.6, 0.8], "translation": [1.0, 2.0, 3.0]});
    let mut seen = vec![all(&document)];
    for line in [
        json!({"volume": {"set": {"volume": 1, "name": "Follow-up", "opacity": 0.25, "pose": turn}}}),
        json!({"volume": {"set": {"volume": 2, "visible": false, "active": true}}}),
        json!({"segment": {"remove": {"id": 3}}}),
        json!({"selection": {"from_label": {"label": 2}}}),
        json!({"volume": {"remove": {"volume": 2}}}),
        json!({"volume": {"remove": {"volume": 0}}}),
        json!({"volume": {"remove": {"volume": 1}}}),
    ] {
        say(&mut document, line);
        seen.push(all(&document));
    }
    assert!(seen.last().unwrap().0.is_empty(), "a document of no volume is one");
    for step in (0..seen.len() - 1).rev() {
        say(&mut document, json!({"history": {"undo": {}}}));
        assert!(all(&document) == seen[step], "taken back to {step}");
    }
    for (step, there) in seen.iter().enumerate().skip(1) {
        say(&mut document, json!({"history": {"redo": {}}}));
        assert!(all(&document) == *there, "done again up to {step}");
    }
}

#[test]
fn volumes_come_back_after_a_crash_and_from_a_project_also_those_that_were_removed_and_brought_back() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    say(&mut document, json!({"volume": {"set": {"volume": 2, "active": true}}}));
    say(&mut document, json!({"selection": {"from_label": {"label": 2}}}));
    say(&mut document, json!({"volume": {"remove": {"volume": 2}}}));
    say(&mut document, json!({"history": {"undo": {}}}));
    let last = all(&document);
    // A program that ends without a word.
    std::mem::drop(document);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("unsaved"));
    let lost = say(&mut document, json!({"project": {"lost": {}}}))["lost"].clone();
    say(&mut document, json!({"project": {"recover": {"id": lost[0]["id"]}}}));
    assert!(all(&document) == last, "after a crash");
    let project = dir.path().join("p");
    say(&mut document, json!({"project": {"save": {"path": project}}}));
    // Saved without it, its voxels are in no file that was opened from now on but in the project: they come back all the same.
    say(&mut document, json!({"volume": {"remove": {"volume": 1}}}));
    say(&mut document, json!({"project": {"save": {}}}));
    say(&mut document, json!({"history": {"undo": {}}}));
    assert!(all(&document) == last, "brought back after a save without it");
    drop(document);
    let mut document = Document::new();
    say(&mut document, json!({"project": {"open": {"path": project}}}));
    assert!(all(&document) == last, "from the project and its journal");
}

#[test]
fn a_volume_that_is_not_there_is_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let before = all(&document);
    for line in [
        json!({"volume": {"remove": {"volume": 7}}}),
        json!({"volume": {"set": {"volume": 9, "visible": false}}}),
        json!({"volume": {"set": {"volume": 1, "opacity": 2.0}}}),
        json!({"volume": {"set": {"volume": 1, "pose": {"rotation": [0, 0, 0, 0], "translation": [0, 0, 0]}}}}),
    ] {
        assert!(run(&mut document, &line.to_string()).is_err(), "{line}");
        assert!(all(&document) == before, "{line}");
    }
}

#[test]
fn a_volume_is_called_by_its_file_without_the_folders_and_steps_say_what_was_done_to_it() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let names = |document: &Document| -> Vec<String> {
        document.state().unwrap().scene.volumes.all.values().map(|volume| volume.name.clone()).collect()
    };
    assert_eq!(names(&document), ["a.nrrd", "b.nrrd", "Atlas"]);
    for (given, step) in [
        (json!({"active": true}), "Choose volume b.nrrd"),
        (json!({"active": true, "opacity": 0.5}), "Change volume b.nrrd"),
        (json!({"visible": false}), "Hide volume b.nrrd"),
        (json!({"visible": true}), "Show volume b.nrrd"),
        (json!({"pose": {"rotation": [0, 0, 0, 1], "translation": [1, 0, 0]}}), "Move volume b.nrrd"),
        (json!({"name": "PET"}), "Rename volume b.nrrd"),
    ] {
        let mut set = json!({"volume": 1});
        set.as_object_mut().unwrap().extend(given.as_object().unwrap().clone());
        say(&mut document, json!({"volume": {"set": set}}));
        assert_eq!(document.history().undo_names().last(), Some(step), "{set}");
    }
    say(&mut document, json!({"volume": {"remove": {"volume": 1}}}));
    assert_eq!(document.history().undo_names().last(), Some("Remove volume PET"));
    assert_eq!(names(&document), ["a.nrrd", "Atlas"]);
    // There is nothing to set where there is none.
    let unknown = run(&mut document, r#"{"volume":{"set":{"volume":1,"visible":true}}}"#).unwrap_err().to_string();
    assert!(unknown.contains("0 (a.nrrd), 2 (Atlas)"), "{unknown}");
    for volume in [0, 2] {
        say(&mut document, json!({"volume": {"remove": {"volume": volume}}}));
    }
    let none = run(&mut document, r#"{"volume":{"set":{"volume":0,"visible":true}}}"#);
    assert!(none.is_err(), "{none:?}");
}

#[test]
fn questions_and_exports_reach_a_volume_that_is_not_the_active_one() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let dims = [[40, 20, 10], [12, 35, 9], [33, 8, 8]];
    let spacing = [1.0, 2.0, 0.5];
    say(&mut document, json!({"volume": {"set": {"volume": 0, "active": true}}}));
    for (id, (dims, spacing)) in dims.into_iter().zip(spacing).enumerate() {
        assert_eq!(say(&mut document, json!({"ask": {"volume": {"volume": id}}}))["dims"], json!(dims));
        let labels = say(&mut document, json!({"ask": {"field": {"field": "labels", "volume": id}}}));
        assert_eq!(labels["nonzero"] != json!(0), id == 2, "{labels}");
        let at = json!({"index": [5.0, 6.0, 7.0]});
        let voxel = say(&mut document, json!({"ask": {"voxel": {"at": at, "volume": id}}}));
        let mm = [-3.0 + 5.0 * spacing, 2.0 + 6.0 * spacing, 1.0 + 7.0 * spacing];
        assert_eq!(voxel["mm"], json!(mm));
        let path = dir.path().join(format!("out{id}.nrrd"));
        say(&mut document, json!({"volume": {"export": {"field": "density", "path": path, "volume": id}}}));
        let mut again = Document::new();
        say(&mut again, json!({"volume": {"open": {"path": path}}}));
        assert_eq!(say(&mut again, json!({"ask": {"volume": {}}}))["dims"], json!(dims));
    }
    let left_out = say(&mut document, json!({"ask": {"volume": {}}}));
    assert_eq!(left_out["dims"], json!(dims[0]));
    for question in [json!({"volume": {"volume": 7}}), json!({"field": {"field": "labels", "volume": 7}})] {
        let refused = run(&mut document, &json!({"ask": question}).to_string()).unwrap_err().to_string();
        assert!(refused.contains('7'), "{refused}");
    }
}

/// What one volume holds, field by field, and its segments.
fn of(document: &Document, id: u32) -> (Vec<Vec<u8>>, String) {
    let (bytes, _) = all(document);
    let own = bytes.into_iter().filter(|(volume, _)| *volume == VolumeId(id)).map(|(_, texels)| texels).collect();
    let settings = &document.state().unwrap().scene.volumes.all[&VolumeId(id)];
    (own, serde_json::to_string(settings).unwrap())
}

#[test]
fn what_names_a_volume_changes_that_one_alone_and_is_taken_back() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let labels = file(dir.path(), "d.nrrd", [12, 35, 9], 2.0);
    let mut commands = vec![
        json!({"segment": {"set": {"id": 3, "name": "Liver", "volume": 2}}}),
        json!({"segment": {"remove": {"id": 4, "volume": 2}}}),
        json!({"selection": {"from_label": {"label": 2, "volume": 2}}}),
        json!({"selection": {"clear": {"volume": 2}}}),
        json!({"segment": {"import": {"path": labels, "volume": 1}}}),
        json!({"selection": {"import": {"path": labels, "threshold": 2.5, "volume": 1}}}),
    ];
    let paints = crate::common::gpu::gpu().is_some();
    if paints {
        let points = json!([{"at": {"index": [5, 5, 5]}}, {"at": {"index": [7, 5, 4]}}]);
        commands.push(json!({"stroke": {"paint": {"points": points, "volume": 1}}}));
        commands.push(json!({"stroke": {"paint": {"points": points, "volume": 2}}}));
    }
    for (target, commands) in
        [(json!({"density": 9.0}), &commands[..]), (json!({"colour": [1, 0, 0, 1]}), &commands[6..])]
    {
        say(&mut document, json!({"brush": {"set": {"target": target, "radius_mm": 2.0}}}));
        for command in commands {
            let verb = command.as_object().unwrap().values().next().unwrap().as_object().unwrap().values().next();
            let named = verb.unwrap()["volume"].as_u64().unwrap() as u32;
            let before: Vec<_> = (0..3).map(|id| of(&document, id)).collect();
            let answer = say(&mut document, command.clone());
            assert_ne!(answer["step"], Value::Null, "{command}: {answer}");
            for id in 0..3 {
                assert_eq!(of(&document, id) != before[id as usize], id == named, "{command}: volume {id}");
            }
            let after = of(&document, named);
            say(&mut document, json!({"history": {"undo": {}}}));
            for id in 0..3 {
                assert!(of(&document, id) == before[id as usize], "{command} taken back: volume {id}");
            }
            say(&mut document, json!({"history": {"redo": {}}}));
            assert!(of(&document, named) == after, "{command} done again");
            let mut elsewhere = command.clone();
            let noun = elsewhere.as_object_mut().unwrap().values_mut().next().unwrap();
            noun.as_object_mut().unwrap().values_mut().next().unwrap()["volume"] = json!(9);
            let refused = run(&mut document, &elsewhere.to_string()).unwrap_err().to_string();
            assert!(refused.contains("2 (Atlas)"), "{refused}");
        }
    }
}

#[test]
fn windows_and_transfer_functions_are_those_of_the_volume_that_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let shown = |document: &Document, id: u32| {
        let scene = &document.state().unwrap().scene;
        let id = VolumeId(id);
        (scene.window_of(id), scene.transfer_of(id).clone())
    };
    let before: Vec<_> = (0..3).map(|id| shown(&document, id)).collect();
    say(&mut document, json!({"view": {"window": {"level": 3.0, "width": 5.0, "volume": 1}}}));
    assert_eq!((shown(&document, 1).0.level, shown(&document, 1).0.width), (3.0, 5.0));
    let function = json!({"colour": [[0, [1, 0, 0]]], "opacity": [[0, 0], [6, 1]], "unit_mm": 1});
    say(&mut document, json!({"transfer": {"set": {"function": function, "volume": 2}}}));
    assert_eq!(shown(&document, 2).1.opacity.len(), 2);
    assert!(
        shown(&document, 0) == before[0]
            && shown(&document, 1).1 == before[1].1
            && shown(&document, 2).0 == before[2].0
    );
    say(&mut document, json!({"transfer": {"set": {"function": function, "volume": 1}}}));
    say(&mut document, json!({"transfer": {"reset": {"volume": 1}}}));
    assert!(shown(&document, 1).1 == before[1].1, "made from its own histogram");
    for command in [
        json!({"view": {"window": {"level": 1, "width": 1, "volume": 7}}}),
        json!({"transfer": {"reset": {"volume": 7}}}),
    ] {
        let refused = run(&mut document, &command.to_string()).unwrap_err().to_string();
        assert!(refused.contains("1 (b.nrrd)"), "{refused}");
    }
}

#[test]
fn a_place_is_told_of_every_visible_volume() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    // The value of a file is (x + 2y + 3z) mod 7; where a volume is moved, another of its voxels lies there.
    let at = |index: [u32; 3]| f64::from((index[0] + 2 * index[1] + 3 * index[2]) % 7);
    let pose = json!({"rotation": [0, 0, 0, 1], "translation": [4.0, 0.0, 0.0]});
    say(&mut document, json!({"volume": {"set": {"volume": 1, "pose": pose}}}));
    let place = json!({"ask": {"voxel": {"at": {"mm": [-3.0 + 8.0, 2.0 + 2.0, 1.0 + 2.0]}}}});
    let told = say(&mut document, place.clone());
    assert_eq!(told["density"], json!(at([8, 2, 2])));
    let names: Vec<_> =
        told["volumes"].as_array().unwrap().iter().map(|v| (v["volume"].clone(), v["name"].clone())).collect();
    assert_eq!(names, [(json!(0), json!("a.nrrd")), (json!(1), json!("b.nrrd")), (json!(2), json!("Atlas"))]);
    assert_eq!(told["volumes"][0]["density"], json!(at([8, 2, 2])));
    assert_eq!(told["volumes"][1]["density"], json!(at([2, 1, 1])), "moved by two of its voxels");
    assert_eq!(
        (&told["volumes"][2]["density"], &told["volumes"][2]["label"]),
        (&json!(at([16, 4, 4])), &json!(at([16, 4, 4]) as u32))
    );
    say(&mut document, json!({"volume": {"set": {"volume": 1, "visible": false}}}));
    let told = say(&mut document, place.clone());
    assert_eq!(told["volumes"].as_array().unwrap().len(), 2, "{told}");
    say(&mut document, json!({"volume": {"remove": {"volume": 1}}}));
    say(&mut document, json!({"volume": {"remove": {"volume": 2}}}));
    assert_eq!(say(&mut document, place).get("volumes"), None, "one volume is told as ever");
}

#[test]
fn a_stroke_that_a_crash_cut_off_is_painted_on_the_volume_that_it_ran_on() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    say(&mut document, json!({"brush": {"set": {"target": {"selection": 1.0}, "radius_mm": 3.0}}}));
    let before: Vec<_> = (0..3).map(|id| of(&document, id)).collect();
    say(&mut document, json!({"stroke": {"begin": {"points": [{"at": {"index": [5, 5, 5]}}], "volume": 1}}}));
    say(&mut document, json!({"stroke": {"extend": {"points": [{"at": {"index": [8, 6, 5]}}]}}}));
    // A program that ends without a word.
    std::mem::drop(document);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("unsaved"));
    let lost = say(&mut document, json!({"project": {"lost": {}}}))["lost"].clone();
    say(&mut document, json!({"project": {"recover": {"id": lost[0]["id"]}}}));
    for id in 0..3 {
        assert_eq!(of(&document, id) != before[id as usize], id == 1, "volume {id}");
    }
    let voxel = json!({"ask": {"voxel": {"at": {"index": [8, 6, 5]}, "volume": 1}}});
    assert_eq!(say(&mut document, voxel)["selection"], json!(1.0));
}

/// What undo knows: every byte, and what was decided of the volumes.
fn decided(document: &Document) -> (Vec<(VolumeId, Vec<u8>)>, String) {
    let scene = &document.state().unwrap().scene;
    let said = (&scene.volumes, &scene.own_looks, &scene.explosion.parts, scene.explosion.next_id);
    (all(document).0, serde_json::to_string(&said).unwrap())
}

/// A look, a part of one, or none.
fn any_look(rng: &mut ChaCha8Rng) -> Value {
    let opacity = f64::from(rng.random_range(0..5)) / 4.0;
    match rng.random_range(0..5) {
        0 => json!("inherit"),
        1 => json!({ "opacity": opacity }),
        2 => json!({"mode": "mip", "lighting": null}),
        3 => json!({"mode": {"iso": 2.5}, "shaded": true, "opacity": opacity}),
        _ => json!({"transfer": {"colour": [[0, [1, 0, 0]]], "opacity": [[1, 0], [4, opacity]], "unit_mm": 2}}),
    }
}

/// A command on any of the volumes that there are, or one that adds or takes away one.
fn any_command(rng: &mut ChaCha8Rng, document: &Document, dir: &Path, n: usize) -> Value {
    let ids: Vec<u32> = document.state().unwrap().volumes.keys().map(|id| id.0).collect();
    let volume = ids[rng.random_range(0..ids.len())];
    let label = rng.random_range(1..7);
    match rng.random_range(0..18) {
        0 if ids.len() > 1 => json!({"volume": {"remove": {"volume": volume}}}),
        0 | 1 => {
            let dims = [rng.random_range(3..40), rng.random_range(3..40), rng.random_range(3..12)];
            let open_as = if rng.random_bool(0.5) { "labels" } else { "image" };
            json!({"volume": {"add": {"path": file(dir, &format!("{n}.nrrd"), dims, 1.5), "as": open_as}}})
        }
        2 => json!({"volume": {"set": {"volume": volume, "opacity": rng.random_range(0..9) as f64 / 8.0}}}),
        3 => {
            json!({"volume": {"set": {"volume": volume, "name": format!("Volume {n}"), "visible": rng.random_bool(0.5)}}})
        }
        4 => json!({"volume": {"set": {"volume": volume, "active": true}}}),
        5 => {
            let shift = [rng.random_range(-9..9), 0, rng.random_range(-9..9)];
            json!({"volume": {"set": {"volume": volume, "pose": {"rotation": [0, 0, 0, 1], "translation": shift}}}})
        }
        6 => json!({"segment": {"set": {"id": label, "name": format!("Segment {n}"), "volume": volume}}}),
        7 => json!({"segment": {"remove": {"id": label, "volume": volume}}}),
        8 => json!({"segment": {"import": {"path": dir.join("c.nrrd"), "volume": volume}}}),
        9 => json!({"selection": {"from_label": {"label": label, "volume": volume}}}),
        11 | 12 => {
            let look = any_look(rng);
            json!({"segment": {"set": {"id": label, "look": look, "volume": volume}}})
        }
        13 => json!({"selection": {"set": {"look": any_look(rng), "volume": volume}}}),
        14 => {
            let parts = &document.state().unwrap().scene.explosion.parts;
            let id = parts[rng.random_range(0..parts.len())].id;
            json!({"part": {"set": {"id": id, "look": any_look(rng)}}})
        }
        15 => json!({"segment": {"show_only": {"ids": [0, label], "volume": volume}}}),
        16 => {
            let at = [rng.random_range(-9..40), rng.random_range(-9..40), 0];
            json!({"part": {"split": {"by": {"plane": {"point": at, "normal": [1, label, 2]}}}}})
        }
        17 => json!({"volume": {"set": {"volume": volume, "look": any_look(rng)}}}),
        10 => json!({"selection": {"import": {"path": dir.join("a.nrrd"), "threshold": label - 1, "volume": volume}}}),
        _ => json!({"selection": {"clear": {"volume": volume}}}),
    }
}

#[test]
fn random_walks_over_volumes_come_back_by_undo_redo_crashes_and_saves() {
    for seed in 0..4 {
        let dir = tempfile::tempdir().unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut document = three(dir.path());
        let mut trace = Vec::new();
        let mut kept = vec![decided(&document)];
        let begun = document.history().undo_names().count();
        for n in 0..32 {
            let command = any_command(&mut rng, &document, dir.path(), n);
            trace.push(command.to_string());
            // A label that is not there, or a file that lies elsewhere, is refused, and has changed nothing.
            let step = run(&mut document, &command.to_string()).is_ok_and(|answer| answer["step"] != Value::Null);
            if step {
                kept.push(decided(&document));
            } else {
                assert!(decided(&document) == kept[kept.len() - 1], "{seed}: changed without a step: {trace:#?}");
            }
        }
        assert_eq!(document.history().undo_names().count() - begun, kept.len() - 1, "{seed}: {trace:#?}");
        for at in (0..kept.len() - 1).rev() {
            say(&mut document, json!({"history": {"undo": {}}}));
            assert!(decided(&document) == kept[at], "{seed}: undo to {at} of {trace:#?}");
        }
        for (at, kept) in kept.iter().enumerate().skip(1) {
            say(&mut document, json!({"history": {"redo": {}}}));
            assert!(decided(&document) == *kept, "{seed}: redo to {at} of {trace:#?}");
        }
        let last = all(&document);
        // A program that ends without a word.
        std::mem::drop(document);
        let mut document = Document::new();
        document.keep_unsaved_in(dir.path().join("unsaved"));
        let lost = say(&mut document, json!({"project": {"lost": {}}}))["lost"].clone();
        say(&mut document, json!({"project": {"recover": {"id": lost[0]["id"]}}}));
        assert!(all(&document) == last, "{seed}: after a crash: {trace:#?}");
        say(&mut document, json!({"project": {"save": {"path": dir.path().join("p")}}}));
        drop(document);
        let mut document = Document::new();
        say(&mut document, json!({"project": {"open": {"path": dir.path().join("p")}}}));
        assert_eq!(all(&document).1, last.1, "{seed}: from the project: {trace:#?}");
        assert!(all(&document) == last, "{seed}: from the project: {trace:#?}");
    }
}

#[test]
fn a_volumes_function_is_reset_to_that_which_it_was_laid_beside_others_with() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let grid = Grid::aligned([16, 14, 12], DVec3::splat(2.0), DVec3::ZERO);
    type Value = fn([u32; 3]) -> f32;
    let maps: [(&str, Value); 3] = [
        ("blocks", |[x, y, _]| ((x / 4 + y / 5) % 4) as f32),
        // Neither do its ids stand in runs, nor are they few.
        ("salt", |[x, y, z]| ((x * 7 + y * 31 + z * 101) % 300) as f32),
        ("sparse", |[x, y, z]| if (x * y * z) % 7 == 3 { 4.0 } else { 0.0 }),
    ];
    for (name, value) in maps {
        let path = dir.path().join(format!("{name}.nrrd"));
        write_nrrd(&path, &grid, value);
        for open_as in ["labels", "image"] {
            let added = say(&mut document, json!({"volume": {"add": {"path": path, "as": open_as}}}));
            let volume = added["volume"].as_u64().unwrap() as u32;
            let function = |document: &Document| document.state().unwrap().scene.transfer_of(VolumeId(volume)).clone();
            let first = function(&document);
            let other = json!({"colour": [[0, [1, 0, 0]]], "opacity": [[0, 0], [6, 1]], "unit_mm": 1});
            say(&mut document, json!({"transfer": {"set": {"function": other, "volume": volume}}}));
            assert_ne!(function(&document), first);
            let path = dir.path().join("p.burin");
            say(&mut document, json!({"project": {"save": {"path": path}}}));
            document = Document::new();
            say(&mut document, json!({"project": {"open": {"path": path}}}));
            say(&mut document, json!({"transfer": {"reset": {"volume": volume}}}));
            assert_eq!(function(&document), first, "{name} as {open_as}");
        }
    }
}
