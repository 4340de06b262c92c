//! Tools as a user's hand drives them, without a window.

use super::scene;
use burin::document::{
    BrushCommand, Command, HistoryCommand, PartCommand, PastOf, Place, Scene, Splitter, StrokeCommand, ViewCommand,
    ViewName,
};
use burin::explode::{Axis, Part, PartId, Poses};
use burin::interact::boxes::BoxCorners;
use burin::interact::{
    Action, Button, Context, Event, Hit, Interaction, Key, Modifiers, PointerEvent, SHORTCUTS, Tool, Wheel, Writing,
    action_of,
};
use burin::math::{DVec2, DVec3, Plane};
use burin::paint::BrushChange;
use burin::volume::{Grid, VolumeId};
use std::collections::BTreeMap;

pub const SIZE: [u32; 2] = [400, 300];

pub struct Hand {
    pub grid: Grid,
    pub scene: Scene,
    poses: Poses,
    pub boxes: BoxCorners,
    pub sample_bytes: BTreeMap<VolumeId, u64>,
    pub interaction: Interaction,
    pub writing: Writing,
    view: ViewName,
    pub modifiers: Modifiers,
    pub hit: Option<Hit>,
}

impl Hand {
    pub fn new(tool: Tool, view: ViewName) -> Self {
        let mut interaction = Interaction::default();
        assert_eq!(interaction.choose(tool), []);
        let hit = (view == ViewName::ThreeD).then_some(Hit {
            world: DVec3::splat(10.0),
            part: Some(PartId(3)),
            depth_mm: 200.0,
        });
        let (grid, scene) = scene();
        Self {
            grid,
            scene,
            poses: Poses::default(),
            boxes: BoxCorners::new(),
            sample_bytes: BTreeMap::new(),
            interaction,
            writing: Writing::default(),
            view,
            modifiers: Modifiers::default(),
            hit,
        }
    }

    fn at(&self, x: f64, y: f64) -> PointerEvent {
        PointerEvent {
            view: self.view,
            px: DVec2::new(x, y),
            size: SIZE,
            modifiers: self.modifiers,
            pressure: 1.0,
            time_s: 0.0,
            hit: self.hit,
            space: None,
        }
    }

    fn send(&mut self, event: Event) -> Vec<Command> {
        self.interaction.handle(
            event,
            &Context {
                scene: &self.scene,
                poses: &self.poses,
                grid: &self.grid,
                boxes: &self.boxes,
                sample_bytes: &self.sample_bytes,
                writing: &self.writing,
                voxel_mm: 1.0,
            },
        )
    }

    pub fn press(&mut self, button: Button, x: f64, y: f64) -> Vec<Command> {
        let e = self.at(x, y);
        self.send(Event::Press(button, e))
    }

    pub fn drag(&mut self, x: f64, y: f64) -> Vec<Command> {
        let e = self.at(x, y);
        self.send(Event::Move(e))
    }

    pub fn release(&mut self, button: Button, x: f64, y: f64) -> Vec<Command> {
        let e = self.at(x, y);
        self.send(Event::Release(button, e))
    }

    fn wheel(&mut self, notches: f64) -> Vec<Command> {
        let wheel = Wheel { view: self.view, notches, modifiers: self.modifiers };
        self.send(Event::Wheel(wheel))
    }
}

const BEGIN: Command = Command::History(HistoryCommand::Begin {});
const END: Command = Command::History(HistoryCommand::End {});

fn pixel_of(command: &Command) -> [f64; 2] {
    let points = match command {
        Command::Stroke(StrokeCommand::Begin { points, .. } | StrokeCommand::Extend { points }) => points,
        other => panic!("a stroke expected, {other:?} found"),
    };
    match points[..] {
        [burin::document::StrokePoint { at: Place::Pixel { px, size, .. }, .. }] => {
            assert_eq!(size, Some(SIZE), "pixels are worth nothing without the picture's size");
            px
        }
        _ => panic!("one pixel expected, {points:?} found"),
    }
}

#[test]
fn a_drag_with_the_brush_is_begin_extend_end_at_its_pixels() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Axial);
    let begin = hand.press(Button::Primary, 10.0, 20.0);
    assert_eq!(begin.len(), 1);
    assert_eq!(pixel_of(&begin[0]), [10.0, 20.0]);
    assert!(matches!(begin[0], Command::Stroke(StrokeCommand::Begin { .. })));
    assert_eq!(pixel_of(&hand.drag(14.0, 20.0)[0]), [14.0, 20.0]);
    assert_eq!(hand.drag(14.0, 20.0), [], "a hand that rests adds no sample");
    let end = hand.release(Button::Primary, 15.5, 21.0);
    assert_eq!(pixel_of(&end[0]), [15.5, 21.0], "the stroke reaches the point where the button went up");
    assert_eq!(end[1], Command::Stroke(StrokeCommand::End {}));
    assert_eq!(hand.drag(30.0, 30.0), [], "nothing paints after the release");
}

#[test]
fn escape_takes_the_stroke_back_and_its_release_says_no_more() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Axial);
    hand.press(Button::Primary, 10.0, 20.0);
    assert_eq!(hand.send(Event::Abort), [Command::Stroke(StrokeCommand::Cancel {})]);
    assert_eq!(hand.send(Event::Abort), []);
    assert_eq!(hand.release(Button::Primary, 15.0, 20.0), []);
}

#[test]
fn held_e_erases_for_one_stroke_only() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Coronal);
    hand.modifiers.erase = true;
    let begin = hand.press(Button::Primary, 1.0, 2.0);
    assert!(matches!(
        begin[0],
        Command::Brush(BrushCommand::Set(BrushChange { erase: Some(true), radius_mm: None, .. }))
    ));
    hand.modifiers.erase = false;
    let end = hand.release(Button::Primary, 1.0, 2.0);
    assert!(matches!(
        end[..],
        [
            Command::Stroke(StrokeCommand::End {}),
            Command::Brush(BrushCommand::Set(BrushChange { erase: Some(false), .. }))
        ]
    ));
    hand.scene.brush.erase = true;
    hand.modifiers.erase = true;
    assert_eq!(hand.press(Button::Primary, 1.0, 2.0).len(), 1, "a brush that erases anyway is left alone");
}

#[test]
fn e_in_mid_stroke_makes_another_stroke_of_the_other_sign_from_there_on() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Axial);
    hand.press(Button::Primary, 10.0, 20.0);
    hand.drag(30.0, 20.0);
    for (held, from, to) in [(true, 30.0, 50.0), (false, 50.0, 90.0)] {
        hand.modifiers.erase = held;
        let commands = hand.drag(to, 20.0);
        assert_eq!(commands.len(), 4, "{commands:?}");
        assert_eq!(commands[0], Command::Stroke(StrokeCommand::End {}));
        assert!(
            matches!(commands[1], Command::Brush(BrushCommand::Set(BrushChange { erase: Some(e), .. })) if e == held)
        );
        assert!(matches!(commands[2], Command::Stroke(StrokeCommand::Begin { .. })));
        assert_eq!(pixel_of(&commands[2]), [from, 20.0], "nothing is left out between the two");
        assert_eq!(pixel_of(&commands[3]), [to, 20.0]);
        assert_eq!(hand.drag(to + 1.0, 20.0).len(), 1, "it goes on as it is");
        hand.drag(to, 20.0);
    }
    assert_eq!(hand.release(Button::Primary, 90.0, 20.0), [Command::Stroke(StrokeCommand::End {})]);
    // Lost while it erases, the brush is as it was.
    hand.press(Button::Primary, 10.0, 20.0);
    hand.modifiers.erase = true;
    hand.drag(40.0, 20.0);
    let aborted = hand.send(Event::Abort);
    assert!(matches!(
        aborted[..],
        [
            Command::Stroke(StrokeCommand::Cancel {}),
            Command::Brush(BrushCommand::Set(BrushChange { erase: Some(false), .. }))
        ]
    ));
    // Letting go of the key a moment before the button paints nothing.
    hand.press(Button::Primary, 10.0, 20.0);
    hand.drag(40.0, 20.0);
    hand.modifiers.erase = false;
    assert_eq!(hand.drag(42.0, 20.0), []);
    let end = hand.release(Button::Primary, 42.0, 21.0);
    assert!(matches!(
        end[..],
        [
            Command::Stroke(StrokeCommand::End {}),
            Command::Brush(BrushCommand::Set(BrushChange { erase: Some(false), .. }))
        ]
    ));
    // A brush that erases anyway goes on.
    hand.scene.brush.erase = true;
    hand.press(Button::Primary, 10.0, 20.0);
    hand.modifiers.erase = true;
    assert_eq!(hand.drag(40.0, 20.0).len(), 1);
}

#[test]
fn the_brush_beside_the_object_turns_the_view_instead() {
    let mut hand = Hand::new(Tool::Brush, ViewName::ThreeD);
    hand.hit = None;
    assert_eq!(hand.press(Button::Primary, 100.0, 100.0), [BEGIN], "a drag is one change of view");
    let turned = hand.drag(130.0, 100.0);
    assert!(matches!(turned[..], [Command::View(ViewCommand::Orbit { azimuth_deg, elevation_deg })]
        if azimuth_deg < 0.0 && elevation_deg == 0.0));
    let start = hand.scene.views.camera;
    assert_eq!(hand.send(Event::Abort), [Command::View(ViewCommand::Camera { camera: start }), END]);
    hand.press(Button::Primary, 100.0, 100.0);
    assert_eq!(hand.release(Button::Primary, 130.0, 100.0)[1..], [END]);
}

#[test]
fn a_click_isolates_and_with_e_held_removes_what_is_connected() {
    use burin::document::{ComponentCommand, Isolation};
    for (view, erase) in [(ViewName::ThreeD, false), (ViewName::Axial, true), (ViewName::Axial, false)] {
        let mut hand = Hand::new(Tool::Isolate, view);
        hand.modifiers.erase = erase;
        assert_eq!(hand.press(Button::Primary, 40.0, 50.0), []);
        let what = Isolation::at(Place::Pixel { view, px: [40.0, 50.0], size: Some(SIZE) });
        let command = if erase { ComponentCommand::Remove(what) } else { ComponentCommand::Keep(what) };
        assert_eq!(hand.release(Button::Primary, 42.0, 51.0), [Command::Component(command)]);
        // A drag is none, and neither is one that is taken back.
        hand.press(Button::Primary, 40.0, 50.0);
        assert_eq!(hand.release(Button::Primary, 60.0, 50.0), []);
        hand.press(Button::Primary, 40.0, 50.0);
        assert_eq!(hand.send(Event::Abort), []);
        assert_eq!(hand.release(Button::Primary, 40.0, 50.0), []);
    }
    // Beside the object the 3D view turns.
    let mut hand = Hand::new(Tool::Isolate, ViewName::ThreeD);
    hand.hit = None;
    assert_eq!(hand.press(Button::Primary, 40.0, 50.0), [BEGIN]);
}

#[test]
fn space_and_the_wheel_button_pan_with_every_tool_and_abort_pans_back() {
    for tool in Tool::ALL {
        for view in [ViewName::ThreeD, ViewName::Sagittal] {
            let mut hand = Hand::new(tool, view);
            hand.modifiers.space = true;
            assert_eq!(hand.press(Button::Primary, 10.0, 10.0), [BEGIN]);
            hand.modifiers.space = false;
            let pan = |px| Command::View(ViewCommand::Pan { view, px });
            assert_eq!(hand.drag(13.0, 6.0), [pan([3.0, -4.0])]);
            assert_eq!(hand.drag(14.0, 6.0), [pan([1.0, 0.0])]);
            assert_eq!(hand.send(Event::Abort), [pan([-4.0, 4.0]), END]);
            hand.press(Button::Middle, 10.0, 10.0);
            assert_eq!(hand.release(Button::Middle, 11.0, 10.0), [pan([1.0, 0.0]), END]);
        }
    }
}

#[test]
fn a_crosshair_that_is_taken_back_is_where_it_was() {
    let mut hand = Hand::new(Tool::Navigate, ViewName::Axial);
    hand.scene.views.crosshair = DVec3::new(3.25, 7.5, 11.0);
    assert_eq!(hand.press(Button::Primary, 10.0, 10.0).len(), 2);
    hand.drag(40.0, 60.0);
    hand.scene.views.crosshair = DVec3::new(30.0, 1.0, 11.0);
    let back = ViewCommand::Crosshair { at: Place::Mm([3.25, 7.5, 11.0]) };
    assert_eq!(hand.send(Event::Abort), [Command::View(back), END]);
}

#[test]
fn right_drag_windows_a_slice_as_one_step_and_zooms_in_3d() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Axial);
    let start = hand.scene.window();
    assert_eq!(hand.press(Button::Secondary, 50.0, 50.0), [Command::History(HistoryCommand::Begin {})]);
    let wider = hand.drag(50.0 + 150.0, 50.0);
    assert!(
        matches!(wider[..], [Command::View(ViewCommand::Window { level, width, .. })]
        if (level - start.level).abs() <= 0.5 && (width - 2.0 * start.width).abs() <= 0.5),
        "half a picture to the right doubles, to the whole number: {wider:?}"
    );
    let end = hand.release(Button::Secondary, 50.0, 50.0 + 150.0);
    assert!(
        matches!(end[..], [Command::View(ViewCommand::Window { level, width, .. }), Command::History(HistoryCommand::End {})]
        if (width - start.width).abs() <= 0.5 && level > start.level + 1.0),
        "down darkens: {end:?}"
    );
    hand.press(Button::Secondary, 50.0, 50.0);
    let odd = hand.drag(50.0 + 37.0, 50.0 + 11.0);
    assert!(
        matches!(odd[..], [Command::View(ViewCommand::Window { level, width, .. })] if level.fract() == 0.0 && width.fract() == 0.0),
        "hundreds have no decimals: {odd:?}"
    );
    assert_eq!(hand.send(Event::Abort), [Command::History(HistoryCommand::Cancel {})]);

    let mut hand = Hand::new(Tool::Navigate, ViewName::ThreeD);
    hand.press(Button::Secondary, 50.0, 50.0);
    assert!(matches!(hand.drag(50.0, 40.0)[..], [Command::View(ViewCommand::Zoom { factor, .. })] if factor < 1.0));
}

#[test]
fn the_wheel_steps_slices_by_whole_voxels_and_modifiers_change_its_meaning() {
    let mut hand = Hand::new(Tool::Navigate, ViewName::Axial);
    let step = |voxels| Command::View(ViewCommand::Scroll { view: ViewName::Axial, voxels });
    assert_eq!(hand.wheel(2.0), [step(2)]);
    assert_eq!(hand.wheel(-0.4), []);
    assert_eq!(hand.wheel(-0.4), []);
    assert_eq!(hand.wheel(-0.4), [step(-1)]);
    hand.modifiers.ctrl = true;
    assert!(matches!(hand.wheel(1.0)[..], [Command::View(ViewCommand::Zoom { factor, .. })] if factor < 1.0));
    hand.modifiers = Modifiers { shift: true, ..Modifiers::default() };
    let radius = hand.scene.brush.radius_mm;
    assert!(
        matches!(hand.wheel(1.0)[..], [Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(r), erase: None, .. }))] if r > radius)
    );
    let mut hand = Hand::new(Tool::Navigate, ViewName::ThreeD);
    assert!(matches!(hand.wheel(-1.0)[..], [Command::View(ViewCommand::Zoom { factor, .. })] if factor > 1.0));
}

#[test]
fn a_brush_never_shrinks_below_half_a_voxel_and_can_grow_from_nothing() {
    let (grid, mut scene) = scene();
    let radius = |scene: &Scene, factor| match Interaction::sized(
        factor,
        &Context {
            scene,
            poses: &Poses::default(),
            grid: &grid,
            boxes: &Default::default(),
            sample_bytes: &Default::default(),
            writing: &Default::default(),
            voxel_mm: 2.0,
        },
    ) {
        Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(r), .. })) => r,
        other => panic!("{other:?}"),
    };
    scene.brush.radius_mm = 0.0;
    assert!(radius(&scene, 1.15) > 1.0);
    assert_eq!(radius(&scene, 0.01), 1.0);
    scene.brush.radius_mm = 400.0;
    assert_eq!(radius(&scene, 2.0), 500.0);
}

#[test]
fn a_brush_for_voxels_of_metres_and_of_nanometres_grows_and_shrinks() {
    let (grid, mut scene) = scene();
    for voxel_mm in [1e-6, 1.0, 1000.0, 1001.0, 30_000.0, 1e9] {
        for radius in [0.0, voxel_mm * 0.5, voxel_mm * 3.0] {
            scene.brush.radius_mm = radius;
            for factor in [1.15, 1.0 / 1.15] {
                let Command::Brush(BrushCommand::Set(BrushChange { radius_mm: Some(new), .. })) = Interaction::sized(
                    factor,
                    &Context {
                        scene: &scene,
                        poses: &Poses::default(),
                        grid: &grid,
                        boxes: &Default::default(),
                        sample_bytes: &Default::default(),
                        writing: &Default::default(),
                        voxel_mm,
                    },
                ) else {
                    panic!("no radius")
                };
                let wanted = (radius.max(voxel_mm * 0.5) * factor).max(voxel_mm * 0.5);
                assert!((new / wanted - 1.0).abs() < 0.006, "{voxel_mm} {radius} {factor}: {new}");
            }
        }
    }
}

#[test]
fn splitters_commit_on_release_and_a_drag_is_no_click() {
    let split = |by| vec![Command::Part(PartCommand::Split { by, size: Some(SIZE) })];
    let mut hand = Hand::new(Tool::DepthSplit, ViewName::ThreeD);
    assert_eq!(hand.press(Button::Primary, 80.0, 90.0), []);
    assert_eq!(hand.release(Button::Primary, 81.0, 90.0), split(Splitter::Depth { px: [80.0, 90.0] }));
    hand.press(Button::Primary, 80.0, 90.0);
    assert_eq!(hand.release(Button::Primary, 120.0, 90.0), [], "a hand that slides away has changed its mind");

    let mut hand = Hand::new(Tool::AxisSplit, ViewName::ThreeD);
    hand.press(Button::Primary, 5.0, 6.0);
    assert_eq!(
        hand.release(Button::Primary, 5.0, 6.0),
        split(Splitter::Axis { px: [5.0, 6.0], axis: Axis::Horizontal })
    );
    hand.modifiers.shift = true;
    hand.press(Button::Primary, 5.0, 6.0);
    assert_eq!(hand.release(Button::Primary, 5.0, 6.0), split(Splitter::Axis { px: [5.0, 6.0], axis: Axis::Vertical }));

    let mut hand = Hand::new(Tool::LineSplit, ViewName::ThreeD);
    hand.hit = None;
    hand.press(Button::Primary, 10.0, 10.0);
    hand.drag(200.0, 50.0);
    assert_eq!(
        hand.release(Button::Primary, 300.0, 60.0),
        split(Splitter::Line { from: [10.0, 10.0], to: [300.0, 60.0] })
    );
    hand.press(Button::Primary, 10.0, 10.0);
    assert_eq!(hand.send(Event::Abort), []);
    assert_eq!(hand.release(Button::Primary, 300.0, 60.0), []);
}

fn part_at_rest() -> Part {
    Part {
        id: PartId(3),
        name: "Left".into(),
        colour: None,
        visible: true,
        held: None,
        importance: 1.0,
        faces: Vec::new(),
        vertices: vec![DVec3::ZERO, DVec3::splat(20.0)],
    }
}

#[test]
fn a_dragged_part_stays_under_the_hand_and_a_turn_keeps_its_centre() {
    let mut hand = Hand::new(Tool::MovePart, ViewName::ThreeD);
    hand.scene.explosion.parts = vec![part_at_rest()];
    let camera = hand.scene.views.camera;
    // A point in the picture's centre, at the depth where the hand takes it.
    let world = camera.eye + camera.forward() * 200.0;
    hand.hit = Some(Hit { world, part: Some(PartId(3)), depth_mm: 200.0 });
    assert_eq!(hand.press(Button::Primary, 200.0, 150.0), [Command::History(HistoryCommand::Begin {})]);
    let Command::Part(PartCommand::Move { id: PartId(3), pose }) = hand.drag(260.0, 120.0)[0].clone() else { panic!() };
    let (px, depth) = camera.project(pose.apply(world), SIZE).unwrap();
    assert!((px - DVec2::new(260.0, 120.0)).length() < 1e-6 && (depth - 200.0).abs() < 1e-6, "{px} at {depth} mm");
    assert_eq!(hand.send(Event::Abort), [Command::History(HistoryCommand::Cancel {})]);
    hand.press(Button::Primary, 200.0, 150.0);
    let click = hand.release(Button::Primary, 200.0, 150.0);
    assert_eq!(click, [Command::History(HistoryCommand::End {})], "a click moves and pins nothing");

    hand.modifiers.ctrl = true;
    hand.press(Button::Primary, 200.0, 150.0);
    let Command::Part(PartCommand::Move { pose, .. }) = hand.drag(260.0, 120.0)[0].clone() else { panic!() };
    let centre = DVec3::splat(10.0);
    assert!((pose.apply(centre) - centre).length() < 1e-9);
    assert!((pose.rotation.length() - 1.0).abs() < 1e-12 && pose.rotation.w < 0.99);
}

#[test]
fn a_second_button_does_not_disturb_a_running_gesture() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Axial);
    hand.press(Button::Primary, 10.0, 20.0);
    assert_eq!(hand.press(Button::Secondary, 10.0, 20.0), []);
    assert_eq!(hand.release(Button::Secondary, 10.0, 20.0), []);
    assert_eq!(hand.drag(12.0, 20.0).len(), 1, "the stroke goes on");
}

#[test]
fn another_tool_takes_back_what_runs() {
    let mut hand = Hand::new(Tool::Brush, ViewName::Axial);
    hand.press(Button::Primary, 10.0, 20.0);
    assert_eq!(hand.interaction.choose(Tool::Navigate), [Command::Stroke(StrokeCommand::Cancel {})]);
}

#[test]
fn shift_click_moves_the_crosshair_with_any_tool_but_the_one_that_uses_shift() {
    for tool in Tool::ALL.into_iter().filter(|t| *t != Tool::AxisSplit) {
        let mut hand = Hand::new(tool, ViewName::Sagittal);
        hand.modifiers.shift = true;
        let commands = hand.press(Button::Primary, 7.0, 8.0);
        assert_eq!(commands[0], BEGIN, "{tool:?}");
        assert!(
            matches!(
                commands[1..],
                [Command::View(ViewCommand::Crosshair { at: Place::Pixel { px: [7.0, 8.0], .. } })]
            ),
            "{tool:?}"
        );
        assert_eq!(hand.release(Button::Primary, 7.0, 8.0).last(), Some(&END), "{tool:?}");
    }
}

#[test]
fn shift_click_on_nothing_in_3d_moves_nothing() {
    for tool in Tool::ALL.into_iter().filter(|t| *t != Tool::AxisSplit) {
        let mut hand = Hand::new(tool, ViewName::ThreeD);
        hand.hit = None;
        hand.modifiers.shift = true;
        assert_eq!(hand.press(Button::Primary, 7.0, 8.0), [], "{tool:?}");
        assert!(hand.interaction.gesture().is_none(), "{tool:?}");
        assert_eq!(hand.drag(90.0, 90.0), [], "{tool:?}");
        assert_eq!(hand.release(Button::Primary, 90.0, 90.0), [], "{tool:?}");
    }
}

/// The one plane splitter of a part that commands are.
fn plane_of(commands: &[Command]) -> (Plane, PartId) {
    match commands {
        [Command::Part(PartCommand::Split { by: Splitter::Plane { point, normal, part: Some(part) }, .. })] => {
            (Plane::through(DVec3::from_array(*point), DVec3::from_array(*normal)).unwrap(), *part)
        }
        other => panic!("one cut of one part expected, {other:?} found"),
    }
}

#[test]
fn splitters_on_a_slice_cut_what_is_seen_there_and_leave_the_crosshair() {
    // Right and up in the picture and along the sight, of a grid that is aligned with the world.
    for (view, right, up) in [
        (ViewName::Axial, DVec3::NEG_X, DVec3::Y),
        (ViewName::Coronal, DVec3::NEG_X, DVec3::Z),
        (ViewName::Sagittal, DVec3::NEG_Y, DVec3::Z),
    ] {
        let world = |hand: &Hand, px: [f64; 2]| {
            let slice = hand.scene.views.slice(view).unwrap();
            let mm = slice.height_mm / f64::from(SIZE[1]);
            let mut at = slice.centre + right * ((px[0] - 200.0) * mm) - up * ((px[1] - 150.0) * mm);
            let sight = right.cross(up);
            at += sight * (hand.scene.views.crosshair - at).dot(sight);
            at
        };
        for (tool, shift, normal) in
            [(Tool::AxisSplit, false, up), (Tool::AxisSplit, true, right), (Tool::DepthSplit, false, right.cross(up))]
        {
            let mut hand = Hand::new(tool, view);
            hand.modifiers.shift = shift;
            assert_eq!(hand.press(Button::Primary, 190.0, 140.0), []);
            let (plane, part) = plane_of(&hand.release(Button::Primary, 191.0, 140.0));
            assert_eq!(part, hand.scene.explosion.parts[0].id);
            assert!(plane.normal.cross(normal).length() < 1e-9, "{view:?} {tool:?}: {plane:?}");
            let off = plane.distance(world(&hand, [190.0, 140.0])).abs();
            // A slice lies on the voxels nearest to the crosshair.
            assert!(off < if tool == Tool::DepthSplit { 1.0 + 1e-9 } else { 1e-6 }, "{view:?} {tool:?}: {off} mm off");
            hand.press(Button::Primary, 190.0, 140.0);
            assert_eq!(hand.release(Button::Primary, 240.0, 140.0), [], "a hand that slides away has changed its mind");
        }
        let mut hand = Hand::new(Tool::LineSplit, view);
        hand.press(Button::Primary, 120.0, 150.0);
        hand.drag(200.0, 160.0);
        let (plane, _) = plane_of(&hand.release(Button::Primary, 280.0, 180.0));
        for px in [[120.0, 150.0], [280.0, 180.0]] {
            assert!(plane.distance(world(&hand, px)).abs() < 1e-6, "{view:?}: the cut goes through both ends");
        }
        assert!(plane.normal.dot(right.cross(up)).abs() < 1e-9, "{view:?}: and straight through the slice");
        let mut hand = Hand::new(Tool::MovePart, view);
        assert_eq!(hand.press(Button::Primary, 190.0, 140.0), [], "slices show parts at rest");
        assert!(Tool::MovePart.refusal(view).is_some() && Tool::MovePart.refusal(ViewName::ThreeD).is_none());
        assert!(Tool::ALL.iter().all(|t| *t == Tool::MovePart || t.picks().is_some() || t.refusal(view).is_none()));
    }
}

#[test]
fn a_line_on_a_slice_cuts_the_parts_that_it_crosses_as_one_step() {
    let mut hand = Hand::new(Tool::LineSplit, ViewName::Axial);
    let middle = hand.grid.world_bounds().centre();
    let halves = Plane::through(middle, DVec3::X).unwrap();
    let id = hand.scene.explosion.parts[0].id;
    hand.scene.explosion.split_at_rest(id, &halves).unwrap().unwrap();
    let mm = hand.scene.views.slices[0].height_mm / f64::from(SIZE[1]);
    let reach = 0.3 * (hand.grid.world_bounds().max.x - middle.x) / mm;
    for (from, to, cuts) in [(-reach, reach, 2), (reach * 0.2, reach, 1), (-reach, -0.2 * reach, 1)] {
        hand.press(Button::Primary, 200.0 + from, 150.0);
        let commands = hand.release(Button::Primary, 200.0 + to, 151.0);
        let of: Vec<_> = commands.iter().filter(|c| matches!(c, Command::Part(PartCommand::Split { .. }))).collect();
        assert_eq!(of.len(), cuts, "{commands:?}");
        let framed = (commands.first(), commands.last()) == (Some(&BEGIN), Some(&END));
        assert_eq!(framed, cuts > 1, "{commands:?}");
    }
}

#[test]
fn every_tool_has_its_own_key_and_keys_do_what_the_page_says() {
    let none = Modifiers::default();
    let ctrl = Modifiers { ctrl: true, ..none };
    let both = Modifiers { shift: true, ..ctrl };
    for tool in Tool::ALL {
        assert_eq!(action_of(Key::Char(tool.key()), none), Some(Action::Choose(tool)));
        assert!(SHORTCUTS.iter().any(|s| s.keys == tool.key().to_string()), "{tool:?} is not on the page of keys");
    }
    assert_eq!(action_of(Key::Char('7'), none), Some(Action::Label(7)));
    assert_eq!(action_of(Key::Char('0'), none), None);
    assert_eq!(action_of(Key::Char('Z'), ctrl), Some(Action::Undo));
    assert_eq!(action_of(Key::Char('Z'), both), Some(Action::Redo));
    assert_eq!(action_of(Key::Char('Y'), ctrl), Some(Action::Redo));
    assert_eq!(action_of(Key::Char('S'), ctrl), Some(Action::Save));
    assert_eq!(action_of(Key::Char('O'), ctrl), Some(Action::Open));
    assert_eq!(action_of(Key::Char('E'), none), None, "E is held, not pressed");
    let shift = Modifiers { shift: true, ..none };
    for key in ('A'..='Z').chain('0'..='9').map(Key::Char).chain([Key::Up, Key::Down, Key::BracketLeft]) {
        assert_eq!(action_of(key, shift), None, "{key:?} with Shift is another key");
        assert_eq!(action_of(key, Modifiers { alt: true, ..none }), None, "{key:?} with Alt is another key");
    }
    assert_eq!(action_of(Key::Home, none), Some(Action::Fit));
    assert_eq!(action_of(Key::Home, shift), Some(Action::Front));
    let alt = Modifiers { alt: true, ..none };
    assert_eq!(action_of(Key::Left, alt), Some(Action::Back(None)));
    assert_eq!(action_of(Key::Right, alt), Some(Action::Forward(None)));
    let alone = Modifiers { shift: true, ..alt };
    assert_eq!(action_of(Key::Left, alone), Some(Action::Back(Some(PastOf::Looks))));
    assert_eq!(action_of(Key::Right, alone), Some(Action::Forward(Some(PastOf::Looks))));
    assert_eq!(action_of(Key::Left, none), None);
    assert_eq!(action_of(Key::Help, Modifiers { shift: true, ..none }), Some(Action::Keys));
    assert!(matches!(action_of(Key::BracketLeft, none), Some(Action::BrushSize(f)) if f < 1.0));
    assert!(matches!(action_of(Key::BracketRight, none), Some(Action::BrushSize(f)) if f > 1.0));
}

#[test]
fn only_what_changed_of_a_brush_is_sent() {
    let old = *scene().1.brush;
    assert_eq!(burin::interact::brush_change(&old, &old), None);
    let mut new = old;
    new.range = Some([1.0, 2.0].map(burin::volume::Number::Real));
    let Some(Command::Brush(BrushCommand::Set(BrushChange { range, radius_mm, any_value, .. }))) =
        burin::interact::brush_change(&old, &new)
    else {
        panic!()
    };
    assert_eq!((range, radius_mm, any_value), (Some([1.0, 2.0].map(burin::volume::Number::Real)), None, false));
    let Some(Command::Brush(BrushCommand::Set(BrushChange { range, any_value, .. }))) =
        burin::interact::brush_change(&new, &old)
    else {
        panic!()
    };
    assert_eq!((range, any_value), (None, true));
}
