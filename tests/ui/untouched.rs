//! What nobody touches stays as it is: a window that shows a document changes nothing of it.

use super::driver::{SMALL, Window};
use crate::common::one::segments;
use burin::document::{BrushCommand, Command, Scene, SegmentCommand, ViewCommand};
use burin::explode::Forces;
use burin::paint::{BrushChange, EraseDensity, Target};
use burin::volume::{Histogram, Mode, Number, Statistics};
use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;
use std::sync::Arc;

#[test]
fn what_lies_beyond_a_sliders_ends_is_shown_and_left_alone() {
    let mut window = Window::open(SMALL);
    window.click("Section Forces");
    window.scene.brush.radius_mm = 0.0;
    window.scene.look.step_voxels = 0.05;
    window.scene.look.mode = Mode::Iso(150.0);
    window.scene.explosion.forces = Forces { delta_viewing: 2.5, ..Forces::default() };
    window.tell(|_| {});
    assert_eq!(window.sent(), [], "a document was shown and nobody did anything");
    // From the end, where it stands, a hand takes it.
    let moved = window.drag("Brush radius", vec2(5.0, 0.0));
    let radius = moved.iter().find_map(|c| match c {
        Command::Brush(BrushCommand::Set(BrushChange { radius_mm, .. })) => *radius_mm,
        _ => None,
    });
    assert!(radius.is_some_and(|r| r >= 0.5), "{moved:?}");
    let moved = window.drag("Surface value", vec2(-9.0, 0.0));
    let last = moved.iter().rev().find_map(|c| match c {
        Command::View(ViewCommand::Look { mode: Some(Mode::Iso(value)), .. }) => Some(*value),
        _ => None,
    });
    assert!(last.is_some_and(|v| v <= 100.0), "{moved:?}");
}

#[test]
fn a_question_mark_that_is_typed_is_a_letter_and_f1_is_no_letter() {
    let mut window = Window::open(SMALL);
    window.harness.get_by_label("Name of part 1").focus();
    window.harness.run_steps(2);
    let open = |window: &Window| window.harness.query_by_label("Close the page of keys").is_some();
    window.key(Modifiers::SHIFT, Key::Questionmark);
    assert!(!open(&window), "typed into a name");
    window.key(Modifiers::NONE, Key::F1);
    assert!(open(&window), "F1 while a name has the keyboard");
    window.key(Modifiers::NONE, Key::F1);
    let mut window = Window::open(SMALL);
    window.key(Modifiers::SHIFT, Key::Questionmark);
    assert!(open(&window), "with nothing that takes text");
}

#[test]
fn a_name_that_is_left_by_escape_is_the_old_one() {
    let mut window = Window::open(SMALL);
    for (key, renamed) in [(Key::Escape, false), (Key::Enter, true)] {
        window.harness.get_by_label("Name of segment 1").focus();
        window.harness.run_steps(2);
        window.harness.get_by_label("Name of segment 1").type_text("lobe");
        window.harness.run_steps(2);
        let sent = window.key(Modifiers::NONE, key);
        assert_eq!(!sent.is_empty(), renamed, "{key:?}: {sent:?}");
    }
}

#[test]
fn a_segment_is_added_beside_the_last_label_there_can_be() {
    let mut window = Window::open(SMALL);
    segments(&mut window.scene).ensure(u16::MAX);
    window.snapshot(|_| {});
    let sent = window.click("Add segment");
    assert!(
        matches!(
            sent[..],
            [
                Command::Segment(SegmentCommand::Set { id: 3, .. }),
                Command::Brush(BrushCommand::Set(BrushChange { target: Some(Target::Label(3)), .. })),
            ]
        ),
        "{sent:?}"
    );
}

#[test]
fn values_of_every_size_are_shown_and_left_alone() {
    let most = f64::MAX;
    for (min, max) in [
        (-most, most),
        (0.0, most),
        (-most, -most),
        (-1e-300, 1e-300),
        (0.0, f64::MIN_POSITIVE),
        (5e-324, 1e-323),
        (0.0, 0.0),
        (1e15, 1e15 + 1.0),
        (-1.0, 1e300),
        (f64::from(f32::MIN), f64::from(f32::MAX)),
    ] {
        for (mode, target) in [
            (Mode::Iso(max), Target::Density(max)),
            (Mode::Dvr, Target::Density(min)),
            (Mode::Mip, Target::Selection(0.5)),
        ] {
            let mut window = Window::open(SMALL);
            let histogram = Histogram { min, max, bins: vec![7, 0, 1, 3], ..Histogram::default() };
            let (grid, _) = super::scene();
            let mut scene = Scene::new(&grid, &histogram, window.scene.active().unwrap().clone());
            scene.look.mode = mode;
            scene.brush.target = target;
            scene.brush.erase_density = EraseDensity::To(max);
            scene.brush.range = Some([min, max].map(Number::from));
            window.scene = scene.clone();
            window.tell(|s| {
                let open = s.open.as_mut().unwrap();
                open.scene = Arc::new(scene.clone());
                open.histogram = Arc::new(histogram.clone());
                open.statistics = Statistics { min, max, ..Statistics::default() };
            });
            assert_eq!(window.sent(), [], "{min:e} to {max:e}, {mode:?}");
            for name in ["Opacity point 1", "Ready looks", "Ready windows", "Surface value", "Window level"] {
                window.harness.get_by_label(name).hover();
                window.harness.run_steps(1);
            }
            window.click("Ready windows");
            window.click("Ready looks");
            assert_eq!(window.sent(), [], "{min:e} to {max:e}, {mode:?}");
        }
    }
}
