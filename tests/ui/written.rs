//! Annotations, labels and cutaways as a hand makes and changes them: what gestures and controls ask for, and what is shown.

use super::driver::{SMALL, Window};
use super::interact::{Hand, SIZE};
use crate::document::maker::labelled;
use burin::document::answers::{AnnotationSaid, Answer, GridSaid, Said};
use burin::document::{
    Align, Anchor, Annotation, AnnotationChange, AnnotationCommand, AnnotationId, Command, Content, Cutaway,
    CutawayChange, CutawayCommand, CutawayId, HistoryCommand, Label, LabelAnchor, LabelChange, LabelCommand, LabelId,
    Named, Outline, Place, Rim, ViewName,
};
use burin::gpu::ObjectId;
use burin::interact::{Button, Hit, Mark, Tool, WritingKind, Written};
use burin::math::DVec3;
use burin::ui::{Picture, Report, Request, Session, spawn};
use burin::volume::VolumeId;
use egui::accesskit::Toggled;
use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn anchor() -> Anchor {
    Anchor {
        volume: VolumeId::FIRST,
        centre: [20.0, 20.0, 10.0],
        toward: [30.0, 20.0, 10.0],
        value: 50.0,
        selected: false,
    }
}

fn text(text: &str) -> Annotation {
    Annotation {
        name: text.into(),
        content: Content::Text { text: text.into(), bend_mm: 0.0, align: Align::Centre },
        anchor: anchor(),
        size_mm: 4.0,
        tracing: Default::default(),
        colour: Annotation::INK,
        halo: None,
        opacity: 1.0,
        lit: true,
        visible: true,
    }
}

fn cutaway() -> Cutaway {
    Cutaway {
        name: "Window 1".into(),
        anchor: anchor(),
        outline: Outline::Grid { width_mm: 20.0, height_mm: 10.0 },
        depth_mm: 8.0,
        rim: Rim { width_mm: 1.0, colour: [0.5; 3] },
        shaded: true,
        spares: Default::default(),
        open: true,
    }
}

fn label(text: &str) -> Label {
    let at = Named::Point { volume: VolumeId::FIRST, index: [20.0, 20.0, 10.0], selected: false };
    Label { text: text.into(), at, visible: true }
}

fn pixel(x: f64, y: f64) -> Option<Place> {
    Some(Place::Pixel { view: ViewName::ThreeD, px: [x, y], size: Some(SIZE) })
}

/// A drag with the hand over matter all the way.
fn dragged(hand: &mut Hand, from: [f64; 2], to: [f64; 2]) -> Vec<Command> {
    assert_eq!(hand.press(Button::Primary, from[0], from[1]), []);
    assert_eq!(hand.drag(to[0], to[1]), []);
    hand.release(Button::Primary, to[0], to[1])
}

fn added(commands: &[Command]) -> AnnotationChange {
    match commands {
        [Command::Annotation(AnnotationCommand::Add(change))] => change.clone(),
        other => panic!("an annotation expected, {other:?} found"),
    }
}

#[test]
fn a_drag_lays_a_text_from_its_centre_to_where_it_goes() {
    let mut hand = Hand::new(Tool::Annotate, ViewName::ThreeD);
    hand.writing.text = "Os frontale".into();
    hand.writing.sizes_mm.insert(WritingKind::Text, 7.0);
    hand.writing.halo = None;
    let change = added(&dragged(&mut hand, [100.0, 90.0], [160.0, 80.0]));
    let content = Content::Text { text: "Os frontale".into(), bend_mm: 0.0, align: Align::Centre };
    assert_eq!(change.content, Some(content));
    assert_eq!((change.at, change.toward, change.size_mm), (pixel(100.0, 90.0), pixel(160.0, 80.0), Some(7.0)));
    assert!(change.no_halo && change.halo.is_none());
    // A click says no direction.
    let change = added(&dragged(&mut hand, [100.0, 90.0], [101.0, 90.0]));
    assert_eq!((change.at, change.toward), (pixel(100.0, 90.0), None));
}

#[test]
fn a_drag_that_leaves_matter_ends_where_it_was_last_over_it() {
    let mut hand = Hand::new(Tool::Annotate, ViewName::ThreeD);
    hand.press(Button::Primary, 100.0, 90.0);
    hand.drag(140.0, 90.0);
    hand.hit = None;
    hand.drag(180.0, 90.0);
    let change = added(&hand.release(Button::Primary, 200.0, 90.0));
    assert_eq!(change.toward, pixel(140.0, 90.0));
    hand.press(Button::Primary, 10.0, 10.0);
    assert!(matches!(hand.drag(20.0, 10.0)[..], [Command::View(_)]), "a drag from the air turns the view");
}

#[test]
fn what_has_two_ends_is_drawn_from_one_to_the_other() {
    let mut hand = Hand::new(Tool::Annotate, ViewName::ThreeD);
    hand.writing.kind = WritingKind::Ruler;
    assert_eq!(dragged(&mut hand, [100.0, 90.0], [102.0, 90.0]), [], "a click is no ruler");
    let change = added(&dragged(&mut hand, [100.0, 90.0], [160.0, 80.0]));
    assert_eq!((change.at, change.to, change.toward), (pixel(100.0, 90.0), pixel(160.0, 80.0), None));
    hand.writing.kind = WritingKind::Arrow;
    hand.press(Button::Primary, 100.0, 90.0);
    hand.hit = Some(Hit { world: DVec3::new(10.0, 13.0, 14.0), part: None, depth_mm: 200.0 });
    hand.drag(160.0, 80.0);
    let marks = hand.interaction.gesture().unwrap().marks(ViewName::ThreeD);
    assert!(marks.iter().any(|mark| matches!(mark, Mark::Note { text, .. } if text == "5 mm straight")), "{marks:?}");
    let change = added(&hand.release(Button::Primary, 160.0, 80.0));
    // It lies about its middle and is as long as it was drawn: 3² + 4² = 5².
    assert_eq!((change.at, change.toward), (pixel(130.0, 85.0), pixel(160.0, 80.0)));
    assert_eq!(change.size_mm, Some(5.0));
}

/// A hand with one annotation and one cutaway where the camera looks at, and the pixel of both.
fn with_things(tool: Tool) -> (Hand, [f64; 2]) {
    let mut hand = Hand::new(tool, ViewName::ThreeD);
    hand.scene.annotations.all.insert(AnnotationId(0), text("Nasus"));
    hand.scene.cutaways.all.insert(CutawayId(0), cutaway());
    hand.scene.labels.all.insert(LabelId(0), label("Nasus"));
    let camera = hand.scene.views.camera;
    let place = camera.target;
    let (px, depth_mm) = camera.project(place, SIZE).unwrap();
    hand.hit = Some(Hit { world: place, part: None, depth_mm });
    hand.writing.places.insert(Written::Annotation(AnnotationId(0)), place);
    hand.writing.places.insert(Written::Cutaway(CutawayId(0)), place);
    hand.writing.places.insert(Written::Label(LabelId(0)), place);
    (hand, px.to_array())
}

#[test]
fn what_is_there_is_moved_turned_and_scaled_by_its_middle() {
    let set = |change: AnnotationChange| {
        let id = Some(AnnotationId(0));
        [Command::Annotation(AnnotationCommand::Set(AnnotationChange { id, ..change }))]
    };
    let (mut hand, [x, y]) = with_things(Tool::Annotate);
    let moved = dragged(&mut hand, [x + 2.0, y], [x + 50.0, y + 20.0]);
    assert_eq!(moved, set(AnnotationChange { at: pixel(x + 50.0, y + 20.0), ..Default::default() }));
    hand.modifiers.shift = true;
    let turned = dragged(&mut hand, [x, y], [x + 50.0, y + 20.0]);
    assert_eq!(turned, set(AnnotationChange { toward: pixel(x + 50.0, y + 20.0), ..Default::default() }));
    hand.modifiers.shift = false;
    hand.modifiers.ctrl = true;
    // 120 pixels double.
    let scaled = dragged(&mut hand, [x, y], [x + 120.0, y]);
    assert_eq!(scaled, set(AnnotationChange { size_mm: Some(8.0), ..Default::default() }));
    hand.modifiers.ctrl = false;
    assert_eq!(dragged(&mut hand, [x, y], [x + 1.0, y]), [], "a click only picks");
    // What is behind what is seen is not taken.
    hand.hit = hand.hit.map(|hit| Hit { depth_mm: hit.depth_mm * 0.5, ..hit });
    let new = dragged(&mut hand, [x, y], [x + 50.0, y]);
    assert!(matches!(new[..], [Command::Annotation(AnnotationCommand::Add(_))]), "{new:?}");
}

#[test]
fn cutaways_and_labels_follow_the_hand_too() {
    let (mut hand, [x, y]) = with_things(Tool::Cutaway);
    let of = |change: CutawayChange| {
        let id = Some(CutawayId(0));
        [Command::Cutaway(CutawayCommand::Set(CutawayChange { id, ..change }))]
    };
    let moved = dragged(&mut hand, [x, y], [x + 50.0, y]);
    assert_eq!(moved, of(CutawayChange { at: pixel(x + 50.0, y), ..Default::default() }));
    hand.modifiers.ctrl = true;
    let scaled = dragged(&mut hand, [x, y], [x - 120.0, y]);
    let (width_mm, height_mm) = (Some(10.0), Some(5.0));
    assert_eq!(scaled, of(CutawayChange { width_mm, height_mm, ..Default::default() }));
    let (mut hand, [x, y]) = with_things(Tool::Label);
    let id = Some(LabelId(0));
    let moved = LabelChange { id, at: pixel(x + 50.0, y), ..Default::default() };
    assert_eq!(dragged(&mut hand, [x, y], [x + 50.0, y]), [Command::Label(LabelCommand::Set(moved))]);
}

#[test]
fn a_click_names_a_place() {
    let mut hand = Hand::new(Tool::Label, ViewName::ThreeD);
    hand.writing.label = "Nasus".into();
    let add = LabelChange { text: Some("Nasus".into()), at: pixel(100.0, 90.0), ..Default::default() };
    assert_eq!(dragged(&mut hand, [100.0, 90.0], [101.0, 91.0]), [Command::Label(LabelCommand::Add(add))]);
    assert_eq!(dragged(&mut hand, [100.0, 90.0], [140.0, 91.0]), [], "a drag is no click");
}

#[test]
fn a_drag_from_the_middle_opens_a_window_of_that_size() {
    let mut hand = Hand::new(Tool::Cutaway, ViewName::ThreeD);
    hand.writing.depth_mm = Some(30.0);
    let mm_per_px = hand.scene.views.camera.mm_per_pixel(200.0, SIZE[1]);
    let cut = dragged(&mut hand, [100.0, 90.0], [160.0, 70.0]);
    let [Command::Cutaway(CutawayCommand::Add(change))] = &cut[..] else { panic!("{cut:?}") };
    assert_eq!((change.at, change.toward, change.depth_mm), (pixel(100.0, 90.0), None, Some(30.0)));
    // 60 and 20 pixels from the middle to the corner.
    let (width, height) = (change.width_mm.unwrap(), change.height_mm.unwrap());
    assert!((width / (120.0 * mm_per_px) - 1.0).abs() < 0.01 && (height / (40.0 * mm_per_px) - 1.0).abs() < 0.01);
    assert_eq!(dragged(&mut hand, [100.0, 90.0], [101.0, 90.0]), [], "a click opens nothing");
}

#[test]
fn on_slices_nothing_is_written_and_the_tools_say_so() {
    for tool in [Tool::Annotate, Tool::Label, Tool::Cutaway] {
        let mut hand = Hand::new(tool, ViewName::Axial);
        let sent = [dragged_anyhow(&mut hand), hand.interaction.choose(tool)].concat();
        assert!(sent.iter().all(|c| matches!(c, Command::View(_) | Command::History(_))), "{sent:?}");
        assert!(tool.refusal(ViewName::Axial).is_some() && tool.refusal(ViewName::ThreeD).is_none());
    }
}

fn dragged_anyhow(hand: &mut Hand) -> Vec<Command> {
    let mut sent = hand.press(Button::Primary, 100.0, 90.0);
    sent.extend(hand.drag(120.0, 90.0));
    sent.extend(hand.release(Button::Primary, 120.0, 90.0));
    sent
}

/// A window with an annotation, a cutaway and a label.
fn window() -> Window {
    let mut window = Window::open(SMALL);
    window.scene.annotations.all.insert(AnnotationId(0), text("Nasus"));
    window.scene.annotations.next = 1;
    window.scene.cutaways.all.insert(CutawayId(0), cutaway());
    window.scene.cutaways.next = 1;
    window.scene.labels.all.insert(LabelId(0), label("Os nasale"));
    window.scene.labels.next = 1;
    window.snapshot(|_| {});
    window
}

fn one<T>(sent: Vec<T>) -> T {
    assert_eq!(sent.len(), 1);
    sent.into_iter().next().unwrap()
}

#[test]
fn the_tools_have_their_rows_in_the_place_of_the_brush() {
    let mut window = Window::open(SMALL);
    assert!(window.harness.query_by_label("Section Annotations").is_none(), "nothing is written yet");
    window.key(Modifiers::NONE, Key::A);
    assert_eq!(window.harness.get_by_label("Annotate").accesskit_node().toggled(), Some(Toggled::True));
    assert!(window.harness.query_by_label("Section Brush").is_none());
    for name in ["Kind of a new annotation", "Text of a new annotation", "Size of a new annotation"] {
        window.rect(name);
    }
    window.key(Modifiers::NONE, Key::C);
    window.rect("Depth of a new cutaway");
    window.key(Modifiers::NONE, Key::T);
    window.rect("Text of a new label");
    let all = Command::Label(LabelCommand::FromSegments { volume: None, segments: None });
    assert_eq!(window.click("Label all segments"), [all]);
    window.key(Modifiers::NONE, Key::B);
    window.rect("Section Brush");
}

#[test]
fn what_the_panel_says_is_what_a_drag_makes() {
    let mut window = Window::open(SMALL);
    window.key(Modifiers::NONE, Key::A);
    window.harness.get_by_label("Text of a new annotation").focus();
    window.harness.run_steps(2);
    window.harness.get_by_label("Text of a new annotation").type_text(" of mine");
    window.harness.run_steps(2);
    shown(&mut window, 0.9);
    let sent = window.drag("3D view", vec2(40.0, 10.0));
    let [Command::Annotation(AnnotationCommand::Add(change))] = &sent[..] else { panic!("{sent:?}") };
    let Some(Content::Text { text, .. }) = &change.content else { panic!("{change:?}") };
    assert!(text.contains("of mine"), "{text}");
    window.key(Modifiers::NONE, Key::C);
    assert_eq!(window.harness.get_by_label("Cutaway").accesskit_node().toggled(), Some(Toggled::True), "keys are free");
}

#[test]
fn the_list_hides_renames_removes_and_changes_what_is_picked() {
    let mut window = window();
    window.key(Modifiers::NONE, Key::A);
    let hide = AnnotationChange { id: Some(AnnotationId(0)), visible: Some(false), ..Default::default() };
    assert_eq!(window.click("Show annotation Nasus"), [Command::Annotation(AnnotationCommand::Set(hide))]);
    let close = CutawayChange { id: Some(CutawayId(0)), open: Some(false), ..Default::default() };
    assert_eq!(window.click("Open Window 1"), [Command::Cutaway(CutawayCommand::Set(close))]);
    assert!(window.harness.query_by_label("Size of the annotation").is_none(), "nothing is picked");
    assert_eq!(window.click("Name of annotation 0"), []);
    let sent = window.drag("Size of the annotation", vec2(30.0, 0.0));
    let begin = Command::History(HistoryCommand::Begin {});
    let end = Command::History(HistoryCommand::End {});
    assert_eq!((sent.first(), sent.last()), (Some(&begin), Some(&end)), "a drag is one step: {sent:?}");
    let sizes = sent.iter().filter(|c| matches!(c, Command::Annotation(AnnotationCommand::Set(AnnotationChange { size_mm: Some(s), .. })) if *s > 4.0));
    assert_eq!(sizes.count(), 3, "{sent:?}");
    let unlit = AnnotationChange { id: Some(AnnotationId(0)), lit: Some(false), ..Default::default() };
    assert_eq!(window.click("Lit"), [Command::Annotation(AnnotationCommand::Set(unlit))]);
    window.click("Name of cutaway 0");
    let sent = window.drag("Depth of the cutaway", vec2(20.0, 0.0));
    assert!(
        sent.iter()
            .any(|c| matches!(c, Command::Cutaway(CutawayCommand::Set(CutawayChange { depth_mm: Some(_), .. })))),
        "{sent:?}"
    );
    let remove = Command::Cutaway(CutawayCommand::Remove { id: CutawayId(0) });
    assert_eq!(window.key(Modifiers::NONE, Key::Delete), [remove]);
    let remove = Command::Annotation(AnnotationCommand::Remove { id: AnnotationId(0) });
    assert_eq!(window.click("Remove Nasus"), [remove]);
}

#[test]
fn labels_are_hidden_removed_and_styled() {
    let mut window = window();
    window.key(Modifiers::NONE, Key::T);
    let hide = LabelChange { id: Some(LabelId(0)), visible: Some(false), ..Default::default() };
    assert_eq!(one(window.click("Show label Os nasale")), Command::Label(LabelCommand::Set(hide)));
    let style = |visible, numbers| {
        Command::Label(LabelCommand::Style { visible, numbers, size_px: None, colour: None, own_colour: false })
    };
    assert_eq!(one(window.click("Numbers")), style(None, Some(true)));
    assert_eq!(one(window.click("Labels")), style(Some(false), None));
    let remove = Command::Label(LabelCommand::Remove { id: LabelId(0) });
    assert_eq!(one(window.click("Remove Os nasale")), remove);
}

#[test]
fn a_remark_stands_under_the_one_concerned_and_offers_the_size_that_fits() {
    let mut window = window();
    window.key(Modifiers::NONE, Key::A);
    let id = AnnotationId(0);
    let grid = GridSaid {
        remarks: vec!["the surface bends so that areas of it are stretched or shrunk by 1.60".into()],
        fitting_mm: Some(2.345),
        ..GridSaid::default()
    };
    let said = AnnotationSaid { id, annotation: text("Nasus"), grid: Some(grid), not_shown: None };
    let set = AnnotationChange { id: Some(id), ..Default::default() };
    let answer = Answer { said: Said::from(said), ..Answer::default() };
    window.report(Report::Done(Box::new(Command::Annotation(AnnotationCommand::Set(set))), Box::new(answer)));
    window.click("Name of annotation 0");
    let smaller = AnnotationChange { id: Some(id), size_mm: Some(2.34), ..Default::default() };
    assert_eq!(window.click("Make it 2.34 mm"), [Command::Annotation(AnnotationCommand::Set(smaller))]);
    assert!(window.harness.query_by_label("Make it 2.34 mm").is_none(), "of another size nothing was said yet");
}

/// A picture of the 3D view in which matter lies at this share of the way to what the camera looks at.
fn shown(window: &mut Window, share: f64) {
    let camera = window.scene.views.camera;
    let depth_mm = vec![(camera.eye.distance(camera.target) * share) as f32; 4];
    let (view, size, rgba) = (ViewName::ThreeD, [2, 2], vec![9; 16]);
    let object = ObjectId::new(VolumeId::FIRST, 0, false, 0);
    let picture = Picture { view, size, rgba, depth_mm, object: vec![object; 4], camera, serial: 0 };
    window.report(Report::Picture(Box::new(picture)));
}

/// Opacity of a text in the window; `None` where it is not.
fn painted(window: &Window, text: &str) -> Option<u8> {
    let shapes = &window.harness.output().shapes;
    let of = shapes.iter().filter_map(|s| match &s.shape {
        egui::Shape::Text(shape) if shape.galley.text() == text => {
            shape.override_text_color.or(Some(shape.fallback_color))
        }
        _ => None,
    });
    of.map(|colour| colour.a()).max()
}

#[test]
fn labels_stand_over_the_3d_view_as_long_as_what_they_name_is_seen() {
    let mut window = window();
    let place = window.scene.views.camera.target;
    let named = window.scene.labels.all[&LabelId(0)].at;
    let anchor = LabelAnchor { id: LabelId(0), text: "Promontorium".into(), place, near_mm: 3.0, named };
    window.snapshot(|s| s.open.as_mut().unwrap().labels = Arc::new(vec![anchor.clone()]));
    assert_eq!(painted(&window, "Promontorium"), None, "there is no picture yet");
    // What is seen is behind it.
    shown(&mut window, 1.2);
    window.harness.run_steps(30);
    assert!(painted(&window, "Promontorium").is_some());
    // Something comes before it: it fades, and is gone.
    shown(&mut window, 0.5);
    window.harness.run_steps(60);
    assert_eq!(painted(&window, "Promontorium"), None);
    window.scene.labels.style.numbers = true;
    window.snapshot(|s| s.open.as_mut().unwrap().labels = Arc::new(vec![anchor.clone()]));
    shown(&mut window, 1.2);
    window.harness.run_steps(60);
    assert!(painted(&window, "1").is_some() && painted(&window, "1  Promontorium").is_some());
    window.scene.labels.style.visible = false;
    window.snapshot(|s| s.open.as_mut().unwrap().labels = Arc::new(vec![anchor]));
    assert_eq!(painted(&window, "1  Promontorium"), None);
}

#[test]
fn while_the_document_works_only_the_newest_length_waits() {
    let mut window = window();
    window.key(Modifiers::NONE, Key::C);
    window.click("Name of cutaway 0");
    // It never answers what is asked from now on.
    window.snapshot(|s| s.serial = 0);
    let sent = window.drag("Depth of the cutaway", vec2(20.0, 0.0));
    let depths: Vec<f64> = sent
        .iter()
        .filter_map(|c| match c {
            Command::Cutaway(CutawayCommand::Set(CutawayChange { depth_mm, .. })) => *depth_mm,
            _ => None,
        })
        .collect();
    assert_eq!(depths.len(), 2, "the first and the last of three: {sent:?}");
    assert!(depths[1] != depths[0]);
    assert_eq!(sent.last(), Some(&Command::History(HistoryCommand::End {})));
}

#[test]
fn the_document_s_thread_says_what_labels_name_and_undo_takes_them_back() {
    let (mut session, thread) = spawn(labelled(), egui::Context::default()).unwrap();
    let at = Some(Place::Index([1.0, 2.0, 3.0]));
    let add = LabelChange { text: Some("Here".into()), at, ..Default::default() };
    assert!(session.send(Request::Apply(Command::Label(LabelCommand::Add(add)))));
    let told = |session: &Session, count: usize| {
        let begun = Instant::now();
        loop {
            for report in session.reports() {
                let Report::Snapshot(snapshot) = report else { continue };
                let Some(open) = &snapshot.open else { continue };
                if open.labels.len() == count && open.scene.labels.all.len() == count {
                    return open.clone();
                }
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "{count} labels never came");
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    let open = told(&session, 1);
    let place = open.grid.world_from_index.transform_point3(DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((open.labels[0].text.as_str(), open.labels[0].place), ("Here", place));
    assert_eq!(open.written.get(&Written::Label(LabelId(0))), Some(&place));
    assert!(session.send(Request::Apply(Command::History(HistoryCommand::Undo { steps: 1 }))));
    assert!(told(&session, 0).written.is_empty());
    session.send(Request::Quit);
    thread.join().unwrap();
}
