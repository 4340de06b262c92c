//! The thread that owns the document: parts follow what is done in the window.

use crate::document::maker::{run, write_nrrd};
use crate::document::maker_gpu::{block, cut, select};
use burin::document::answers_ask::VoxelSaid;
use burin::document::{Command, Document, ViewName};
use burin::math::{DVec3, Pose};
use burin::ui::{Report, Request, Session, Severity, Snapshot, spawn};
use burin::volume::Grid;
use serde_json::json;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a loaded machine may take for one thing. An idle one needs a tenth.
const PATIENCE: Duration = Duration::from_secs(60);

const VIEWS: [ViewName; 4] = [ViewName::ThreeD, ViewName::Axial, ViewName::Coronal, ViewName::Sagittal];

/// A window's end without a window.
struct Desk {
    session: Session,
    now: Arc<Snapshot>,
    thread: std::thread::JoinHandle<()>,
    /// Pictures since the last look.
    pictures: Vec<ViewName>,
    /// Whether parts ever moved.
    moved: bool,
    /// Whether the 3D view is to be finer.
    refining: bool,
    /// Serial of the last picture of the 3D view.
    shows: u64,
    /// What was under the pointer last.
    probe: Option<VoxelSaid>,
}

impl Desk {
    fn new(document: Document) -> Self {
        let (session, thread) = spawn(document, egui::Context::default()).unwrap();
        Self {
            session,
            now: Arc::default(),
            thread,
            pictures: Vec::new(),
            moved: false,
            refining: false,
            shows: 0,
            probe: None,
        }
    }

    fn apply(&mut self, line: &str) {
        let command: Command = serde_json::from_str(line).unwrap();
        assert!(self.session.send(Request::Apply(command)));
    }

    /// Takes reports until something is so.
    fn until(&mut self, what: &str, mut so: impl FnMut(&Self) -> bool) {
        let begun = Instant::now();
        while !so(self) {
            for report in self.session.reports() {
                match report {
                    Report::Snapshot(snapshot) => {
                        self.moved |= snapshot.moving;
                        self.now = snapshot;
                    }
                    Report::Picture(picture) => {
                        self.pictures.push(picture.view);
                        if picture.view == ViewName::ThreeD {
                            self.shows = picture.serial;
                        }
                    }
                    Report::Refining(refining) => self.refining = refining,
                    Report::Probe(probe) => self.probe = probe,
                    Report::Message(Severity::Error, text) | Report::Refused(_, text) | Report::Complaint(_, text) => {
                        panic!("{text}")
                    }
                    _ => {}
                }
            }
            assert!(begun.elapsed() < PATIENCE, "waited in vain until {what}");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn poses(&self) -> Vec<Pose> {
        let open = self.now.open.as_ref().unwrap();
        open.poses.in_order(&open.scene.explosion.parts)
    }

    /// Everything asked for is done and no part moves.
    fn rest(&mut self, serial: u64) -> Vec<Pose> {
        self.until("parts are at rest", |d| d.now.open.is_some() && d.now.serial == serial && !d.now.moving);
        self.poses()
    }

    fn close(mut self) {
        self.session.send(Request::Quit);
        self.thread.join().unwrap();
    }
}

fn farthest(a: &[Pose], b: &[Pose]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.translation.distance(b.translation)).fold(0.0, f64::max)
}

/// Eight parts about a selection, opened; at rest.
fn exploded(forces: &str) -> Option<Document> {
    let mut document = block()?;
    cut(&mut document);
    select(&mut document);
    run(&mut document, r#"{"explosion":{"degree":{"value":1}}}"#).unwrap();
    if !forces.is_empty() {
        let mut all = json!(document.state().unwrap().scene.explosion.forces);
        all[forces] = json!(false);
        run(&mut document, &json!({"explosion":{"forces":{"forces":all}}}).to_string()).unwrap();
    }
    run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap();
    Some(document)
}

#[test]
fn parts_make_way_for_a_view_that_turns_and_come_to_rest_where_settle_puts_them() {
    let Some(document) = exploded("") else { return };
    let mut desk = Desk::new(document);
    let before = desk.rest(0);
    desk.apply(r#"{"view":{"orbit":{"azimuth_deg":70,"elevation_deg":20}}}"#);
    desk.until("parts move", |d| d.now.moving);
    let after = desk.rest(1);
    assert!(farthest(&before, &after) > 1.0, "mm: {}", farthest(&before, &after));
    desk.apply(r#"{"explosion":{"settle":{}}}"#);
    assert_eq!(desk.rest(2), after);
    desk.close();
}

#[test]
fn a_view_that_turns_leaves_parts_alone_without_a_viewing_force() {
    let Some(document) = exploded("viewing") else { return };
    let mut desk = Desk::new(document);
    let before = desk.rest(0);
    desk.apply(r#"{"view":{"orbit":{"azimuth_deg":70,"elevation_deg":20}}}"#);
    assert_eq!(desk.rest(1), before);
    desk.close();
}

#[test]
fn a_name_or_a_colour_sets_nothing_in_motion_and_a_part_that_is_hidden_does() {
    let Some(document) = exploded("") else { return };
    let part = document.state().unwrap().scene.explosion.parts[0].id.0;
    let mut desk = Desk::new(document);
    desk.rest(0);
    desk.moved = false;
    desk.apply(&json!({"part":{"set":{"id":part,"name":"lobe"}}}).to_string());
    desk.apply(&json!({"part":{"set":{"id":part,"colour":[1,0,0]}}}).to_string());
    desk.rest(2);
    assert!(!desk.moved);
    desk.apply(&json!({"part":{"set":{"id":part,"visible":false}}}).to_string());
    desk.rest(3);
    assert!(desk.moved);
    desk.close();
}

#[test]
fn parts_follow_a_stroke_while_it_runs_and_every_view_is_drawn_meanwhile() {
    let Some(document) = exploded("") else { return };
    let mut desk = Desk::new(document);
    desk.session.send(Request::Show(VIEWS.to_vec()));
    let before = desk.rest(0);
    desk.session.send(Request::Held(Some(ViewName::ThreeD)));
    desk.apply(r#"{"stroke":{"begin":{"points":[{"at":{"mm":[50,36,28]}}]}}}"#);
    desk.until("parts follow", |d| d.now.serial == 1 && farthest(&before, &d.poses()) > 1.0);
    desk.pictures.clear();
    // A sample a frame, as a hand gives them; while they come every view is drawn again.
    let mut serial = 1;
    let begun = Instant::now();
    while !VIEWS.iter().all(|v| desk.pictures.contains(v)) {
        serial += 1;
        let x = 50.0 - f64::from(serial as u32 % 40);
        desk.apply(&json!({"stroke":{"extend":{"points":[{"at":{"mm":[x, 36.0, 28.0]}}]}}}).to_string());
        desk.until("the sample is painted", |d| d.now.serial == serial);
        assert!(begun.elapsed() < PATIENCE, "only {:?} were drawn", desk.pictures);
    }
    assert_eq!(desk.now.undo.last().map(String::as_str), Some("Degree of explosion"), "the stroke still runs");
    desk.apply(r#"{"stroke":{"end":{}}}"#);
    desk.session.send(Request::Held(None));
    let after = desk.rest(serial + 1);
    desk.apply(r#"{"explosion":{"settle":{}}}"#);
    assert_eq!(desk.rest(serial + 2), after);
    // What was painted taken back, parts go where they were.
    desk.apply(r#"{"history":{"undo":{}}}"#);
    assert_eq!(desk.rest(serial + 3), before);
    desk.close();
}

#[test]
fn the_view_under_the_hand_is_drawn_first_and_no_other_starves() {
    for hand in [ViewName::Sagittal, ViewName::ThreeD] {
        let Some(document) = block() else { return };
        let mut desk = Desk::new(document);
        desk.session.send(Request::Show(VIEWS.to_vec()));
        desk.rest(0);
        desk.until("all is drawn", |d| VIEWS.iter().all(|v| d.pictures.contains(v)));
        desk.session.send(Request::Held(Some(hand)));
        for serial in 1..=6 {
            desk.pictures.clear();
            let opacity = 0.1 * serial as f64;
            desk.apply(&json!({"view":{"layer":{"field":"selection","visible":true,"opacity":opacity}}}).to_string());
            desk.until("all is drawn", |d| d.now.serial == serial && VIEWS.iter().all(|v| d.pictures.contains(v)));
            // Never twice running: at first it may have been the last.
            let first = if serial == 1 { 2 } else { 1 };
            assert!(desk.pictures[..first].contains(&hand), "{hand:?} in {:?}", desk.pictures);
        }
        desk.close();
    }
}

#[test]
fn a_drag_in_one_view_draws_no_other() {
    let Some(document) = block() else { return };
    let mut desk = Desk::new(document);
    desk.session.send(Request::Show(VIEWS.to_vec()));
    desk.rest(0);
    desk.until("all is drawn", |d| VIEWS.iter().all(|v| d.pictures.contains(v)) && !d.refining);
    desk.pictures.clear();
    desk.apply(r#"{"history":{"begin":{}}}"#);
    for _ in 0..3 {
        desk.apply(r#"{"view":{"zoom":{"view":"axial","factor":0.8}}}"#);
    }
    desk.apply(r#"{"history":{"end":{}}}"#);
    desk.rest(5);
    desk.until("the slice is drawn", |d| d.pictures.contains(&ViewName::Axial));
    // What comes after it would be drawn before what was asked later.
    desk.apply(r#"{"view":{"zoom":{"view":"axial","factor":1.1}}}"#);
    desk.rest(6);
    desk.until("the slice is drawn again", |d| d.pictures.len() > 1);
    assert!(desk.pictures.iter().all(|v| *v == ViewName::Axial), "{:?}", desk.pictures);
    desk.close();
}

#[test]
fn the_3d_view_says_whether_all_of_it_is_there_and_what_it_shows() {
    let Some(document) = block() else { return };
    let mut desk = Desk::new(document);
    desk.session.send(Request::Show(VIEWS.to_vec()));
    desk.rest(0);
    desk.until("it is drawn", |d| d.pictures.contains(&ViewName::ThreeD) && !d.refining);
    for (serial, line) in [
        (1, r#"{"view":{"orbit":{"azimuth_deg":10,"elevation_deg":0}}}"#),
        (2, r#"{"stroke":{"paint":{"points":[{"at":{"mm":[30,20,20]}}]}}}"#),
        (3, r#"{"history":{"undo":{}}}"#),
    ] {
        desk.apply(line);
        desk.until("it is to be drawn", |d| d.refining || d.shows == serial);
        desk.until("it shows the change", |d| d.shows == serial && !d.refining);
    }
    desk.close();
}

#[test]
fn what_lies_under_the_pointer_is_asked_of_the_document_as_it_is_now() {
    let Some(document) = block() else { return };
    let mut desk = Desk::new(document);
    desk.rest(0);
    let selected = |d: &Desk| d.probe.as_ref().and_then(|voxel| voxel.values.as_ref()).unwrap().selection;
    let size = [64, 64];
    let probe = Request::Probe { view: ViewName::Axial, px: burin::math::DVec2::splat(32.0), size };
    desk.session.send(probe.clone());
    desk.until("it answers", |d| d.probe.as_ref().is_some_and(|voxel| voxel.inside));
    assert_eq!(selected(&desk), 0.0);
    desk.apply(r#"{"brush":{"set":{"target":{"selection":1},"radius_mm":9,"falloff":"hard"}}}"#);
    let at = r#"{"pixel":{"view":"axial","px":[32,32],"size":[64,64]}}"#;
    desk.apply(&format!(r#"{{"stroke":{{"paint":{{"points":[{{"at":{at}}}]}}}}}}"#));
    desk.session.send(probe);
    desk.until("it follows", |d| selected(d) == 1.0);
    desk.close();
}

/// What comes back from a document, until something is so.
fn reports(document: Document, ask: Vec<Request>, mut enough: impl FnMut(&[Report]) -> bool) -> Vec<Report> {
    let (mut session, thread) = spawn(document, egui::Context::default()).unwrap();
    for request in ask {
        assert!(session.send(request));
    }
    let (begun, mut all) = (Instant::now(), Vec::new());
    while !enough(&all) {
        all.extend(session.reports());
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {all:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
    session.send(Request::Quit);
    thread.join().unwrap();
    all
}

#[test]
fn a_small_picture_is_what_the_command_would_write() {
    let Some(mut document) = block() else { return };
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("whole.png");
    let wish = json!({ "path": file, "size": [40, 30], "background": [0.2, 0.4, 0.6], "supersample": 2 });
    let written = run(&mut document, &json!({ "render": { "image": wish } }).to_string()).unwrap();
    assert_eq!(written["size"], json!([40, 30]));
    let mut asked = wish.clone();
    asked["path"] = json!("");
    let sketch: burin::document::RenderCommand = serde_json::from_value(json!({ "image": asked })).unwrap();
    let all = reports(document, vec![Request::Sketch(sketch.clone())], |all| {
        all.iter().any(|r| matches!(r, Report::Sketch(..)))
    });
    let Some(Report::Sketch(of, Ok((size, rgba)))) = all.iter().find(|r| matches!(r, Report::Sketch(..))) else {
        panic!("{all:?}")
    };
    assert_eq!((of, size), (&sketch, &[40, 30]));
    assert!(*rgba == image::open(&file).unwrap().into_rgba8().into_raw());
}

#[test]
fn what_was_refused_is_said_with_its_command_and_taken_back_once_it_works() {
    let dir = tempfile::tempdir().unwrap();
    let none = dir.path().join("none.nii");
    let good = dir.path().join("good.nrrd");
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n".to_vec();
    bytes.extend([7; 64]);
    std::fs::write(&good, bytes).unwrap();
    let open = |path: &std::path::Path| -> Command {
        serde_json::from_value(json!({ "volume": { "open": { "path": path } } })).unwrap()
    };
    let ask = vec![Request::Apply(open(&none)), Request::Apply(open(&good))];
    let all = reports(Document::new(), ask, |all| all.iter().any(|r| matches!(r, Report::Done(..))));
    let refused = all.iter().find_map(|r| match r {
        Report::Refused(command, why) => Some((command, why)),
        _ => None,
    });
    let (command, why) = refused.unwrap();
    assert_eq!(**command, open(&none));
    assert!(why.contains("none.nii") && why.contains("it is not there") && !why.contains("os error"), "{why}");
    assert!(all.iter().any(|r| matches!(r, Report::Mended(topic) if topic == "volume.open")), "{all:?}");
}

#[test]
fn the_same_volume_opened_again_is_another_document() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("slope.nrrd");
    let grid = Grid::aligned([6, 5, 4], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&file, &grid, |[x, ..]| x as f32);
    let project = folder.path().join("slope.burin");
    let mut desk = Desk::new(Document::new());
    let mut known = Vec::new();
    for (serial, command) in [
        json!({ "volume": { "open": { "path": file } } }),
        json!({ "project": { "save": { "path": project } } }),
        json!({ "volume": { "open": { "path": file } } }),
        json!({ "project": { "open": { "path": project } } }),
    ]
    .iter()
    .enumerate()
    {
        desk.apply(&command.to_string());
        desk.until("it is done", |d| d.now.open.is_some() && d.now.serial == serial as u64 + 1);
        // By it a window knows that what it remembers of the last document means nothing any more.
        known.push(desk.now.open.as_ref().unwrap().histogram.clone());
    }
    let same: Vec<bool> = known.windows(2).map(|w| Arc::ptr_eq(&w[0], &w[1])).collect();
    assert_eq!(same, [true, false, false], "a save keeps the document, an opening does not");
    desk.close();
}
