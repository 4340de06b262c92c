//! Mouse, pen and stylus come to the tools by one trait.

use burin::document::ContactForce;
use burin::document::{Command, Place, State, StrokeCommand, ViewName};
use burin::explode::Poses;
use burin::interact::boxes::BoxCorners;
use burin::interact::devices::*;
use burin::interact::{Button, Context, Event, Interaction, Modifiers, Tool};
use burin::math::{Camera, DQuat, DVec2, DVec3, Pose};
use std::collections::BTreeMap;

const SIZE: [u32; 2] = [200, 100];

fn moment(state: &State) -> Moment {
    let camera: Camera = state.scene.views.camera;
    Moment { seen: Some((camera, SIZE)), modifiers: Modifiers::default(), time_s: 0.5, hit: None }
}

fn does(interaction: &mut Interaction, state: &State, events: Vec<Event>) -> Vec<Command> {
    let (poses, boxes, sample_bytes) = (Poses::default(), BoxCorners::new(), BTreeMap::new());
    let (scene, subject) = (&state.scene, state.at(None).unwrap());
    let context = Context {
        scene,
        poses: &poses,
        grid: subject.grid(),
        boxes: &boxes,
        sample_bytes: &sample_bytes,
        voxel_mm: 1.0,
        writing: &Default::default(),
    };
    events.into_iter().flat_map(|event| interaction.handle(event, &context)).collect()
}

#[test]
fn mouse_and_pen_are_where_they_are_and_as_hard_as_they_are_pressed() {
    let state = crate::document::maker::state();
    let place = ScreenPlace { view: ViewName::Axial, px: DVec2::new(3.0, 4.0), size: SIZE };
    let buttons = Buttons::only(Button::Primary);
    let pointers: [(&dyn Pointer, f32); 4] = [
        (&Mouse { place, buttons }, 1.0),
        (&Pen { place, buttons, force: 0.25 }, 0.25),
        (&Pen { place, buttons, force: 7.0 }, 1.0),
        (&Pen { place, buttons, force: f32::NAN }, 0.0),
    ];
    for (pointer, pressure) in pointers {
        let event = pointer_event(pointer, &moment(&state)).unwrap();
        assert_eq!((event.view, event.px, event.size, event.pressure), (ViewName::Axial, place.px, SIZE, pressure));
        assert_eq!((event.space, event.hit, event.time_s), (None, None, 0.5));
        assert!(pointer.buttons().held(Button::Primary) && !pointer.buttons().held(Button::Middle));
        assert_eq!(pointer.direction(), None);
    }
}

#[test]
fn a_stylus_paints_by_places_of_the_world() {
    let state = crate::document::maker::state();
    let mut interaction = Interaction::default();
    interaction.choose(Tool::Brush);
    let mut stylus = Stylus::new(Feel::new(ContactForce::default()));
    let mut follower = Follower::default();
    let tip = |i: f64| state.bounds().centre() + DVec3::new(i, 0.3 * i, -0.2);
    let turned = DQuat::from_rotation_x(0.4);
    let (mut commands, at_rest) = (Vec::new(), moment(&state));
    for (i, held) in [(0.0, false), (1.0, true), (2.0, true), (2.0, true), (3.0, false), (4.0, false)] {
        stylus.pose = Pose { rotation: turned, translation: tip(i) };
        stylus.buttons = Buttons::default().with(Button::Primary, held);
        stylus.force = 0.5;
        let events = follower.events(&stylus, &at_rest);
        commands.push(does(&mut interaction, &state, events));
    }
    let points = |command: &Command| match command {
        Command::Stroke(StrokeCommand::Begin { points, .. } | StrokeCommand::Extend { points }) => points.clone(),
        other => panic!("{other:?}"),
    };
    let counts: Vec<usize> = commands.iter().map(Vec::len).collect();
    assert_eq!(counts, [0, 1, 1, 0, 2, 0], "{commands:?}");
    for (i, at) in [(1, 1.0), (2, 2.0), (4, 3.0)] {
        let [point] = points(&commands[i][0])[..] else { panic!("{commands:?}") };
        assert_eq!((point.at, point.pressure), (Place::Mm(tip(at).to_array()), 0.5));
        // A disc faces the hand.
        let normal = DVec3::from_array(point.normal.unwrap());
        assert!(normal.distance(turned * DVec3::Z) < 1e-12, "{normal}");
    }
    assert!(matches!(commands[4][1], Command::Stroke(StrokeCommand::End {})));
}

#[test]
fn a_stylus_behind_the_eye_lets_go() {
    let state = crate::document::maker::state();
    let mut stylus = Stylus::new(Feel::new(ContactForce::default()));
    let mut follower = Follower::default();
    stylus.pose.translation = state.bounds().centre();
    stylus.buttons = Buttons::only(Button::Primary);
    assert!(matches!(
        follower.events(&stylus, &moment(&state))[..],
        [Event::Move(_), Event::Press(Button::Primary, _)]
    ));
    let camera = state.scene.views.camera;
    stylus.pose.translation = camera.eye - camera.forward() * 10.0;
    assert_eq!(follower.events(&stylus, &moment(&state)), [Event::Abort]);
    assert_eq!(follower.events(&stylus, &moment(&state)), []);
    assert_eq!(pointer_event(&stylus, &Moment { seen: None, ..moment(&state) }), None);
}
