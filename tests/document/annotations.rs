//! Annotations, labels and cutaways as what a person decides: one step each, undone, kept, brought back, and refused with a reason.

use super::maker::{run, write_nrrd};
use crate::common::gpu::gpu;
use burin::document::{Document, Scene};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::Grid;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

pub const ISO: f64 = 100.0;
pub const RADIUS: f64 = 15.0;

pub fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// Of unequal voxels, turned in the world.
pub fn grid() -> Grid {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.4);
    let matrix3 = turned * DMat3::from_diagonal(DVec3::new(1.0, 1.1, 0.9));
    Grid { dims: [44, 40, 48], world_from_index: DAffine3 { matrix3, translation: DVec3::new(-7.0, 5.0, 3.0) } }
}

/// The middle of the ball, world mm.
pub fn middle() -> DVec3 {
    grid().world_from_index.transform_point3(DVec3::new(21.3, 19.6, 23.2))
}

/// A ball whose values fall by 10 a mm outward, 100 on its surface; from a file in a folder, opaque, seen against y.
pub fn ball(dir: &Path) -> Option<Document> {
    gpu()?;
    let path = dir.join("ball.nrrd");
    let (grid, middle) = (grid(), middle());
    write_nrrd(&path, &grid, |v| {
        let at = grid.world_from_index.transform_point3(DVec3::from_array(v.map(f64::from)));
        (ISO + 10.0 * (RADIUS - at.distance(middle))) as f32
    });
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    say(&mut document, json!({"volume":{"open":{"path":path}}}));
    let function = json!({"colour":[[0,[0.5,0.5,0.5]]],"opacity":[[95,0],[105,1]],"unit_mm":1});
    say(&mut document, json!({"transfer":{"set":{"function":function}}}));
    say(&mut document, json!({"view":{"look":{"mode":{"iso":ISO}}}}));
    say(&mut document, json!({"view":{"size":{"view":"3d","size":[96,96]}}}));
    say(&mut document, json!({"view":{"frame":{"from":[0,-1,0]}}}));
    Some(document)
}

/// A place on the ball's surface, world mm.
pub fn on(direction: DVec3) -> Value {
    json!({"mm":(middle() + direction.normalize() * RADIUS).to_array()})
}

pub fn text(document: &mut Document, more: Value) -> Value {
    let mut add = json!({"text":"Ab","at":on(DVec3::NEG_Y),"toward":on(DVec3::new(0.5, -1.0, 0.0)),"size_mm":5});
    add.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    say(document, json!({"annotation":{"add":add}}))
}

fn scene(document: &Document) -> Scene {
    document.state().unwrap().scene.clone()
}

/// Every verb that makes a step, each after those before it.
fn steps(dir: &Path) -> Vec<Value> {
    let image = dir.join("dot.png");
    image::RgbaImage::from_pixel(4, 2, image::Rgba([255, 0, 0, 128])).save(&image).unwrap();
    let at = on(DVec3::NEG_Y);
    let places: Vec<Value> = [(0.3, 0.3), (-0.3, 0.3), (-0.3, -0.3), (0.3, -0.3)]
        .into_iter()
        .map(|(x, z)| on(DVec3::new(x, -1.0, z)))
        .collect();
    vec![
        json!({"segment":{"set":{"id":3,"name":"jaw"}}}),
        json!({"annotation":{"add":{"text":"Nose","at":at,"size_mm":4}}}),
        json!({"annotation":{"set":{"id":0,"name":"Tip"}}}),
        json!({"annotation":{"set":{"id":0,"text":"Nose\nתיבה","colour":[1,0,0],"no_halo":true}}}),
        json!({"annotation":{"set":{"id":0,"at":on(DVec3::new(0.2, -1.0, 0.1))}}}),
        json!({"annotation":{"set":{"id":0,"turn_deg":30}}}),
        json!({"annotation":{"set":{"id":0,"size_mm":3,"opacity":0.5,"visible":false}}}),
        json!({"annotation":{"add":{"content":{"image":{"path":image}},"at":at,"size_mm":6}}}),
        json!({"annotation":{"add":{"content":{"pattern":{"kind":"cross","aspect":1,"spacing_mm":1,"line_mm":0.2}},"at":at,"size_mm":6}}}),
        json!({"annotation":{"add":{"content":{"arrow":{"thickness":0.1}},"at":at,"size_mm":6}}}),
        json!({"annotation":{"add":{"content":{"ruler":{"to":[0,0,0]}},"at":at,"to":on(DVec3::X),"size_mm":2}}}),
        json!({"label":{"add":{"text":"here","at":at}}}),
        json!({"label":{"add":{"segment":3}}}),
        json!({"label":{"add":{"annotation":0}}}),
        json!({"label":{"set":{"id":0,"text":"there"}}}),
        json!({"label":{"style":{"numbers":true,"size_px":20}}}),
        json!({"label":{"remove":{"id":1}}}),
        json!({"cutaway":{"add":{"at":at,"width_mm":6,"depth_mm":4}}}),
        json!({"cutaway":{"add":{"lasso":places,"depth_mm":3}}}),
        json!({"cutaway":{"add":{"annotation":0,"depth_mm":3}}}),
        json!({"cutaway":{"set":{"id":0,"depth_mm":6,"rim_mm":0.5}}}),
        json!({"cutaway":{"set":{"id":1,"name":"Door","open":false}}}),
        json!({"cutaway":{"remove":{"id":2}}}),
        json!({"annotation":{"remove":{"id":0}}}),
    ]
}

#[test]
fn every_verb_is_one_step_that_is_undone_and_done_again() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let mut scenes = vec![scene(&document)];
    let begun = document.history().undo_names().len();
    for line in steps(dir.path()) {
        let answer = say(&mut document, line.clone());
        assert!(answer["step"].as_str().is_some_and(|step| !step.is_empty()), "{line}: {answer}");
        scenes.push(scene(&document));
        assert_eq!(document.history().undo_names().len() - begun, scenes.len() - 1, "{line}: one step");
        assert_ne!(scenes[scenes.len() - 1], scenes[scenes.len() - 2], "{line}");
    }
    for before in scenes.iter().rev().skip(1) {
        say(&mut document, json!({"history":{"undo":{}}}));
        assert_eq!(&scene(&document), before);
    }
    for after in &scenes[1..] {
        say(&mut document, json!({"history":{"redo":{}}}));
        assert_eq!(&scene(&document), after);
    }
    // What named an annotation went with it.
    let last = &scenes[scenes.len() - 1];
    let at = |id| last.labels.all.get(&burin::document::LabelId(id));
    assert!(at(0).is_some() && at(1).is_none() && at(2).is_none(), "{:?}", last.labels);
    assert_eq!(last.annotations.all.len(), 4);
}

fn project(dir: &Path) -> PathBuf {
    dir.join("p.burin")
}

fn told(document: &mut Document) -> Value {
    let of = |document: &mut Document, ask: Value| say(document, json!({ "ask": ask }));
    json!([
        of(document, json!({"annotations":{"vertices":true}})),
        of(document, json!({"cutaways":{"mesh":true}})),
        of(document, json!({"labels":{}}))
    ])
}

#[test]
fn what_was_saved_is_opened_and_what_was_not_comes_back_from_the_journal() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let mut steps = steps(dir.path());
    let unsaved = steps.split_off(14);
    for line in steps {
        say(&mut document, line);
    }
    say(&mut document, json!({"project":{"save":{"path":project(dir.path())}}}));
    let (saved, said) = (scene(&document), told(&mut document));
    drop(document);
    // An image is in the project.
    std::fs::remove_file(dir.path().join("dot.png")).unwrap();
    let opened = |document: &mut Document| say(document, json!({"project":{"open":{"path":project(dir.path())}}}));
    let mut document = Document::new();
    let answer = opened(&mut document);
    assert_eq!(answer["warnings"], json!([]), "{answer}");
    assert_eq!(scene(&document), saved);
    assert_eq!(told(&mut document), said, "laid as it was");
    for line in unsaved {
        say(&mut document, line);
    }
    let (newest, said) = (scene(&document), told(&mut document));
    assert_ne!(newest, saved);
    drop(document);
    let mut document = Document::new();
    opened(&mut document);
    assert_eq!(scene(&document), newest, "from the journal");
    assert_eq!(told(&mut document), said);
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    text(&mut document, json!({}));
    say(&mut document, json!({"label":{"add":{"text":"x","at":on(DVec3::X)}}}));
    say(&mut document, json!({"cutaway":{"add":{"at":on(DVec3::NEG_Y),"width_mm":6,"depth_mm":4}}}));
    let at = on(DVec3::NEG_Y);
    let no_image = dir.path().join("no.png");
    std::fs::write(&no_image, b"this is a text").unwrap();
    let gone = dir.path().join("gone.png");
    let image = |path: &Path| json!({"image":{"path":path}});
    let before = (scene(&document), document.history().undo_names().len());
    let long: String = "many words ".repeat(400);
    for (line, words) in [
        (json!({"annotation":{"add":{"at":at}}}), ["content", "nothing found", "a text"]),
        (json!({"annotation":{"add":{"text":"x"}}}), ["at", "nothing found", "surface"]),
        (json!({"annotation":{"add":{"text":" \n","at":at}}}), ["text", "2 characters found", "1 to 2000"]),
        (json!({"annotation":{"add":{"text":long,"at":at}}}), ["text", "4400 characters found", "1 to 2000"]),
        (json!({"annotation":{"add":{"text":"x","at":at,"size_mm":0}}}), ["size_mm", "0 found", "positive"]),
        (json!({"annotation":{"add":{"text":"x","at":at,"opacity":1.5}}}), ["opacity", "1.5 found", "0 to 1"]),
        (json!({"annotation":{"add":{"text":"x","at":at,"toward":at}}}), ["toward", "centre", "another place"]),
        (json!({"annotation":{"add":{"text":"x","at":at,"tolerance":0}}}), ["tolerance", "0 found", "0.0001 to 0.5"]),
        (json!({"annotation":{"add":{"text":"x","at":at,"step_mm":-1}}}), ["step_mm", "-1 found", "positive"]),
        (json!({"annotation":{"add":{"id":0,"text":"x","at":at}}}), ["id", "0 found", "annotation.set"]),
        (json!({"annotation":{"add":{"text":"x","at":at,"volume":9}}}), ["volume", "9", ""]),
        (json!({"annotation":{"add":{"content":image(&no_image),"at":at}}}), ["path", "no.png", "PNG"]),
        (json!({"annotation":{"add":{"content":image(&gone),"at":at}}}), ["path", "gone.png", "PNG"]),
        (
            json!({"annotation":{"add":{"content":{"pattern":{"kind":"lines","aspect":1,"spacing_mm":1,"line_mm":2}},"at":at,"size_mm":5}}}),
            ["line_mm", "2 found", "under the spacing"],
        ),
        (json!({"annotation":{"add":{"content":{"ruler":{"to":[0,0,0]}},"at":at}}}), ["to", "nothing found", "ends"]),
        (json!({"annotation":{"set":{"id":7,"text":"y"}}}), ["id", "7 found", "0 (Ab)"]),
        (json!({"annotation":{"set":{"text":"y"}}}), ["id", "nothing found", "annotation"]),
        (json!({"annotation":{"remove":{"id":7}}}), ["id", "7 found", "0 (Ab)"]),
        (json!({"ask":{"annotations":{"id":7}}}), ["id", "7 found", "0 (Ab)"]),
        (json!({"label":{"add":{"at":at}}}), ["text", "nothing found", "says"]),
        (json!({"label":{"add":{"text":"x"}}}), ["at", "nothing found", "names"]),
        (json!({"label":{"add":{"text":"","at":at}}}), ["text", "0 characters found", "1 to 500"]),
        (json!({"label":{"add":{"segment":8}}}), ["segment", "8 found", "segment"]),
        (json!({"label":{"add":{"annotation":8}}}), ["id", "8 found", "0 (Ab)"]),
        (json!({"label":{"add":{"part":80}}}), ["part 80", "does not exist", "the parts are 1"]),
        (json!({"label":{"add":{"text":"x","at":at,"part":1}}}), ["at", "several", "one of"]),
        (json!({"label":{"set":{"id":8}}}), ["id", "8 found", "label"]),
        (json!({"label":{"remove":{"id":8}}}), ["id", "8 found", "label"]),
        (json!({"label":{"style":{"size_px":2}}}), ["size_px", "2 found", "6 to 96"]),
        (json!({"label":{"from_segments":{"segments":[4]}}}), ["segments", "4 found", "segment"]),
        (json!({"cutaway":{"add":{"lasso":[at, on(DVec3::X)]}}}), ["lasso", "2 places found", "3 to"]),
        (json!({"cutaway":{"add":{"lasso":[]}}}), ["lasso", "no place found", "3"]),
        (json!({"cutaway":{"add":{"at":at,"depth_mm":0}}}), ["depth_mm", "0 found", "positive"]),
        (json!({"cutaway":{"add":{"at":at,"width_mm":-2}}}), ["width_mm", "-2 found", "positive"]),
        (json!({"cutaway":{"add":{"at":at,"rim_mm":-2}}}), ["rim", "-2 found", "0 or more"]),
        (json!({"cutaway":{"add":{}}}), ["at", "nothing found", "surface"]),
        (json!({"cutaway":{"set":{"id":5}}}), ["id", "5 found", "Window 1"]),
        (json!({"cutaway":{"remove":{"id":5}}}), ["id", "5 found", "Window 1"]),
        (json!({"cutaway":{"add":{"annotation":5}}}), ["id", "5 found", "0 (Ab)"]),
    ] {
        let error = match run(&mut document, &line.to_string()) {
            Ok(answer) => panic!("{line}: {answer}"),
            Err(error) => error.to_string(),
        };
        assert!(words.iter().all(|word| error.contains(word)), "{line}: {error}");
        assert_eq!((scene(&document), document.history().undo_names().len()), before, "{line}");
    }
    // JSON has no such numbers, but whoever links the library has.
    let mut command: burin::document::Command =
        serde_json::from_value(json!({"annotation":{"add":{"text":"x","at":at,"value":1}}})).unwrap();
    if let burin::document::Command::Annotation(burin::document::AnnotationCommand::Add(change)) = &mut command {
        change.value = Some(f64::NAN);
    }
    let error = document.apply(command).unwrap_err().to_string();
    assert!(["value", "NaN found", "finite"].iter().all(|word| error.contains(word)), "{error}");
    assert_eq!(scene(&document), before.0);
}

/// What was written before there were any opens as one that has none.
#[test]
fn a_scene_that_does_not_speak_of_them_has_none() {
    let document = super::maker::labelled();
    let told = serde_json::to_value(scene(&document)).unwrap();
    for name in ["annotations", "labels", "cutaways"] {
        assert!(told.get(name).is_none(), "{name}: a document without is written as it was before: {told}");
    }
    let opened: Scene = serde_json::from_value(told).unwrap();
    assert_eq!(opened, scene(&document));
    assert!(opened.annotations.all.is_empty() && opened.labels.all.is_empty() && opened.cutaways.all.is_empty());
}
