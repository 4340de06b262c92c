//! What is lit, held and shown: controls show what is, at once, and a hand that leaves leaves nothing half done.

use super::driver::{SMALL, Window};
use burin::document::{BrushCommand, Command, PartCommand, StrokeCommand};
use burin::explode::PartId;
use burin::paint::{Target, Tip};
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
        let sent = window.click("Pin Right half");
        let set = matches!(&sent[..], [Command::Part(PartCommand::Set { id: PartId(2), pinned: Some(p), .. })] if *p == pinned);
        assert!(set, "{sent:?}");
        assert_eq!((lit(&window, "Pin Right half"), lit(&window, "Pin Left half")), (pinned, false));
    }
}

#[test]
fn a_part_has_its_own_colours_again_before_the_document_answers() {
    let mut window = Window::open(SMALL);
    let own = value(&window, "Colour of Right half");
    window.click("Colour of Right half");
    window.click("Pick red");
    assert_ne!(value(&window, "Colour of Right half"), own);
    window.click("The volume's own colours");
    assert_eq!(value(&window, "Colour of Right half"), own);
}

#[test]
fn how_dabs_overlap_is_what_was_clicked() {
    let mut window = Window::open(SMALL);
    let names = [("Overlap: Builds up", Tip::BuildUp), ("Overlap: Even", Tip::Wash)];
    assert!(lit(&window, "Overlap: Even"));
    for (name, wanted) in names {
        let sent = window.click(name);
        let set = matches!(&sent[..], [Command::Brush(BrushCommand::Set { tip: Some(tip), .. })] if *tip == wanted);
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
        Command::Brush(BrushCommand::Set { erase: Some(erase), .. }) => Some(*erase),
        _ => None,
    };
    let sent = window.sent();
    assert_eq!(sent.first().and_then(erases), Some(true), "{sent:?}");
    assert!(matches!(sent[1], Command::Stroke(StrokeCommand::Begin { .. })), "{sent:?}");
    assert_eq!(sent.last().and_then(erases), Some(false), "{sent:?}");
    let ends = sent.iter().position(|c| *c == Command::Stroke(StrokeCommand::End {}));
    assert_eq!(ends, Some(sent.len() - 2), "{sent:?}");
}
