//! What takes its time: named, measured, stopped.

use super::driver::{SMALL, Window};
use crate::document::maker::labelled;
use burin::document::{Command, HistoryCommand, VolumeCommand, Watch};
use burin::ui::{Report, Request, Severity, spawn};
use egui_kittest::kittest::{NodeT, Queryable};
use std::sync::{Arc, Mutex};
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
    assert!(!window.worker_end.stop.is_set());
    window.click("Cancel");
    assert!(window.worker_end.stop.is_set());
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
    let open = VolumeCommand::Open { path, component: 0, frame: 0, range: None, open_as: Default::default() };
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
                Report::Message(severity, text) => notes.push((severity, text)),
                Report::Snapshot(s) => {
                    name = s.open.as_ref().unwrap().scene.origin().unwrap().path.display().to_string()
                }
                Report::Done(..) => panic!("it was done to its end"),
                _ => {}
            }
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "{told:?} {notes:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(told.is_sorted() && told.last() < Some(&100), "{told:?}");
    assert!(matches!(&notes[..], [(Severity::Note, text)] if text.contains("stopped on request")), "{notes:?}");
    assert_eq!(name, "ramp.nrrd");
    session.send(Request::Quit);
    thread.join().unwrap();
}

#[test]
fn what_is_over_at_once_is_not_worth_a_word() {
    let mut window = Window::open(SMALL);
    window.worker_end.reports.send(Report::Started("Undoing".into())).unwrap();
    // A frame of the harness is a quarter of a second.
    window.harness.run_steps(1);
    assert!(window.harness.query_by_label_contains("Undoing").is_none());
    window.harness.run_steps(2);
    assert!(window.harness.query_by_label_contains("Undoing").is_some());
}

#[test]
fn a_jump_over_many_steps_tells_how_far_it_is_and_stops_between_two() {
    let mut document = labelled();
    for id in 1..=6 {
        let name = Some(format!("Part {id}"));
        let set = burin::document::SegmentCommand::Set {
            id,
            name,
            colour: None,
            visible: None,
            locked: None,
            look: None,
            volume: None,
        };
        document.apply(Command::Segment(set)).unwrap();
    }
    let told = Arc::new(Mutex::new(Vec::new()));
    let listener = told.clone();
    document.set_watch(Watch::new(move |share| {
        listener.lock().unwrap().push(share);
        share < 0.45
    }));
    let answer = document.apply(Command::History(HistoryCommand::Undo { steps: 5 })).unwrap().to_json().unwrap();
    assert_eq!(answer["undone"].as_array().unwrap().len(), 3, "{answer}");
    assert_eq!(*told.lock().unwrap(), [0.0, 0.2, 0.4, 0.6]);
    assert!(answer["warning"].to_string().contains("after 3 of 5 steps"), "{answer}");
    // One step is whole or not at all.
    let answer = document.apply(Command::History(HistoryCommand::Redo { steps: 1 })).unwrap().to_json().unwrap();
    assert_eq!((answer["redone"].as_array().unwrap().len(), told.lock().unwrap().len()), (1, 4), "{answer}");
}
