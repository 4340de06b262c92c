//! Where parts stand is found and not decided: it is in no scene, no history and no journal, and yet it is there at once.

use super::keep_support::write_sealed;
use super::maker::{bytes, run, write_nrrd};
use super::maker_gpu::{block, cut, select};
use burin::document::{Document, State, ViewName};
use burin::math::{DVec3, Pose};
use burin::volume::Grid;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn say(document: &mut Document, command: Value) -> Value {
    run(document, &command.to_string()).unwrap()
}

fn degree(document: &mut Document, value: f64) {
    say(document, json!({"explosion":{"degree":{"value":value}}}));
}

fn settle(document: &mut Document) -> Value {
    say(document, json!({"explosion":{"settle":{}}}))
}

/// All that a script is told of the parts.
fn parts(document: &mut Document) -> Value {
    say(document, json!({"ask":{"parts":{}}}))
}

fn poses(document: &Document) -> Vec<Pose> {
    document.poses().in_order(&document.state().unwrap().scene.explosion.parts)
}

fn are_home(document: &Document) -> bool {
    poses(document).iter().all(|pose| *pose == Pose::IDENTITY)
}

fn step_to_rest(document: &mut Document) {
    for _ in 0..2000 {
        if say(document, json!({"explosion":{"step":{"steps":4}}}))["moving"] == false {
            return;
        }
    }
    panic!("parts never come to rest");
}

/// Eight parts about a selection, saved as a project; closed.
fn saved(dir: &Path) -> Option<(Document, PathBuf)> {
    let mut document = block()?;
    cut(&mut document);
    select(&mut document);
    let project = dir.join("block.burin");
    say(&mut document, json!({"project":{"save":{"path":project}}}));
    Some((document, project))
}

fn opened(project: &Path) -> Document {
    let mut document = Document::new();
    let answer = say(&mut document, json!({"project":{"open":{"path":project}}}));
    assert_eq!(answer["warnings"], json!([]));
    document
}

fn journal(project: &Path, generation: u32) -> Vec<u8> {
    std::fs::read(project.join(format!("journal-{generation:06}"))).unwrap()
}

#[test]
fn a_moving_explosion_writes_nothing_to_scene_history_and_journal() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 1.0);
    let known = |d: &mut Document| {
        let scene = serde_json::to_string(&d.state().unwrap().scene).unwrap();
        let names: Vec<String> = d.history().undo_names().chain(d.history().redo_names()).map(String::from).collect();
        (scene, names, journal(&project, 1))
    };
    let before = known(&mut document);
    step_to_rest(&mut document);
    let noted = std::fs::read(project.join("journal-000001.poses")).unwrap();
    let apart = poses(&document);
    assert!(!are_home(&document));
    assert!(known(&mut document) == before);
    // Neither do views that turn meanwhile, nor what is on its way beside its poses.
    for _ in 0..5 {
        say(&mut document, json!({"view":{"orbit":{"azimuth_deg":9,"elevation_deg":3}}}));
        say(&mut document, json!({"explosion":{"step":{"steps":2}}}));
    }
    assert_ne!(poses(&document), apart);
    assert!(std::fs::read(project.join("journal-000001.poses")).unwrap() == noted);
    say(&mut document, json!({"view":{"frame":{"from":[1,1,1]}}}));
    let before = known(&mut document);
    settle(&mut document);
    assert_ne!(poses(&document), apart);
    assert!(known(&mut document) == before);
    // What is told of the parts says where they stand; what is kept of the scene does not.
    let all = parts(&mut document)["parts"].take();
    assert_eq!(say(&mut document, json!({"ask":{"scene":{}}}))["scene"]["explosion"]["parts"], all);
    say(&mut document, json!({"project":{"save":{}}}));
    let kept = std::fs::read(project.join("generation-000002/generation.json")).unwrap();
    let kept: Value = serde_json::from_slice(&kept).unwrap();
    for (kept, told) in kept["scene"]["explosion"]["parts"].as_array().unwrap().iter().zip(all.as_array().unwrap()) {
        assert_eq!(kept["pose"], json!(Pose::IDENTITY));
        assert_ne!(told["pose"], json!(Pose::IDENTITY));
    }
}

#[test]
fn a_saved_project_shows_its_poses_at_once_and_has_nowhere_to_move() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 0.7);
    settle(&mut document);
    say(&mut document, json!({"project":{"save":{}}}));
    let picture = |d: &mut Document| d.picture(ViewName::ThreeD, [64, 64], None).unwrap().colour;
    let (stand, shown) = (parts(&mut document), picture(&mut document));
    drop(document);
    let mut document = opened(&project);
    assert_eq!(parts(&mut document), stand);
    assert!(!document.must_move() && picture(&mut document) == shown && !document.is_unsaved());
    // Reading ahead is no reason to move.
    document.prepare().unwrap();
    assert!(!document.must_move());
    // What it was found for is known with it: nothing moves before something is another way.
    let at = poses(&document);
    step_to_rest(&mut document);
    assert_eq!(poses(&document), at);
    say(&mut document, json!({"view":{"frame":{"from":[1,1,1]}}}));
    assert!(document.must_move());
}

#[test]
fn parts_that_were_saved_on_their_way_stand_there_and_go_on() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 1.0);
    say(&mut document, json!({"explosion":{"step":{"steps":9}}}));
    say(&mut document, json!({"project":{"save":{}}}));
    let stand = parts(&mut document);
    drop(document);
    let mut document = opened(&project);
    assert!(!are_home(&document) && document.must_move());
    assert_eq!(parts(&mut document), stand);
    step_to_rest(&mut document);
    let rest = poses(&document);
    settle(&mut document);
    assert_eq!(poses(&document), rest);
}

#[test]
fn after_a_crash_parts_stand_where_they_last_rested_and_what_was_decided_is_there() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 1.0);
    settle(&mut document);
    let rest = parts(&mut document);
    drop(document);
    let mut document = opened(&project);
    assert_eq!(parts(&mut document), rest);
    assert!(!are_home(&document) && !document.must_move());
    // Halves stand where the whole stood.
    let id = rest["parts"][0]["id"].clone();
    say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[16,12,10],"normal":[1,2,1],"part":id}}}}}));
    let halves = parts(&mut document);
    let last = halves["parts"].as_array().unwrap().len() - 1;
    for half in [last - 1, last] {
        assert_eq!(halves["parts"][half]["pose"], rest["parts"][0]["pose"]);
    }
    drop(document);
    let mut document = opened(&project);
    assert_eq!(parts(&mut document), halves);
    // A degree that nobody let the parts follow: they stand where they stood, and know where to go.
    degree(&mut document, 0.4);
    drop(document);
    let mut document = opened(&project);
    let stand = parts(&mut document);
    assert_eq!((&stand["degree"], &stand["parts"]), (&json!(0.4), &halves["parts"]));
    assert!(document.must_move());
    step_to_rest(&mut document);
    let way = poses(&document);
    settle(&mut document);
    assert_eq!(poses(&document), way);
}

#[test]
fn a_document_that_was_never_saved_comes_back_with_its_poses() {
    if block().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("ball.nrrd");
    let grid = Grid::aligned([40, 36, 33], DVec3::ONE, DVec3::ZERO);
    let middle = DVec3::new(20.0, 18.0, 16.0);
    let inside = |v: [u32; 3]| DVec3::from_array(v.map(f64::from)).distance(middle) < 14.0;
    write_nrrd(&file, &grid, |v| if inside(v) { 100.0 } else { 0.0 });
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("state"));
    say(&mut document, json!({"volume":{"open":{"path":file}}}));
    for normal in [[1, 0, 0], [0, 1, 0]] {
        let by = json!({"plane":{"point":middle.to_array(),"normal":normal}});
        say(&mut document, json!({"part":{"split":{"by":by}}}));
    }
    say(&mut document, json!({"selection":{"import":{"path":file,"threshold":50,"soften_mm":0}}}));
    degree(&mut document, 1.0);
    settle(&mut document);
    assert!(!are_home(&document));
    let rest = parts(&mut document);
    drop(document);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.path().join("state"));
    let lost = say(&mut document, json!({"project":{"lost":{}}}))["lost"][0]["id"].clone();
    say(&mut document, json!({"project":{"recover":{"id":lost}}}));
    assert_eq!(parts(&mut document), rest);
}

#[test]
fn undo_and_redo_bring_each_degree_with_its_poses() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    let mut stood = vec![(bytes(&document), parts(&mut document))];
    for value in [1.0, 0.4, 0.8, 0.0] {
        degree(&mut document, value);
        settle(&mut document);
        stood.push((bytes(&document), parts(&mut document)));
    }
    for (undo, order) in [("undo", [3, 2, 1, 0]), ("redo", [1, 2, 3, 4])] {
        for i in order {
            say(&mut document, json!({"history":{undo:{}}}));
            assert_eq!((bytes(&document), parts(&mut document)), stood[i], "{undo} to {i}");
            assert!(!document.must_move(), "{undo} to {i}");
        }
    }
    say(&mut document, json!({"history":{"undo":{"steps":3}}}));
    assert_eq!((bytes(&document), parts(&mut document)), stood[1]);
    // A motion that is cut short is where it was, too, and goes on from there.
    degree(&mut document, 0.2);
    say(&mut document, json!({"explosion":{"step":{"steps":5}}}));
    let between = parts(&mut document);
    say(&mut document, json!({"history":{"undo":{}}}));
    assert_eq!((bytes(&document), parts(&mut document)), stood[1]);
    say(&mut document, json!({"history":{"redo":{}}}));
    assert_eq!(parts(&mut document), between);
    assert!(document.must_move());
}

#[test]
fn undo_of_a_name_leaves_parts_where_they_stand() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    degree(&mut document, 1.0);
    settle(&mut document);
    let (first, id) = (poses(&document), parts(&mut document)["parts"][0]["id"].clone());
    say(&mut document, json!({"part":{"set":{"id":id,"name":"lobe","colour":[1,0,0]}}}));
    assert!(!document.must_move(), "a name pushes nothing");
    say(&mut document, json!({"view":{"frame":{"from":[1,1,1]}}}));
    settle(&mut document);
    let second = poses(&document);
    assert_ne!(second, first);
    say(&mut document, json!({"history":{"undo":{}}}));
    assert_eq!(poses(&document), second);
    assert_eq!(parts(&mut document)["parts"][0]["name"], "Part 8");
}

#[test]
fn a_hand_s_pose_is_a_decision() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 1.0);
    settle(&mut document);
    let free = parts(&mut document);
    let id = free["parts"][3]["id"].clone();
    let pinned = |d: &mut Document| {
        let part = parts(d)["parts"][3].clone();
        (part["pinned"].clone(), part["pose"].clone())
    };
    // Who pins a part wants it where it is.
    let said = say(&mut document, json!({"part":{"set":{"id":id,"pinned":true}}}));
    assert_eq!((&said["step"], &said["part"]["pose"]), (&json!("Pin Part 11"), &free["parts"][3]["pose"]));
    say(&mut document, json!({"view":{"frame":{"from":[1,1,1]}}}));
    settle(&mut document);
    assert_eq!(pinned(&mut document), (json!(true), free["parts"][3]["pose"].clone()));
    // Dragged, in one step; let go it stays until forces take it.
    let hand = json!({"rotation":[0.0,0.0,0.6,0.8],"translation":[9.0,-4.0,2.0]});
    say(&mut document, json!({"history":{"begin":{}}}));
    for _ in 0..3 {
        say(&mut document, json!({"part":{"move":{"id":id,"pose":hand}}}));
    }
    say(&mut document, json!({"history":{"end":{}}}));
    settle(&mut document);
    let held = parts(&mut document);
    assert_eq!(held["parts"][3]["pose"], hand);
    say(&mut document, json!({"part":{"set":{"id":id,"pinned":false}}}));
    assert_eq!(pinned(&mut document), (json!(false), hand.clone()));
    assert!(document.must_move());
    drop(document);
    let mut document = opened(&project);
    assert_eq!(pinned(&mut document), (json!(false), hand));
    settle(&mut document);
    assert_ne!(parts(&mut document)["parts"][3]["pose"], held["parts"][3]["pose"]);
}

#[test]
fn a_drag_that_is_taken_back_leaves_everything_where_it_stood() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    degree(&mut document, 1.0);
    settle(&mut document);
    let before = (bytes(&document), parts(&mut document));
    let id = before.1["parts"][2]["id"].clone();
    say(&mut document, json!({"history":{"begin":{}}}));
    // Far more than undo remembers of anything.
    for i in 0..300 {
        let pose = json!({"rotation":[0,0,0,1],"translation":[i,0,0]});
        say(&mut document, json!({"part":{"move":{"id":id,"pose":pose}}}));
    }
    say(&mut document, json!({"history":{"cancel":{}}}));
    assert_eq!((bytes(&document), parts(&mut document)), before);
    assert!(!document.must_move());
}

#[test]
fn a_cache_that_is_damaged_or_gone_costs_no_more_than_finding_poses_again() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 1.0);
    settle(&mut document);
    let rest = parts(&mut document);
    drop(document);
    let cache = project.join("journal-000001.poses");
    let whole = std::fs::read(&cache).unwrap();
    let mut bent = whole.clone();
    let digit = bent.iter().rposition(u8::is_ascii_digit).unwrap();
    bent[digit] = if bent[digit] == b'1' { b'2' } else { b'1' };
    for damage in [Some(&b""[..]), Some(&whole[..whole.len() / 2]), Some(&bent), Some(b"\n{}"), None] {
        match damage {
            Some(bytes) => std::fs::write(&cache, bytes).unwrap(),
            None => std::fs::remove_file(&cache).unwrap(),
        }
        let mut document = opened(&project);
        assert!(are_home(&document) && document.must_move(), "{damage:?}");
        settle(&mut document);
        assert_eq!(parts(&mut document), rest);
    }
    // A project whose poses are none, by hand: told, and no part is lost.
    let mut document = opened(&project);
    say(&mut document, json!({"project":{"save":{}}}));
    drop(document);
    let manifest = project.join("generation-000002/generation.json");
    let mut kept: Value = serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
    kept["poses"]["parts"][1]["pose"]["rotation"] = json!([0.0, 0.0, 0.0, 7.0]);
    write_sealed(&manifest, &kept);
    let mut document = Document::new();
    let told = say(&mut document, json!({"project":{"open":{"path":project}}}))["warnings"].to_string();
    assert!(told.contains("parts[1].pose") && told.contains("a unit quaternion"), "{told}");
    assert!(are_home(&document) && document.must_move());
    settle(&mut document);
    assert_eq!(parts(&mut document), rest);
}

#[test]
fn what_was_not_saved_goes_with_its_poses_and_what_a_crash_left_stays() {
    let dir = tempfile::tempdir().unwrap();
    let Some((mut document, project)) = saved(dir.path()) else { return };
    degree(&mut document, 1.0);
    settle(&mut document);
    say(&mut document, json!({"project":{"save":{}}}));
    let first = parts(&mut document);
    let turn = |d: &mut Document, from: [i32; 3]| {
        say(d, json!({"view":{"frame":{"from":from}}}));
        settle(d);
        parts(d)
    };
    assert_ne!(turn(&mut document, [1, 1, 1]), first);
    document.discard_unsaved().unwrap();
    let mut document = opened(&project);
    assert_eq!(parts(&mut document), first);
    let crashed = turn(&mut document, [1, 0, 1]);
    drop(document);
    let mut document = opened(&project);
    assert_eq!(parts(&mut document), crashed);
    turn(&mut document, [0, 1, 1]);
    document.leave_as_found().unwrap();
    assert_eq!(parts(&mut opened(&project)), crashed);
    // Nothing but generations, journals and their poses lies in the folder.
    let left: Vec<String> =
        std::fs::read_dir(&project).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    assert!(left.iter().all(|name| !name.contains("new") && !name.contains("000001.poses")), "{left:?}");
}

#[test]
fn painting_and_looking_about_move_nothing_until_steps_are_made() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    assert!(!document.must_move(), "degree 0");
    degree(&mut document, 1.0);
    assert!(document.must_move());
    settle(&mut document);
    let rest = poses(&document);
    let state = |d: &Document| d.state().map(|s: &State| s.scene.explosion.clone());
    let before = state(&document);
    for (line, must) in [
        (r#"{"view":{"window":{"level":100,"width":50}}}"#, false),
        (r#"{"brush":{"set":{"target":{"label":2},"radius_mm":3}}}"#, false),
        (r#"{"stroke":{"paint":{"points":[{"at":{"mm":[30,20,20]}}]}}}"#, false),
        (r#"{"brush":{"set":{"target":{"selection":1},"radius_mm":9}}}"#, false),
        (r#"{"stroke":{"paint":{"points":[{"at":{"mm":[40,20,20]}}]}}}"#, true),
        (r#"{"view":{"orbit":{"azimuth_deg":40,"elevation_deg":0}}}"#, true),
    ] {
        run(&mut document, line).unwrap();
        assert_eq!(document.must_move(), must, "{line}");
        assert_eq!((poses(&document), state(&document)), (rest.clone(), before.clone()), "{line}");
    }
    step_to_rest(&mut document);
    assert!(!document.must_move());
    run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":40,"elevation_deg":0}}}"#).unwrap();
    assert!(document.must_move(), "the viewing force looks along other rays");
    let mut forces = json!(document.state().unwrap().scene.explosion.forces);
    forces["viewing"] = json!(false);
    say(&mut document, json!({"explosion":{"forces":{"forces":forces}}}));
    settle(&mut document);
    run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":40,"elevation_deg":0}}}"#).unwrap();
    assert!(!document.must_move(), "no force looks along rays");
    degree(&mut document, 0.0);
    assert!(document.must_move(), "the way home");
    step_to_rest(&mut document);
    assert!(!document.must_move() && are_home(&document));
}
