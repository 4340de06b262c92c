//! The swatch beside the label to paint has the colour that is painted; colours are typed as hex.

use super::driver::{SMALL, Window};
use crate::common::one::segments;
use burin::document::{Command, PartCommand};
use burin::explode::PartId;
use burin::paint::Target;
use egui_kittest::kittest::{NodeT, Queryable};

fn hex(colour: [f32; 3]) -> String {
    let [r, g, b] = colour.map(|x| (x * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn swatch(window: &Window) -> String {
    let node = window.harness.get_by_label("Colour of the label to paint");
    node.accesskit_node().value().unwrap_or_default()
}

#[test]
fn the_swatch_of_a_label_is_the_colour_that_its_segment_gets() {
    let mut window = Window::open(SMALL);
    for id in [1_u16, 2, 3, 9, 40, 255, 256, 1000, 65_535] {
        window.scene.brush.target = Target::Label(id);
        window.snapshot(|_| {});
        let before = swatch(&window);
        // The first stroke puts the segment into the table.
        segments(&mut window.scene).ensure(id);
        let given = hex(window.scene.segments().get(id).unwrap().colour);
        assert_eq!(before, given, "label {id} before its first stroke");
        window.snapshot(|_| {});
        assert_eq!(swatch(&window), given, "and after it");
        segments(&mut window.scene).get_mut(id).unwrap().colour = [0.2, 0.4, 0.6];
        window.snapshot(|_| {});
        assert_eq!(swatch(&window), "#336699", "and in the colour that it was given by hand");
    }
}

#[test]
fn the_swatch_follows_a_key_before_the_document_answers() {
    let mut window = Window::open(SMALL);
    window.key(egui::Modifiers::NONE, egui::Key::Num7);
    let mut table = window.scene.segments().clone();
    table.ensure(7);
    assert_eq!(swatch(&window), hex(table.get(7).unwrap().colour));
}

#[test]
fn a_colour_is_typed_as_hex() {
    let mut window = Window::open(SMALL);
    for (typed, wanted) in
        [("#336699", [0.2, 0.4, 0.6]), ("f00", [1.0, 0.0, 0.0]), (" 00ff7F ", [0.0, 1.0, 127.0 / 255.0])]
    {
        window.click("Colour of Upper half");
        let field = window.harness.get_by_label("Colour in hex");
        field.focus();
        window.harness.run_steps(2);
        window.key(egui::Modifiers::COMMAND, egui::Key::A);
        window.harness.get_by_label("Colour in hex").type_text(typed);
        window.harness.run_steps(3);
        let sent = window.sent();
        let last = sent.iter().rev().find_map(|c| match c {
            Command::Part(PartCommand::Set { id: PartId(2), colour: Some(colour), .. }) => Some(*colour),
            _ => None,
        });
        let colour = last.unwrap_or_else(|| panic!("{typed}: {sent:?}"));
        assert!(colour.iter().zip(wanted).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-3), "{typed}: {colour:?}");
        window.key(egui::Modifiers::NONE, egui::Key::Escape);
        window.snapshot(|_| {});
    }
    window.click("Colour of Upper half");
    window.harness.get_by_label("Colour in hex").focus();
    window.harness.run_steps(2);
    window.key(egui::Modifiers::COMMAND, egui::Key::A);
    window.harness.get_by_label("Colour in hex").type_text("#12345");
    window.harness.run_steps(3);
    assert_eq!(window.sent(), [], "five digits are no colour");
}
