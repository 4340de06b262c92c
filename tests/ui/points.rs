//! Points of the transfer function and the paint's colour, by hand in the window: added, taken away, set by numbers.

use super::driver::{SMALL, Window};
use burin::document::{BrushCommand, Command, TransferCommand};
use burin::paint::{BrushChange, Target};
use burin::volume::TransferFunction;
use egui::{Modifiers, PointerButton, Pos2, pos2};
use egui_kittest::kittest::{NodeT, Queryable};

/// The one function that was sent.
fn set(sent: &[Command]) -> &TransferFunction {
    let mut found = sent.iter().filter_map(|c| match c {
        Command::Transfer(TransferCommand::Set { function, .. }) => Some(function),
        _ => None,
    });
    let function = found.next().unwrap_or_else(|| panic!("no function in {sent:?}"));
    assert_eq!(found.next(), None, "once");
    function.check().unwrap();
    function
}

/// Presses a button at a place so many times in a row, as fast as hands are.
fn press(window: &mut Window, at: Pos2, button: PointerButton, times: usize) -> Vec<Command> {
    window.harness.hover_at(at);
    window.harness.run_steps(1);
    window.sent();
    for _ in 0..times {
        for pressed in [true, false] {
            let event = egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE };
            window.harness.input_mut().events.push(event);
        }
    }
    window.harness.run_steps(3);
    window.sent()
}

/// Types a number into a field and takes it by Enter.
fn number(window: &mut Window, name: &str, text: &str) -> Vec<Command> {
    window.harness.get_by_label(name).focus();
    window.harness.run_steps(2);
    window.key(Modifiers::COMMAND, egui::Key::A);
    window.harness.get_by_label(name).type_text(text);
    window.harness.run_steps(1);
    let mut sent = window.sent();
    sent.extend(window.key(Modifiers::NONE, egui::Key::Enter));
    sent
}

fn middle(window: &Window, name: &str) -> Pos2 {
    window.rect(name).center()
}

#[test]
fn a_point_is_added_where_it_is_double_clicked_and_is_then_the_chosen_one() {
    for colour in [false, true] {
        let mut window = Window::open(SMALL);
        let (name, ground) = if colour {
            ("Colour point", "Colours over the values")
        } else {
            ("Opacity point", "Transfer function over the histogram")
        };
        let old = window.scene.transfer.clone();
        let [a, b] = [1, 2].map(|i| middle(&window, &format!("{name} {i}")));
        let ground = window.rect(ground);
        let share = 0.5;
        let x = a.x + (b.x - a.x) * share;
        let at = pos2(x, if colour { ground.top() + 3.0 } else { ground.top() + ground.height() * 0.3 });
        let sent = press(&mut window, at, PointerButton::Primary, 2);
        let new = set(&sent);
        let (was, now): (Vec<f64>, Vec<f64>) = if colour {
            (old.colour.iter().map(|p| p.0).collect(), new.colour.iter().map(|p| p.0).collect())
        } else {
            (old.opacity.iter().map(|p| p.0).collect(), new.opacity.iter().map(|p| p.0).collect())
        };
        let wanted = was[0] + (was[1] - was[0]) * f64::from(share);
        assert_eq!(now.len(), was.len() + 1, "{name}");
        assert!((now[1] - wanted).abs() < 1.0, "{name}: {now:?}, {wanted} wanted");
        assert_eq!([&now[..1], &now[2..]].concat(), was, "{name}: the others stay");
        if colour {
            assert_eq!(new.colour[1].1, old.colour_at(new.colour[1].0), "of the colour that was there");
        }
        // Its numbers are shown at once.
        let field = if colour { "Value of the colour" } else { "Value of the point" };
        let shown: f64 = window.harness.get_by_label(field).value().unwrap().trim().parse().unwrap();
        assert!((shown - wanted).abs() < 1.0, "{field}: {shown}");
    }
}

#[test]
fn a_point_goes_by_the_other_button_and_no_other_one_is_chosen_for_it() {
    for (name, field) in [("Opacity point", "Value of the point"), ("Colour point", "Value of the colour")] {
        let mut window = Window::open(SMALL);
        let old = window.scene.transfer.clone();
        window.click(&format!("{name} 1"));
        assert!(window.harness.query_by_label(field).is_some());
        let at = middle(&window, &format!("{name} 1"));
        let sent = press(&mut window, at, PointerButton::Secondary, 1);
        let new = set(&sent);
        if name.starts_with("Colour") {
            assert_eq!((&new.colour[..], &new.opacity), (&old.colour[1..], &old.opacity));
        } else {
            assert_eq!((&new.opacity[..], &new.colour), (&old.opacity[1..], &old.colour));
        }
        assert!(window.harness.query_by_label(field).is_none(), "{name}");
    }
}

#[test]
fn a_chosen_point_is_set_by_its_numbers() {
    let mut window = Window::open(SMALL);
    let old = window.scene.transfer.clone();
    let value = old.opacity[1].0 + 1.5;
    window.click("Opacity point 2");
    let sent = number(&mut window, "Value of the point", &format!("{value}"));
    assert_eq!(set(&sent).opacity[1], (value, old.opacity[1].1));
    let sent = number(&mut window, "Opacity of the point", "0.25");
    assert_eq!(set(&sent).opacity[1], (value, 0.25), "the value follows at once");
    window.click("Colour point 2");
    let sent = number(&mut window, "Value of the colour", &format!("{value}"));
    assert_eq!(set(&sent).colour[1], (value, old.colour[1].1));
    window.click("Colour of the point");
    let sent = window.click("Pick red");
    let [r, g, b] = set(&sent).colour[1].1;
    assert!(r > 0.7 && g < 0.5 && b < 0.5, "{sent:?}");
}

#[test]
fn paint_is_mixed_of_what_was_picked() {
    let mut window = Window::open(SMALL);
    window.scene.brush.target = Target::Colour([0.1, 0.2, 0.3, 0.8]);
    window.snapshot(|_| {});
    window.click("Paint colour");
    for (name, of) in [("Pick red", 0), ("Pick green", 1), ("Pick blue", 2)] {
        let sent = window.click(name);
        let [Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Colour([r, g, b, a])), .. }))] =
            &sent[..]
        else {
            panic!("{name}: {sent:?}")
        };
        let rgb = [*r, *g, *b];
        assert!((0..3).all(|i| i == of || rgb[i] < rgb[of]), "{name}: {rgb:?}");
        assert_eq!(*a, 0.8, "its opacity stays");
        let swatch = window.harness.get_by_label("Paint colour").accesskit_node().value().unwrap();
        let shown = rgb.map(|c| (c * 255.0).round() as u8);
        assert_eq!(swatch, format!("#{:02x}{:02x}{:02x}", shown[0], shown[1], shown[2]), "{name}");
    }
}
