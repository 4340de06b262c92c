//! The menu of looks of volumes, parts, segments and the selection: what it sends, what it marks, whose curve is edited, what is left out.

use super::driver::{LARGE, SMALL, SMALLEST, Window};
use super::volumes::two_volumes;
use burin::document::own_looks::LookChange;
use burin::document::{Command, HistoryCommand, OwnLook};
use burin::volume::{Mode, TransferFunction, VolumeId};
use egui::vec2;
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::{Value, json};

/// Every thing of the test window that has a menu: its button, and where its look stands in the command.
const THINGS: [(&str, &str); 3] =
    [("Look of Segment 1", "segment"), ("Look of Lower half", "part"), ("Look of the selection", "selection")];

fn said(sent: &[Command]) -> Vec<Value> {
    sent.iter().map(|command| serde_json::to_value(command).unwrap()).collect()
}

/// The look that one command gives.
fn given(sent: &[Command], noun: &str) -> Value {
    let [only] = &said(sent)[..] else { panic!("{sent:?}") };
    only[noun]["set"]["look"].clone()
}

fn opened(button: &str) -> Window {
    let mut window = Window::open(SMALL);
    assert_eq!(window.click(button), [], "a menu changes nothing by itself");
    window
}

/// The first segment has this for itself.
fn dress_segment(window: &mut Window, look: LookChange) {
    window.scene.own_looks.segments.entry(VolumeId::FIRST).or_default().insert(1, look);
    window.snapshot(|_| {});
}

fn has(window: &Window, name: &str) -> bool {
    window.harness.query_by_label(name).is_some()
}

#[test]
fn each_row_of_the_menu_gives_what_it_says_and_no_more() {
    for (button, noun) in THINGS {
        for (control, wanted) in [
            ("Mode of the look: Volume", json!({ "mode": "dvr" })),
            ("Mode of the look: Maximum", json!({ "mode": "mip" })),
            ("Light of the look: Off", json!({ "lighting": null })),
        ] {
            let mut window = opened(button);
            assert_eq!(given(&window.click(control), noun), wanted, "{button}, {control}");
        }
        let mut window = opened(button);
        let look = given(&window.click("Light of the look: On"), noun);
        assert!(look["lighting"]["ambient"].is_number(), "{button}: {look}");
        let mut window = opened(button);
        let look = given(&window.click("Mode of the look: Surface"), noun);
        let value = look["mode"]["iso"].as_f64().unwrap();
        assert!((0.0..=100.0).contains(&value), "{button}: {look}");
        // What is inherited already is not chosen again.
        for control in ["Mode of the look: As inherited", "Light of the look: As inherited"] {
            assert_eq!(opened(button).click(control), [], "{button}, {control}");
        }
    }
}

#[test]
fn one_colour_is_the_things_own_and_as_opaque_as_what_it_belongs_to() {
    let window = Window::open(SMALL);
    let (opacity, segment) = (window.scene.transfer.opacity.clone(), window.scene.segments().colour_of(1));
    for (button, noun, colour) in [
        ("Look of Segment 1", "segment", segment),
        ("Look of the selection", "selection", burin::document::SELECTION_COLOUR),
        ("Look of Lower half", "part", [0.95; 3]),
    ] {
        let mut window = opened(button);
        let look = given(&window.click("Colours of the look: One colour"), noun);
        let function: TransferFunction = serde_json::from_value(look["transfer"].clone()).unwrap();
        assert_eq!(look.as_object().unwrap().len(), 1, "{look}");
        assert_eq!(function.opacity, opacity, "{button}");
        for value in [0.0, 40.0, 100.0] {
            assert_eq!(function.colour_at(value), colour, "{button} at {value}");
        }
        // The window follows at once; another colour keeps the rest.
        let look = given(&window.click("Pick blue"), noun);
        let function: TransferFunction = serde_json::from_value(look["transfer"].clone()).unwrap();
        assert_eq!(function.colour_at(50.0), [0.30, 0.50, 0.88], "{button}");
        assert_eq!(function.opacity, opacity, "{button}");
    }
    let mut window = opened("Look of Segment 1");
    window.click("Colours of the look: One colour");
    window.click("Pick red");
    let look = given(&window.click("In the segment's colour"), "segment");
    let function: TransferFunction = serde_json::from_value(look["transfer"].clone()).unwrap();
    assert_eq!(function.colour_at(50.0), segment);
}

#[test]
fn what_is_to_be_inherited_again_is_one_step_that_keeps_the_rest() {
    let mut window = Window::open(SMALL);
    let look = LookChange { mode: Some(Mode::Mip), lighting: Some(None), opacity: 0.5, transfer: None };
    dress_segment(&mut window, look);
    window.click("Look of Segment 1");
    let sent = window.click("Mode of the look: As inherited");
    let [Command::History(HistoryCommand::Begin {}), inherit, rest, Command::History(HistoryCommand::End {})] =
        &sent[..]
    else {
        panic!("{sent:?}")
    };
    let look = |command: &Command| serde_json::to_value(command).unwrap()["segment"]["set"]["look"].clone();
    assert_eq!(look(inherit), json!("inherit"));
    assert_eq!(look(rest), json!({ "lighting": null, "opacity": 0.5 }));
    assert_eq!(given(&window.click("As inherited"), "segment"), json!("inherit"));
}

#[test]
fn a_drag_of_the_opacity_is_one_step_and_the_button_says_that_there_is_a_look() {
    for (button, noun) in THINGS {
        let mut window = opened(button);
        let sent = window.drag("Opacity of the look", vec2(-40.0, 0.0));
        let [Command::History(HistoryCommand::Begin {}), changes @ .., Command::History(HistoryCommand::End {})] =
            &sent[..]
        else {
            panic!("{button}: {sent:?}")
        };
        assert!(!changes.is_empty());
        for change in said(changes) {
            let look = &change[noun]["set"]["look"];
            assert!((0.0..1.0).contains(&look["opacity"].as_f64().unwrap()), "{button}: {change}");
            assert_eq!(look.as_object().unwrap().len(), 1, "{button}: {change}");
        }
        let node = window.harness.get_by_label(button);
        let tip = node.accesskit_node().data().description().unwrap_or_default().to_owned();
        assert!(tip.starts_with("It has a look of its own"), "{button}: {tip}");
    }
}

#[test]
fn a_curve_by_value_is_edited_in_the_panel_until_one_goes_back() {
    let mut window = opened("Look of Segment 1");
    assert!(!has(&window, "Own function of Segment 1"));
    let look = given(&window.click("Colours of the look: By value"), "segment");
    let copied: TransferFunction = serde_json::from_value(look["transfer"].clone()).unwrap();
    assert_eq!(copied, *window.scene.transfer, "it begins as what it belongs to");
    assert!(has(&window, "Own function of Segment 1"));
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
    let sent = window.drag("Opacity point 2", vec2(0.0, -20.0));
    let changes: Vec<_> = sent.iter().filter(|command| !matches!(command, Command::History(_))).collect();
    assert!(!changes.is_empty(), "{sent:?}");
    for change in changes {
        let change = serde_json::to_value(change).unwrap();
        assert!(change["segment"]["set"]["look"]["transfer"]["opacity"].is_array(), "{change}");
    }
    let [Command::Segment(_)] = &window.click("Rebuild from histogram")[..] else { panic!("of the segment") };
    window.click("Back to the volume's function");
    let [Command::Transfer(_)] = &window.click("Rebuild from histogram")[..] else { panic!("of the volume") };
    // What has no function for itself any more is not edited.
    window.click("Look of Segment 1");
    window.click("Edit its curve");
    assert!(has(&window, "Back to the volume's function"));
    window.click("Look of Segment 1");
    window.click("Colours of the look: As inherited");
    window.harness.run_steps(2);
    assert!(!has(&window, "Back to the volume's function"));
}

#[test]
fn the_panels_show_the_look_of_the_volume_that_is_at_hand_and_say_whose_it_is() {
    let mut window = Window::open(SMALL);
    two_volumes(&mut window);
    assert!(has(&window, "Function of small: shared with PET") && has(&window, "Look of small: shared with PET"));
    let colours = TransferFunction {
        colour: vec![(0.0, [0.0; 3]), (50.0, [1.0, 0.0, 0.0]), (100.0, [1.0; 3])],
        opacity: vec![(0.0, 0.0), (20.0, 0.1), (40.0, 0.2), (60.0, 0.4), (100.0, 1.0)],
        unit_mm: 1.0,
    };
    let own = OwnLook { transfer: colours, mode: Mode::Mip, lighting: None };
    if let Some(shown) = window.scene.shown.get_mut(&VolumeId(1)) {
        shown.own = Some(own);
    }
    window.scene.volumes.active = VolumeId(1);
    window.snapshot(|_| {});
    assert!(has(&window, "Function of PET: its own") && has(&window, "Look of PET: its own"));
    assert!(has(&window, "Opacity point 5"), "its own five points");
    let lit = window.harness.get_by_label("Mode: Maximum").accesskit_node().toggled();
    assert_eq!(lit, Some(egui::accesskit::Toggled::True), "its own mode");
}

#[test]
fn a_volume_gets_a_look_of_its_own_and_gives_it_up() {
    let mut window = Window::open(SMALL);
    two_volumes(&mut window);
    window.click("Look of volume PET");
    let look = given(&window.click("Mode of the look: Maximum"), "volume");
    assert_eq!(look, json!({ "mode": "mip" }));
    // The window knows what that makes of it.
    let look = given(&window.click("As inherited"), "volume");
    assert_eq!(look, json!("inherit"));
    assert!(!has(&window, "Opacity of the look"), "it stands in the volume's row");
    let look = given(&window.click("Colours of the look: By value"), "volume");
    assert_eq!(look["transfer"], serde_json::to_value(&*window.scene.transfer).unwrap());
    // Its curve is shown where the curve of the volume at hand is.
    let sent = said(&window.click("Edit its curve"));
    assert_eq!(sent, [json!({ "volume": { "set": { "volume": 1, "active": true } } })]);
    window.harness.run_steps(2);
    assert!(has(&window, "Function of PET: its own"));
}

#[test]
fn segments_are_shown_alone_others_join_them_and_the_window_says_that_the_rest_is_hidden_and_not_gone() {
    let only = |ids: Value| json!([{ "segment": { "show_only": { "ids": ids, "volume": 0 } } }]);
    let as_json = |sent: &[Command]| serde_json::to_value(sent).unwrap();
    for size in [SMALLEST, SMALL, LARGE] {
        let mut window = Window::open(size);
        assert!(!has(&window, "Show all") && !has(&window, "Show Segment 2 in 3D"));
        window.click("Look of Segment 1");
        assert_eq!(as_json(&window.click("Show only this one")), only(json!([1])));
        window.key(egui::Modifiers::NONE, egui::Key::Escape);
        assert!(has(&window, "1 hidden in 3D, not gone"), "in {size:?}");
        assert_eq!(as_json(&window.click("Show all")), only(json!(null)));
        assert!(!has(&window, "1 hidden in 3D, not gone"));
    }
    // In a list that has room for all its rows.
    let mut window = Window::open(LARGE);
    window.click("Look of Segment 1");
    window.click("Show only this one");
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
    let list = window.rect("Name of segment 1");
    assert!(window.rect("Show all").bottom() <= list.top() && list.width() > 60.0, "{list:?}");
    assert_eq!(as_json(&window.click("Also what has no label")), only(json!([0, 1])));
    assert_eq!(as_json(&window.click("Show Segment 2 in 3D")), only(json!([0, 1, 2])));
    assert!(has(&window, "None hidden in 3D") && !has(&window, "1 hidden in 3D, not gone"));
    assert_eq!(as_json(&window.click("Show Segment 2 in 3D")), only(json!([0, 1])));
    assert_eq!(as_json(&window.click("Also what has no label")), only(json!([1])));
    // Where the last one would be hidden all come back, rather than an empty picture.
    assert_eq!(as_json(&window.click("Show Segment 1 in 3D")), only(json!(null)));
    assert!(!has(&window, "Show all"));
    // From the menu of one that is among them, and of one that is not.
    window.click("Look of Segment 1");
    window.click("Show only this one");
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
    window.click("Look of Segment 2");
    assert_eq!(as_json(&window.click("Show this one too")), only(json!([1, 2])));
    assert_eq!(as_json(&window.click("Hide this one")), only(json!([1])));
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
}

#[test]
fn the_menu_and_its_buttons_lie_in_the_window_and_cover_nothing_of_each_other() {
    for size in [SMALLEST, SMALL, LARGE] {
        let mut window = Window::open(size);
        two_volumes(&mut window);
        for name in ["Name of segment 1", "Name of part 1", "Name of volume 1"] {
            assert!(window.rect(name).width() > 60.0, "{name}: {:?} in {size:?}", window.rect(name));
        }
        let mute = window.rect("Opacity of layer Selection, value");
        assert!(mute.right() <= window.rect("Look of the selection").left() + 0.6, "{mute:?} in {size:?}");
        // In a small window the layers are scrolled to.
        let buttons = ["Look of Lower half", "Look of Segment 1", "Look of volume PET", "Look of the selection"];
        for button in &buttons[..if size == SMALLEST { 3 } else { 4 }] {
            window.click(button);
            for control in ["Light of the look: Off", "Pick white", "Edit its curve", "As inherited"] {
                let place = window.rect(control);
                let all = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(size[0], size[1]));
                assert!(all.contains_rect(place), "{button}, {control}: {place:?} in {size:?}");
            }
            window.key(egui::Modifiers::NONE, egui::Key::Escape);
        }
    }
}

#[test]
fn the_brush_says_that_what_it_paints_is_hidden() {
    let mut window = Window::open(SMALL);
    two_volumes(&mut window);
    let hidden = "small is hidden: paint on it is not seen";
    assert!(!has(&window, hidden));
    window.click("Show volume small");
    assert!(has(&window, hidden));
}

#[test]
fn menus_of_what_every_volume_may_have_say_of_which_volume_it_is() {
    for (button, title) in
        [("Look of Segment 1", "Look in 3D: Segment 1"), ("Look of the selection", "Look in 3D: the selection")]
    {
        let mut window = opened(button);
        assert!(has(&window, title), "{title}");
        window.key(egui::Modifiers::NONE, egui::Key::Escape);
        two_volumes(&mut window);
        window.click(button);
        window.harness.run_steps(2);
        assert!(has(&window, &format!("{title} of small")), "{title}");
    }
}

#[test]
fn the_menu_says_what_changes_and_no_more_of_what_has_a_look_already() {
    let function = (*Window::open(SMALL).scene.transfer).clone();
    let curve = TransferFunction { opacity: vec![(10.0, 0.0), (30.0, 0.8)], ..function };
    let all = LookChange { mode: Some(Mode::Mip), lighting: Some(None), opacity: 0.5, transfer: Some(curve.clone()) };
    let dressed = || {
        let mut window = Window::open(SMALL);
        dress_segment(&mut window, all.clone());
        window.click("Look of Segment 1");
        window
    };
    assert_eq!(given(&dressed().click("Mode of the look: Volume"), "segment"), json!({ "mode": "dvr" }));
    let look = given(&dressed().click("Light of the look: On"), "segment");
    assert_eq!(look.as_object().unwrap().keys().collect::<Vec<_>>(), ["lighting"]);
    // What is inherited again is given up; the rest is said anew.
    for (control, field) in
        [("Mode of the look", "mode"), ("Light of the look", "lighting"), ("Colours of the look", "transfer")]
    {
        let sent = dressed().click(&format!("{control}: As inherited"));
        let [_, inherit, rest, _] = &said(&sent)[..] else { panic!("{control}: {sent:?}") };
        assert_eq!(inherit["segment"]["set"]["look"], json!("inherit"));
        let mut wanted = json!({"mode": "mip", "lighting": null, "opacity": 0.5, "transfer": curve});
        wanted.as_object_mut().unwrap().remove(field);
        assert_eq!(rest["segment"]["set"]["look"], wanted, "{control}");
    }
    // Colours by value are again those of what it belongs to, as opaque as it was.
    let mut window = dressed();
    window.click("Colours of the look: One colour");
    let look = given(&window.click("Colours of the look: By value"), "segment");
    let function: TransferFunction = serde_json::from_value(look["transfer"].clone()).unwrap();
    assert_eq!((function.colour, function.opacity), (window.scene.transfer.colour.clone(), curve.opacity));
    // A drag of the surface's value is one step.
    let mut window = opened("Look of Segment 1");
    window.click("Mode of the look: Surface");
    let sent = window.drag("Surface value of the look", vec2(30.0, 0.0));
    let [Command::History(HistoryCommand::Begin {}), changes @ .., Command::History(HistoryCommand::End {})] =
        &sent[..]
    else {
        panic!("{sent:?}")
    };
    assert!(!changes.is_empty() && said(changes).iter().all(|c| c["segment"]["set"]["look"]["mode"]["iso"].is_f64()));
}

#[test]
fn what_a_menu_takes_as_inherited_is_of_the_volume_that_it_is_of_and_not_of_another() {
    let lit = |window: &Window, name: &str| {
        window.harness.get_by_label(name).accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    let mut window = Window::open(SMALL);
    two_volumes(&mut window);
    let colours = TransferFunction {
        colour: vec![(1000.0, [1.0, 0.0, 0.0]), (2000.0, [1.0; 3])],
        opacity: vec![(1000.0, 0.0), (1600.0, 0.5), (2000.0, 1.0)],
        unit_mm: 1.0,
    };
    // The volume at hand has a look of its own; the other is shown as the document is, which is unlit.
    window.scene.shown.get_mut(&VolumeId::FIRST).unwrap().own =
        Some(OwnLook { transfer: colours.clone(), mode: Mode::Mip, lighting: Some(Default::default()) });
    window.scene.look.lighting = None;
    window.snapshot(|_| {});
    window.click("Look of volume PET");
    assert!(lit(&window, "Mode of the look: Volume") && lit(&window, "Light of the look: Off"));
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
    // Segments begin as their volume; of a volume that is not at hand surfaces lie among the values of its function.
    window.scene.volumes.all.get_mut(&VolumeId(1)).unwrap().segments.ensure(1);
    let own = OwnLook { transfer: colours.clone(), mode: Mode::Mip, lighting: None };
    window.scene.shown.get_mut(&VolumeId::FIRST).unwrap().own = None;
    window.scene.shown.get_mut(&VolumeId(1)).unwrap().own = Some(own);
    window.snapshot(|_| {});
    window.click("Look of volume PET");
    assert_eq!(given(&window.click("Mode of the look: Surface"), "volume"), json!({"mode": {"iso": 1600.0}}));
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
    window.scene.volumes.active = VolumeId(1);
    window.snapshot(|_| {});
    window.click("Look of Segment 1");
    let look = given(&window.click("Colours of the look: By value"), "segment");
    assert_eq!(look["transfer"], serde_json::to_value(&colours).unwrap());
    assert!(has(&window, "Own function of Segment 1 of PET"));
    // Another volume at hand shows its own function.
    window.scene.volumes.active = VolumeId::FIRST;
    window.snapshot(|_| {});
    assert!(!has(&window, "Back to the volume's function"));
}
