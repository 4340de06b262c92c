//! What went wrong reaches the window with a way out, and a failure on the document's thread ends neither the window nor the work.

use crate::common::one::One;
use crate::common::volumes::Watched;
use crate::document::maker::{run, write_nrrd};
use burin::document::{Command, Document, Origin, ProjectCommand, State};
use burin::math::DVec3;
use burin::ui::{Offer, Report, Request, Session, Severity, Snapshot, Then, spawn};
use burin::volume::*;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long a loaded machine may take for one thing.
const PATIENCE: Duration = Duration::from_secs(60);

/// A document whose source fails on demand as no source may.
fn brittle(dir: &Path) -> (Document, Arc<AtomicBool>) {
    let origin = Origin { path: dir.join("v.nrrd"), component: 0, frame: 0 };
    let grid = Grid::aligned([8; 3], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&origin.path, &grid, |_| 0.0);
    let broken = Arc::new(AtomicBool::new(false));
    let memory = MemorySource::new("brittle", grid, Voxels::F32(vec![0.5; 512]), (1.0, 0.0)).unwrap();
    let breaks = broken.clone();
    let source = Arc::new(Watched(memory, move |_, _| {
        assert!(!breaks.load(Ordering::Relaxed), "the source broke");
        Ok(())
    }));
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let histogram = Histogram { min: 0.0, max: 1.0, bins: vec![512], ..Histogram::default() };
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("states"));
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    (document, broken)
}

struct Desk {
    session: Session,
    now: Arc<Snapshot>,
    said: Vec<(Severity, String)>,
    offers: Vec<Offer>,
    done: u64,
}

impl Desk {
    fn new(document: Document) -> (Self, std::thread::JoinHandle<()>) {
        let (session, thread) = spawn(document, egui::Context::default()).unwrap();
        let desk = Self { session, now: Arc::default(), said: Vec::new(), offers: Vec::new(), done: 0 };
        (desk, thread)
    }

    fn apply(&mut self, command: Command) {
        assert!(self.session.send(Request::Apply(command)), "the thread is gone");
    }

    fn line(&mut self, line: &serde_json::Value) {
        self.apply(serde_json::from_value(line.clone()).unwrap());
    }

    fn until(&mut self, what: &str, so: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !so(self) {
            for report in self.session.reports() {
                match report {
                    Report::Snapshot(snapshot) => self.now = snapshot,
                    Report::Message(severity, text) => self.said.push((severity, text)),
                    Report::Offer(offer) => self.offers.push(*offer),
                    Report::Done(..) => self.done += 1,
                    _ => {}
                }
            }
            assert!(begun.elapsed() < PATIENCE, "waited in vain until {what}: {:?}", self.said);
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

#[test]
fn a_failure_on_the_documents_thread_is_an_error_in_the_window_and_the_work_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let (mut document, broken) = brittle(dir.path());
    let project = dir.path().join("p");
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let (mut desk, thread) = Desk::new(document);
    desk.line(&json!({"segment":{"set":{"id":7,"name":"jaw"}}}));
    desk.until("the step is done", |d| d.now.serial == 1 && d.now.unsaved);
    broken.store(true, Ordering::Relaxed);
    desk.line(&json!({"volume":{"export":{"field":"density","path":dir.path().join("out.nrrd")}}}));
    desk.until("the failure is told", |d| !d.offers.is_empty());
    let (severity, text) = desk.said.last().unwrap();
    assert_eq!(*severity, Severity::Error);
    assert!(text.contains("has failed: ") && text.contains("the source broke"), "{text}");
    assert!(text.contains("every finished step of it is on disk"), "{text}");
    assert!(desk.now.open.is_none());
    assert!(!dir.path().join("out.nrrd").exists());
    // The thread goes on, and what was done comes back.
    let offer = desk.offers.pop().unwrap();
    let Then::Do(_, open) = offer.then else { panic!("{offer:?}") };
    assert_eq!(open, Command::Project(ProjectCommand::Open { path: project, source: None, generation: None }));
    desk.apply(open);
    desk.until("it is open again", |d| d.now.open.is_some());
    assert_eq!(desk.now.open.as_ref().unwrap().scene.segments().get(7).unwrap().name, "jaw");
    desk.session.send(Request::Quit);
    thread.join().unwrap();
}

#[test]
fn a_failure_in_a_document_that_nobody_keeps_says_what_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let (document, broken) = brittle(dir.path());
    let (mut desk, thread) = Desk::new(document);
    desk.until("it is shown", |d| d.now.open.is_some());
    broken.store(true, Ordering::Relaxed);
    desk.line(&json!({"volume":{"export":{"field":"density","path":dir.path().join("out.nrrd")}}}));
    desk.until("the failure is told", |d| !d.said.is_empty());
    assert!(desk.said[0].1.contains("what was not saved of it is lost"), "{:?}", desk.said);
    desk.session.send(Request::Quit);
    thread.join().unwrap();
}

#[test]
fn a_save_that_cannot_link_offers_to_embed_and_a_missing_volume_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let (volume, project) = (dir.path().join("v.nrrd"), dir.path().join("p"));
    let grid = Grid::aligned([8; 3], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&volume, &grid, |v| v[0] as f32);
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
    run(&mut document, &json!({"project":{"save":{"path":project,"density":"linked"}}}).to_string()).unwrap();
    drop(document);
    // Elsewhere: it is asked for.
    let moved = dir.path().join("moved.nrrd");
    std::fs::rename(&volume, &moved).unwrap();
    let (mut desk, thread) = Desk::new(Document::new());
    desk.line(&json!({"project":{"open":{"path":project}}}));
    desk.until("the volume is asked for", |d| !d.offers.is_empty());
    assert_eq!(desk.offers.pop().unwrap().then, Then::FindSource(project.clone()));
    desk.line(&json!({"project":{"open":{"path":project,"source":moved}}}));
    desk.until("it is open", |d| d.now.open.is_some());
    // Another in its place: a save offers to keep what was opened.
    write_nrrd(&dir.path().join("other.nrrd"), &grid, |v| v[1] as f32);
    std::fs::rename(dir.path().join("other.nrrd"), &moved).unwrap();
    desk.line(&json!({"project":{"save":{}}}));
    desk.until("it offers to embed", |d| !d.offers.is_empty());
    let Then::Do(_, command) = desk.offers.pop().unwrap().then else { panic!("a command") };
    let done = desk.done;
    desk.apply(command);
    desk.until("it is saved", |d| d.done > done);
    desk.session.send(Request::Quit);
    thread.join().unwrap();
    std::fs::remove_file(&moved).unwrap();
    let mut again = Document::new();
    run(&mut again, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    let source = &again.state().unwrap().one().source;
    let first: f32 = bytemuck::pod_read_unaligned(&source.read([3, 0, 0], [1; 3]).unwrap().as_bytes()[..4]);
    assert_eq!(first, 3.0);
}

#[test]
fn a_box_that_would_lose_edits_asks_and_becomes_smaller_when_told_to() {
    let dir = tempfile::tempdir().unwrap();
    let volume = dir.path().join("v.nrrd");
    write_nrrd(&volume, &Grid::aligned([12; 3], DVec3::ONE, DVec3::ZERO), |v| v[0] as f32);
    let Some(_gpu) = crate::common::gpu::gpu() else { return };
    let mut document = Document::new();
    for line in [
        json!({"volume":{"open":{"path":volume}}}),
        json!({"sub_volume":{"add":{"lo":[2,2,2],"hi":[9,9,9],"scale":2}}}),
        json!({"brush":{"set":{"target":{"label":3},"radius_mm":1}}}),
        json!({"stroke":{"paint":{"volume":1,"points":[{"at":{"mm":[8,5,5]}}]}}}),
    ] {
        run(&mut document, &line.to_string()).unwrap();
    }
    let (mut desk, thread) = Desk::new(document);
    desk.until("it is shown", |d| d.now.open.is_some());
    let box_of = |d: &Desk| d.now.open.as_ref().unwrap().scene.volumes.all[&VolumeId(1)].sub_volume.unwrap().of;
    desk.line(&json!({"sub_volume":{"set":{"volume":1,"hi":[6,9,9]}}}));
    desk.until("it asks", |d| !d.offers.is_empty());
    assert_eq!(box_of(&desk).hi, [9; 3], "nothing is done before the answer");
    let Then::Do(_, command) = desk.offers.pop().unwrap().then else { panic!("a command") };
    desk.apply(command);
    desk.until("it is smaller", |d| box_of(d).hi == [6, 9, 9]);
    desk.session.send(Request::Quit);
    thread.join().unwrap();
}

#[test]
fn the_window_says_that_a_linked_volume_is_another_one_as_soon_as_that_is_known() {
    let dir = tempfile::tempdir().unwrap();
    let (volume, project) = (dir.path().join("v.nrrd"), dir.path().join("p"));
    let grid = Grid::aligned([8; 3], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&volume, &grid, |v| v[0] as f32);
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
    run(&mut document, &json!({"project":{"save":{"path":project,"density":"linked"}}}).to_string()).unwrap();
    drop(document);
    write_nrrd(&volume, &grid, |v| v[1] as f32);
    let (mut desk, thread) = Desk::new(Document::new());
    desk.line(&json!({"project":{"open":{"path":project}}}));
    desk.until("it is said", |d| d.said.iter().any(|(_, text)| text.contains("v.nrrd: blake3: ")));
    assert!(desk.now.open.is_some());
    desk.session.send(Request::Quit);
    thread.join().unwrap();
}
