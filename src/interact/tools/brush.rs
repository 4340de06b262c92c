//! The brush: a drag is a stroke; E takes away for as long as it is held.
//!
//! What a stroke paints is the document's: points of the picture go to it as they come. Owns the way from key to `erase`.

use crate::document::{Command, Place, Scene, StrokeCommand, StrokePoint, ViewName};
use crate::interact::aim::Aimed;
use crate::interact::brush::{reach, set_erase};
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::tools::{About, Does, Press};

pub(super) const ABOUT: About = About {
    name: "Brush",
    group: "Paint",
    keys: &[
        ("B", "Brush"),
        ("[  ]", "Smaller or larger brush"),
        ("Shift + wheel", "Smaller or larger brush"),
        ("Hold E", "Erase, also from the middle of a stroke on"),
        ("1 … 9", "Paint this label"),
        ("Esc", "Take the running stroke back"),
    ],
    hint: "Drag paints; hold E to erase; outside the object a drag turns the 3D view",
    icon: &[
        Pen::Line(&[(14.0, 2.0), (7.5, 8.5)]),
        Pen::Closed(&[(7.0, 8.0), (9.0, 10.0), (7.0, 13.0), (2.0, 14.0), (3.5, 9.5)]),
    ],
    of_parts: false,
    has_shift: false,
};

pub(super) struct Brush;

impl Does for Brush {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if e.view == ViewName::ThreeD && e.hit.is_none() {
            return Press::Looks;
        }
        let fixed = context.scene.brush.erase;
        Press::begins(Stroke { last: *e, erase: e.modifiers.erase && !fixed, fixed })
    }

    fn marks(&self, scene: &Scene, at: &Aimed) -> Vec<Mark> {
        let Some(mm_per_px) = at.mm_per_px else { return Vec::new() };
        let rim = scene.brush.radius_mm / mm_per_px;
        let radius = rim * reach(&scene.brush);
        let erase = scene.brush.erase || at.erase;
        let (at, ink) = (at.px, if erase { Ink::Erase } else { Ink::Paint });
        let mut marks = Vec::new();
        if radius < rim {
            marks.push(Mark::Ring { at, radius_px: rim, ink, faint: true });
        }
        marks.push(Mark::Ring { at, radius_px: radius, ink, faint: false });
        marks.push(Mark::Dot { at, ink });
        if erase {
            marks.push(Mark::Minus { at, ink });
        }
        marks
    }
}

/// A stroke under the hand.
#[derive(Debug)]
struct Stroke {
    last: PointerEvent,
    /// The brush is set to take away for as long as the key is held.
    erase: bool,
    /// It takes away anyway.
    fixed: bool,
}

impl Gesture for Stroke {
    fn start(&self, e: &PointerEvent) -> Vec<Command> {
        let begin = begin(e);
        if self.erase { vec![set_erase(true), begin] } else { vec![begin] }
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let switch = !self.fixed && e.modifiers.erase != self.erase;
        if (e.px, e.space) == (self.last.px, self.last.space) || switch && e.px.distance(self.last.px) <= CLICK_PX {
            return Vec::new();
        }
        let mut commands = Vec::new();
        if switch {
            // From where the key changed on it is another stroke.
            self.erase = e.modifiers.erase;
            commands.push(Command::Stroke(StrokeCommand::End {}));
            commands.extend([set_erase(self.erase), begin(&self.last)]);
        }
        self.last = *e;
        commands.push(Command::Stroke(StrokeCommand::Extend { points: vec![point(e)] }));
        commands
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.over(StrokeCommand::End {})
    }

    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        self.over(StrokeCommand::Cancel {})
    }
}

impl Stroke {
    fn over(&self, how: StrokeCommand) -> Vec<Command> {
        let over = Command::Stroke(how);
        if self.erase { vec![over, set_erase(false)] } else { vec![over] }
    }
}

fn begin(e: &PointerEvent) -> Command {
    Command::Stroke(StrokeCommand::begin(vec![point(e)]))
}

fn point(e: &PointerEvent) -> StrokePoint {
    let (at, normal) = match e.space {
        // What is in space says itself where it is, inside of matter too; a disc faces where it comes from.
        Some(space) => (Place::Mm(space.mm.to_array()), space.direction.map(|d| (-d).to_array())),
        None => (Place::Pixel { view: e.view, px: e.px.to_array(), size: Some(e.size) }, None),
    };
    StrokePoint { at, pressure: e.pressure, breaks: false, normal }
}
