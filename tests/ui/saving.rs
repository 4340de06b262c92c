//! Saving, what waits for it, and what a crash left.

use super::driver::{SMALL, Window};
use super::replies;
use super::replies::{recovered, saved};
use burin::document::{Command, DensityKeeping, ProjectCommand, VolumeCommand};
use burin::ui::{Report, Severity};
use egui::{Modifiers, ViewportCommand, ViewportEvent, ViewportId};
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A window with unsaved work, in a project if one is named.
fn unsaved(project: Option<&str>) -> Window {
    let mut window = Window::open(SMALL);
    told(&mut window, project, true);
    window
}

fn told(window: &mut Window, project: Option<&str>, unsaved: bool) {
    window.snapshot(|s| {
        s.unsaved = unsaved;
        s.project = project.map(PathBuf::from);
    });
}

fn close(window: &mut Window) {
    let viewport = window.harness.input_mut().viewports.entry(ViewportId::ROOT).or_default();
    viewport.events.push(ViewportEvent::Close);
    window.harness.run_steps(3);
    let viewport = window.harness.input_mut().viewports.entry(ViewportId::ROOT).or_default();
    viewport.events.clear();
    window.harness.run_steps(2);
}

fn save(path: Option<&str>) -> Command {
    let density: Option<DensityKeeping> = None;
    Command::Project(ProjectCommand::Save { path: path.map(PathBuf::from), density })
}

/// The save is done; answers whether the window closes, and what it asks for next.
fn done(window: &mut Window, command: Command) -> (bool, Vec<Command>) {
    window.worker_end.reports.send(saved(command, None)).unwrap();
    let mut closes = false;
    for _ in 0..3 {
        window.harness.step();
        let output = &window.harness.output().viewport_output[&ViewportId::ROOT];
        closes |= output.commands.contains(&ViewportCommand::Close);
    }
    (closes, window.sent())
}

#[test]
fn a_window_with_unsaved_work_closes_once_it_is_saved() {
    let mut window = unsaved(Some("/data/head.burin"));
    close(&mut window);
    assert!(window.harness.query_by_label_contains("Save before closing?").is_some());
    let sent = window.key(Modifiers::NONE, egui::Key::Enter);
    assert_eq!(sent, [save(None)], "Enter is the button that loses nothing");
    // What would be done now would be lost.
    assert_eq!(window.key(Modifiers::NONE, egui::Key::Num3), []);
    assert_eq!(done(&mut window, save(None)), (true, vec![]));
}

#[test]
fn a_save_that_was_given_up_closes_nothing_later() {
    let mut window = unsaved(None);
    close(&mut window);
    window.key(Modifiers::NONE, egui::Key::Enter);
    assert!(window.harness.query_by_label("Path").is_some(), "where is asked");
    window.key(Modifiers::NONE, egui::Key::Escape);
    told(&mut window, Some("/data/head.burin"), true);
    assert_eq!(window.key(Modifiers::COMMAND, egui::Key::S), [save(None)]);
    assert_eq!(done(&mut window, save(None)), (false, vec![]));

    close(&mut window);
    window.key(Modifiers::NONE, egui::Key::Enter);
    window.report(Report::Message(Severity::Error, "the disk is full".into()));
    assert!(window.harness.query_by_label_contains("Saving head.burin").is_none(), "the window can be used again");
    assert_eq!(window.key(Modifiers::COMMAND, egui::Key::S), [save(None)]);
    assert_eq!(done(&mut window, save(None)), (false, vec![]));
}

#[test]
fn what_is_opened_over_unsaved_work_waits_for_the_save() {
    for project in [None, Some("/data/head.burin")] {
        let mut window = unsaved(project);
        assert_eq!(window.key(Modifiers::COMMAND, egui::Key::O), []);
        window.harness.get_by_label("Path").type_text("/data/other.nii");
        window.harness.run_steps(2);
        assert_eq!(window.key(Modifiers::NONE, egui::Key::Enter), []);
        assert!(window.harness.query_by_label_contains("Save before other.nii is opened?").is_some());
        let mut sent = window.key(Modifiers::NONE, egui::Key::Enter);
        if project.is_none() {
            assert_eq!(sent, []);
            sent = window.key(Modifiers::NONE, egui::Key::Enter);
            assert!(matches!(&sent[..], [Command::Project(ProjectCommand::Save { path: Some(_), .. })]), "{sent:?}");
        } else {
            assert_eq!(sent, [save(None)]);
        }
        let (closes, next) = done(&mut window, sent.remove(0));
        assert!(!closes);
        assert!(
            matches!(&next[..], [Command::Volume(VolumeCommand::Open { path, .. })] if path == Path::new("/data/other.nii")),
            "{next:?}"
        );
    }
}

#[test]
fn what_a_crash_left_is_said() {
    let mut window = Window::open(SMALL);
    let open =
        Command::Project(ProjectCommand::Open { path: "/data/head.burin".into(), source: None, generation: None });
    window.report(recovered(open, 2));
    let said = "What was not saved when the program ended was brought back, \
        and the stroke that was running as far as it had come. Save to keep it.";
    assert!(window.harness.query_by_label(said).is_some());
    // Until it is saved, or something else is open.
    let other: Command = serde_json::from_value(serde_json::json!({"volume":{"open":{"path":"/data/b.nii"}}})).unwrap();
    for then in [save(None), other] {
        let open =
            Command::Project(ProjectCommand::Open { path: "/data/head.burin".into(), source: None, generation: None });
        window.report(recovered(open, 2));
        assert!(window.harness.query_by_label(said).is_some());
        window.report(replies::done(then));
        assert!(window.harness.query_by_label(said).is_none());
    }

    let mut window = Window::empty(SMALL);
    window.report(replies::lost(&[("1-a", "/data/head.nii.gz")], Duration::from_secs(7500)));
    assert!(window.harness.query_by_label("2 hours ago").is_some());
    let recover = Command::Project(ProjectCommand::Recover { id: "1-a".into() });
    assert_eq!(window.click("Recover head.nii.gz"), [recover]);
}

/// What a crash left of two files.
fn lost(window: &mut Window) {
    let left = [("1-a", "/data/head.nii.gz"), ("2-b", "/data/skull.nrrd")];
    window.report(replies::lost(&left, Duration::ZERO));
}

#[test]
fn what_a_crash_left_replaces_unsaved_work_only_after_a_question() {
    let mut window = Window::open(SMALL);
    let recover = |id: &str| Command::Project(ProjectCommand::Recover { id: id.into() });
    lost(&mut window);
    assert_eq!(window.click("Recover skull.nrrd"), [recover("2-b")], "nothing to lose: at once");
    window.snapshot(|s| {
        s.unsaved = true;
        s.project = Some("/data/other.burin".into());
    });
    lost(&mut window);
    assert_eq!(window.click("Recover skull.nrrd"), []);
    assert!(window.harness.query_by_label("Save before skull.nrrd is opened?").is_some());
    assert_eq!(window.click("Cancel"), []);
    lost(&mut window);
    window.click("Recover skull.nrrd");
    assert_eq!(window.click("Discard changes"), [recover("2-b")]);
    lost(&mut window);
    window.click("Recover head.nii.gz");
    assert_eq!(window.key(Modifiers::NONE, egui::Key::Enter), [save(None)]);
    assert_eq!(done(&mut window, save(None)), (false, vec![recover("1-a")]), "once all is on disk");
}

#[test]
fn what_a_crash_left_is_thrown_away_by_the_second_click_only() {
    let mut window = Window::empty(SMALL);
    lost(&mut window);
    assert_eq!(window.click("Throw away head.nii.gz"), []);
    let forget = Command::Project(ProjectCommand::Forget { id: "1-a".into() });
    assert_eq!(window.click("Throw away head.nii.gz for good"), [forget]);
    assert!(window.harness.query_by_label("Throw away skull.nrrd").is_some(), "the other one stays");
    assert!(window.harness.query_by_label("Throw away head.nii.gz for good").is_none());
}

#[test]
fn what_a_crash_left_may_be_decided_later() {
    let mut window = Window::open(SMALL);
    lost(&mut window);
    assert!(window.harness.query_by_label("Recover skull.nrrd").is_some());
    assert_eq!(window.click("Decide later"), [], "nothing is thrown away");
    assert!(window.harness.query_by_label("Recover skull.nrrd").is_none());
}
