//! The document's thread: what it names while it works, what it says once, and what it leaves when the window is closed.

use crate::document::maker::{labelled, write_nrrd};
use burin::document::{Command, Document, recovery};
use burin::math::DVec3;
use burin::ui::{Report, Request, Session, spawn};
use burin::volume::Grid;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

struct Desk {
    session: Session,
    thread: JoinHandle<()>,
    reports: Vec<Report>,
}

impl Desk {
    fn new(document: Document) -> Self {
        let (session, thread) = spawn(document, egui::Context::default()).unwrap();
        Self { session, thread, reports: Vec::new() }
    }

    fn apply(&mut self, line: &Value) {
        let command: Command = serde_json::from_value(line.clone()).unwrap();
        assert!(self.session.send(Request::Apply(command)));
    }

    /// Gathers reports until one is so.
    fn until(&mut self, what: &str, so: impl Fn(&Report) -> bool) {
        let begun = Instant::now();
        loop {
            let fresh: Vec<Report> = self.session.reports();
            let done = fresh.iter().any(&so);
            self.reports.extend(fresh);
            if done {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "waited in vain until {what}: {:?}", self.reports);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Does a command to its end: a segment of this id is there then.
    fn settle(&mut self, id: u16) {
        self.apply(&json!({"segment":{"set":{"id":id}}}));
        let there = |r: &Report| match r {
            Report::Snapshot(s) => s.open.as_ref().is_some_and(|o| o.scene.segments().get(id).is_some()),
            _ => false,
        };
        self.until("the segment is there", there);
    }

    fn quit(mut self) {
        self.session.send(Request::Quit);
        self.thread.join().unwrap();
    }
}

fn volume(folder: &Path, name: &str, value: impl Fn([u32; 3]) -> f32) -> PathBuf {
    let path = folder.join(name);
    write_nrrd(&path, &Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO), value);
    path
}

#[test]
fn whatever_may_take_its_time_is_named_with_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = volume(folder.path(), "v.nrrd", |v| f32::from(v[0] > 3));
    let mut desk = Desk::new(labelled());
    for (line, named) in [
        (json!({"volume":{"export":{"field":"labels","path":folder.path().join("out.nrrd")}}}), "Exporting out.nrrd"),
        (json!({"project":{"save":{"path":folder.path().join("p.burin")}}}), "Saving"),
        (json!({"segment":{"remove":{"id":2}}}), "Removing a segment"),
        (json!({"selection":{"from_label":{"label":1}}}), "Selecting"),
        (json!({"history":{"undo":{}}}), "Undoing"),
        (json!({"history":{"redo":{}}}), "Redoing"),
        (json!({"volume":{"open":{"path":file}}}), "Opening v.nrrd"),
        (json!({"segment":{"import":{"path":file}}}), "Importing segments"),
        (json!({"project":{"open":{"path":folder.path().join("p.burin")}}}), "Opening p.burin"),
    ] {
        desk.reports.clear();
        desk.apply(&line);
        desk.until(named, |r| matches!(r, Report::Finished));
        let begun = desk.reports.iter().filter_map(|r| match r {
            Report::Started(what) => Some(what.as_str()),
            _ => None,
        });
        assert_eq!(begun.collect::<Vec<_>>(), [named]);
    }
    desk.quit();
}

#[test]
fn a_complaint_goes_once_when_its_command_works() {
    let mut desk = Desk::new(labelled());
    desk.apply(&json!({"segment":{"set":{"id":0}}}));
    desk.until("it is refused", |r| matches!(r, Report::Refused(..)));
    for id in [5, 6, 7] {
        desk.settle(id);
    }
    let mended: Vec<_> = desk.reports.iter().filter(|r| matches!(r, Report::Mended(_))).collect();
    assert!(matches!(mended[..], [Report::Mended(topic)] if topic == "segment.set"), "{mended:?}");
    desk.quit();
}

#[test]
fn the_histogram_that_is_shown_is_that_of_the_open_volume() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = Desk::new(Document::new());
    for (name, scale) in [("a.nrrd", 1.0), ("b.nrrd", 100.0), ("a.nrrd", 1.0)] {
        let path = volume(folder.path(), name, |v| v[0] as f32 * scale);
        desk.apply(&json!({"volume":{"open":{"path":path}}}));
        let shown = |r: &Report| match r {
            Report::Snapshot(s) => s.open.as_ref().is_some_and(|o| o.scene.origin().unwrap().path == path),
            _ => false,
        };
        desk.until(name, shown);
        let Some(Report::Snapshot(snapshot)) = desk.reports.iter().rfind(|r| shown(r)) else { panic!("{name}") };
        let histogram = &snapshot.open.as_ref().unwrap().histogram;
        let width = (histogram.max - histogram.min) / histogram.bins.len() as f64;
        assert!((histogram.max - 11.0 * f64::from(scale)).abs() <= 2.0 * width, "{name}: up to {}", histogram.max);
    }
    desk.quit();
}

#[test]
fn a_window_that_is_closed_leaves_nothing_to_recover_and_one_that_vanishes_leaves_all() {
    for closed in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let states = folder.path().join("states");
        let path = volume(folder.path(), "v.nrrd", |v| v[0] as f32);
        let mut document = Document::new();
        document.keep_unsaved_in(states.clone());
        let mut desk = Desk::new(document);
        desk.apply(&json!({"volume":{"open":{"path":path}}}));
        desk.settle(7);
        assert!(std::fs::read_dir(&states).unwrap().next().is_some(), "it is kept while it is open");
        if closed {
            desk.quit();
        } else {
            let Desk { session, thread, .. } = desk;
            drop(session);
            thread.join().unwrap();
        }
        assert_eq!(recovery::list(&states).unwrap().len(), usize::from(!closed));
    }
}
