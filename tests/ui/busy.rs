//! What takes its time: named, measured, stopped.

use super::driver::{SMALL, Window};
use crate::document::maker::labelled;
use burin::document::{Command, VolumeCommand};
use burin::ui::{Gravity, Report, Request, spawn};
use egui_kittest::kittest::{NodeT, Queryable};
use std::time::{Duration, Instant};

#[test]
fn work_that_takes_its_time_is_named_while_it_runs() {
    let mut window = Window::open(SMALL);
    window.report(Report::Started("Saving".into()));
    assert!(window.harness.query_by_label_contains("Saving").is_some());
    window.report(Report::Finished);
    assert!(window.harness.query_by_label_contains("Saving").is_none());
}

#[test]
fn what_tells_how_far_it_is_can_be_stopped() {
    let mut window = Window::open(SMALL);
    window.report(Report::Started("Saving".into()));
    assert!(window.harness.query_by_label("Cancel").is_none(), "nobody would hear it");
    window.report(Report::Progress(42));
    assert!(window.harness.query_by_label_contains("Saving  42 %").is_some());
    assert!(!window.far.stop.is_set());
    window.click("Cancel");
    assert!(window.far.stop.is_set());
    assert!(window.harness.get_by_label("Cancel").accesskit_node().is_disabled());
    window.report(Report::Finished);
    assert!(window.harness.query_by_label("Cancel").is_none());
}

#[test]
fn a_stopped_opening_leaves_open_what_was() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("large.nrrd");
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 256 256 160\nencoding: raw\n\n".to_vec();
    bytes.extend((0..256 * 256 * 160).map(|i| (i % 251) as u8));
    std::fs::write(&path, bytes).unwrap();
    let (mut session, thread) = spawn(labelled(), egui::Context::default()).unwrap();
    let open = VolumeCommand::Open { path, component: 0, frame: 0, range: None };
    assert!(session.send(Request::Apply(Command::Volume(open))));
    let (mut told, mut notes, mut name) = (Vec::new(), Vec::new(), String::new());
    let begun = Instant::now();
    while notes.is_empty() || name.is_empty() {
        for report in session.reports() {
            match report {
                Report::Progress(percent) => {
                    session.stop();
                    told.push(percent);
                }
                Report::Message(gravity, text) => notes.push((gravity, text)),
                Report::Snapshot(s) => name = s.open.as_ref().unwrap().scene.origin.path.display().to_string(),
                Report::Done(..) => panic!("it was done to its end"),
                _ => {}
            }
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "{told:?} {notes:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(told.is_sorted() && told.last() < Some(&100), "{told:?}");
    assert!(matches!(&notes[..], [(Gravity::Note, text)] if text.contains("stopped on request")), "{notes:?}");
    assert_eq!(name, "ramp.nrrd");
    session.send(Request::Quit);
    thread.join().unwrap();
}
