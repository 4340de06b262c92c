//! Numbers that are typed: what counts is the number that was entered, not what stood there on the way to it.

use super::driver::{SMALL, Window};
use burin::document::{BrushCommand, Command, ExplosionCommand, TransferCommand};
use burin::paint::BrushChange;
use burin::volume::Number;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

/// Clicks a number, types another letter by letter as a hand does, and ends with a key; what was sent on the way.
fn enter(window: &mut Window, name: &str, letters: &str, key: Key) -> Vec<Command> {
    window.harness.get_by_label(name).click();
    window.harness.run_steps(3);
    let mut sent = window.sent();
    for letter in letters.chars() {
        window.harness.event(egui::Event::Text(letter.to_string()));
        window.harness.run_steps(2);
        sent.extend(window.sent());
    }
    sent.extend(window.key(Modifiers::NONE, key));
    sent
}

#[test]
fn a_number_is_taken_once_when_it_is_entered() {
    let mut window = Window::open(SMALL);
    let sent = enter(&mut window, "Degree of explosion, value", "75", Key::Enter);
    assert_eq!(sent, [Command::Explosion(ExplosionCommand::Degree { value: 0.75 })], "one step to take back");
    let sent = enter(&mut window, "Degree of explosion, value", "3", Key::Escape);
    assert_eq!(sent, [], "Escape leaves the old one");
    // A click elsewhere enters it.
    window.harness.get_by_label("Brush radius, value").click();
    window.harness.run_steps(2);
    for letter in ["1", "2"] {
        window.harness.event(egui::Event::Text(letter.into()));
        window.harness.run_steps(2);
    }
    assert_eq!(window.sent(), []);
    let at = window.rect("Section Layers").center();
    window.harness.drag_at(at);
    window.harness.run_steps(1);
    window.harness.drop_at(at);
    window.harness.run_steps(3);
    let sent = window.sent();
    assert!(
        matches!(sent[..], [Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(12.0), .. }))]),
        "{sent:?}"
    );
}

#[test]
fn a_number_whose_first_digits_are_out_of_order_can_be_typed() {
    let mut window = Window::open(SMALL);
    window.scene.brush.range = Some([40.0, 90.0].map(Number::from));
    window.snapshot(|_| {});
    let sent = enter(&mut window, "Highest value to paint", "77", Key::Enter);
    let range = sent.iter().find_map(|c| match c {
        Command::Brush(BrushCommand::Set(BrushChange { range, .. })) => *range,
        _ => None,
    });
    assert_eq!(range, Some([40.0, 77.0].map(Number::from)), "{sent:?}");
    // A point of the curve between two others.
    window.scene.transfer.opacity = vec![(10.0, 0.0), (50.0, 0.5), (90.0, 1.0)];
    window.snapshot(|_| {});
    window.click("Opacity point 2");
    let sent = enter(&mut window, "Value of the point", "64", Key::Enter);
    let [Command::Transfer(TransferCommand::Set { function, .. })] = &sent[..] else { panic!("{sent:?}") };
    assert_eq!(function.opacity[1], (64.0, 0.5));
}
