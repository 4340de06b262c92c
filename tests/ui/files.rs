//! Opening, saving and what is said of it, in a window whose document is the test.

use super::driver::{SMALL, Window};
use super::replies::{done, saved};
use burin::document::{Command, OpenAs, ProjectCommand, VolumeCommand};
use burin::ui::{Offer, Recent, Report, Severity, Then};
use burin::volume::FieldKind;
use egui::{Modifiers, OutputCommand};
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};

fn open(path: &Path) -> Command {
    serde_json::from_value(serde_json::json!({ "volume": { "open": { "path": path } } })).unwrap()
}

/// A picture of the 3D view, as a script would have it.
fn image(path: &str) -> Command {
    serde_json::from_value(serde_json::json!({ "render": { "image": { "path": path } } })).unwrap()
}

/// A window with nothing open that keeps its list of files in a folder.
fn started(state: &Path) -> Window {
    let mut window = Window::with_files([1280.0, 800.0], Recent::kept_in(state.into()), Some(state.into()));
    window.harness.run_steps(3);
    window.sent();
    window
}

/// What the window sends once it has looked at a file, which it does beside.
fn sent_in_time(window: &mut Window) -> Vec<Command> {
    let begun = std::time::Instant::now();
    loop {
        window.harness.run_steps(1);
        let sent = window.sent();
        if !sent.is_empty() {
            return sent;
        }
        assert!(begun.elapsed().as_secs() < 20, "nothing is ever sent");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
}

#[test]
fn the_start_page_opens_what_was_open_lately() {
    let dir = tempfile::tempdir().unwrap();
    let volume = dir.path().join("head.nii");
    std::fs::write(&volume, "x").unwrap();
    let state = dir.path().join("state");
    let mut recent = Recent::kept_in(state.clone());
    recent.note_volume(&dir.path().join("gone.nrrd"), OpenAs::Image);
    recent.note_volume(&volume, OpenAs::Image);
    let mut window = started(&state);
    let begun = std::time::Instant::now();
    while window.harness.query_by_label("Recent 2: gone.nrrd, not found").is_none() {
        assert!(begun.elapsed().as_secs() < 20, "nobody looked");
        window.harness.run_steps(1);
    }
    window.harness.get_by_label("Recent 1: head.nii").click();
    assert_eq!(sent_in_time(&mut window), [open(&volume)]);
    window.click("Forget recent 2");
    assert!(window.harness.query_by_label_contains("gone.nrrd").is_none());
    window.click("Forget all recent files");
    assert!(Recent::kept_in(state).entries().is_empty());
    assert!(window.harness.query_by_label("What you open and save will be listed here.").is_some());
}

#[test]
fn what_a_volume_was_opened_as_is_not_asked_again() {
    let dir = tempfile::tempdir().unwrap();
    let volume = dir.path().join("atlas.nrrd");
    std::fs::write(&volume, "x").unwrap();
    let state = dir.path().join("state");
    for (open_as, name) in [(OpenAs::Labels, "labels"), (OpenAs::Selection, "selection"), (OpenAs::Image, "image")] {
        // What was opened in one window is known to the next.
        let mut window = started(&state);
        let open = serde_json::json!({ "volume": { "open": { "path": volume, "as": name } } });
        let open: Command = serde_json::from_value(open).unwrap();
        window.report(done(open.clone()));
        assert_eq!(Recent::kept_in(state.clone()).entries()[0].open_as, Some(open_as));
        assert_eq!(started(&state).click("Recent 1: atlas.nrrd"), [open], "as {name}, at once");
    }
    // A list that was written before anybody was asked.
    let list = serde_json::json!({ "version": 1, "entries": [{ "path": volume, "project": false, "when": 7 }] });
    std::fs::write(state.join("recent.json"), list.to_string()).unwrap();
    assert_eq!(Recent::kept_in(state).entries()[0].open_as, None);
}

#[test]
fn one_click_opens_the_sample() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = started(dir.path());
    let sent = window.click("Open the sample head");
    let [Command::Volume(VolumeCommand::Open { path, .. })] = &sent[..] else { panic!("{sent:?}") };
    assert!(path.starts_with(dir.path()) && std::fs::metadata(path).unwrap().len() > 3_000_000);
    for step in ["Select", "Split", "Slide"] {
        assert!(window.harness.query_by_label(step).is_some(), "{step}");
    }
}

#[test]
fn the_first_steps_are_there_on_the_sample_and_done_by_a_click() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = started(dir.path());
    let [open] = &window.click("Open the sample head")[..] else { panic!("nothing is opened") };
    let open = open.clone();
    window.snapshot(|_| {});
    window.report(done(open.clone()));
    let selected = serde_json::to_value(window.click("Select the brain")).unwrap();
    let brain = selected[0]["selection"]["import"]["path"].as_str().unwrap();
    assert!(std::fs::metadata(brain).unwrap().len() > 1_000_000);
    let split = serde_json::to_value(window.click("Split the head")).unwrap();
    let normals: Vec<_> = (0..3).map(|i| split[i]["part"]["split"]["by"]["plane"]["normal"].clone()).collect();
    assert_eq!(serde_json::json!(normals), serde_json::json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
    let slid = serde_json::to_value(window.click("Slide the parts apart")).unwrap();
    assert_eq!(slid[0]["explosion"]["degree"]["value"], 1.0);
    window.click("Close the first steps");
    assert!(window.harness.query_by_label("Select the brain").is_none());
    // Another volume is no lesson.
    window.report(done(open));
    assert!(window.harness.query_by_label("Select the brain").is_some());
    window.report(done(self::open(Path::new("/data/head.nii"))));
    assert!(window.harness.query_by_label("Select the brain").is_none());
}

#[test]
fn a_step_that_is_clicked_early_does_those_before_it() {
    let dir = tempfile::tempdir().unwrap();
    for (click, wanted) in [
        ("Slide the parts apart", &["selection", "part", "part", "part", "view", "explosion"][..]),
        ("Split the head", &["selection", "part", "part", "part", "view"]),
    ] {
        let mut window = started(dir.path());
        let [open] = &window.click("Open the sample head")[..] else { panic!("nothing is opened") };
        let open = open.clone();
        window.snapshot(|_| {});
        window.report(done(open));
        let nouns = |sent: Vec<Command>| -> Vec<String> {
            let nouns =
                sent.iter().map(|c| serde_json::to_value(c).unwrap().as_object().unwrap().keys().next().cloned());
            nouns.map(Option::unwrap).collect()
        };
        let first = window.click(click);
        assert_eq!(nouns(first), wanted, "{click}");
        assert_eq!(nouns(window.click("Select the brain")), ["selection"], "again, for itself");
        assert_eq!(nouns(window.click("Slide the parts apart")), ["explosion"], "and those before it no more");
    }
}

#[test]
fn a_wrong_volume_of_a_project_leaves_what_was_typed() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = started(dir.path());
    let offer = || {
        let then = Then::FindSource("/data/h.burin".into());
        Report::Offer(Box::new(Offer { title: "Not there".into(), text: "missing (os error 2)".into(), then }))
    };
    window.report(offer());
    window.click("Find the file…");
    window.harness.get_by_label("Path").type_text("/moved/head.nii");
    window.harness.run_steps(2);
    let sent = window.key(Modifiers::NONE, egui::Key::Enter);
    let wanted =
        serde_json::json!([{ "project": { "open": { "path": "/data/h.burin", "source": "/moved/head.nii" } } }]);
    assert_eq!(serde_json::to_value(&sent).unwrap(), wanted);
    window.report(offer());
    window.report(Report::Refused(Box::new(sent[0].clone()), "another".into()));
    assert!(window.harness.query_by_label("another").is_some());
    assert_eq!(window.harness.get_by_label("Path").value().as_deref(), Some("/moved/head.nii"));
}

#[test]
fn a_name_is_typed_over_the_one_that_is_offered_and_keeps_the_ending() {
    let mut window = Window::open(SMALL);
    window.key(Modifiers::COMMAND | Modifiers::SHIFT, egui::Key::S);
    assert_eq!(window.harness.get_by_label("Path").value().as_deref(), Some("small.burin"));
    window.harness.event(egui::Event::Text("left ear".into()));
    window.harness.run_steps(2);
    assert_eq!(window.harness.get_by_label("Path").value().as_deref(), Some("left ear.burin"));
}

#[test]
fn what_was_opened_and_saved_is_listed() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = started(dir.path());
    window.report(done(open(Path::new("/data/head.nii"))));
    let save = Command::Project(ProjectCommand::Save { path: Some("/data/head.burin".into()), density: None });
    window.report(saved(save, Some("/data/head.burin")));
    let listed: Vec<(PathBuf, bool)> =
        Recent::kept_in(dir.path().into()).entries().iter().map(|s| (s.path.clone(), s.project)).collect();
    assert_eq!(listed, [("/data/head.burin".into(), true), ("/data/head.nii".into(), false)]);
}

#[test]
fn a_path_that_failed_comes_back_with_the_reason() {
    let dir = tempfile::tempdir().unwrap();
    let bad = dir.path().join("bad.nii");
    std::fs::write(&bad, "x").unwrap();
    let mut window = started(dir.path());
    window.key(Modifiers::COMMAND, egui::Key::O);
    window.harness.get_by_label("Path").type_text(bad.to_str().unwrap());
    window.harness.run_steps(2);
    window.harness.key_press_modifiers(Modifiers::NONE, egui::Key::Enter);
    let sent = sent_in_time(&mut window);
    assert_eq!(sent, [open(&bad)]);
    assert!(window.harness.query_by_label("Path").is_none(), "meanwhile the window is free");
    window.report(Report::Refused(Box::new(sent[0].clone()), "bad.nii: it is empty (os error 5)".into()));
    assert_eq!(window.harness.get_by_label("Path").value().as_deref(), bad.to_str(), "what was typed is there");
    assert!(window.harness.query_by_label("bad.nii: it is empty").is_some(), "in words alone");
    assert!(window.harness.query_by_label_contains("Messages").is_none(), "it is said once");
    // Once more, and this time it works: nothing is left of it.
    window.harness.key_press_modifiers(Modifiers::NONE, egui::Key::Enter);
    assert_eq!(sent_in_time(&mut window), sent);
    window.report(done(sent[0].clone()));
    window.report(Report::Refused(Box::new(sent[0].clone()), "of another way in".into()));
    assert!(window.harness.query_by_label("Path").is_none());
}

#[test]
fn a_save_that_failed_on_the_way_out_still_closes_once_it_works() {
    let mut window = Window::open(SMALL);
    window.snapshot(|s| s.unsaved = true);
    let viewport = window.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    viewport.events.push(egui::ViewportEvent::Close);
    window.harness.run_steps(2);
    window.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default().events.clear();
    window.key(Modifiers::NONE, egui::Key::Enter);
    let sent = window.key(Modifiers::NONE, egui::Key::Enter);
    assert!(matches!(&sent[..], [Command::Project(ProjectCommand::Save { path: Some(_), .. })]), "{sent:?}");
    window.report(Report::Refused(Box::new(sent[0].clone()), "the disk is full".into()));
    assert!(window.harness.query_by_label("the disk is full").is_some());
    let again = window.key(Modifiers::NONE, egui::Key::Enter);
    assert_eq!(again, sent, "the same place once more");
    window.worker_end.reports.send(done(again[0].clone())).unwrap();
    window.harness.step();
    let output = &window.harness.output().viewport_output[&egui::ViewportId::ROOT];
    assert!(output.commands.contains(&egui::ViewportCommand::Close));
}

#[test]
fn what_was_written_is_said_with_a_way_to_it() {
    let mut window = Window::open(SMALL);
    for (command, said) in [
        (image("/data/view 1.png"), "Saved picture view 1.png"),
        (
            Command::Volume(VolumeCommand::Export {
                field: FieldKind::Labels,
                label: None,
                path: "/data/l.nrrd".into(),
                volume: None,
            }),
            "Exported labels to l.nrrd",
        ),
        (
            Command::Project(ProjectCommand::Save { path: Some("/data/h.burin".into()), density: None }),
            "Saved project h.burin",
        ),
    ] {
        window.report(done(command));
        assert!(window.harness.query_by_label(said).is_some(), "{said}");
    }
    window.harness.get_by_label("Copy the path of what was written").click();
    window.harness.step();
    let copied = window.harness.output().platform_output.commands.clone();
    window.harness.run_steps(2);
    let commands = [copied, window.harness.output().platform_output.commands.clone()].concat();
    assert!(
        commands.iter().any(|c| matches!(c, OutputCommand::CopyText(text) if text == "/data/h.burin")),
        "{commands:?}"
    );
    assert!(window.harness.query_by_label("Saved project h.burin").is_none(), "it goes");
    window.click("Messages");
    assert!(window.harness.query_by_label("Saved picture view 1.png").is_some(), "and is kept in the list");
}

#[test]
fn a_short_word_goes_by_itself_and_lies_over_no_control() {
    for size in [[900.0, 600.0], SMALL] {
        let mut window = Window::open(size);
        let save = Command::Project(ProjectCommand::Save { path: Some("/data/h.burin".into()), density: None });
        window.report(done(save));
        let word = window.harness.get_by_label("Saved project h.burin").rect();
        for name in ["Open", "Brush radius", "Axial slice", "Sagittal slice", "Step 1: Stroke", "Degree of explosion"] {
            let control = window.harness.query_by_label(name).map(|c| c.rect());
            assert!(control.is_none_or(|c| !c.intersects(word)), "{name} lies under {word:?} in {size:?}");
        }
        let steps = (9.0 / f64::from(window.harness.input_mut().predicted_dt)).ceil() as usize;
        window.harness.run_steps(steps);
        assert!(window.harness.query_by_label("Saved project h.burin").is_none());
    }
}

#[test]
fn an_error_goes_with_its_cause() {
    let mut window = Window::open(SMALL);
    let image = image("/data/v.png");
    window.report(Report::Refused(Box::new(image), "/data/v.png: the disk is full (os error 28)".into()));
    window.report(Report::Message(Severity::Warning, "something else".into()));
    assert!(window.harness.query_by_label("/data/v.png: the disk is full").is_some());
    window.report(Report::Mended("project.save".into()));
    assert!(window.harness.query_by_label("/data/v.png: the disk is full").is_some());
    window.report(Report::Mended("render.image".into()));
    assert!(window.harness.query_by_label("/data/v.png: the disk is full").is_none());
    assert!(window.harness.query_by_label("something else").is_some());
}

#[test]
fn a_warning_is_shown_and_words_stand_above_each_other() {
    let mut window = Window::open(SMALL);
    window.report(Report::Message(Severity::Warning, "it covers a third of the volume (os error 1)".into()));
    window.report(done(image("/data/a.png")));
    let warning = window.harness.get_by_label("it covers a third of the volume").rect();
    let word = window.harness.get_by_label("Saved picture a.png").rect();
    assert!(warning.bottom() < word.top(), "{warning:?} {word:?}");
    window.report(Report::Message(Severity::Warning, "it covers a third of the volume (os error 1)".into()));
    assert_eq!(
        window.harness.query_all_by_label("it covers a third of the volume").count(),
        1,
        "the same is said once"
    );
    for i in 0..5 {
        window.report(done(image(&format!("/data/{i}.png"))));
    }
    let words = window.harness.query_all_by_label_contains("Saved picture").count();
    assert!(words <= 3, "{words} at once");
}

#[test]
fn names_break_no_line() {
    let mut window = Window::open(SMALL);
    window.snapshot(|s| s.project = Some("/data/two\nlines.burin".into()));
    assert!(window.harness.query_by_label("two\\nlines.burin").is_some());
    window.report(Report::Message(Severity::Error, "two\nlines: it is not there (os error 2)".into()));
    assert!(window.harness.query_by_label("two\\nlines: it is not there").is_some());
    window.report(done(image("/data/a\tb.png")));
    assert!(window.harness.query_by_label("Saved picture a\\tb.png").is_some());
}

#[test]
fn a_path_and_enter_within_one_slow_frame_are_taken_in_their_order() {
    let dir = tempfile::tempdir().unwrap();
    let mut window = started(dir.path());
    window.key(Modifiers::COMMAND, egui::Key::O);
    let key =
        |key| egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    let text = |text: &str| egui::Event::Text(text.into());
    let path = "/nowhere/head.nii";
    window.harness.input_mut().events.extend([text("/nowhere/"), text("head.nii"), key(egui::Key::Enter)]);
    window.harness.step();
    window.harness.run_steps(3);
    assert_eq!(window.sent(), [open(Path::new(path))]);
}

#[test]
fn a_list_that_was_emptied_stays_closed_until_something_goes_wrong() {
    for empty in ["Dismiss all", "Dismiss message 1"] {
        let mut window = Window::open(SMALL);
        window.report(Report::Message(Severity::Error, "one".into()));
        let open = |w: &Window| w.harness.query_by_label_contains("Messages (").is_some();
        assert!(open(&window));
        window.click(empty);
        assert!(!open(&window));
        window.report(done(image("/data/a.png")));
        assert!(!open(&window), "a word is enough for what went well");
        window.report(Report::Message(Severity::Error, "two".into()));
        assert!(open(&window));
    }
}

#[test]
fn a_warning_begins_as_a_sentence_does() {
    for (said, shown) in [
        ("the file covers 13 % of the volume", "The file covers 13 % of the volume"),
        ("head.nii: it is not there", "head.nii: it is not there"),
        ("76 labels got no voxel", "76 labels got no voxel"),
        ("ölpest is a name", "ölpest is a name"),
        ("", ""),
    ] {
        assert_eq!(burin::interact::readout::sentence(said), shown);
    }
}

#[test]
fn ways_to_a_file_stand_behind_what_is_said_of_it() {
    let mut window = Window::open(SMALL);
    window.report(Report::Message(Severity::Error, "one".into()));
    window.report(done(image("/data/a.png")));
    let (text, way) = (window.rect("Saved picture a.png"), window.rect("Show message 2 in its folder"));
    assert!(text.right() <= way.left() && (text.center().y - way.center().y).abs() < 2.0, "{text:?} {way:?}");
}

#[test]
fn a_projects_first_file_stands_for_its_folder() {
    let dir = tempfile::tempdir().unwrap();
    let project = dir.path().join("head.burin");
    std::fs::create_dir(&project).unwrap();
    std::fs::write(project.join("project.json"), "{}").unwrap();
    for named in [project.clone(), project.join("project.json")] {
        let mut window = started(dir.path());
        window.key(Modifiers::COMMAND, egui::Key::O);
        window.harness.get_by_label("Path").type_text(named.to_str().unwrap());
        window.harness.run_steps(2);
        window.harness.key_press_modifiers(Modifiers::NONE, egui::Key::Enter);
        let sent = serde_json::to_value(sent_in_time(&mut window)).unwrap();
        assert_eq!(sent, serde_json::json!([{ "project": { "open": { "path": project } } }]), "{named:?}");
    }
}

#[test]
fn words_wait_until_a_question_is_answered() {
    let mut window = Window::open(SMALL);
    window.key(Modifiers::COMMAND, egui::Key::O);
    window.report(done(image("/data/a.png")));
    let second = (1.0 / f64::from(window.harness.input_mut().predicted_dt)).ceil() as usize;
    window.harness.run_steps(9 * second);
    assert!(window.harness.query_by_label("Saved picture a.png").is_none(), "not over the question");
    window.key(Modifiers::NONE, egui::Key::Escape);
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label("Saved picture a.png").is_some(), "afterwards for their time");
    window.harness.run_steps(9 * second);
    assert!(window.harness.query_by_label("Saved picture a.png").is_none());
}

#[test]
fn imports_that_failed_come_back_with_the_reason() {
    for (entry, import) in [("Import labels…", "segment"), ("Import selection…", "selection")] {
        let mut window = Window::open(SMALL);
        window.click("More…");
        window.click(entry);
        window.harness.get_by_label("Path").type_text("/nowhere/mask.nrrd");
        window.harness.run_steps(2);
        let sent = window.key(Modifiers::NONE, egui::Key::Enter);
        let wanted = serde_json::json!({ import: { "import": { "path": "/nowhere/mask.nrrd" } } });
        assert_eq!(sent, [serde_json::from_value::<Command>(wanted).unwrap()]);
        assert!(window.harness.query_by_label("Path").is_none());
        window.report(Report::Refused(Box::new(sent[0].clone()), "it is not there".into()));
        assert_eq!(window.harness.get_by_label("Path").value().as_deref(), Some("/nowhere/mask.nrrd"), "{entry}");
        assert!(window.harness.query_by_label("it is not there").is_some(), "{entry}");
    }
}
