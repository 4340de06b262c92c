//! What is lit, held and shown: controls show what is, at once, and a hand that leaves leaves nothing half done.

use super::driver::{SMALL, Window};
use burin::document::answers_ask::{VolumeVoxelSaid, VoxelSaid, VoxelValues};
use burin::document::{BrushCommand, Command, PartCommand, StrokeCommand, ViewName};
use burin::explode::PartId;
use burin::gpu::ObjectId;
use burin::paint::{BrushChange, Target, Tip};
use burin::ui::{Picture, Report};
use burin::volume::{Mode, Number, VolumeId};
use egui::accesskit::Toggled;
use egui::{Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

fn lit(window: &Window, name: &str) -> bool {
    window.harness.get_by_label(name).accesskit_node().toggled() == Some(Toggled::True)
}

fn value(window: &Window, name: &str) -> Option<String> {
    window.harness.get_by_label(name).value()
}

#[test]
fn a_pin_goes_in_and_out_before_the_document_answers() {
    let mut window = Window::open(SMALL);
    for pinned in [true, false, true] {
        let sent = window.click("Pin Upper half");
        let set = matches!(&sent[..], [Command::Part(PartCommand::Set { id: PartId(2), pinned: Some(p), .. })] if *p == pinned);
        assert!(set, "{sent:?}");
        assert_eq!((lit(&window, "Pin Upper half"), lit(&window, "Pin Lower half")), (pinned, false));
    }
}

#[test]
fn a_part_has_its_own_colours_again_before_the_document_answers() {
    let mut window = Window::open(SMALL);
    let own = value(&window, "Colour of Upper half");
    window.click("Colour of Upper half");
    window.click("Pick red");
    assert_ne!(value(&window, "Colour of Upper half"), own);
    window.click("The volume's own colours");
    assert_eq!(value(&window, "Colour of Upper half"), own);
}

#[test]
fn how_dabs_overlap_is_what_was_clicked() {
    let mut window = Window::open(SMALL);
    let names = [("Overlap: Builds up", Tip::BuildUp), ("Overlap: Even", Tip::Wash)];
    assert!(lit(&window, "Overlap: Even"));
    for (name, wanted) in names {
        let sent = window.click(name);
        let set = matches!(&sent[..], [Command::Brush(BrushCommand::Set(BrushChange { tip: Some(tip), .. }))] if *tip == wanted);
        assert!(set, "{name}: {sent:?}");
        assert!(names.iter().all(|(other, _)| lit(&window, other) == (*other == name)), "{name}");
    }
}

#[test]
fn four_views_are_lit_while_there_are_four() {
    let mut window = Window::open(SMALL);
    assert!(lit(&window, "Four views"));
    window.click("Only the Sagittal view");
    assert!(!lit(&window, "Four views"));
    window.click("Four views");
    assert!(lit(&window, "Four views"));
}

#[test]
fn the_segment_that_is_painted_is_lit_and_no_other() {
    let mut window = Window::open(SMALL);
    for target in [Target::Label(2), Target::Label(1), Target::Selection(1.0)] {
        window.scene.brush.target = target;
        window.snapshot(|_| {});
        for id in [1, 2] {
            assert_eq!(lit(&window, &format!("Paint segment Segment {id}")), target == Target::Label(id), "{target:?}");
        }
    }
}

#[test]
fn a_stroke_is_taken_back_when_the_window_is_left() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = window.harness.get_by_label("Axial view").rect().center();
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    assert!(matches!(window.sent()[..], [Command::Stroke(StrokeCommand::Begin { .. })]));
    window.harness.event(egui::Event::WindowFocused(false));
    window.harness.run_steps(2);
    assert_eq!(window.sent(), [Command::Stroke(StrokeCommand::Cancel {})], "nobody hears the button go up");
    window.harness.event(egui::Event::PointerMoved(at + vec2(9.0, 0.0)));
    window.harness.run_steps(2);
    assert_eq!(window.sent(), []);
}

#[test]
fn e_that_is_held_before_the_button_erases_for_this_stroke() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let key = |window: &mut Window, pressed| {
        let event = egui::Event::Key {
            key: egui::Key::E,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::NONE,
        };
        window.harness.input_mut().events.push(event);
        window.harness.run_steps(3);
    };
    key(&mut window, true);
    assert_eq!(window.sent(), []);
    let at = window.harness.get_by_label("Axial view").rect().center();
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    window.harness.drop_at(at + vec2(9.0, 0.0));
    window.harness.run_steps(2);
    key(&mut window, false);
    let erases = |command: &Command| match command {
        Command::Brush(BrushCommand::Set(BrushChange { erase: Some(erase), .. })) => Some(*erase),
        _ => None,
    };
    let sent = window.sent();
    assert_eq!(sent.first().and_then(erases), Some(true), "{sent:?}");
    assert!(matches!(sent[1], Command::Stroke(StrokeCommand::Begin { .. })), "{sent:?}");
    assert_eq!(sent.last().and_then(erases), Some(false), "{sent:?}");
    let ends = sent.iter().position(|c| *c == Command::Stroke(StrokeCommand::End {}));
    assert_eq!(ends, Some(sent.len() - 2), "{sent:?}");
}

/// Puts the pointer down at a share of a slider.
fn slide(window: &mut Window, name: &str, share: f32) -> Vec<Command> {
    let rail = window.rect(name);
    let at = egui::pos2(rail.left() + rail.width() * share, rail.center().y);
    window.harness.hover_at(at);
    window.harness.run_steps(1);
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    window.harness.drop_at(at);
    window.harness.run_steps(2);
    window.sent()
}

#[test]
fn sliders_of_the_paint_set_what_they_show() {
    let mut window = Window::open(SMALL);
    for (target, name) in
        [(Target::Selection(0.9), "Interest"), (Target::Colour([0.1, 0.2, 0.3, 0.9]), "Colour opacity")]
    {
        window.scene.brush.target = target;
        window.snapshot(|_| {});
        let sent = slide(&mut window, name, 0.25);
        let painted = sent.iter().rev().find_map(|c| match c {
            Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Selection(x)), .. })) => Some(*x),
            Command::Brush(BrushCommand::Set(BrushChange {
                target: Some(Target::Colour([0.1, 0.2, 0.3, x])), ..
            })) => Some(*x),
            _ => None,
        });
        let painted = painted.unwrap_or_else(|| panic!("{name}: {sent:?}"));
        assert!((painted - 0.25).abs() < 0.06, "{name}: {painted}");
    }
}

#[test]
fn buttons_of_the_explosion_and_of_the_light_ask_for_what_they_say() {
    let mut window = Window::open(SMALL);
    let command = |json: serde_json::Value| serde_json::from_value::<Command>(json).unwrap();
    assert_eq!(window.click("Settle"), [command(serde_json::json!({ "explosion": { "settle": {} } }))]);
    assert_eq!(window.click("Join all parts"), [command(serde_json::json!({ "part": { "reset": {} } }))]);
    for lit in [true, false] {
        window.scene.look.lighting = lit.then(Default::default);
        window.snapshot(|_| {});
        let wanted = command(serde_json::json!({ "view": { "look": { "shaded": !lit } } }));
        assert_eq!(window.click("Headlight"), [wanted]);
    }
}

#[test]
fn a_click_with_the_line_cuts_nothing_and_a_drag_on_a_slice_does() {
    for (by, cuts) in [(0.0, false), (2.0, false), (60.0, true)] {
        let mut window = Window::open(SMALL);
        window.click("Line split");
        let at = window.harness.get_by_label("Axial view").rect().center();
        window.harness.hover_at(at);
        window.harness.run_steps(1);
        window.harness.drag_at(at);
        window.harness.run_steps(1);
        window.harness.hover_at(at + vec2(by, 0.0));
        window.harness.run_steps(1);
        window.harness.drop_at(at + vec2(by, 0.0));
        window.harness.run_steps(2);
        let sent = window.sent();
        let splits = sent.iter().filter(|c| matches!(c, Command::Part(PartCommand::Split { .. }))).count();
        assert_eq!(splits > 0, cuts, "{by}: {sent:?}");
    }
}

#[test]
fn escape_takes_a_stroke_back_whatever_else_is_held() {
    for modifiers in [Modifiers::NONE, Modifiers::SHIFT] {
        let mut window = Window::open(SMALL);
        window.click("Brush");
        let at = window.harness.get_by_label("Axial view").rect().center();
        window.harness.drag_at(at);
        window.harness.run_steps(2);
        let sent = window.key(modifiers, egui::Key::Escape);
        assert_eq!(sent.last(), Some(&Command::Stroke(StrokeCommand::Cancel {})), "{modifiers:?}: {sent:?}");
    }
}

#[test]
fn arrows_move_the_slice_under_the_pointer_and_nothing_in_3d() {
    let mut window = Window::open(SMALL);
    for (view, moves) in [("3D view", false), ("Axial view", true), ("Coronal view", true)] {
        let at = window.harness.get_by_label(view).rect().center();
        window.harness.hover_at(at);
        window.harness.run_steps(2);
        window.sent();
        let sent = window.key(Modifiers::NONE, egui::Key::ArrowUp);
        assert_eq!(sent.len(), usize::from(moves), "{view}: {sent:?}");
    }
}

#[test]
fn the_light_can_be_set_where_it_does_anything() {
    let mut window = Window::open(SMALL);
    for (mode, light) in [(Mode::Dvr, true), (Mode::Mip, false), (Mode::Iso(40.0), true)] {
        window.scene.look.mode = mode;
        window.snapshot(|_| {});
        assert_eq!(window.harness.get_by_label("Headlight").accesskit_node().is_disabled(), !light, "{mode:?}");
    }
}

/// The pointer stands in the 3D view, which shows this.
fn point_at(window: &mut Window, object: ObjectId) {
    let camera = window.scene.views.camera;
    let depth_mm = vec![camera.eye.distance(camera.target) as f32; 4];
    let (view, size, rgba) = (ViewName::ThreeD, [2, 2], vec![9; 16]);
    let picture = Picture { view, size, rgba, depth_mm, object: vec![object; 4], camera, serial: 0 };
    window.report(Report::Picture(Box::new(picture)));
    let at = window.rect("3D view").center();
    window.harness.hover_at(at);
    window.harness.run_steps(2);
}

#[test]
fn the_status_line_says_of_3d_that_it_shows_what_is_selected_as_the_picture_tells() {
    let mut window = Window::open(SMALL);
    let probe = |selection: f32| {
        let (density, colour) = (Number::Whole(7), [0.0; 4]);
        let values = VoxelValues { voxel: [1; 3], density, half_step: 0.0, colour, selection, label: 0, segment: None };
        Report::Probe(Some(VoxelSaid { inside: true, values: Some(values), ..VoxelSaid::default() }))
    };
    let says = |window: &mut Window, selected: bool, share: f32| {
        point_at(window, ObjectId::new(VolumeId::FIRST, 0, selected, 0));
        window.report(probe(share));
        let texts = ["selected 30 %", "selected 100 %", "selected  ·  Lower half", "selected  ·  Upper half"];
        texts.map(|text| window.harness.query_by_label_contains(text).is_some())
    };
    assert_eq!(says(&mut window, false, 0.0), [false; 4]);
    assert_eq!(says(&mut window, false, 0.3), [true, false, false, false]);
    assert_eq!(says(&mut window, false, 1.0), [false; 4], "a neighbour's voxel");
    let word = says(&mut window, true, 1.0);
    assert!(word[..2] == [false; 2] && (word[2] || word[3]), "{word:?}");
}

#[test]
fn the_status_line_says_of_a_label_map_beside_others_its_segment_or_that_there_is_none() {
    let mut window = Window::open(SMALL);
    super::volumes::two_volumes(&mut window);
    let at = window.rect("Axial view").center();
    window.harness.hover_at(at);
    window.harness.run_steps(2);
    let values = |label: u16, segment: Option<&str>| {
        let (density, colour, segment) = (Number::Whole(0), [0.0; 4], segment.map(str::to_owned));
        VoxelValues { voxel: [1; 3], density, half_step: 0.0, colour, selection: 0.0, label, segment }
    };
    let mut said = |label_map: bool, segment: Option<&str>| {
        window.scene.volumes.all.get_mut(&VolumeId(1)).unwrap().label_map = label_map;
        window.snapshot(|_| {});
        let (density, colour, segment) = (Number::Whole(0), [0.0; 4], segment.map(str::to_owned));
        let values = VoxelValues { voxel: [1; 3], density, half_step: 0.0, colour, selection: 0.0, label: 0, segment };
        let other = VolumeVoxelSaid { volume: VolumeId(1), name: "PET".into(), values: Some(values.clone()) };
        let voxel = VoxelSaid { inside: true, values: Some(values), volumes: vec![other], ..VoxelSaid::default() };
        window.report(Report::Probe(Some(voxel)));
        ["PET: 0", "PET: no segment", "PET: Lung"].map(|text| window.harness.query_by_label(text).is_some())
    };
    assert_eq!(said(false, None), [true, false, false]);
    assert_eq!(said(true, None), [false, true, false]);
    assert_eq!(said(true, Some("Lung")), [false, false, true]);
    // What 3D shows is told once.
    for (volume, segment, again) in [(1, 5, false), (1, 0, true), (0, 5, true)] {
        point_at(&mut window, ObjectId::new(VolumeId(volume), 0, false, segment));
        let values = values(0, Some("Lung"));
        let other = VolumeVoxelSaid { volume: VolumeId(1), name: "PET".into(), values: Some(values.clone()) };
        let voxel = VoxelSaid { inside: true, values: Some(values), volumes: vec![other], ..VoxelSaid::default() };
        window.report(Report::Probe(Some(voxel)));
        assert_eq!(window.harness.query_by_label("PET: Lung").is_some(), again, "{volume} {segment}");
    }
}
