//! What the values of a file mean, how a picture shall be, what is exported: the questions, and the commands that they lead to.

use super::driver::{SMALL, Window};
use super::replies::lost;
use burin::document::Command;
use burin::ui::{Report, Request};
use egui::Modifiers;
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn command(json: serde_json::Value) -> Command {
    serde_json::from_value(json).unwrap()
}

/// 8³ voxels with a block of ones.
pub(super) fn write_mask(dir: &Path) -> PathBuf {
    let path = dir.join("mask.nrrd");
    let mut file = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n".to_vec();
    file.extend((0..512).map(|n| u8::from(n % 8 > 2 && n / 64 > 2)));
    std::fs::write(&path, file).unwrap();
    path
}

/// Drops a file, and waits until the window has looked at it.
pub(super) fn drop_file(window: &mut Window, path: &Path) {
    window.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.into())));
    window.harness.step();
    window.harness.input_mut().dropped_files.clear();
    let begun = Instant::now();
    while window.harness.query_by_label("Open as: Labels").is_none() {
        assert!(begun.elapsed() < Duration::from_secs(20), "nothing is asked");
        window.harness.run_steps(1);
        std::thread::sleep(Duration::from_millis(5));
    }
    window.harness.run_steps(2);
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("nobody reads it".into())
    }
}

#[test]
fn a_label_map_is_asked_about_once() {
    let dir = tempfile::tempdir().unwrap();
    let path = write_mask(dir.path());
    let open = |meaning: &str| command(json!({ "volume": { "open": { "path": path, "as": meaning } } }));
    for (name, wanted) in [
        ("Open as: Labels", open("labels")),
        ("Open as: Image", open("image")),
        ("Open as: Selection", open("selection")),
    ] {
        let mut window = Window::empty(SMALL);
        drop_file(&mut window, &path);
        assert!(window.harness.query_by_label("Open as: Labels of what is open").is_none());
        assert_eq!(window.click(name), [wanted]);
        assert!(window.harness.query_by_label(name).is_none());
    }
    let mut window = Window::open(SMALL);
    for (name, wanted) in [
        ("Open as: Labels of what is open", command(json!({ "segment": { "import": { "path": path } } }))),
        ("Open as: Selection of what is open", command(json!({ "selection": { "import": { "path": path } } }))),
        ("Open as: Labels", open("labels")),
    ] {
        drop_file(&mut window, &path);
        assert_eq!(window.click(name), [wanted]);
    }
    drop_file(&mut window, &path);
    assert_eq!(window.key(Modifiers::NONE, egui::Key::Escape), []);
    assert!(window.harness.query_by_label("Open as: Labels").is_none());
}

#[test]
fn what_was_chosen_waits_for_a_question_that_comes_first() {
    let dir = tempfile::tempdir().unwrap();
    let path = write_mask(dir.path());
    let mut window = Window::empty(SMALL);
    window.harness.input_mut().dropped_files.push(Arc::new(Dropped(path)));
    window.harness.step();
    window.harness.input_mut().dropped_files.clear();
    window.worker_end.reports.send(lost(&[("1", "/data/a.nii")], Duration::ZERO)).unwrap();
    window.harness.step();
    std::thread::sleep(Duration::from_millis(300));
    window.harness.run_steps(3);
    assert!(window.harness.query_by_label("Recover a.nii").is_some());
    assert!(window.harness.query_by_label("Open as: Labels").is_none());
    window.key(Modifiers::NONE, egui::Key::Escape);
    let begun = Instant::now();
    while window.harness.query_by_label("Open as: Labels").is_none() {
        assert!(begun.elapsed() < Duration::from_secs(20), "it is forgotten");
        window.harness.run_steps(1);
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_label_map_over_unsaved_work_is_opened_after_the_save() {
    let dir = tempfile::tempdir().unwrap();
    let path = write_mask(dir.path());
    let mut window = Window::open(SMALL);
    window.snapshot(|s| s.unsaved = true);
    drop_file(&mut window, &path);
    assert_eq!(window.click("Open as: Labels"), []);
    assert!(window.harness.query_by_label("Save before mask.nrrd is opened?").is_some());
    let open = command(json!({ "volume": { "open": { "path": path, "as": "labels" } } }));
    assert_eq!(window.click("Discard changes"), [open]);
}

/// The menu's entry.
fn choose(window: &mut Window, name: &str) {
    window.click("More…");
    window.click(name);
}

/// Takes the offered path; answers what is sent.
fn take_path(window: &mut Window, typed: &Path) -> Vec<Command> {
    window.click("Choose where…");
    let field = window.harness.get_by_label("Path");
    field.focus();
    window.harness.run_steps(1);
    window.key(Modifiers::COMMAND, egui::Key::A);
    window.harness.get_by_label("Path").type_text(typed.to_str().unwrap());
    window.harness.run_steps(2);
    window.key(Modifiers::NONE, egui::Key::Enter)
}

#[test]
fn a_picture_is_written_as_it_was_wished() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = Window::open(SMALL);
    let path = dir.path().join("v.png");
    let shown = window.harness.get_by_label("Axial view").rect().size() * window.harness.ctx.pixels_per_point();
    window.scene.views.slices[0].size = [shown.x as u32, shown.y as u32];
    window.snapshot(|_| {});
    let image = |more: serde_json::Value| {
        let mut image = json!({ "path": path, "supersample": 2 });
        image.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        command(json!({ "render": { "image": image } }))
    };
    choose(&mut window, "Save picture…");
    window.click("Size: HD");
    assert_eq!(take_path(&mut window, &path), [image(json!({ "size": [1920, 1080] }))], "3D is what is meant first");

    choose(&mut window, "Save picture…");
    window.click("View: Axial");
    window.click("Size: 2×");
    window.click("Background: None");
    window.click("Edges: Finest");
    let size = [shown.x as u32 * 2, shown.y as u32 * 2];
    let wanted = image(json!({ "view": "axial", "size": size, "transparent": true, "supersample": 4 }));
    assert_eq!(take_path(&mut window, &path), [wanted]);

    // What was wished last is wished again.
    choose(&mut window, "Save picture…");
    window.click("View: 3D");
    window.click("Size: 4K");
    window.click("Background: Colour");
    let wanted = image(json!({ "size": [3840, 2160], "background": [1.0, 1.0, 1.0], "supersample": 4 }));
    assert_eq!(take_path(&mut window, &path), [wanted]);

    choose(&mut window, "Save picture…");
    window.click("Format: EXR");
    let exr = dir.path().join("v");
    let wanted = image(json!({ "path": dir.path().join("v.exr"), "size": [3840, 2160], "supersample": 4 }));
    assert_eq!(take_path(&mut window, &exr), [wanted], "the ending is the format's");
}

#[test]
fn the_small_picture_is_of_the_same_command_and_shape() {
    let mut window = Window::open(SMALL);
    choose(&mut window, "Save picture…");
    window.click("Size: HD");
    window.click("Background: None");
    window.harness.run_steps(1);
    window.worker_end.requests.try_iter().for_each(drop);
    window.harness.get_by_label("View: Coronal").click();
    window.harness.run_steps(2);
    let asked: Vec<Request> = window.worker_end.requests.try_iter().map(|(_, r)| r).collect();
    let Some(Request::Sketch(sketch)) = asked.iter().find(|r| matches!(r, Request::Sketch(_))) else {
        panic!("{asked:?}")
    };
    let sketch_json = serde_json::to_value(sketch).unwrap();
    let image = &sketch_json["image"];
    assert_eq!((&image["view"], &image["transparent"]), (&json!("coronal"), &json!(true)));
    let size: [u32; 2] = serde_json::from_value(image["size"].clone()).unwrap();
    assert!(size[0] <= 400 && size[0] * 1080 / 1920 - size[1] <= 1, "{size:?}");
    let spinning = |w: &Window| w.harness.query_by_label("Running").is_some();
    assert!(spinning(&window));
    window.report(Report::Sketch(sketch.clone(), Ok((size, vec![200; (size[0] * size[1] * 4) as usize]))));
    assert!(!spinning(&window));
    window.report(Report::Sketch(sketch.clone(), Err("there is no GPU".into())));
    assert!(window.harness.query_by_label("there is no GPU").is_some());
}

#[test]
fn a_picture_that_is_too_large_is_not_begun() {
    let mut window = Window::open(SMALL);
    choose(&mut window, "Save picture…");
    window.click("Size: Own");
    for name in ["Width in pixels", "Height in pixels"] {
        window.harness.get_by_label(name).focus();
        window.harness.run_steps(2);
        window.key(Modifiers::COMMAND, egui::Key::A);
        window.harness.get_by_label(name).type_text("16384");
        window.harness.run_steps(1);
        window.key(Modifiers::NONE, egui::Key::Enter);
    }
    assert!(window.harness.query_by_label_contains("are too many").is_some());
    assert!(window.harness.get_by_label("Choose where…").accesskit_node().is_disabled());
}

#[test]
fn what_is_exported_is_chosen_and_gets_its_ending() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = Window::open(SMALL);
    let first = window.scene.segments().0[0].id;
    for (what, format, field, ending) in [
        ("What: Labels", "Format: Segments (.seg.nrrd)", "labels", ".seg.nrrd"),
        ("What: Labels", "Format: NIfTI (.nii.gz)", "labels", ".nii.gz"),
        ("What: Density", "Format: NRRD", "density", ".nrrd"),
        ("What: Density", "Format: NIfTI (.nii.gz)", "density", ".nii.gz"),
        ("What: Selection", "Format: NRRD", "selection", ".nrrd"),
        ("What: Selection", "Format: NIfTI (.nii.gz)", "selection", ".nii.gz"),
        ("What: Colour", "Format: NRRD", "colour", ".nrrd"),
    ] {
        choose(&mut window, "Export…");
        window.click(what);
        window.click(format);
        let path = dir.path().join(format!("out{ending}"));
        let wanted = command(json!({ "volume": { "export": { "field": field, "path": path } } }));
        assert_eq!(take_path(&mut window, &dir.path().join("out")), [wanted]);
    }
    // A surface is the selection's or a segment's: the one that is painted, else the first.
    for (what, format, field, label, ending) in [
        ("What: Selection", "Surface: PLY", "selection", None, ".ply"),
        ("What: Labels", "Surface: STL", "labels", Some(first), ".stl"),
        ("What: Labels", "Surface: glTF", "labels", Some(first), ".glb"),
    ] {
        choose(&mut window, "Export…");
        window.click(what);
        window.click(format);
        window.harness.step();
        let path = dir.path().join(format!("out{ending}"));
        let mut wanted = json!({"field": field, "path": path});
        if let Some(label) = label {
            wanted["label"] = json!(label);
        }
        assert_eq!(take_path(&mut window, &dir.path().join("out")), [command(json!({"volume":{"export":wanted}}))]);
    }
    // From there back to voxels no label is left.
    choose(&mut window, "Export…");
    window.click("What: Labels");
    window.click("Surface: OBJ");
    window.click("Format: NRRD");
    let wanted = json!({"volume":{"export":{"field":"labels","path":dir.path().join("out.nrrd")}}});
    assert_eq!(take_path(&mut window, &dir.path().join("out")), [command(wanted)]);
    choose(&mut window, "Export…");
    window.click("What: Density");
    assert!(window.harness.query_by_label("Surface: STL").is_none(), "values have no surface");
}

#[test]
fn the_question_says_why_it_is_asked() {
    let dir = tempfile::tempdir().unwrap();
    let mask = write_mask(dir.path());
    let segments = dir.path().join("mask.seg.nrrd");
    std::fs::copy(&mask, &segments).unwrap();
    for (path, why, other) in [
        (&mask, "Its values look like those of regions", "It is a file of segments."),
        (&segments, "It is a file of segments.", "Its values look like those of regions"),
    ] {
        let mut window = Window::empty(SMALL);
        drop_file(&mut window, path);
        assert!(window.harness.query_by_label_contains(why).is_some(), "{path:?}");
        assert!(window.harness.query_by_label_contains(other).is_none(), "{path:?}");
    }
}
