//! A part under the hand: shifted in the plane of the picture or turned about its centre, one step of history, pinned where it ends.

use crate::document::{Command, PartCommand, Scene, ViewName};
use crate::explode::PartId;
use crate::interact::context::Context;
use crate::interact::event::{Hit, PointerEvent};
use crate::interact::gesture::{DEGREES_PER_HEIGHT, Gesture};
use crate::interact::mark::Pen;
use crate::interact::tools::{About, Does, Press};
use crate::math::{Camera, DQuat, DVec2, DVec3, Pose};

pub(super) const ABOUT: About = About {
    name: "Move part",
    group: "Parts",
    keys: &[
        ("M", "Move part"),
        ("Drag, tool Move part", "Move a part and pin it"),
        ("Ctrl + drag, tool Move part", "Turn a part and pin it"),
    ],
    hint: "In the 3D view a drag moves a part and pins it; Ctrl + drag turns it",
    icon: &[
        Pen::Line(&[(8.0, 1.5), (8.0, 14.5)]),
        Pen::Line(&[(1.5, 8.0), (14.5, 8.0)]),
        Pen::Line(&[(6.0, 3.5), (8.0, 1.5), (10.0, 3.5)]),
        Pen::Line(&[(6.0, 12.5), (8.0, 14.5), (10.0, 12.5)]),
        Pen::Line(&[(3.5, 6.0), (1.5, 8.0), (3.5, 10.0)]),
        Pen::Line(&[(12.5, 6.0), (14.5, 8.0), (12.5, 10.0)]),
    ],
    of_parts: true,
    has_shift: false,
};

pub(super) struct MovePart;

impl Does for MovePart {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        // Slices show the volume at rest: there is nothing to move there.
        if e.view != ViewName::ThreeD {
            return Press::Nothing;
        }
        let taken = e.hit.and_then(|hit| {
            let part = context.scene.explosion.parts.iter().find(|p| Some(p.id) == hit.part)?;
            let (start, centre) = (context.poses.of(part), part.centre());
            Some(Held { id: part.id, start, from: e.px, hit, turn: e.modifiers.ctrl, centre, moved: false })
        });
        taken.map_or(Press::Looks, Press::begins)
    }

    fn refusal(&self, view: ViewName) -> Option<&'static str> {
        (view != ViewName::ThreeD).then_some("Parts are moved in the 3D view")
    }
}

/// A part under the hand.
#[derive(Debug)]
struct Held {
    id: PartId,
    start: Pose,
    from: DVec2,
    hit: Hit,
    turn: bool,
    centre: DVec3,
    moved: bool,
}

impl Gesture for Held {
    fn drag(&mut self, e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        // A click alone must not pin the part.
        self.moved |= e.px != self.from;
        if !self.moved {
            return Vec::new();
        }
        let pose = self.pose(&scene.views.camera, e);
        vec![Command::Part(PartCommand::Move { id: self.id, pose })]
    }
}

impl Held {
    /// Where the part is after a drag: shifted at the depth where it was taken, or turned.
    fn pose(&self, camera: &Camera, e: &PointerEvent) -> Pose {
        let (start, d) = (self.start, e.px - self.from);
        let (right, up) = camera.right_up();
        if self.turn {
            let angle = d / f64::from(e.size[1].max(1)) * DEGREES_PER_HEIGHT.to_radians();
            let rotation = DQuat::from_axis_angle(up, angle.x) * DQuat::from_axis_angle(right, angle.y);
            let about = Pose::about(start.apply(self.centre), rotation, DVec3::ZERO);
            return Pose { rotation: rotation * start.rotation, translation: about.apply(start.translation) };
        }
        let mm = camera.mm_per_pixel(self.hit.depth_mm, e.size[1]);
        Pose { translation: start.translation + right * (d.x * mm) - up * (d.y * mm), ..start }
    }
}
