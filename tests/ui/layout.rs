//! The window's division: nothing covers anything, nothing moves when something comes, borders are dragged and remembered.

use super::driver::{LARGE, SMALL, SMALLEST, Window};
use crate::common::one::segments;
use burin::document::{Command, TransferCommand};
use burin::explode::{Part, PartId};
use burin::paint::Target;
use burin::ui::Layout;
use burin::volume::Mode;
use egui::{Rect, Vec2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use std::collections::BTreeMap;

/// Controls by name with where they lie.
fn places(window: &Window) -> BTreeMap<String, Rect> {
    let mut places = BTreeMap::new();
    let mut stack = vec![window.harness.root()];
    while let Some(node) = stack.pop() {
        stack.extend(node.children());
        let about = node.accesskit_node();
        use egui::accesskit::Role as R;
        let acts = matches!(
            about.role(),
            R::Button
                | R::CheckBox
                | R::RadioButton
                | R::Slider
                | R::SpinButton
                | R::TextInput
                | R::ComboBox
                | R::ColorWell
        );
        if let Some(label) = about.label().filter(|_| acts) {
            places.insert(label, node.rect());
        }
    }
    places
}

/// The areas that borders leave, each with the controls that are wholly in sight there.
fn areas(window: &Window, size: [f32; 2]) -> Vec<Vec<(String, Rect)>> {
    let zoom = window.harness.ctx.zoom_factor();
    let (left, right) = (window.rect("Border of the left panel"), window.rect("Border of the right panel"));
    let (segments, parts) = (window.rect("Border over the segments"), window.rect("Border over the parts"));
    let steps = window.rect("Border over the history");
    let views =
        (window.rect("Border between left and right views"), window.rect("Border between upper and lower views"));
    let (top, bottom, width) = (left.top(), left.bottom(), size[0] / zoom);
    let area = |x0: f32, y0: f32, x1: f32, y1: f32| Rect::from_min_max(egui::pos2(x0, y0), egui::pos2(x1, y1));
    let (upright, level) = views;
    // What a list has is told by name: what is scrolled out of sight above it lies there too.
    let (any, segment, part, step) =
        ([""].as_slice(), ["Segment ", "segment "].as_slice(), ["half"].as_slice(), ["Step "].as_slice());
    let all = [
        (area(0.0, 0.0, width, top), any),
        (area(0.0, top, left.left(), segments.top()), any),
        (area(0.0, segments.bottom(), left.left(), bottom), segment),
        (area(right.right(), top, width, parts.top()), any),
        (area(right.right(), parts.bottom(), width, steps.top()), part),
        (area(right.right(), steps.bottom(), width, bottom), step),
        (area(left.right(), top, upright.left(), level.top()), any),
        (area(upright.right(), top, right.left(), level.top()), any),
        (area(left.right(), level.bottom(), upright.left(), bottom), any),
        (area(upright.right(), level.bottom(), right.left(), bottom), any),
    ];
    let places = places(window);
    let within = |(area, words): &(Rect, &[&str])| {
        let named = |name: &str| words.iter().any(|word| name.contains(word));
        places.clone().into_iter().filter(|(name, rect)| area.contains_rect(*rect) && named(name)).collect()
    };
    all.iter().map(within).collect()
}

#[test]
fn no_control_covers_another_at_any_size() {
    for size in [SMALLEST, SMALL, LARGE] {
        for target in [Target::Selection(1.0), Target::Label(1), Target::Colour([1.0; 4]), Target::Density(1234.5678)] {
            let mut window = Window::open(size);
            window.scene.brush.target = target;
            window.scene.brush.radius_mm = 1234.5;
            window.scene.window().level = -123_456.789;
            window.snapshot(|_| {});
            window.click("Opacity point 2");
            window.harness.run_steps(4);
            let areas = areas(&window, size);
            let seen: usize = areas.iter().map(Vec::len).sum();
            assert!(seen > 45, "{seen} controls in sight in {size:?}");
            for area in areas {
                for (i, (name, rect)) in area.iter().enumerate() {
                    for (other, place) in &area[i + 1..] {
                        // Points of the function may lie close to each other.
                        let free = name.contains(" point ") && other.contains(" point ");
                        let common = rect.shrink(0.6).intersect(place.shrink(0.6));
                        assert!(free || !common.is_positive(), "{name} {rect:?} and {other} {place:?} in {size:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_panel_s_contents_stay_within_it_however_narrow_it_is() {
    for size in [SMALLEST, SMALL] {
        let mut window = Window::open(size);
        window.drag("Border of the left panel", vec2(-400.0, 0.0));
        window.drag("Border of the right panel", vec2(400.0, 0.0));
        window.click("Section Forces");
        let (left, right) = (window.rect("Border of the left panel"), window.rect("Border of the right panel"));
        for name in [
            "Paint: Density",
            "Mode: Maximum",
            "Paint mode",
            "Brush radius, value",
            "Highest value to paint",
            "Add segment",
        ] {
            assert!(window.rect(name).right() <= left.left(), "{name} {:?} beside {left:?}", window.rect(name));
        }
        for name in ["Rebuild from histogram", "Degree of explosion, value", "Join all parts"] {
            let rect = window.rect(name);
            assert!(rect.left() >= right.right() && rect.right() <= size[0], "{name} {rect:?} beside {right:?}");
        }
    }
}

/// Controls that two windows have in common and that lie elsewhere.
fn moved(before: &BTreeMap<String, Rect>, after: &BTreeMap<String, Rect>, but: &[&str]) -> Vec<String> {
    let both = before.iter().filter_map(|(name, rect)| Some((name, rect, after.get(name)?)));
    let moved = both.filter(|(name, a, b)| *a != *b && !but.contains(&name.as_str()));
    moved.map(|(name, a, b)| format!("{name}: {a:?} to {b:?}")).collect()
}

#[test]
fn nothing_moves_when_another_thing_is_chosen_or_comes_to_a_list() {
    for size in [SMALLEST, SMALL, LARGE] {
        let mut window = Window::open(size);
        segments(&mut window.scene).0.clear();
        window.scene.explosion.parts.truncate(1);
        window.snapshot(|s| s.undo.clear());
        window.harness.run_steps(4);
        let before = places(&window);
        let mut then = |what: &str, but: &[&str], change: &dyn Fn(&mut Window)| {
            change(&mut window);
            window.snapshot(|_| {});
            window.harness.run_steps(4);
            let moved = moved(&before, &places(&window), but);
            assert!(moved.is_empty(), "{what} in {size:?}: {moved:#?}");
        };
        for target in [Target::Label(7), Target::Colour([1.0; 4]), Target::Density(3.0), Target::Selection(0.5)] {
            then("another target", &[], &|w| w.scene.brush.target = target);
        }
        for radius in [0.5, 10.0, 99.9, 12_345.0] {
            then("another radius", &[], &|w| w.scene.brush.radius_mm = radius);
        }
        then("a weak label brush", &[], &|w| {
            w.scene.brush.target = Target::Label(1);
            w.scene.brush.strength = 0.2;
        });
        for mode in [Mode::Iso(50.0), Mode::Mip, Mode::Dvr] {
            then("another mode", &[], &|w| w.scene.look.mode = mode);
        }
        then("segments", &[], &|w| (1..40).for_each(|id| segments(&mut w.scene).ensure(id)));
        then("parts", &["Name of part 1", "Show Lower half", "Pin Lower half", "Colour of Lower half"], &|w| {
            let part = w.scene.explosion.parts[0].clone();
            let more = (2..40).map(|id| Part { id: PartId(id), name: format!("Piece {id}"), ..part.clone() });
            w.scene.explosion.parts.extend(more);
        });
        then("an undone range", &[], &|w| w.scene.brush.range = Some([1.0, 99.5].map(burin::volume::Number::Real)));
    }
}

#[test]
fn every_border_is_dragged_and_a_double_click_puts_it_back() {
    let mut window = Window::open(SMALL);
    let borders = [
        ("Border of the left panel", vec2(70.0, 0.0)),
        ("Border of the right panel", vec2(-70.0, 0.0)),
        ("Border between left and right views", vec2(60.0, 0.0)),
        ("Border between upper and lower views", vec2(0.0, -60.0)),
        ("Corner of all four views", vec2(-50.0, 40.0)),
        ("Border over the segments", vec2(0.0, -60.0)),
        ("Border over the parts", vec2(0.0, -40.0)),
        ("Border over the history", vec2(0.0, -30.0)),
    ];
    for (name, by) in borders {
        // A place on it that belongs to no other.
        let before = window.rect(name);
        let sent = drag_off_centre(&mut window, name, by);
        assert_eq!(sent, [], "a border is no command");
        let after = window.rect(name);
        assert!(
            (after.center() - before.center() - by).length() < 2.0,
            "{name}: {before:?} to {after:?}, not by {by:?}"
        );
        let at = off_centre(after, name);
        double_click_at(&mut window, at);
        let back = window.rect(name);
        assert!((back.center() - before.center()).length() < 1.5, "{name}: back at {back:?}, was {before:?}");
    }
}

/// A long border crosses others in its middle.
fn off_centre(rect: Rect, name: &str) -> egui::Pos2 {
    if name.starts_with("Corner") { rect.center() } else { rect.min + rect.size() * vec2(0.5, 0.5) + long(rect) * 0.2 }
}

fn long(rect: Rect) -> Vec2 {
    if rect.width() > rect.height() { vec2(rect.width(), 0.0) } else { vec2(0.0, rect.height()) }
}

fn drag_off_centre(window: &mut Window, name: &str, by: Vec2) -> Vec<Command> {
    let from = off_centre(window.rect(name), name);
    window.harness.hover_at(from);
    window.harness.run_steps(1);
    window.harness.drag_at(from);
    window.harness.run_steps(1);
    for share in [0.25, 0.6, 1.0] {
        window.harness.hover_at(from + by * share);
        window.harness.run_steps(1);
    }
    window.harness.drop_at(from + by);
    window.harness.run_steps(4);
    window.sent()
}

fn double_click_at(window: &mut Window, pos: egui::Pos2) {
    window.harness.hover_at(pos);
    window.harness.run_steps(1);
    let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
    let click = |pressed| egui::Event::PointerButton { pos, button, pressed, modifiers };
    window.harness.input_mut().events.extend([true, false, true, false].map(click));
    window.harness.run_steps(4);
}

#[test]
fn views_and_panels_keep_what_they_need_wherever_a_border_is_dragged() {
    let mut window = Window::open(SMALL);
    for by in [vec2(3000.0, 3000.0), vec2(-3000.0, -3000.0)] {
        for name in [
            "Corner of all four views",
            "Border of the left panel",
            "Border of the right panel",
            "Border over the parts",
        ] {
            drag_off_centre(&mut window, name, by);
        }
        for view in ["3D view", "Axial view", "Coronal view", "Sagittal view"] {
            let rect = window.rect(view);
            assert!(rect.width() >= 50.0 && rect.height() >= 50.0, "{view} {rect:?} after {by:?}");
        }
        for name in ["Brush radius", "Opacity point 1", "Section Parts", "Section History"] {
            let rect = window.rect(name);
            assert!(rect.left() >= 0.0 && rect.right() <= SMALL[0] && rect.width() > 8.0, "{name} {rect:?}");
        }
    }
}

#[test]
fn a_layout_is_there_again_at_the_next_start() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state").join("window.json");
    let mut window = Window::keeping(SMALL, &path);
    let first = window.rect("Border of the left panel").center().x;
    drag_off_centre(&mut window, "Border of the left panel", vec2(64.0, 0.0));
    drag_off_centre(&mut window, "Border between upper and lower views", vec2(0.0, 80.0));
    drag_off_centre(&mut window, "Border over the segments", vec2(0.0, -80.0));
    let wanted = ["Border of the left panel", "Axial view", "Add segment"].map(|n| window.rect(n));
    assert!((wanted[0].center().x - first - 64.0).abs() < 1.0);
    let mut again = Window::keeping(SMALL, &path);
    again.harness.run_steps(4);
    assert_eq!(["Border of the left panel", "Axial view", "Add segment"].map(|n| again.rect(n)), wanted);
    double_click_at(&mut again, off_centre(wanted[0], ""));
    let third = Window::keeping(SMALL, &path);
    assert!((third.rect("Border of the left panel").center().x - first).abs() < 1.0, "what was put back is kept too");
}

#[test]
fn what_is_folded_is_folded_at_the_next_start() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("window.json");
    let mut window = Window::keeping(SMALL, &path);
    let there = |w: &Window, name: &str| w.harness.query_by_label(name).is_some();
    for section in ["Section Layers", "Section History", "Section Forces"] {
        assert_eq!(window.click(section), [], "folding is no command");
    }
    let mut again = Window::keeping(SMALL, &path);
    again.harness.run_steps(4);
    assert!(!there(&again, "Window level") && !there(&again, "Step 1: Stroke"));
    assert!(there(&again, "Viewing force") && there(&again, "Brush radius"), "the others as they were");
    again.click("Section Layers");
    let mut third = Window::keeping(SMALL, &path);
    third.harness.run_steps(4);
    assert!(there(&third, "Window level") && !there(&third, "Step 1: Stroke"));
}

#[test]
fn the_number_of_a_slice_ends_before_the_buttons_beside_it() {
    for size in [SMALLEST, SMALL, LARGE] {
        let window = Window::open(size);
        for view in ["Axial", "Coronal", "Sagittal"] {
            let name = format!("{view} slice ");
            let number = window.harness.get_by_label_contains(&name).rect();
            let fit = window.rect(&format!("Fit the {view} view"));
            assert!(number.right() <= fit.left() && number.width() >= 7.0, "{view} {number:?} {fit:?} in {size:?}");
        }
    }
}

#[test]
fn a_damaged_or_hostile_layout_is_the_usual_one() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("window.json");
    assert_eq!(Layout::read(&path), Layout::default(), "no file");
    let long = format!("{{\"left\": 300{}}}", " ".repeat(1 << 20));
    for text in
        ["", "{", "null", "[]", "{\"left\": \"wide\"}", "{\"views\": [0.5]}", "{\"folds\": 3}", "\u{0}\u{0}", &long]
    {
        std::fs::write(&path, text).unwrap();
        assert_eq!(Layout::read(&path), Layout::default(), "{:?}", &text[..text.len().min(40)]);
    }
    std::fs::write(&path, "{\"left\": 1e30, \"right\": -7, \"views\": [9, -9], \"lists\": 1e30, \"steps\": 2}")
        .unwrap();
    let window = Window::keeping(SMALL, &path);
    for name in
        ["3D view", "Axial view", "Coronal view", "Sagittal view", "Section History", "Section Parts", "Brush radius"]
    {
        let rect = window.rect(name);
        assert!(rect.width() > 8.0 && rect.height() > 8.0 && rect.right() <= SMALL[0], "{name} {rect:?}");
    }
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    assert_eq!(Layout::read(&path), Layout::default(), "a folder in its place");
    let mut window = Window::keeping(SMALL, &path);
    drag_off_centre(&mut window, "Border of the left panel", vec2(30.0, 0.0));
    assert!(window.harness.query_by_label("Brush radius").is_some(), "what cannot be kept stops nothing");
}

#[cfg(unix)]
#[test]
fn the_folder_of_a_layout_is_for_its_user_alone() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state/burin/window.json");
    // Lists of files and recovered work come to lie beside it.
    Layout::default().write(&path).unwrap();
    let mode = std::fs::metadata(path.parent().unwrap()).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o700, "{mode:o}");
    assert_eq!(Layout::read(&path), Layout::default());
}

#[test]
fn a_list_leaves_room_for_its_scroll_bar() {
    for size in [SMALLEST, SMALL, LARGE] {
        let mut window = Window::open(size);
        (3..60).for_each(|id| segments(&mut window.scene).ensure(id));
        let part = window.scene.explosion.parts[0].clone();
        let more = (3..60).map(|id| Part { id: PartId(id), name: format!("Piece {id}"), ..part.clone() });
        window.scene.explosion.parts.extend(more);
        window.snapshot(|s| s.undo = (0..60).map(|i| format!("Stroke {i}")).collect());
        window.harness.run_steps(4);
        // Under the pointer a bar is 8 points wide.
        let bars = |name: &str| window.rect(name).right() - 12.0 - 8.0;
        let places = places(&window);
        for (words, most) in [
            (&["Remove Segment ", "Lock Segment "][..], bars("Border of the left panel")),
            (&["Pin ", "Show Piece ", "Step "], size[0] / window.harness.ctx.zoom_factor() - 8.0 - 12.0 - 8.0),
        ] {
            let rows = places.iter().filter(|(name, _)| words.iter().any(|word| name.starts_with(word)));
            let mut count = 0;
            for (name, rect) in rows {
                assert!(rect.right() <= most, "{name} {rect:?} reaches over {most} in {size:?}");
                count += 1;
            }
            assert!(count > 3, "{count} in {size:?}");
        }
    }
}

#[test]
fn a_folded_list_leaves_its_height_to_the_others() {
    let mut window = Window::open(LARGE);
    let part = window.scene.explosion.parts[0].clone();
    let more = (3..60).map(|id| Part { id: PartId(id), name: format!("Piece {id}"), ..part.clone() });
    window.scene.explosion.parts.extend(more);
    window.snapshot(|_| {});
    let rows = |w: &Window| (3..60).filter(|id| w.harness.query_by_label(&format!("Pin Piece {id}")).is_some()).count();
    let before = rows(&window);
    window.click("Section History");
    window.harness.run_steps(4);
    assert!(rows(&window) > before + 5, "{} rows, {before} before", rows(&window));
    window.click("Section History");
    window.click("Section Parts");
    window.harness.run_steps(4);
    assert_eq!(rows(&window), 0);
    assert!(window.harness.query_by_label("Step 1: Stroke").is_some());
}

#[test]
fn an_opacity_point_moves_without_its_colour_and_with_it_while_shift_is_held() {
    let mut window = Window::open(SMALL);
    let old = window.scene.transfer.clone();
    assert_eq!(old.colour[1].0, old.opacity[1].0, "both begin at one value");
    let last = |sent: Vec<Command>| {
        let set = sent.into_iter().rev().find_map(|c| match c {
            Command::Transfer(TransferCommand::Set { function, .. }) => Some(function),
            _ => None,
        });
        set.expect("the function was set")
    };
    let alone = last(window.drag("Opacity point 2", vec2(12.0, 5.0)));
    assert!(alone.opacity[1].0 > old.opacity[1].0);
    assert_eq!(alone.colour, old.colour);
    window.snapshot(|_| {});
    window.harness.event(egui::Event::ModifiersChanged(egui::Modifiers::SHIFT));
    window.harness.run_steps(1);
    let both = last(window.drag("Opacity point 2", vec2(12.0, 5.0)));
    assert!(both.opacity[1].0 > old.opacity[1].0);
    assert_eq!(both.colour[1].0, both.opacity[1].0, "the colour came along");
    assert_eq!((both.colour[0], both.colour[2]), (old.colour[0], old.colour[2]));
}

#[test]
fn the_renderer_is_named_by_what_it_is() {
    let mut window = Window::open(SMALL);
    assert!(window.harness.query_by_label("Software renderer").is_some());
    window.snapshot(|s| s.gpu = Some(Ok("NVIDIA H100 PCIe (Vulkan)".into())));
    assert!(window.harness.query_by_label("NVIDIA H100 PCIe").is_some());
}
