//! The list of volumes: what it sends, what it marks, that it takes no room where there is one, and a document without any.

use super::driver::{LARGE, SMALL, SMALLEST, Window};
use super::meaning::{drop_file, write_mask};
use burin::document::{Command, HistoryCommand, Origin, Scene, VolumeLook, VolumeSettings};
use burin::math::{DVec3, Pose};
use burin::volume::VolumeId;
use egui::accesskit::Toggled;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::{Value, json};

const PET: VolumeId = VolumeId(1);

fn add(scene: &mut Scene, id: u32, name: &str) {
    let origin = Origin { path: format!("/data/{name}.nii").into(), component: 0, frame: 0 };
    scene.volumes.all.insert(VolumeId(id), VolumeSettings::new(name, origin));
    scene.volumes.next = id + 1;
    let window = scene.window();
    scene.shown.insert(VolumeId(id), VolumeLook::new(window));
}

/// A second volume comes.
pub(super) fn two_volumes(window: &mut Window) {
    add(&mut window.scene, PET.0, "PET");
    window.snapshot(|_| {});
    window.harness.run_steps(3);
}

fn opened(size: [f32; 2]) -> Window {
    let mut window = Window::open(size);
    two_volumes(&mut window);
    window
}

fn volume(sent: &[Command]) -> Value {
    let [Command::Volume(command)] = sent else { panic!("{sent:?}") };
    serde_json::to_value(command).unwrap()
}

/// A number is clicked, typed and entered.
fn enter(window: &mut Window, name: &str, text: &str) -> Vec<Command> {
    window.click(name);
    window.harness.event(egui::Event::Text(text.into()));
    window.harness.run_steps(2);
    window.key(Modifiers::NONE, Key::Enter)
}

fn double_click(window: &mut Window, name: &str) {
    let pos = window.rect(name).left_center() + egui::vec2(10.0, 0.0);
    let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::NONE);
    let click = |pressed| egui::Event::PointerButton { pos, button, pressed, modifiers };
    window.harness.hover_at(pos);
    window.harness.run_steps(1);
    window.harness.input_mut().events.extend([true, false, true, false].map(click));
    window.harness.run_steps(4);
    window.sent();
}

#[test]
fn one_volume_as_it_was_opened_has_no_list() {
    let mut window = Window::open(SMALL);
    assert!(window.harness.query_by_label("Section Volumes").is_none());
    // One that is hidden, weak or moved can be brought back.
    let as_opened = window.scene.volumes.all[&VolumeId::FIRST].clone();
    for changed in [
        VolumeSettings { visible: false, ..as_opened.clone() },
        VolumeSettings { opacity: 0.5, ..as_opened.clone() },
        VolumeSettings { pose: Pose { translation: DVec3::X, ..Pose::IDENTITY }, ..as_opened.clone() },
    ] {
        window.scene.volumes.all.insert(VolumeId::FIRST, changed);
        window.snapshot(|_| {});
        window.harness.run_steps(2);
        assert!(window.harness.query_by_label("Show volume small").is_some());
        window.scene.volumes.all.insert(VolumeId::FIRST, as_opened.clone());
        window.snapshot(|_| {});
        window.harness.run_steps(2);
        assert!(window.harness.query_by_label("Section Volumes").is_none());
    }
    two_volumes(&mut window);
    assert!(window.harness.query_by_label("Section Volumes").is_some());
}

#[test]
fn each_control_of_a_row_sends_what_it_says() {
    let mut window = opened(SMALL);
    let sent = window.click("Show volume PET");
    assert_eq!(volume(&sent), json!({ "set": { "volume": 1, "visible": false } }));
    let sent = enter(&mut window, "Opacity of volume PET", "25");
    assert_eq!(volume(&sent), json!({ "set": { "volume": 1, "opacity": 0.25 } }));
    for control in ["Name of volume 1", "Paint volume PET"] {
        let mut window = opened(SMALL);
        assert_eq!(volume(&window.click(control)), json!({ "set": { "volume": 1, "active": true } }), "{control}");
    }
    // The one that is painted already is not chosen again.
    for control in ["Name of volume 0", "Paint volume small"] {
        assert_eq!(opened(SMALL).click(control), [], "{control}");
    }
    let mut window = opened(SMALL);
    double_click(&mut window, "Name of volume 1");
    window.harness.event(egui::Event::Text("FDG".into()));
    window.harness.run_steps(2);
    let sent = window.key(Modifiers::NONE, Key::Enter);
    assert_eq!(volume(&sent), json!({ "set": { "volume": 1, "name": "FDG" } }));
    let sent = opened(SMALL).click("Remove volume PET");
    assert_eq!(volume(&sent), json!({ "remove": { "volume": 1 } }));
}

#[test]
fn a_sign_lets_strokes_paint_a_volume_besides_the_active_one() {
    let mut window = opened(SMALL);
    add(&mut window.scene, 2, "Atlas");
    window.snapshot(|_| {});
    window.harness.run_steps(3);
    let said = |sent: &[Command]| {
        let [Command::Brush(command)] = sent else { panic!("{sent:?}") };
        serde_json::to_value(command).unwrap()
    };
    let lit = |window: &Window, name: &str| {
        window.harness.get_by_label(name).accesskit_node().toggled() == Some(Toggled::True)
    };
    assert!(!lit(&window, "Paint volume PET too"));
    assert_eq!(said(&window.click("Paint volume PET too")), json!({ "also": { "volumes": [1] } }));
    // The document is busy: the list shows it at once.
    assert!(lit(&window, "Paint volume PET too") && !lit(&window, "Paint volume Atlas too"));
    assert_eq!(said(&window.click("Paint volume Atlas too")), json!({ "also": { "volumes": [1, 2] } }));
    assert_eq!(said(&window.click("Paint volume PET too")), json!({ "also": { "volumes": [2] } }));
    // The active one is painted anyway, and what is hidden is not.
    assert!(window.harness.query_by_label("Paint volume small too").is_none());
    window.click("Show volume Atlas");
    assert!(window.harness.query_by_label("Paint volume Atlas too").is_none());
}

#[test]
fn the_list_shows_at_once_what_is_sent_and_marks_the_volume_that_is_painted() {
    let mut window = opened(SMALL);
    let lit = |window: &Window, name: &str| {
        window.harness.get_by_label(name).accesskit_node().toggled() == Some(Toggled::True)
    };
    assert!(lit(&window, "Paint volume small") && !lit(&window, "Paint volume PET"));
    // The document is busy: it says nothing.
    window.click("Paint volume PET");
    assert!(!lit(&window, "Paint volume small") && lit(&window, "Paint volume PET"));
    window.click("Show volume PET");
    let sent = window.click("Show volume PET");
    assert_eq!(volume(&sent), json!({ "set": { "volume": 1, "visible": true } }), "what was hidden is shown again");
    let said = window.harness.get_by_label("Paint volume PET");
    assert!(said.accesskit_node().data().description().unwrap_or_default().contains("brush paints this volume"));
}

#[test]
fn a_volume_is_shifted_and_turned_about_its_own_middle_in_numbers() {
    // Of 64 × 64 × 32 voxels of 1 × 1 × 2 mm from (0, 0, 0).
    let middle = DVec3::new(31.5, 31.5, 31.0);
    let pose = |sent: &[Command]| -> Pose {
        let said = volume(sent);
        assert_eq!(said["set"].as_object().unwrap().len(), 2, "{said}");
        serde_json::from_value(said["set"]["pose"].clone()).unwrap()
    };
    for (name, text, moves, to) in [
        ("Shift to the right of the volume", "12.5", DVec3::ZERO, DVec3::new(12.5, 0.0, 0.0)),
        ("Shift to the front of the volume", "-3", DVec3::ZERO, DVec3::new(0.0, -3.0, 0.0)),
        ("Shift up of the volume", "0.25", DVec3::ZERO, DVec3::new(0.0, 0.0, 0.25)),
        ("Nod of the volume", "90", DVec3::Y, DVec3::Z),
        ("Tilt of the volume", "90", DVec3::Z, DVec3::X),
        ("Turn of the volume", "90", DVec3::X, DVec3::Y),
    ] {
        let mut window = opened(SMALL);
        window.click("Place of volume PET");
        let moved = pose(&enter(&mut window, name, text));
        let error = (moved.apply(middle + moves) - (middle + to)).length();
        assert!(error < 1e-9, "{name} {text}: {moved:?}, off by {error} mm");
        // The fields say what was made of them, and the next one keeps it.
        let sent = enter(&mut window, "Shift up of the volume", "7");
        let both = pose(&sent);
        let lifted = DVec3::new(to.x, to.y, 7.0);
        let wanted = middle + if moves == DVec3::ZERO { lifted } else { to + DVec3::Z * 7.0 };
        assert!((both.apply(middle + moves) - wanted).length() < 1e-6, "{name}: {both:?}");
        let back = window.click("Back to its place");
        assert_eq!(pose(&back), Pose::IDENTITY);
    }
}

#[test]
fn more_volumes_move_nothing_and_their_rows_lie_in_the_column() {
    for size in [SMALLEST, SMALL, LARGE] {
        let mut window = opened(size);
        let before = ["Section Brush", "Name of volume 1", "Remove volume PET"].map(|name| window.rect(name));
        let border = window.rect("Border of the left panel");
        for id in 2..40 {
            add(&mut window.scene, id, &format!("a long name of a follow-up that nobody reads to its end, {id}"));
        }
        window.snapshot(|_| {});
        window.harness.run_steps(3);
        let after = ["Section Brush", "Name of volume 1", "Remove volume PET"].map(|name| window.rect(name));
        assert_eq!(before, after, "in {size:?}");
        let row = [
            "Paint volume PET",
            "Show volume PET",
            "Name of volume 1",
            "Opacity of volume PET",
            "Place of volume PET",
            "Remove volume PET",
        ]
        .map(|name| window.rect(name));
        for pair in row.windows(2) {
            assert!(pair[0].right() <= pair[1].left() + 0.6, "{pair:?} in {size:?}");
        }
        assert!(row[2].width() > 60.0 && row[5].right() <= border.left(), "{row:?} beside {border:?} in {size:?}");
    }
}

#[test]
fn a_label_map_comes_beside_what_is_open_on_its_own_grid() {
    let dir = tempfile::tempdir().unwrap();
    let path = write_mask(dir.path());
    for (name, wanted) in [
        (
            "Open as: Another volume",
            json!({ "add": { "path": path, "as": "labels", "component": u32::MAX, "frame": 0, "range": null } }),
        ),
        (
            "Open as: Another volume of grey values",
            json!({ "add": { "path": path, "component": u32::MAX, "frame": 0, "range": null, "opacity": 0.5 } }),
        ),
    ] {
        let mut window = Window::open(SMALL);
        // What is there stays: unsaved work is no question.
        window.snapshot(|s| s.unsaved = true);
        drop_file(&mut window, &path);
        assert_eq!(volume(&window.click(name)), wanted);
    }
    let mut window = Window::empty(SMALL);
    drop_file(&mut window, &path);
    assert!(window.harness.query_by_label("Open as: Another volume").is_none(), "there is nothing beside it");
}

#[test]
fn a_document_whose_last_volume_is_gone_shows_the_start_page_and_can_be_undone_saved_and_added_to() {
    let mut window = opened(SMALL);
    window.snapshot(|s| {
        s.open = None;
        s.unsaved = true;
    });
    window.harness.run_steps(3);
    assert!(
        window.harness.query_by_label("Open…").is_some() && window.harness.query_by_label("Section Brush").is_none()
    );
    let undo = Command::History(HistoryCommand::Undo { steps: 1 });
    assert_eq!(window.key(Modifiers::COMMAND, Key::Z), std::slice::from_ref(&undo));
    assert_eq!(window.click("Undo"), [undo]);
    window.snapshot(|s| {
        s.open = None;
        s.project = Some("/data/head.burin".into());
    });
    let save = json!({ "project": { "save": { "path": null, "density": null } } });
    assert_eq!(serde_json::to_value(window.click("Save")).unwrap(), json!([save]));
    window.click("Add a volume…");
    assert!(window.harness.query_by_label("Path").is_some());
    // Where nothing was ever open there is nothing to add to.
    let mut window = Window::empty(SMALL);
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label("Add a volume…").is_none());
}

#[test]
fn a_file_that_is_added_by_its_path_is_asked_about_only_if_it_looks_like_regions() {
    let dir = tempfile::tempdir().unwrap();
    let scan = dir.path().join("scan.nrrd");
    let mut file = b"NRRD0004\ntype: uint16\ndimension: 3\nsizes: 8 8 8\nencoding: raw\nendian: little\n\n".to_vec();
    file.extend((0..512_u16).flat_map(|n| (n.wrapping_mul(40_503) >> 3).to_le_bytes()));
    std::fs::write(&scan, file).unwrap();
    for (path, asked) in [(scan, false), (write_mask(dir.path()), true)] {
        let mut window = Window::open(SMALL);
        window.click("More…");
        window.click("Add a volume…");
        let field = window.harness.get_by_label("Path");
        field.focus();
        window.harness.run_steps(1);
        window.key(Modifiers::COMMAND, Key::A);
        window.harness.get_by_label("Path").type_text(path.to_str().unwrap());
        window.harness.run_steps(2);
        let mut sent = window.key(Modifiers::NONE, Key::Enter);
        let begun = std::time::Instant::now();
        while sent.is_empty() && window.harness.query_by_label("Open as: Another volume").is_none() {
            assert!(begun.elapsed().as_secs() < 20, "nothing comes of {path:?}");
            window.harness.run_steps(1);
            std::thread::sleep(std::time::Duration::from_millis(5));
            sent.extend(window.sent());
        }
        // In its first frame a dialog is measured; only then does it lie where it is clicked.
        window.harness.run_steps(2);
        assert_eq!(sent.is_empty(), asked, "{path:?}: {sent:?}");
        if asked {
            assert!(window.harness.query_by_label("Open as: Labels").is_none(), "it comes beside what is open");
            sent = window.click("Open as: Another volume");
        }
        assert_eq!(volume(&sent)["add"]["path"], json!(path));
    }
}

#[test]
fn the_volume_that_is_painted_is_removed_from_the_menu_which_names_it_among_several() {
    for size in [SMALL, LARGE] {
        for (mut window, name) in [(Window::open(size), "Remove the volume"), (opened(size), "Remove small")] {
            window.click("More…");
            window.harness.run_steps(2);
            let remove = json!({ "volume": { "remove": { "volume": 0 } } });
            assert_eq!(serde_json::to_value(window.click(name)).unwrap(), json!([remove]));
        }
    }
}

#[test]
fn layers_and_segments_say_whose_they_are_where_that_is_a_question() {
    let mut window = Window::open(SMALL);
    let names = |window: &Window, name: &str| window.harness.query_all_by_label(name).count();
    assert_eq!(names(&window, "small"), 0);
    add(&mut window.scene, 1, "A follow-up of the same head half a year later");
    add(&mut window.scene, 2, "small");
    for (active, name) in [(0, "small (0)"), (1, "A follow-up of the same head half a year later"), (2, "small (2)")] {
        window.scene.volumes.active = VolumeId(active);
        window.snapshot(|_| {});
        window.harness.run_steps(3);
        assert_eq!(names(&window, name), 2, "{name}: over layers and over segments");
        for heading in ["Section Layers", "Section Segments"] {
            let rect = window.rect(heading);
            let labels: Vec<_> = window.harness.query_all_by_label(name).map(|label| label.rect()).collect();
            assert!(labels.iter().any(|label| rect.contains_rect(*label)), "{heading} {rect:?}: {labels:?}");
        }
    }
}

#[test]
fn segments_have_a_strength_in_slices_and_one_in_3d() {
    let layer = |sent: &[Command]| serde_json::to_value(sent).unwrap()[0]["view"]["layer"].clone();
    let mut window = Window::open(SMALL);
    let (slices, solid) = ("Opacity of layer Segments", "Opacity of layer Segments in 3D");
    let sent = enter(&mut window, solid, "40");
    let said = layer(&sent);
    assert_eq!((&said["field"], &said["opacity"]), (&json!("labels"), &json!(0.5)));
    assert!((said["opacity_3d"].as_f64().unwrap() - 0.4).abs() < 1e-6);
    let said = layer(&enter(&mut window, slices, "25"));
    assert_eq!(said["opacity"], json!(0.25));
    assert!((said["opacity_3d"].as_f64().unwrap() - 0.4).abs() < 1e-6, "that of 3D stays: {said}");
    let said = layer(&window.click("Show layer Segments"));
    assert_eq!((&said["visible"], &said["opacity"]), (&json!(false), &json!(0.25)));
    assert!(said["opacity_3d"].is_number());
    // Until that of 3D is said it is one for both.
    let mut window = Window::open(SMALL);
    let said = layer(&enter(&mut window, slices, "25"));
    assert_eq!((&said["opacity"], said.get("opacity_3d")), (&json!(0.25), None), "both follow");
}
