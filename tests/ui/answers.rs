//! The window answers: every hand movement has its effect, or a word that says why not.

use super::driver::{SMALL, Window};
use burin::document::{
    BrushCommand, Command, HistoryCommand, PastOf, StrokeCommand, StrokePoint, ViewCommand, ViewName,
};
use burin::interact::Tool;
use burin::paint::{BrushChange, Target};
use burin::ui::{Picture, Report, Request};
use egui::accesskit::Toggled;
use egui::{Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

const BEGIN: Command = Command::History(HistoryCommand::Begin {});
const END: Command = Command::History(HistoryCommand::End {});

fn is_in_hand(window: &Window, tool: Tool) -> bool {
    window.harness.get_by_label(tool.name()).accesskit_node().toggled() == Some(Toggled::True)
}

fn middle(window: &Window, view: &str) -> Pos2 {
    window.harness.get_by_label(view).rect().center()
}

fn hover(window: &mut Window, at: Pos2) {
    window.harness.hover_at(at);
    window.harness.run_steps(2);
}

#[test]
fn with_nothing_open_keys_do_nothing() {
    let mut window = Window::empty(SMALL);
    window.harness.run_steps(3);
    use egui::Key as K;
    for key in [K::B, K::X, K::D, K::L, K::M, K::Num1, K::CloseBracket, K::Home, K::F, K::ArrowUp] {
        assert_eq!(window.key(Modifiers::NONE, key), [], "{key:?}");
    }
    for key in [K::Z, K::Y, K::S] {
        assert_eq!(window.key(Modifiers::COMMAND, key), [], "Ctrl + {key:?}");
    }
    assert_eq!(window.key(Modifiers::ALT, K::ArrowLeft), []);
    for name in ["Save", "Four views", "Undo", "Back to the view before", "Brush"] {
        assert!(window.harness.get_by_label(name).accesskit_node().is_disabled(), "{name}");
    }
    window.snapshot(|_| {});
    assert!(is_in_hand(&window, Tool::Navigate), "no key chose a tool");
    assert!(window.harness.query_by_label("Axial view").is_some(), "nor a view");
}

#[test]
fn choosing_what_to_paint_takes_the_brush() {
    let mut window = Window::open(SMALL);
    window.scene.brush.target = Target::Selection(1.0);
    window.snapshot(|_| {});
    // The one that is lit already too.
    for name in ["Paint: Selection", "Paint: Label", "Paint: Colour", "Paint: Density", "Paint segment Segment 2"] {
        window.click("Line split");
        assert!(!is_in_hand(&window, Tool::Brush));
        window.click(name);
        assert!(is_in_hand(&window, Tool::Brush), "{name}");
    }
    window.click("Navigate");
    window.click("Label to paint");
    window.click("1  Segment 1");
    assert!(is_in_hand(&window, Tool::Brush), "a label out of the list");
    window.click("Navigate");
    let sent = window.key(Modifiers::NONE, egui::Key::Num2);
    assert!(
        matches!(sent[..], [Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Label(2)), .. }))])
            && is_in_hand(&window, Tool::Brush)
    );
}

#[test]
fn home_fits_the_view_under_the_pointer_and_each_view_has_a_button_for_it() {
    let mut window = Window::open(SMALL);
    for (view, name, title) in [
        (ViewName::ThreeD, "3D view", "3D"),
        (ViewName::Axial, "Axial view", "Axial"),
        (ViewName::Coronal, "Coronal view", "Coronal"),
        (ViewName::Sagittal, "Sagittal view", "Sagittal"),
    ] {
        let fit = [Command::View(ViewCommand::Fit { view })];
        let at = middle(&window, name);
        hover(&mut window, at);
        assert_eq!(window.key(Modifiers::NONE, egui::Key::Home), fit, "{name}");
        assert_eq!(window.click(&format!("Fit the {title} view")), fit, "{name}");
    }
    assert!(matches!(
        window.key(Modifiers::SHIFT, egui::Key::Home)[..],
        [Command::View(ViewCommand::Frame { from: [0.0, 1.0, 0.0], .. })]
    ));
    window.click("Only the Coronal view");
    let fit = Command::View(ViewCommand::Fit { view: ViewName::Coronal });
    assert_eq!(window.key(Modifiers::NONE, egui::Key::Home), [fit], "the view that is alone");
}

#[test]
fn views_and_looks_go_back_and_forward_by_button_and_by_key() {
    let mut window = Window::open(SMALL);
    let back = |of| [Command::View(ViewCommand::Back { of })];
    let forward = |of| [Command::View(ViewCommand::Forward { of })];
    let dead = |window: &Window, name: &str| window.harness.get_by_label(name).accesskit_node().is_disabled();
    assert!(dead(&window, "Back to the view before") && dead(&window, "Forward to the next view"));
    window.snapshot(|s| s.back = Some("Window".into()));
    assert!(!dead(&window, "Back to the view before") && dead(&window, "Forward to the next view"));
    assert_eq!(window.click("Back to the view before"), back(None));
    window.snapshot(|s| s.forward = Some("Turn".into()));
    assert_eq!(window.click("Forward to the next view"), forward(None));
    assert_eq!(window.key(Modifiers::ALT, egui::Key::ArrowLeft), back(None));
    assert_eq!(window.key(Modifiers::ALT, egui::Key::ArrowRight), forward(None));
    let alone = Modifiers::ALT | Modifiers::SHIFT;
    assert_eq!(window.key(alone, egui::Key::ArrowLeft), back(Some(PastOf::Looks)));
    assert_eq!(window.key(alone, egui::Key::ArrowRight), forward(Some(PastOf::Looks)));
}

#[test]
fn the_wheel_until_it_rests_is_one_change_of_view() {
    let mut window = Window::open(SMALL);
    let at = middle(&window, "Axial view");
    hover(&mut window, at);
    window.sent();
    let turn = |window: &mut Window| {
        let event = egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: vec2(0.0, 1.0),
            modifiers: Modifiers::NONE,
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
        };
        window.harness.event(event);
        window.harness.run_steps(1);
    };
    (0..4).for_each(|_| turn(&mut window));
    let slice = Command::View(ViewCommand::Scroll { view: ViewName::Axial, voxels: 1 });
    let sent = window.sent();
    assert_eq!(sent[0], BEGIN, "{sent:?}");
    assert_eq!(sent[1..], vec![slice.clone(); 4]);
    window.harness.run_steps(8);
    assert_eq!(window.sent(), [END], "at rest");
    turn(&mut window);
    assert_eq!(window.key(Modifiers::NONE, egui::Key::CloseBracket).first(), Some(&BEGIN));
    turn(&mut window);
    window.sent();
    window.harness.drag_at(at);
    window.harness.run_steps(1);
    let sent = window.sent();
    assert_eq!(sent[..2], [END, BEGIN], "a press ends it and begins its own: {sent:?}");
}

/// Whether the window asked what is under the pointer.
fn asked(window: &mut Window) -> bool {
    window
        .worker_end
        .requests
        .try_iter()
        .filter(|(_, r)| matches!(r, Request::Probe { view: ViewName::Axial, .. }))
        .count()
        > 0
}

#[test]
fn a_resting_pointer_asks_again_after_each_change() {
    let mut window = Window::open(SMALL);
    let at = middle(&window, "Axial view");
    hover(&mut window, at);
    assert!(asked(&mut window), "the pointer moved");
    window.harness.run_steps(4);
    assert!(!asked(&mut window), "nothing happens");
    for (moving, asks) in [(true, false), (false, true), (false, true)] {
        window.tell(|s| s.moving = moving);
        assert_eq!(asked(&mut window), asks, "a motion asks once it is at rest");
    }
}

#[test]
fn a_held_key_chooses_once_and_grows_the_brush_as_long_as_it_is_held() {
    let mut window = Window::open(SMALL);
    // A key that is pressed and was not let go before repeats.
    let key = |window: &mut Window, key, pressed| {
        let modifiers = Modifiers::NONE;
        window.harness.event(egui::Event::Key { key, physical_key: None, pressed, repeat: false, modifiers });
        window.harness.run_steps(2);
        window.sent().len()
    };
    assert_eq!(key(&mut window, egui::Key::CloseBracket, true), 1);
    assert_eq!(key(&mut window, egui::Key::CloseBracket, true), 1, "it repeats");
    key(&mut window, egui::Key::B, true);
    window.click("Navigate");
    key(&mut window, egui::Key::B, true);
    assert!(is_in_hand(&window, Tool::Navigate), "a key that was held before chooses nothing");
    let four = |window: &Window| window.harness.query_by_label("Coronal view").is_some();
    let at = middle(&window, "Axial view");
    hover(&mut window, at);
    for (pressed, shown) in [(true, false), (true, false), (true, false), (false, false), (true, true), (true, true)] {
        key(&mut window, egui::Key::F, pressed);
        assert_eq!(four(&window), shown, "one view and four do not alternate while F is held");
    }
}

fn begun(sent: &[Command]) -> Option<f32> {
    sent.iter().find_map(|c| match c {
        Command::Stroke(StrokeCommand::Begin { points, .. }) => match points[..] {
            [StrokePoint { pressure, .. }] => Some(pressure),
            _ => None,
        },
        _ => None,
    })
}

#[test]
fn the_pens_pressure_ends_with_its_stroke() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = middle(&window, "Axial view");
    let touch = egui::Event::Touch {
        device_id: egui::TouchDeviceId(1),
        id: egui::TouchId(1),
        phase: egui::TouchPhase::Start,
        pos: at,
        force: Some(0.25),
    };
    window.harness.event(touch);
    for (pressure, whose) in [(0.25, "the pen's"), (1.0, "the mouse's")] {
        window.harness.drag_at(at);
        window.harness.run_steps(2);
        assert_eq!(begun(&window.sent()), Some(pressure), "{whose}");
        window.harness.drop_at(at);
        window.harness.run_steps(2);
    }
}

#[test]
fn a_note_at_the_pointer_says_what_came_to_nothing_and_fades() {
    let mut window = Window::open(SMALL);
    let text = "Nothing changed: every voxel here lies outside the value range";
    let at = middle(&window, "Axial view");
    hover(&mut window, at);
    window.report(Report::Nothing(text.into()));
    let place = window.harness.get_by_label(text).rect();
    assert!(place.distance_to_pos(at) < 60.0 && !place.contains(at), "{place:?} beside {at:?}");
    window.harness.run_steps(30);
    assert!(window.harness.query_by_label(text).is_none(), "it goes by itself");
    window.click("Move part");
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    window.harness.drop_at(at);
    window.harness.run_steps(1);
    assert_eq!(window.sent(), [], "the crosshair stays");
    assert!(window.harness.query_by_label("Parts are moved in the 3D view").is_some());
}

fn picture(window: &Window, view: ViewName, serial: u64) -> Report {
    let size = [40, 30];
    let pixels = (size[0] * size[1]) as usize;
    let (depth_mm, object) = match view {
        ViewName::ThreeD => (
            vec![window.scene.views.camera.eye.distance(window.scene.views.camera.target) as f32; pixels],
            vec![burin::gpu::ObjectId::new(burin::volume::VolumeId::FIRST, 0, false, 0); pixels],
        ),
        _ => (Vec::new(), Vec::new()),
    };
    let camera = window.scene.views.camera;
    Report::Picture(Box::new(Picture { view, size, rgba: vec![90; pixels * 4], depth_mm, object, camera, serial }))
}

#[test]
fn a_mark_says_that_the_3d_view_is_not_yet_all_there_is() {
    let mut window = Window::open(SMALL);
    let marked = |window: &Window| window.harness.query_by_label("Refining").is_some();
    window.report(Report::Refining(true));
    window.harness.run_steps(6);
    assert!(!marked(&window), "no picture has come: that is said in its place");
    let report = picture(&window, ViewName::ThreeD, 0);
    window.report(report);
    window.harness.run_steps(6);
    assert!(marked(&window));
    let view = window.harness.get_by_label("3D view").rect();
    assert!(view.contains_rect(window.harness.get_by_label("Refining").rect()));
    let at = middle(&window, "3D view");
    window.harness.drag_at(at);
    window.harness.run_steps(3);
    assert!(!marked(&window), "while a hand turns the view it is always coarse");
    window.harness.drop_at(at);
    window.harness.run_steps(6);
    assert!(marked(&window));
    window.report(Report::Refining(false));
    assert!(!marked(&window));
}

#[test]
fn the_explosion_says_what_it_needs() {
    let mut window = Window::open(SMALL);
    let says = |window: &Window| window.harness.query_by_label_contains("Select something first").is_some();
    assert!(!says(&window));
    window.snapshot(|s| s.selected = false);
    assert!(says(&window));
}

#[test]
fn the_slice_slider_is_one_change_of_view() {
    let mut window = Window::open(SMALL);
    let rail = window.harness.get_by_label("Coronal slice").rect();
    window.harness.drag_at(rail.left_center() + vec2(4.0, 0.0));
    window.harness.run_steps(1);
    for share in [0.3, 0.5, 0.8] {
        window.harness.hover_at(rail.left_center() + vec2(rail.width() * share, 0.0));
        window.harness.run_steps(1);
    }
    window.harness.event(egui::Event::PointerButton {
        pos: rail.center(),
        button: PointerButton::Primary,
        pressed: false,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(2);
    let sent = window.sent();
    assert_eq!((sent.first(), sent.last()), (Some(&BEGIN), Some(&END)), "{sent:?}");
    assert!(
        sent.len() > 4
            && sent[1..sent.len() - 1].iter().all(|c| matches!(c, Command::View(ViewCommand::Crosshair { .. })))
    );
}
