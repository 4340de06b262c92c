//! What controls, keys and the pointer ask for.

use super::driver::{LARGE, SMALL, Window};
use burin::document::{
    BrushCommand, Command, ExplosionCommand, HistoryCommand, Layer, PartCommand, ProjectCommand, SegmentCommand,
    StrokeCommand, TransferCommand, ViewCommand,
};
use burin::explode::PartId;
use burin::paint::{BrushChange, Target};
use burin::ui::{Report, Severity};
use burin::volume::FieldKind;
use egui::accesskit::Toggled;
use egui::{Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

#[test]
fn tools_are_chosen_by_button_and_by_key() {
    let mut window = Window::open(SMALL);
    for tool in burin::interact::Tool::ALL {
        let at = |window: &Window| window.harness.get_by_label(tool.name()).accesskit_node().toggled();
        let named = window.harness.get_all_by_label(tool.name()).count();
        assert_eq!(named, 1);
        window.click(tool.name());
        assert_eq!(at(&window), Some(Toggled::True), "{tool:?} by its button");
    }
    for (key, tool) in [(egui::Key::B, "Brush"), (egui::Key::N, "Navigate"), (egui::Key::L, "Line split")] {
        window.key(Modifiers::NONE, key);
        assert_eq!(
            window.harness.get_by_label(tool).accesskit_node().toggled(),
            Some(Toggled::True),
            "{tool} by its key"
        );
    }
}

#[test]
fn keys_become_commands() {
    let mut window = Window::open(SMALL);
    let undo = Command::History(HistoryCommand::Undo { steps: 1 });
    let redo = Command::History(HistoryCommand::Redo { steps: 1 });
    assert_eq!(window.key(Modifiers::COMMAND, egui::Key::Z), [undo]);
    assert_eq!(window.key(Modifiers::COMMAND, egui::Key::Y), std::slice::from_ref(&redo));
    assert_eq!(window.key(Modifiers::COMMAND | Modifiers::SHIFT, egui::Key::Z), [redo]);
    assert!(matches!(window.key(Modifiers::NONE, egui::Key::CloseBracket)[..],
        [Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(r), .. }))] if r > 5.0));
    assert!(matches!(
        window.key(Modifiers::NONE, egui::Key::Num2)[..],
        [Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Label(2)), .. }))]
    ));
    window.snapshot(|s| s.project = Some("/data/head.burin".into()));
    assert!(matches!(
        window.key(Modifiers::COMMAND, egui::Key::S)[..],
        [Command::Project(ProjectCommand::Save { path: None, density: None })]
    ));
}

#[test]
fn a_name_is_chosen_by_a_click_and_edited_by_two() {
    let mut window = Window::open(SMALL);
    let chosen = window.click("Name of segment 2");
    assert!(
        matches!(chosen[..], [Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Label(2)), .. }))]),
        "{chosen:?}"
    );
    // Keys stay the tools' until the name is edited.
    assert!(matches!(
        window.key(Modifiers::NONE, egui::Key::Num1)[..],
        [Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Label(1)), .. }))]
    ));
    assert_eq!(window.click("Name of part 1"), [], "parts have nothing to choose");
    for (name, entered) in [("Name of segment 2", "liver"), ("Name of part 1", "lid")] {
        let pos = window.rect(name).left_center() + egui::vec2(10.0, 0.0);
        let click = |pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        window.harness.hover_at(pos);
        window.harness.run_steps(1);
        window.harness.input_mut().events.extend([true, false, true, false].map(click));
        window.harness.run_steps(4);
        window.sent();
        // All of it is marked: what is typed takes its place.
        window.harness.event(egui::Event::Text(entered.into()));
        window.harness.run_steps(2);
        let sent = serde_json::to_value(window.key(Modifiers::NONE, egui::Key::Enter)).unwrap();
        let set = if name.contains("part") { &sent[0]["part"]["set"] } else { &sent[0]["segment"]["set"] };
        assert_eq!(set["name"], entered, "{sent}");
    }
}

#[test]
fn a_key_typed_into_a_name_is_no_shortcut() {
    let mut window = Window::open(SMALL);
    window.harness.get_by_label("Name of part 1").focus();
    window.harness.run_steps(2);
    assert_eq!(window.key(Modifiers::NONE, egui::Key::Num3), []);
    window.harness.get_by_label("Name of part 1").type_text(" lobe");
    window.harness.run_steps(2);
    let renamed = window.key(Modifiers::NONE, egui::Key::Enter);
    assert!(
        matches!(&renamed[..], [Command::Part(PartCommand::Set { id: PartId(1), name: Some(name), colour: None, .. })]
        if name.contains("lobe")),
        "{renamed:?}"
    );
}

#[test]
fn a_control_reached_by_tab_takes_its_own_keys_and_no_others() {
    let mut window = Window::open(SMALL);
    window.harness.get_by_label("Brush strength").focus();
    window.harness.run_steps(2);
    let grown = window.key(Modifiers::NONE, egui::Key::CloseBracket);
    assert!(
        matches!(grown[..], [Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(_), .. }))]),
        "{grown:?}"
    );
    // Over a slice an arrow moves that; under the keyboard's control it is the slider's.
    let slice = window.harness.get_by_label("Axial view").rect().center();
    window.harness.hover_at(slice);
    window.harness.run_steps(2);
    window.harness.get_by_label("Brush strength").focus();
    window.harness.run_steps(2);
    assert_eq!(window.key(Modifiers::NONE, egui::Key::ArrowDown), [], "nor is it another control's");
    window.harness.get_by_label("Axial slice").focus();
    window.harness.run_steps(2);
    let moved = window.key(Modifiers::NONE, egui::Key::ArrowDown);
    assert!(moved.iter().all(|c| !matches!(c, Command::View(ViewCommand::Scroll { .. }))), "{moved:?}");
}

#[test]
fn a_key_hit_in_mid_stroke_does_not_take_the_stroke_back() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = window.harness.get_by_label("Axial view").rect().center();
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    for key in [egui::Key::Num3, egui::Key::X, egui::Key::CloseBracket] {
        window.key(Modifiers::NONE, key);
    }
    window.harness.drop_at(at + vec2(9.0, 0.0));
    window.harness.run_steps(2);
    assert_eq!(window.sent().last(), Some(&Command::Stroke(StrokeCommand::End {})));
}

#[test]
fn the_degree_slider_is_one_step_of_history() {
    let mut window = Window::open(SMALL);
    let rail = window.harness.get_by_label("Degree of explosion").rect();
    let at = |share: f32| egui::pos2(rail.left() + rail.width() * share, rail.center().y);
    window.harness.drag_at(at(0.05));
    window.harness.run_steps(2);
    for share in [0.2, 0.4, 0.5] {
        window.harness.hover_at(at(share));
        window.harness.run_steps(1);
    }
    window.harness.drop_at(at(0.5));
    window.harness.run_steps(2);
    let sent = window.sent();
    let degrees: Vec<f64> = sent
        .iter()
        .filter_map(|c| match c {
            Command::Explosion(ExplosionCommand::Degree { value }) => Some(*value),
            _ => None,
        })
        .collect();
    assert_eq!(sent.first(), Some(&Command::History(HistoryCommand::Begin {})), "{sent:?}");
    assert_eq!(sent.last(), Some(&Command::History(HistoryCommand::End {})), "{sent:?}");
    assert_eq!(sent.len(), degrees.len() + 2, "one group about the whole drag: {sent:?}");
    assert!(degrees.is_sorted() && (degrees[degrees.len() - 1] - 0.5).abs() < 0.05, "{degrees:?}");
}

#[test]
fn a_dragged_point_of_the_transfer_function_is_one_step_and_stays_a_function() {
    let mut window = Window::open(SMALL);
    let from = window.harness.get_by_label("Opacity point 2").rect().center();
    window.harness.drag_at(from);
    window.harness.run_steps(2);
    for step in 1..=4 {
        window.harness.hover_at(from - vec2(10.0, 12.0) * step as f32);
        window.harness.run_steps(1);
    }
    window.harness.drop_at(from - vec2(40.0, 48.0));
    window.harness.run_steps(2);
    let sent = window.sent();
    let set: Vec<_> = sent
        .iter()
        .filter_map(|c| match c {
            Command::Transfer(TransferCommand::Set { function, .. }) => Some(function),
            _ => None,
        })
        .collect();
    assert_eq!(sent.len(), set.len() + 2, "{sent:?}");
    let (old, new) = (&window.scene.transfer, set.last().unwrap());
    new.check().unwrap();
    assert_eq!(new.opacity.len(), old.opacity.len());
    assert!(new.opacity[1].0 < old.opacity[1].0 && new.opacity[1].1 > old.opacity[1].1);
    assert_eq!((new.opacity[0], new.opacity[2]), (old.opacity[0], old.opacity[2]));
    assert_eq!(new.colour, old.colour);
}

#[test]
fn a_step_of_history_is_reached_by_a_click() {
    let mut window = Window::open(SMALL);
    assert_eq!(window.click("Step 1: Stroke"), [Command::History(HistoryCommand::Undo { steps: 2 })]);
    assert_eq!(window.click("Step 4: Degree of explosion"), [Command::History(HistoryCommand::Redo { steps: 1 })]);
    assert_eq!(window.click("Step 3: Rename part"), [], "that is where one is");
}

#[test]
fn the_name_of_a_step_ends_where_the_list_does() {
    let mut window = Window::open(SMALL);
    let long = "Remove volume of a follow-up whose name nobody reads to its end";
    window.snapshot(|s| s.undo.push(long.into()));
    window.harness.run_steps(3);
    let row = window.rect(&format!("Step 4: {long}"));
    let texts: Vec<_> = window
        .harness
        .output()
        .shapes
        .iter()
        .filter_map(|s| match &s.shape {
            egui::Shape::Text(text) if text.galley.text() == long => Some(text.pos.x + text.galley.size().x),
            _ => None,
        })
        .collect();
    assert!(!texts.is_empty() && texts.iter().all(|right| *right <= row.right()), "{texts:?} in {row:?}");
}

#[test]
fn parts_and_segments_are_hidden_pinned_and_locked_by_name() {
    let mut window = Window::open(SMALL);
    assert!(matches!(
        window.click("Show Lower half")[..],
        [Command::Part(PartCommand::Set { id: PartId(1), visible: Some(false), pinned: None, .. })]
    ));
    assert!(matches!(
        window.click("Pin Upper half")[..],
        [Command::Part(PartCommand::Set { id: PartId(2), visible: None, pinned: Some(true), .. })]
    ));
    assert!(matches!(
        window.click("Lock Segment 2")[..],
        [Command::Segment(SegmentCommand::Set { id: 2, locked: Some(true), visible: None, .. })]
    ));
    let label = window.click("Paint segment Segment 1");
    assert!(
        matches!(label[..], [Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Label(1)), .. }))]),
        "{label:?}"
    );
}

#[test]
fn the_window_follows_before_the_document_answers() {
    let mut window = Window::open(SMALL);
    assert_eq!(window.key(Modifiers::NONE, egui::Key::CloseBracket).len(), 1);
    let second = window.key(Modifiers::NONE, egui::Key::CloseBracket);
    assert!(
        matches!(second[..], [Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(r), .. }))] if r > 5.0 * 1.15 * 1.1),
        "the second press grows what the first one made: {second:?}"
    );
}

#[test]
fn errors_stay_until_they_are_dismissed() {
    let mut window = Window::open(SMALL);
    let text = "/data/x.nii: dim[1]: -3 found, 1 to 32767 expected";
    window.report(Report::Message(Severity::Error, text.into()));
    window.harness.run_steps(50);
    assert!(window.harness.query_by_label(text).is_some());
    window.click("Dismiss message 1");
    assert!(window.harness.query_by_label(text).is_none());
}

#[test]
fn a_stroke_on_a_slice_sends_every_sample() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = window.harness.get_by_label("Axial view").rect().center();
    window.harness.drag_at(at);
    // Several samples in one frame: none may be lost.
    for i in 1..=5 {
        window.harness.event(egui::Event::PointerMoved(at + vec2(i as f32 * 6.0, 0.0)));
    }
    window.harness.run_steps(2);
    window.harness.drop_at(at + vec2(30.0, 0.0));
    window.harness.run_steps(2);
    let sent = window.sent();
    assert!(matches!(sent[0], Command::Stroke(StrokeCommand::Begin { .. })), "{sent:?}");
    let extends = sent.iter().filter(|c| matches!(c, Command::Stroke(StrokeCommand::Extend { .. }))).count();
    assert_eq!(extends, 5, "{sent:?}");
    assert_eq!(sent.last(), Some(&Command::Stroke(StrokeCommand::End {})));
}

#[test]
fn e_between_two_samples_of_a_frame_divides_the_stroke_there() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = window.harness.get_by_label("Axial view").rect().center();
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    window.sent();
    let key = |pressed| egui::Event::Key {
        key: egui::Key::E,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    // Pressed and let go within one frame.
    for (i, event) in [(1, None), (2, Some(key(true))), (3, None), (4, Some(key(false)))] {
        let moved = egui::Event::PointerMoved(at + vec2(i as f32 * 10.0, 0.0));
        window.harness.input_mut().events.extend(event.into_iter().chain([moved]));
    }
    window.harness.run_steps(2);
    let names: Vec<&str> = window
        .sent()
        .iter()
        .map(|c| match c {
            Command::Stroke(StrokeCommand::Begin { .. }) => "begin",
            Command::Stroke(StrokeCommand::Extend { .. }) => "extend",
            Command::Stroke(StrokeCommand::End {}) => "end",
            Command::Brush(BrushCommand::Set(BrushChange { erase: Some(true), .. })) => "erase",
            Command::Brush(BrushCommand::Set(BrushChange { erase: Some(false), .. })) => "paint",
            other => panic!("{other:?}"),
        })
        .collect();
    let divided = ["extend", "end", "erase", "begin", "extend", "extend", "end", "paint", "begin", "extend"];
    assert_eq!(names, divided);
}

#[test]
fn escape_takes_a_stroke_back() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = window.harness.get_by_label("Coronal view").rect().center();
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    let sent = window.key(Modifiers::NONE, egui::Key::Escape);
    assert_eq!(sent.last(), Some(&Command::Stroke(StrokeCommand::Cancel {})), "{sent:?}");
}

#[test]
fn a_window_that_lost_the_focus_in_mid_drag_takes_the_next_press() {
    let mut window = Window::open(SMALL);
    window.click("Brush");
    let at = window.harness.get_by_label("Coronal view").rect().center();
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    window.harness.event(egui::Event::WindowFocused(false));
    window.harness.run_steps(2);
    assert_eq!(window.sent().last(), Some(&Command::Stroke(StrokeCommand::Cancel {})), "nobody hears the button go up");
    window.harness.event(egui::Event::WindowFocused(true));
    window.harness.drag_at(at);
    window.harness.run_steps(2);
    assert!(matches!(window.sent()[..], [Command::Stroke(StrokeCommand::Begin { .. })]));
    window.harness.drop_at(at);
    window.harness.run_steps(2);
    assert_eq!(window.sent().last(), Some(&Command::Stroke(StrokeCommand::End {})));
}

#[test]
fn one_view_fills_the_place_of_four_and_goes_back() {
    let mut window = Window::open(SMALL);
    let before = window.harness.get_by_label("Sagittal view").rect();
    window.click("Only the Sagittal view");
    let alone = window.harness.get_by_label("Sagittal view").rect();
    assert!(alone.width() > before.width() * 1.9 && window.harness.query_by_label("Axial view").is_none());
    window.click("All four views");
    assert_eq!(window.harness.get_by_label("Sagittal view").rect(), before);
}

#[test]
fn what_is_needed_is_in_sight_at_both_sizes() {
    for size in [SMALL, LARGE] {
        let window = Window::open(size);
        let whole = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(size[0], size[1]));
        for name in [
            "Open",
            "Save",
            "Undo",
            "Brush",
            "Move part",
            "Brush radius",
            "Show Segment 1",
            "Opacity of layer Selection",
            "Show layer Density",
            "Window width",
            "Opacity point 1",
            "Mode: Volume",
            "Degree of explosion",
            "Pin Lower half",
            "Step 1: Stroke",
            "3D view",
            "Axial slice",
        ] {
            let rect = window.harness.get_by_label(name).rect();
            assert!(whole.contains_rect(rect), "{name} at {rect:?} in {size:?}");
        }
    }
}

#[test]
fn the_last_steps_are_in_sight_however_long_the_list_of_parts_is() {
    let mut window = Window::open(SMALL);
    let parts = window.scene.explosion.parts.clone();
    window.scene.explosion.parts.extend((3..20).map(|id| {
        let name = format!("Piece {id}");
        burin::explode::Part { id: PartId(id), name, ..parts[0].clone() }
    }));
    window.snapshot(|s| s.undo = (0..30).map(|i| format!("Step of {i}")).collect());
    window.harness.run_steps(3);
    let rect = window.harness.get_by_label("Step 30: Step of 29").rect();
    let views = window.harness.get_by_label("Sagittal view").rect();
    assert!(rect.bottom() <= views.bottom() && rect.top() > views.top(), "{rect:?} beside {views:?}");
}

#[test]
fn the_list_of_parts_takes_what_height_there_is() {
    for (size, messages, least) in [(SMALL, 0, 7), (SMALL, 2, 4), (LARGE, 0, 16)] {
        let mut window = Window::open(size);
        let part = window.scene.explosion.parts[0].clone();
        window.scene.explosion.parts = (1..=36)
            .map(|id| burin::explode::Part { id: PartId(id), name: format!("Piece {id}"), ..part.clone() })
            .collect();
        window.snapshot(|_| {});
        for i in 0..messages {
            window.report(Report::Message(Severity::Error, format!("message {i}")));
        }
        window.harness.run_steps(3);
        let steps = window.harness.get_by_label("Section History").rect();
        let whole = |id: &u32| {
            let name = format!("Pin Piece {id}");
            let row = window.harness.query_by_label(&name);
            row.is_some_and(|row| row.rect().bottom() <= steps.top())
        };
        let seen = (1..=36).filter(whole).count();
        assert!(seen >= least, "{seen} parts in sight in {size:?} with {messages} messages");
    }
}

#[test]
fn density_is_hidden_by_its_layer() {
    let mut window = Window::open(SMALL);
    let hide = Layer { visible: false, ..Layer::new(FieldKind::Density) };
    assert_eq!(window.click("Show layer Density"), [Command::View(ViewCommand::Layer(hide.into()))]);
    let show = Layer { visible: true, ..hide };
    assert_eq!(
        window.click("Show layer Density"),
        [Command::View(ViewCommand::Layer(show.into()))],
        "the row follows at once"
    );
}

#[test]
fn the_page_of_keys_opens_by_f1_and_closes_by_escape() {
    let mut window = Window::open(SMALL);
    window.key(Modifiers::NONE, egui::Key::F1);
    let whole = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(SMALL[0], SMALL[1]));
    for line in burin::interact::SHORTCUTS {
        let mut rects: Vec<_> = window.harness.query_all_by_label(line.what).map(|node| node.rect()).collect();
        rects.extend(window.harness.query_all_by_label(line.keys).map(|node| node.rect()));
        assert!(rects.len() > 1, "{} is missing", line.what);
        assert!(rects.iter().all(|rect| whole.contains_rect(*rect)), "{} is cut off: {rects:?}", line.what);
    }
    window.key(Modifiers::NONE, egui::Key::Escape);
    assert!(window.harness.query_by_label("Zoom").is_none());
}

#[test]
fn nothing_open_says_what_to_do() {
    let mut window = Window::empty(SMALL);
    window.harness.run_steps(3);
    assert!(window.harness.query_by_label("Open a volume to begin").is_some());
    assert!(window.harness.get_by_label("Save").accesskit_node().is_disabled());
}

#[test]
fn a_part_is_coloured_by_hand_and_given_its_own_colours_back() {
    let mut window = Window::open(SMALL);
    assert_eq!(window.click("Colour of Upper half"), []);
    let picked = window.click("Pick red");
    let Some(Command::Part(PartCommand::Set { id: PartId(2), colour: Some([r, g, b]), own_colour: false, .. })) =
        picked.first()
    else {
        panic!("{picked:?}")
    };
    assert!(*r > 0.7 && *g < 0.5 && *b < 0.5, "{picked:?}");
    let rail = window.harness.get_all_by_label("Brightness").next().unwrap().rect();
    window.harness.drag_at(rail.center());
    window.harness.run_steps(2);
    window.harness.hover_at(rail.left_center() + vec2(3.0, 0.0));
    window.harness.run_steps(2);
    window.harness.drop_at(rail.left_center() + vec2(3.0, 0.0));
    window.harness.run_steps(2);
    let sent = window.sent();
    assert_eq!(sent.first(), Some(&Command::History(HistoryCommand::Begin {})), "{sent:?}");
    assert_eq!(sent.last(), Some(&Command::History(HistoryCommand::End {})), "one step: {sent:?}");
    let own = window.click("The volume's own colours");
    assert!(matches!(own[..], [Command::Part(PartCommand::Set { id: PartId(2), own_colour: true, .. })]), "{own:?}");
    assert!(window.harness.query_by_label("Pick red").is_none(), "the picker is closed");
}

#[test]
fn a_click_within_one_slow_frame_moves_a_slider() {
    let mut window = Window::open(SMALL);
    let rail = window.harness.get_by_label("Degree of explosion").rect();
    let pos = egui::pos2(rail.left() + rail.width() * 0.75, rail.center().y);
    window.harness.hover_at(pos);
    window.harness.run_steps(2);
    window.sent();
    let button = |pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let mut raw = egui::RawInput { events: vec![button(true), button(false)], ..Default::default() };
    let ctx = window.harness.ctx.clone();
    let mut frames = Vec::new();
    for _ in 0..3 {
        eframe::App::raw_input_hook(window.harness.state_mut(), &ctx, &mut raw);
        frames.push(raw.events.len());
        window.harness.input_mut().events.append(&mut raw.events);
        window.harness.run_steps(1);
    }
    assert_eq!(frames, [1, 1, 0], "press and release come in two frames, and come once");
    let mut degrees = window.sent().into_iter().filter_map(|c| match c {
        Command::Explosion(ExplosionCommand::Degree { value }) => Some(value),
        _ => None,
    });
    let last = degrees.next_back().expect("the slider moved");
    assert!((last - 0.75).abs() < 0.06, "{last}");
}
