//! The panel of the brush: all of it is in sight, what means nothing cannot be chosen, erasing says what it leaves.

use super::driver::{SMALL, Window};
use burin::document::{BrushCommand, Command, ComponentCommand, Isolation, PieceSize};
use burin::paint::{BrushChange, EraseDensity, Falloff, Target};
use burin::volume::Number;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};

const TARGETS: [Target; 4] =
    [Target::Selection(1.0), Target::Label(1), Target::Colour([1.0, 0.0, 0.0, 1.0]), Target::Density(3.0)];

/// What the tests' window loses to its frame.
const FRAME: f32 = 16.0;

fn painting(target: Target) -> Window {
    let mut window = Window::open(SMALL.map(|side| side + FRAME));
    window.scene.brush.target = target;
    window.snapshot(|_| {});
    window.harness.run_steps(4);
    window
}

#[test]
fn the_whole_left_column_is_in_sight_in_a_small_window() {
    for target in TARGETS {
        let window = painting(target);
        let border = window.rect("Border over the segments");
        for name in [
            "Paint: Density",
            "Brush radius",
            "Brush strength",
            "Shape: Ball",
            "Edge: Hard",
            "Overlap: Even",
            "Erase",
            "Visible only",
            "Paint only where the value is",
            "Highest value to paint",
            "Opacity of layer Segments",
            "Opacity of layer Segments in 3D",
            "Detail of the 3D view",
        ] {
            let rect = window.rect(name);
            assert!(rect.bottom() + 2.0 <= border.top(), "{name} {rect:?} over {border:?} with {target:?}");
        }
    }
}

#[test]
fn labels_have_no_edge_to_choose_and_say_why() {
    for target in TARGETS {
        let mut window = painting(target);
        let label = matches!(target, Target::Label(_));
        for (falloff, name) in
            [(Falloff::Hard, "Edge: Hard"), (Falloff::Linear, "Edge: Linear"), (Falloff::Smooth, "Edge: Smooth")]
        {
            window.scene.brush.falloff = falloff;
            window.snapshot(|_| {});
            for other in ["Edge: Hard", "Edge: Linear", "Edge: Smooth"] {
                let node = window.harness.get_by_label(other);
                let about = node.accesskit_node();
                assert_eq!(about.is_disabled(), label, "{other} with {target:?}");
                // What is shown is what is painted.
                let lit = about.toggled() == Some(egui::accesskit::Toggled::True);
                assert_eq!(lit, if label { other == "Edge: Hard" } else { other == name }, "{other}, {falloff:?}");
                let why = about.data().description().unwrap_or_default().contains("hard rim");
                assert_eq!(why, label, "{other} with {target:?}");
            }
        }
        window.scene.brush.falloff = Falloff::Smooth;
        window.snapshot(|_| {});
        assert_eq!(window.click("Edge: Linear").is_empty(), label);
    }
}

#[test]
fn erasing_density_says_what_it_leaves() {
    for target in TARGETS {
        let mut window = painting(target);
        let name = "What erasing density leaves";
        if !matches!(target, Target::Density(_)) {
            assert!(window.harness.query_by_label(name).is_none(), "{target:?}");
            assert!(window.harness.query_by_label("leaves nothing").is_some(), "{target:?}");
            continue;
        }
        assert!(window.harness.query_by_label("Value after erasing").is_none());
        window.click(name);
        let sent = window.click("sets to a value");
        let [Command::Brush(BrushCommand::Set(BrushChange { erase_density: Some(EraseDensity::To(value)), .. }))] =
            sent[..]
        else {
            panic!("{sent:?}")
        };
        assert_eq!(value, 0.0, "the least value that there is");
        window.scene.brush.erase_density = EraseDensity::To(12.5);
        window.snapshot(|_| {});
        let (field, choice) = (window.rect("Value after erasing"), window.rect(name));
        assert!(field.left() >= choice.right() && field.right() <= window.rect("Border of the left panel").left());
        assert!((field.center().y - choice.center().y).abs() < 1.0 && choice.width() > 60.0, "{field:?} {choice:?}");
        // Opened again, the value that is there stays.
        window.click(name);
        assert_eq!(window.click("sets to a value"), []);
    }
}

#[test]
fn the_end_of_a_range_that_is_typed_is_the_one_that_is_meant() {
    for (name, typed, wanted) in [
        ("Highest value to paint", "10", [10.0, 10.0]),
        ("Highest value to paint", "70", [40.0, 70.0]),
        ("Lowest value to paint", "80", [80.0, 80.0]),
        ("Lowest value to paint", "5", [5.0, 60.0]),
    ] {
        let mut window = painting(Target::Selection(1.0));
        window.scene.brush.range = Some([40.0, 60.0].map(Number::Real));
        window.snapshot(|_| {});
        window.harness.get_by_label(name).focus();
        window.harness.run_steps(2);
        window.key(Modifiers::COMMAND, Key::A);
        window.harness.get_by_label(name).type_text(typed);
        window.harness.run_steps(1);
        let mut sent = window.sent();
        sent.extend(window.key(Modifiers::NONE, Key::Enter));
        let set = sent.iter().rev().find_map(|c| match c {
            Command::Brush(BrushCommand::Set(BrushChange { range: Some(range), .. })) => {
                Some(range.map(Number::to_f64))
            }
            _ => None,
        });
        assert_eq!(set, Some(wanted), "{name} {typed}: {sent:?}");
    }
}

#[test]
fn with_the_tool_that_isolates_small_pieces_go_by_a_button_and_nothing_moves() {
    let mut window = painting(Target::Selection(1.0));
    let (radius, strength) = (window.rect("Brush radius"), window.rect("Brush strength"));
    window.key(Modifiers::NONE, Key::I);
    window.harness.run_steps(4);
    assert!(window.harness.query_by_label("Brush radius").is_none());
    assert_eq!(window.rect("Brush strength"), strength);
    assert_eq!(window.rect("Remove").center().y, radius.center().y);
    let small =
        |voxels| Command::Component(ComponentCommand::Remove(Isolation::smaller_than(PieceSize::Voxels(voxels))));
    assert_eq!(window.click("Remove"), [small(20)]);
    let name = "Size of small pieces";
    window.harness.get_by_label(name).focus();
    window.harness.run_steps(2);
    window.key(Modifiers::COMMAND, Key::A);
    window.harness.get_by_label(name).type_text("300");
    window.harness.run_steps(1);
    window.key(Modifiers::NONE, Key::Enter);
    assert_eq!(window.click("Remove"), [small(300)]);
    window.key(Modifiers::NONE, Key::B);
    window.harness.run_steps(4);
    assert_eq!((window.rect("Brush radius"), window.rect("Brush strength")), (radius, strength));
}
