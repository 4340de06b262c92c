//! Isolation in one gesture: a click keeps alone what is connected to the place, or with E held takes it away.
//!
//! What is connected is the document's to find: the pixel goes to it.

use crate::document::{Command, ComponentCommand, Isolation, Place, Scene, ViewName};
use crate::interact::aim::Aimed;
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::tools::{About, Does, Press};

pub(super) const ABOUT: About = About {
    name: "Isolate",
    group: "Paint",
    keys: &[
        ("I", "Isolate: keep only what is connected to the click"),
        ("Hold E", "Remove what is connected instead"),
    ],
    hint: "Click keeps what is connected and removes the rest; hold E to remove it; a selection bounds both",
    icon: &[
        Pen::Closed(&[(5.0, 5.0), (11.0, 5.0), (11.0, 11.0), (5.0, 11.0)]),
        Pen::Line(&[(1.5, 4.5), (1.5, 1.5), (4.5, 1.5)]),
        Pen::Line(&[(11.5, 1.5), (14.5, 1.5), (14.5, 4.5)]),
        Pen::Line(&[(14.5, 11.5), (14.5, 14.5), (11.5, 14.5)]),
        Pen::Line(&[(4.5, 14.5), (1.5, 14.5), (1.5, 11.5)]),
    ],
    of_parts: false,
    has_shift: false,
};

pub(super) struct Isolate;

impl Does for Isolate {
    fn press(&self, e: &PointerEvent, _context: &Context<'_>) -> Press {
        if e.view == ViewName::ThreeD && e.hit.is_none() {
            return Press::Looks;
        }
        Press::begins(Pick(*e))
    }

    fn marks(&self, _scene: &Scene, at: &Aimed) -> Vec<Mark> {
        if at.mm_per_px.is_none() {
            return Vec::new();
        }
        let (px, ink) = (at.px, if at.erase { Ink::Erase } else { Ink::Paint });
        let dot = Mark::Dot { at: px, ink };
        if at.erase { vec![dot, Mark::Minus { at: px, ink }] } else { vec![dot] }
    }
}

/// A click that has not ended.
#[derive(Debug)]
struct Pick(PointerEvent);

impl Gesture for Pick {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        Vec::new()
    }

    fn commit(self: Box<Self>, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let from = self.0;
        if from.px.distance(e.px) > CLICK_PX {
            return Vec::new();
        }
        let at = Place::Pixel { view: from.view, px: from.px.to_array(), size: Some(from.size) };
        let what = Isolation::at(at);
        vec![Command::Component(match from.modifiers.erase {
            true => ComponentCommand::Remove(what),
            false => ComponentCommand::Keep(what),
        })]
    }
}
