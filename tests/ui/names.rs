//! Every control can be found and told from the others by its name, whatever the window shows.

use super::driver::{SMALL, Window};
use super::replies::{done, lost};
use super::volumes::two_volumes;
use crate::common::one::segments;
use burin::document::{Command, ProjectCommand};
use burin::explode::{Part, PartId};
use burin::paint::Target;
use burin::ui::{Report, Severity};
use burin::volume::{Mode, VolumeId};
use egui::Modifiers;
use egui::accesskit::Role as R;
use egui_kittest::kittest::NodeT;
use std::collections::BTreeMap;
use std::time::Duration;

/// Names of all controls with how often each comes; those without a name are said with their place.
fn controls(window: &Window) -> (BTreeMap<String, u32>, Vec<String>) {
    let (mut names, mut nameless) = (BTreeMap::<String, u32>::new(), Vec::new());
    let mut stack = vec![window.harness.root()];
    while let Some(node) = stack.pop() {
        stack.extend(node.children());
        let about = node.accesskit_node();
        let role = about.role();
        if !acts(&node) {
            continue;
        }
        match about.label().filter(|l| !l.trim().is_empty()) {
            Some(label) => *names.entry(format!("{role:?} {label}")).or_default() += 1,
            None => nameless.push(format!("{role:?} at {:?}", node.rect())),
        }
    }
    (names, nameless)
}

/// Whether it is a control.
pub(super) fn acts(node: &egui_kittest::Node<'_>) -> bool {
    let about = node.accesskit_node();
    let role = about.role();
    let acts = matches!(
        role,
        R::Button
            | R::CheckBox
            | R::RadioButton
            | R::Slider
            | R::SpinButton
            | R::TextInput
            | R::ComboBox
            | R::ColorWell
            | R::ListItem
            | R::Link
    );
    // Whatever else can be clicked is a control too. Text can, to be selected; edges and bars are the toolkit's.
    let other = !matches!(role, R::Label | R::TextRun | R::ScrollBar | R::Splitter);
    acts || other && about.data().supports_action(egui::accesskit::Action::Click)
}

/// What the window shows beside what it always does, and a control that is only there then.
pub(super) fn states() -> Vec<(&'static str, Window, &'static str)> {
    let mut states = Vec::new();
    let mut add = |name, control, prepare: &dyn Fn(&mut Window)| {
        let mut window = Window::open(SMALL);
        prepare(&mut window);
        window.harness.run_steps(3);
        states.push((name, window, control));
    };
    let target = |target| {
        move |window: &mut Window| {
            window.scene.brush.target = target;
            window.snapshot(|_| {});
        }
    };
    let left = |window: &mut Window| {
        window.report(lost(&[("1", "/data/a.nii"), ("2", "/data/b.nii")], Duration::ZERO));
    };
    let close = |window: &mut Window| {
        window.snapshot(|s| s.unsaved = true);
        let viewport = window.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.events.push(egui::ViewportEvent::Close);
        window.harness.run_steps(2);
        window.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default().events.clear();
    };
    let say = |window: &mut Window| {
        for (severity, text) in [(Severity::Error, "one"), (Severity::Warning, "two"), (Severity::Note, "three")] {
            window.report(Report::Message(severity, text.into()));
        }
    };
    let many = |window: &mut Window| {
        let part = window.scene.explosion.parts[0].clone();
        let more = (3..36).map(|id| Part { id: PartId(id), name: format!("Piece {id}"), ..part.clone() });
        window.scene.explosion.parts.extend(more);
        (3..40).for_each(|id| segments(&mut window.scene).ensure(id));
        window.snapshot(|_| {});
    };
    let press = |key| move |window: &mut Window| drop(window.key(Modifiers::NONE, key));
    let click = |name| move |window: &mut Window| drop(window.click(name));
    add("a selection to paint", "Interest", &target(Target::Selection(1.0)));
    add("a label to paint", "Label to paint", &target(Target::Label(1)));
    add("a colour to paint", "Colour opacity", &target(Target::Colour([1.0, 0.0, 0.0, 1.0])));
    add("a density to paint", "Density to paint", &target(Target::Density(3.0)));
    add("a surface", "Surface value", &|window| {
        window.scene.look.mode = Mode::Iso(50.0);
        window.snapshot(|_| {});
    });
    add("forces", "Viewing force", &click("Section Forces"));
    add("a chosen point of opacity", "Opacity of the point", &click("Opacity point 2"));
    add("a chosen point of colour", "Colour of the point", &click("Colour point 2"));
    add("a colour picker", "Pick red", &click("Colour of Upper half"));
    add("ready looks", "See-through", &click("Ready looks"));
    add("ready windows", "Automatic", &click("Ready windows"));
    add("the menu", "Export…", &click("More…"));
    let from_menu = |name| {
        move |window: &mut Window| {
            window.click("More…");
            window.click(name);
        }
    };
    add("an export", "Format: NIfTI (.nii.gz)", &from_menu("Export…"));
    add("an export of a surface", "Segment to export", &|window| {
        from_menu("Export…")(window);
        window.click("What: Labels");
        window.click("Surface: STL");
    });
    add("a picture to save", "Size: 4K", &from_menu("Save picture…"));
    add("a picture of a size of its own", "Height in pixels", &|window| {
        from_menu("Save picture…")(window);
        window.click("Size: Own");
        window.click("Background: Colour");
    });
    add("a folder to be made", "Make the folder", &|window| {
        window.key(Modifiers::COMMAND | Modifiers::SHIFT, egui::Key::S);
        window.click("New folder");
    });
    add("what was written", "Copy the path of what was written", &|window| {
        let save = Command::Project(ProjectCommand::Save { path: Some("/data/h.burin".into()), density: None });
        window.report(done(save));
    });
    add("what was written, in the list", "Copy the path of message 1", &|window| {
        let save = Command::Project(ProjectCommand::Save { path: Some("/data/h.burin".into()), density: None });
        window.report(done(save));
        window.click("Messages");
    });
    add("the labels to choose from", "2  Segment 2", &|window| {
        target(Target::Label(1))(window);
        window.click("Label to paint");
    });
    add("the modes to choose from", "Subtract", &click("Paint mode"));
    add("many parts and segments", "Show Segment 3", &many);
    add("two volumes", "Opacity of volume small", &two_volumes);
    add("two volumes of one name", "Opacity of volume small (1)", &|window| {
        two_volumes(window);
        window.scene.volumes.all.get_mut(&VolumeId(1)).unwrap().name = "small".into();
        window.snapshot(|_| {});
    });
    add("the place of a volume", "Shift to the right of the volume", &|window| {
        two_volumes(window);
        window.click("Place of volume PET");
    });
    add("messages", "Dismiss message 2", &say);
    add("keys", "Close the page of keys", &press(egui::Key::F1));
    add("one view", "All four views", &click("Only the Sagittal view"));
    add("long work", "Cancel", &|window| {
        window.report(Report::Started("Saving".into()));
        window.report(Report::Progress(42));
    });
    add("a path to type", "Path", &|window| drop(window.key(Modifiers::COMMAND, egui::Key::O)));
    add("what a crash left", "Recover b.nii", &left);
    add("a question before closing", "Discard changes", &close);
    let mut empty = Window::empty(SMALL);
    empty.harness.run_steps(3);
    states.push(("nothing open", empty, "Open…"));
    states
}

#[test]
fn every_control_has_a_name_of_its_own_whatever_is_shown() {
    for (state, window, control) in states() {
        let (names, nameless) = controls(&window);
        assert_eq!(nameless, Vec::<String>::new(), "with {state}");
        let twice: Vec<_> = names.iter().filter(|(_, n)| **n > 1).collect();
        assert!(twice.is_empty(), "with {state}, a name must say which control it is: {twice:?}");
        let there = names.keys().any(|name| name.split_once(' ').is_some_and(|(_, label)| label == control));
        assert!(there, "with {state} there is no {control}: {names:#?}");
        let least = if state == "nothing open" { 4 } else { 60 };
        assert!(names.len() > least, "with {state} the walk found only {} controls", names.len());
    }
}
