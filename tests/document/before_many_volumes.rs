//! What the program wrote before it knew many volumes opens with every voxel, value, name and pose that was put into it: a project
//! with a journal, one that links its volume, and a document that was never saved. tests/fixtures/README.md says what they are.
//!
//! Voxels are worked out here from the balls that were painted; names, looks, views and poses are compared with what that program
//! said of them (the .json beside each) before it was killed.

use super::maker::run;
use crate::common::gpu::gpu;
use burin::document::Document;
use burin::io;
use burin::math::DVec3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const DIMS: [u32; 3] = [70, 41, 37];

/// World mm between voxels of these places, as the file's header has the axes.
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = std::array::from_fn(|i| a[i] - b[i]);
    (x * DVec3::new(0.78, 0.19, 0.02) + y * DVec3::new(-0.26, 1.07, 0.05) + z * DVec3::new(0.01, -0.08, 1.69)).length()
}

/// A voxel of `ramp.nrrd`.
fn source(v: [u32; 3]) -> f64 {
    let [x, y, z] = v.map(i64::from);
    ((3 * x + 5 * y + 7 * z) % 500 - 100 + 20 * ((x / 8 + y / 8 + z / 8) % 2)) as f64
}

/// What one voxel holds.
#[derive(Clone, Copy, Debug)]
struct Voxel {
    density: f64,
    colour: [f64; 4],
    selection: f64,
    label: u32,
}

enum To {
    Density(f64),
    Colour([f64; 4]),
    Selection(f64),
    Label(u32),
}

/// A click with a ball of full strength that replaces: hard, but for the one that is `smooth`.
struct Click(To, [u32; 3], f64, bool);

impl Click {
    /// Equation 1 of the 2008 paper with G of equation 2.
    fn on(&self, voxel: &mut Voxel, at: [u32; 3]) {
        let Self(to, centre, radius, smooth) = self;
        let x = apart(at.map(f64::from), centre.map(f64::from)) / radius;
        let g = if x > 1.0 {
            return;
        } else if *smooth {
            (1.0 - x * x).powi(2)
        } else {
            1.0
        };
        match to {
            To::Density(v) => voxel.density = *v,
            To::Colour(v) => voxel.colour = *v,
            To::Selection(v) => voxel.selection += g * (v - voxel.selection),
            To::Label(v) => voxel.label = *v,
        }
    }
}

/// Saved in `whole`, journaled in `unsaved`.
const FIELDS: [Click; 8] = [
    Click(To::Density(333.25), [10, 10, 10], 3.3, false),
    Click(To::Density(4000.5), [33, 31, 31], 4.4, false),
    Click(To::Colour([0.2, 0.4, 0.6, 1.0]), [20, 30, 12], 5.1, false),
    Click(To::Colour([1.0, 0.0, 0.0, 0.5]), [48, 20, 30], 3.7, false),
    Click(To::Selection(0.6), [40, 20, 18], 6.2, false),
    Click(To::Selection(1.0), [32, 8, 6], 7.3, true),
    Click(To::Label(7), [22, 22, 20], 5.3, false),
    Click(To::Label(300), [55, 12, 10], 4.9, false),
];
/// Since the save, in `whole`.
const LAST: [Click; 4] = [
    Click(To::Density(-50.5), [60, 30, 20], 2.9, false),
    Click(To::Colour([0.0, 1.0, 0.2, 0.8]), [12, 30, 30], 3.1, false),
    Click(To::Selection(0.2), [40, 20, 18], 2.6, false),
    Click(To::Label(9), [55, 12, 10], 2.2, false),
];
/// In `linked`: two saved, one since; label 7 was painted, saved and removed since.
const LINKED: [Click; 3] = [
    Click(To::Density(333.5), [10, 10, 10], 3.3, false),
    Click(To::Selection(0.6), [40, 20, 18], 6.2, false),
    Click(To::Density(-50.5), [60, 30, 20], 2.9, false),
];

fn expected<'a>(clicks: impl Iterator<Item = &'a Click> + Clone, at: [u32; 3]) -> Voxel {
    let mut voxel = Voxel { density: source(at), colour: [0.0; 4], selection: 0.0, label: 0 };
    clicks.for_each(|click| click.on(&mut voxel, at));
    voxel
}

fn fixtures() -> PathBuf {
    crate::common::root().join("tests/fixtures/before_many_volumes")
}

/// A copy of everything, since opening writes locks and journals.
fn copied(to: &Path) -> PathBuf {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
            let (from, to) = (entry.path(), to.join(entry.file_name()));
            if from.is_dir() { copy(&from, &to) } else { assert!(std::fs::copy(&from, &to).is_ok()) }
        }
    }
    let to = to.join("copied");
    copy(&fixtures(), &to);
    to
}

fn opened(project: &Path) -> Document {
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"project": {"open": {"path": project}}}).to_string()).unwrap();
    assert_eq!(answer["warnings"], json!([]), "{answer}");
    document
}

/// All voxels of a field as an export has them: components by voxel, x fastest.
fn exported(document: &mut Document, field: &str, components: u32) -> Vec<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("field.nrrd");
    run(document, &json!({"volume": {"export": {"field": field, "path": path}}}).to_string()).unwrap();
    let file = io::open(&path).unwrap();
    assert_eq!(file.grid.dims, DIMS);
    let step = file.grid.world_from_index.matrix3 * DVec3::ONE - DVec3::new(0.53, 1.18, 1.76);
    assert!(step.length() < 1e-9 && file.grid.world_from_index.translation == DVec3::new(-31.5, 12.25, 4.0));
    let read = |c| file.source(c, 0, &|_| true).unwrap().read([0; 3], DIMS).unwrap();
    (0..components).map(read).map(|voxels| (0..voxels.len()).map(|i| voxels.get(i)).collect()).collect()
}

/// Every voxel of all four fields; `selected` knows better where it answers, NaN where nobody knows.
fn assert_voxels<'a>(
    document: &mut Document,
    clicks: impl Iterator<Item = &'a Click> + Clone,
    selected: impl Fn([u32; 3]) -> Option<f64>,
) {
    let density = &exported(document, "density", 1)[0];
    let colour = exported(document, "colour", 4);
    let selection = &exported(document, "selection", 1)[0];
    let labels = &exported(document, "labels", 1)[0];
    let (mut i, mut painted) = (0, 0);
    for z in 0..DIMS[2] {
        for y in 0..DIMS[1] {
            for x in 0..DIMS[0] {
                let (at, mut e) = ([x, y, z], expected(clicks.clone(), [x, y, z]));
                if let Some(value) = selected(at) {
                    e.selection = if value.is_nan() { selection[i] / 255.0 } else { value };
                }
                if e.density == source(at) {
                    assert_eq!(density[i], e.density, "{at:?}");
                } else {
                    // The export has integers; the question has the fraction too.
                    assert!((density[i] - e.density).abs() <= 0.5, "{at:?}: {} for {e:?}", density[i]);
                    let voxel = ask(document, json!({"voxel": {"at": {"index": at}}}));
                    let (value, half) = (voxel["density"].as_f64().unwrap(), voxel["half_step"].as_f64().unwrap());
                    assert!((value - e.density).abs() <= half && half < 0.01, "{voxel} for {e:?}");
                    painted += 1;
                }
                for (c, channel) in colour.iter().enumerate() {
                    assert!((channel[i] - 255.0 * e.colour[c]).abs() < 0.51, "{at:?}: {} for {e:?}", channel[i]);
                }
                // A fall-off's value is rounded once, in 32 bits.
                assert!((selection[i] - 255.0 * e.selection).abs() < 0.51, "{at:?}: {} for {e:?}", selection[i]);
                assert_eq!(labels[i], f64::from(e.label), "{at:?}");
                i += 1;
            }
        }
    }
    assert!(painted > 90, "{painted}");
}

fn ask(document: &mut Document, question: Value) -> Value {
    run(document, &json!({ "ask": question }).to_string()).unwrap()
}

/// That `now` says all that `told` says; it may say more.
fn assert_says(now: &Value, told: &Value, place: &str) {
    match (told, now) {
        // Where the file was on the machine that wrote it.
        (Value::String(old), Value::String(new)) if old == "/volumes/ramp.nrrd" => {
            assert!(new.ends_with("ramp.nrrd"), "{place}: {new}");
        }
        (Value::Object(told), _) => {
            for (key, told) in told {
                assert_says(now.get(key).unwrap_or(&Value::Null), told, &format!("{place}.{key}"));
            }
        }
        (Value::Array(told), Value::Array(now)) => {
            assert_eq!(now.len(), told.len(), "{place}");
            now.iter()
                .zip(told)
                .enumerate()
                .for_each(|(i, (now, told))| assert_says(now, told, &format!("{place}[{i}]")));
        }
        (Value::Number(old), Value::Number(new)) => {
            let (old, new) = (old.as_f64().unwrap(), new.as_f64().unwrap());
            assert!((old - new).abs() <= 1e-9 * old.abs().max(1.0), "{place}: {new} for {old}");
        }
        _ => assert_eq!(now, told, "{place}"),
    }
}

/// Names, looks, views, pasts, parts and their poses, as they were told.
fn assert_told(document: &mut Document, name: &str, but: &[&str]) {
    let told = std::fs::read_to_string(fixtures().join(name).with_extension("json")).unwrap();
    let told: Value = serde_json::from_str(&told).unwrap();
    for question in ["volume", "scene", "parts", "history"] {
        assert_says(&ask(document, json!({question: {}})), &told[question], question);
    }
    for field in ["density", "colour", "selection", "labels"].iter().filter(|f| !but.contains(f)) {
        assert_says(&ask(document, json!({"field": {"field": field}})), &told[field], field);
    }
}

/// As it was opened, and once this program has saved it and opened it again.
fn also_saved_again(mut document: Document, project: &Path, mut check: impl FnMut(&mut Document)) {
    check(&mut document);
    run(&mut document, &json!({"project": {"save": {"path": project}}}).to_string()).unwrap();
    drop(document);
    check(&mut opened(project));
}

#[test]
fn a_project_with_a_journal_opens_with_every_voxel_value_name_and_pose() {
    let dir = tempfile::tempdir().unwrap();
    let project = copied(dir.path()).join("whole.burin");
    also_saved_again(opened(&project), &project, |document| {
        assert_voxels(document, FIELDS.iter().chain(&LAST), |_| None);
        assert_told(document, "whole", &[]);
        // What the script gave, in its own numbers: one part held by hand, one named since the save.
        let parts = ask(document, json!({"parts": {}}))["parts"].take();
        let part = |id: u64| parts.as_array().unwrap().iter().find(|p| p["id"] == json!(id)).unwrap();
        assert_eq!((&part(4)["name"], &part(4)["pinned"]), (&json!("Front"), &json!(true)));
        assert_eq!(part(4)["pose"]["translation"], json!([3.5, -2.25, 8.0]));
        assert_eq!((&part(8)["name"], &part(8)["visible"]), (&json!("Top – hidden"), &json!(false)));
        assert_eq!(part(9)["name"], json!("Renamed since"));
        let voxel = ask(document, json!({"voxel": {"at": {"index": [22, 22, 20]}}}));
        assert_eq!(voxel["segment"], json!("Nucleus caudatus, links"));
    });
}

#[test]
fn a_project_that_links_its_volume_opens_with_every_voxel_and_name() {
    let dir = tempfile::tempdir().unwrap();
    let project = copied(dir.path()).join("linked.burin");
    also_saved_again(opened(&project), &project, |document| {
        assert_voxels(document, LINKED.iter(), |_| None);
        assert_told(document, "linked", &[]);
    });
}

/// It was opened from a folder that is not there: the copy is put in its place in what is kept, with the time that the file had.
fn lost(copied: &Path) -> (PathBuf, String) {
    let unsaved = copied.join("unsaved");
    let folder = std::fs::read_dir(unsaved.join("recovery")).unwrap().next().unwrap().unwrap().path();
    let kept = folder.join("generation.json");
    let mut manifest: Value = serde_json::from_slice(&std::fs::read(&kept).unwrap()).unwrap();
    let link = &mut manifest["volume"]["kept"]["linked"];
    link["path"] = json!(copied.join("ramp.nrrd"));
    let modified = std::time::Duration::from_nanos(link["modified_ns"].as_u64().unwrap());
    let file = std::fs::File::options().append(true).open(copied.join("ramp.nrrd")).unwrap();
    file.set_modified(std::time::SystemTime::UNIX_EPOCH + modified).unwrap();
    std::fs::write(&kept, manifest.to_string()).unwrap();
    (unsaved, folder.file_name().unwrap().to_str().unwrap().to_owned())
}

#[test]
fn a_document_that_was_never_saved_comes_back_with_every_step_and_the_stroke_that_was_running() {
    let dir = tempfile::tempdir().unwrap();
    let copied = copied(dir.path());
    let (unsaved, id) = lost(&copied);
    let mut document = Document::new();
    document.keep_unsaved_in(unsaved);
    run(&mut document, &json!({"project": {"recover": {"id": id}}}).to_string()).unwrap();
    // It needs a GPU; without one it is the one thing that is missing.
    let painted = gpu().is_some();
    // From one voxel to its neighbour with a ball of 2.8 mm, to 0.4: between two dabs a little less than the radius is reached.
    let running = |at: [u32; 3]| {
        let at = at.map(f64::from);
        let nearest = (0..=100).map(|t| f64::from(t) / 100.0).map(|t| apart(at, [60.0 + t, 8.0 + t, 30.0]));
        let distance = nearest.fold(f64::INFINITY, f64::min);
        (painted && distance <= 2.81).then_some(if distance < 2.7 { 0.4 } else { f64::NAN })
    };
    also_saved_again(document, &dir.path().join("saved.burin"), |document| {
        assert_voxels(document, FIELDS.iter(), running);
        assert_told(document, "unsaved", if painted { &["selection"] } else { &[] });
    });
}
