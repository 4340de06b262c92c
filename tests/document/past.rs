//! Views and looks go back by a past of their own, and undo leaves them alone.

use super::keep_support::write_sealed;
use super::maker::{labelled, run, state, undone, write_nrrd};
use burin::document::{Document, Looks, PastOf, Views};
use burin::math::DVec3;
use burin::volume::{Grid, VolumeId};
use rand::{Rng, SeedableRng, seq::IndexedRandom};
use serde_json::{Value, json};
use std::path::Path;

fn looks(document: &Document) -> Looks {
    document.state().unwrap().scene.looks()
}

fn views(document: &Document) -> Views {
    (*document.state().unwrap().scene.views).clone()
}

fn counts(document: &Document, of: PastOf) -> (usize, usize) {
    document.state().unwrap().past.counts(Some(of))
}

const WINDOW: &str = r#"{"view":{"window":{"level":7,"width":9}}}"#;
const ORBIT: &str = r#"{"view":{"orbit":{"azimuth_deg":10,"elevation_deg":0}}}"#;
const BACK: &str = r#"{"view":{"back":{}}}"#;
const FORWARD: &str = r#"{"view":{"forward":{}}}"#;

#[test]
fn whatever_changes_a_look_is_no_step_of_undo_and_goes_back_and_forward() {
    let lines = [
        (r#"{"view":{"look":{"mode":{"iso":40}}}}"#, "Look: surface"),
        (r#"{"view":{"look":{"mode":"mip"}}}"#, "Look: maximum"),
        (r#"{"view":{"look":{"shaded":false}}}"#, "Headlight off"),
        (r#"{"view":{"look":{"step_voxels":0.25}}}"#, "Look"),
        (r#"{"view":{"look":{"background":[1,1,1]}}}"#, "Background"),
        (r#"{"view":{"focus":{"distance_mm":9,"opacity":0.5}}}"#, "Focus"),
        (WINDOW, "Window"),
        (r#"{"view":{"layer":{"field":"density","visible":false,"opacity":1}}}"#, "Layer density"),
        (r#"{"view":{"layer":{"field":"labels","visible":true,"opacity":0.2}}}"#, "Layer labels"),
        (
            r#"{"transfer":{"set":{"function":{"colour":[[0,[1,0,0]]],"opacity":[[0,0.5]],"unit_mm":1}}}}"#,
            "Transfer function",
        ),
    ];
    for (line, name) in lines {
        let mut document = labelled();
        run(&mut document, r#"{"segment":{"set":{"id":1,"name":"bone"}}}"#).unwrap();
        let (before, fields) = (looks(&document), undone(&document));
        assert_eq!(run(&mut document, line).unwrap()["step"], Value::Null, "{line}");
        let after = looks(&document);
        assert_ne!(after, before, "{line}");
        assert_eq!(document.history().undo_names().collect::<Vec<_>>(), ["Rename segment Segment 1"], "{line}");
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        assert_eq!(looks(&document), after, "undo leaves looks alone: {line}");
        run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap();
        let said = run(&mut document, BACK).unwrap();
        assert_eq!((&said["moved"], &said["change"], &said["of"]), (&true.into(), &name.into(), &"looks".into()));
        assert_eq!((looks(&document), undone(&document)), (before, fields), "{line}");
        assert_eq!(run(&mut document, BACK).unwrap()["moved"], false);
        run(&mut document, FORWARD).unwrap();
        assert_eq!(looks(&document), after, "{line}");
        assert_eq!(run(&mut document, FORWARD).unwrap()["moved"], false);
    }
}

#[test]
fn a_look_that_stays_as_it_is_or_is_refused_is_no_change() {
    let mut document = labelled();
    for line in [
        r#"{"transfer":{"reset":{}}}"#,
        r#"{"view":{"look":{"shaded":true}}}"#,
        r#"{"view":{"window":{"level":1,"width":0}}}"#,
        r#"{"view":{"look":{"mode":"mip","step_voxels":99}}}"#,
        r#"{"view":{"layer":{"field":"labels","visible":true,"opacity":3}}}"#,
    ] {
        let before = looks(&document);
        let _refused = run(&mut document, line);
        assert_eq!((looks(&document), counts(&document, PastOf::Looks)), (before, (0, 0)), "{line}");
    }
}

#[test]
fn views_and_looks_are_walked_in_their_order_or_each_for_itself() {
    let mut document = labelled();
    let (view, look) = (views(&document), looks(&document));
    for line in [ORBIT, WINDOW, ORBIT, r#"{"view":{"layer":{"field":"colour","visible":false,"opacity":1}}}"#] {
        run(&mut document, line).unwrap();
    }
    let walk = |document: &mut Document, line: &str| run(document, line).unwrap()["change"].clone();
    let order: Vec<_> = (0..5).map(|_| walk(&mut document, BACK)).collect();
    assert_eq!(json!(order), json!(["Layer colour", "Turn", "Window", "Turn", null]));
    assert_eq!((views(&document), looks(&document)), (view.clone(), look.clone()));
    let order: Vec<_> = (0..5).map(|_| walk(&mut document, FORWARD)).collect();
    assert_eq!(json!(order), json!(["Turn", "Window", "Turn", "Layer colour", null]));
    let (end, shown) = (views(&document), looks(&document));
    let of = |way: &str, of: &str| format!(r#"{{"view":{{"{way}":{{"of":"{of}"}}}}}}"#);
    let order: Vec<_> = (0..3).map(|_| walk(&mut document, &of("back", "views"))).collect();
    assert_eq!(json!(order), json!(["Turn", "Turn", null]));
    assert_eq!((views(&document), looks(&document)), (view, shown), "looks stay");
    (0..2).for_each(|_| drop(walk(&mut document, &of("forward", "views"))));
    let order: Vec<_> = (0..3).map(|_| walk(&mut document, &of("back", "looks"))).collect();
    assert_eq!(json!(order), json!(["Layer colour", "Window", null]));
    assert_eq!((views(&document), looks(&document)), (end, look), "views stay");
    let told = run(&mut document, r#"{"ask":{"history":{}}}"#).unwrap();
    assert_eq!(told["views"], json!({"back": 2, "forward": 0}));
    assert_eq!(told["looks"], json!({"back": 0, "forward": 2}));
}

#[test]
fn a_new_change_forgets_what_lay_ahead_of_its_own_kind() {
    let mut document = labelled();
    for line in [ORBIT, ORBIT, WINDOW, BACK, BACK] {
        run(&mut document, line).unwrap();
    }
    assert_eq!((counts(&document, PastOf::Views), counts(&document, PastOf::Looks)), ((1, 1), (0, 1)));
    run(&mut document, ORBIT).unwrap();
    let turned = views(&document);
    assert_eq!(counts(&document, PastOf::Views), (2, 0));
    assert_eq!(run(&mut document, r#"{"view":{"forward":{"of":"views"}}}"#).unwrap()["moved"], false);
    assert_eq!(views(&document), turned);
    assert_eq!(run(&mut document, FORWARD).unwrap()["change"], "Window", "the window lies ahead still");
    assert_eq!(run(&mut document, BACK).unwrap()["change"], "Window", "back is the inverse of forward");
    run(&mut document, r#"{"view":{"look":{"mode":"mip"}}}"#).unwrap();
    assert_eq!(run(&mut document, FORWARD).unwrap()["moved"], false);
}

#[test]
fn a_drag_is_one_change_and_one_that_returns_or_is_taken_back_is_none() {
    let window =
        |d: &mut Document, w: u32| run(d, &format!(r#"{{"view":{{"window":{{"level":1,"width":{w}}}}}}}"#)).unwrap();
    let group = |d: &mut Document, what: &str| run(d, &format!(r#"{{"history":{{"{what}":{{}}}}}}"#)).unwrap();
    let mut document = labelled();
    window(&mut document, 5);
    group(&mut document, "begin");
    (6..20).for_each(|w| drop(window(&mut document, w)));
    (0..3).for_each(|_| drop(run(&mut document, ORBIT).unwrap()));
    assert_eq!(group(&mut document, "end")["step"], Value::Null);
    assert_eq!(document.history().undo_names().len(), 0);
    assert_eq!((counts(&document, PastOf::Looks), counts(&document, PastOf::Views)), ((2, 0), (1, 0)));
    (0..2).for_each(|_| drop(run(&mut document, BACK).unwrap()));
    assert_eq!(looks(&document).shown[&VolumeId::FIRST].window.width, 5.0);
    // What lies ahead survives a group that did nothing.
    for end in ["end", "cancel"] {
        group(&mut document, "begin");
        window(&mut document, 9);
        run(&mut document, ORBIT).unwrap();
        if end == "end" {
            window(&mut document, 5);
            run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":-10,"elevation_deg":0}}}"#).unwrap();
        }
        group(&mut document, end);
        assert_eq!(looks(&document).shown[&VolumeId::FIRST].window.width, 5.0, "{end}");
        assert_eq!(counts(&document, PastOf::Looks), (1, 1), "{end}");
    }
    run(&mut document, r#"{"view":{"forward":{"of":"looks"}}}"#).unwrap();
    assert_eq!(looks(&document).shown[&VolumeId::FIRST].window.width, 19.0);
    // So it does of views: a slice made smaller and larger again.
    run(&mut document, BACK).unwrap();
    let before = (views(&document), counts(&document, PastOf::Views));
    let zoom = |d: &mut Document, factor: f64| {
        run(d, &format!(r#"{{"view":{{"zoom":{{"view":"axial","factor":{factor}}}}}}}"#)).unwrap()
    };
    group(&mut document, "begin");
    [2.0, 4.0, 0.125].into_iter().for_each(|factor| drop(zoom(&mut document, factor)));
    group(&mut document, "end");
    assert_eq!((views(&document), counts(&document, PastOf::Views)), before);
    zoom(&mut document, 2.0);
    assert_eq!(counts(&document, PastOf::Views), (before.1.0 + 1, 0));
}

#[test]
fn a_group_of_both_is_one_step_and_one_look_and_cancel_takes_both_back() {
    let mut document = labelled();
    let (before, shown) = (undone(&document), looks(&document));
    let rename = r#"{"segment":{"set":{"id":1,"name":"bone"}}}"#;
    for end in ["cancel", "end"] {
        for line in [r#"{"history":{"begin":{}}}"#, rename, WINDOW] {
            run(&mut document, line).unwrap();
        }
        run(&mut document, &format!(r#"{{"history":{{"{end}":{{}}}}}}"#)).unwrap();
        if end == "cancel" {
            assert_eq!((undone(&document), looks(&document)), (before.clone(), shown.clone()));
            assert_eq!(counts(&document, PastOf::Looks), (0, 0));
        }
    }
    assert_eq!(document.history().undo_names().collect::<Vec<_>>(), ["Rename segment Segment 1"]);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(undone(&document), before);
    assert_ne!(looks(&document), shown);
    run(&mut document, BACK).unwrap();
    assert_eq!(looks(&document), shown);
}

#[test]
fn the_past_has_an_end() {
    let mut document = labelled();
    for level in 0..300 {
        run(&mut document, &format!(r#"{{"view":{{"window":{{"level":{level},"width":1}}}}}}"#)).unwrap();
    }
    assert_eq!(counts(&document, PastOf::Looks), (128, 0));
    while run(&mut document, BACK).unwrap()["moved"] == true {}
    assert_eq!(
        (looks(&document).shown[&VolumeId::FIRST].window.level, counts(&document, PastOf::Looks)),
        (171.0, (0, 128))
    );
}

#[test]
fn a_look_is_work_that_can_be_lost_and_a_view_is_none() {
    let mut document = labelled();
    run(&mut document, ORBIT).unwrap();
    assert!(!document.is_unsaved());
    run(&mut document, BACK).unwrap();
    assert!(!document.is_unsaved());
    run(&mut document, WINDOW).unwrap();
    assert!(document.is_unsaved());
}

/// What a walk all the way back and all the way forward shows, and where it started.
fn walked(document: &mut Document) -> Vec<(Views, Looks)> {
    let mut seen = vec![(views(document), looks(document))];
    for way in ["back", "forward"] {
        while run(document, &format!(r#"{{"view":{{"{way}":{{}}}}}}"#)).unwrap()["moved"] == true {
            seen.push((views(document), looks(document)));
        }
    }
    seen
}

fn random_line(rng: &mut impl Rng) -> String {
    let n: u32 = rng.random_range(0..100);
    let lines = [
        format!(r#"{{"view":{{"window":{{"level":{n},"width":{}}}}}}}"#, n + 1),
        format!(r#"{{"view":{{"layer":{{"field":"labels","visible":true,"opacity":0.{n}}}}}}}"#),
        format!(r#"{{"view":{{"look":{{"mode":{{"iso":{n}}}}}}}}}"#),
        format!(r#"{{"view":{{"orbit":{{"azimuth_deg":{n},"elevation_deg":1}}}}}}"#),
        r#"{"view":{"fit":{"view":"axial"}}}"#.into(),
        format!(r#"{{"view":{{"zoom":{{"view":"axial","factor":1.{n}}}}}}}"#),
        format!(r#"{{"view":{{"size":{{"view":"axial","size":[{0},{0}]}}}}}}"#, n + 10),
        format!(r#"{{"segment":{{"set":{{"id":1,"name":"bone {n}"}}}}}}"#),
        BACK.into(),
        BACK.into(),
        FORWARD.into(),
        r#"{"view":{"back":{"of":"looks"}}}"#.into(),
        r#"{"view":{"forward":{"of":"views"}}}"#.into(),
        r#"{"history":{"begin":{}}}"#.into(),
        r#"{"history":{"end":{}}}"#.into(),
        r#"{"history":{"cancel":{}}}"#.into(),
        r#"{"history":{"undo":{}}}"#.into(),
    ];
    lines.choose(rng).unwrap().clone()
}

fn opened(folder: &Path) -> Document {
    let volume = folder.join("ramp.nrrd");
    write_nrrd(&volume, &Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO), |[x, y, z]| (x + y + z) as f32);
    let mut document = Document::new();
    run(&mut document, &json!({"volume": {"open": {"path": volume}}}).to_string()).unwrap();
    document
}

fn reopened(project: &Path) -> Document {
    let mut document = Document::new();
    run(&mut document, &json!({"project": {"open": {"path": project}}}).to_string()).unwrap();
    document
}

#[test]
fn the_past_comes_back_with_the_project_and_after_a_crash() {
    for seed in 0..6 {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("p");
        let mut document = opened(folder.path());
        run(&mut document, &json!({"project": {"save": {"path": project}}}).to_string()).unwrap();
        for round in 0..3 {
            for _ in 0..25 {
                // A begin within a group, or an end without one, is refused.
                let _refused = run(&mut document, &random_line(&mut rng));
            }
            // A group is nothing that a project knows.
            let _none = run(&mut document, r#"{"history":{"end":{}}}"#);
            // The end of a group is told with what comes next.
            run(&mut document, WINDOW).unwrap();
            if round == 1 {
                run(&mut document, r#"{"project":{"save":{}}}"#).unwrap();
            }
            let past = document.state().unwrap().past.clone();
            let here = (views(&document), looks(&document));
            drop(document);
            document = reopened(&project);
            assert_eq!((views(&document), looks(&document)), here, "seed {seed}, round {round}");
            assert_eq!(document.state().unwrap().past, past, "seed {seed}, round {round}");
        }
        let seen = walked(&mut document);
        assert!(seen.len() > 10, "seed {seed}: a past that is empty tests nothing");
        let leave = (views(&document), looks(&document));
        drop(document);
        let mut again = reopened(&project);
        assert_eq!((views(&again), looks(&again)), leave);
        // From the newest: the same way back, and the same forward again.
        let twice = walked(&mut again);
        assert_eq!(twice.last(), seen.last(), "seed {seed}");
    }
}

#[test]
fn a_project_of_before_has_no_past_and_a_damaged_one_loses_only_that() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p");
    let mut document = opened(folder.path());
    for line in [ORBIT, WINDOW, ORBIT] {
        run(&mut document, line).unwrap();
    }
    run(&mut document, &json!({"project": {"save": {"path": project}}}).to_string()).unwrap();
    drop(document);
    let file = project.join("generation-000001/generation.json");
    let whole: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    assert_eq!(whole["past"]["looks"]["back"].as_array().unwrap().len(), 1);
    let with = |change: &dyn Fn(&mut Value)| {
        let mut json = whole.clone();
        change(&mut json);
        write_sealed(&file, &json);
        let document = reopened(&project);
        (counts(&document, PastOf::Views).0, counts(&document, PastOf::Looks).0)
    };
    assert_eq!(with(&|_| {}), (2, 1));
    assert_eq!(with(&|json| drop(json.as_object_mut().unwrap().remove("past"))), (0, 0));
    assert_eq!(with(&|json| json["past"]["views"]["back"][0]["other"]["camera"]["up"] = json!([0, 0, 1])), (2, 1));
    // Numbers that cannot grow any more are no reason to fail.
    assert_eq!(with(&|json| json["past"]["changes"] = json!(u64::MAX)), (2, 1));
    let mut document = reopened(&project);
    run(&mut document, r#"{"view":{"window":{"level":70,"width":90}}}"#).unwrap();
    run(&mut document, BACK).unwrap();
    assert_eq!(counts(&document, PastOf::Looks), (1, 1));
    document.leave_as_found().unwrap();
    let eye = |json: &mut Value| {
        let camera = &mut json["past"]["views"]["back"][1]["other"]["camera"];
        camera["eye"] = camera["target"].clone();
    };
    assert_eq!(with(&eye), (1, 1), "a camera that looks nowhere");
    assert_eq!(
        with(&|json| json["past"]["looks"]["back"][0]["other"]["shown"]["0"]["window"]["width"] = json!(-1)),
        (2, 0)
    );
}

#[test]
fn a_view_alone_has_its_past_too() {
    let mut document = Document::new();
    document.adopt(state());
    let start = views(&document);
    run(&mut document, r#"{"view":{"fit":{"view":"coronal"}}}"#).unwrap();
    run(&mut document, r#"{"view":{"scroll":{"view":"axial","voxels":3}}}"#).unwrap();
    run(&mut document, r#"{"view":{"size":{"view":"axial","size":[99,33]}}}"#).unwrap();
    run(&mut document, BACK).unwrap();
    run(&mut document, BACK).unwrap();
    let now = views(&document);
    assert_eq!(now.slices[0].size, [99, 33], "sizes are the window's");
    assert_eq!((now.camera, now.crosshair, now.slices[1]), (start.camera, start.crosshair, start.slices[1]));
}
