//! The lasso: a contour drawn on a slice fills with what the brush paints; E takes away.
//!
//! Owns the way of the hand until the button goes up. What is filled is the document's.

use crate::document::{Command, Lasso as Contour, Place, Scene, StrokeCommand, ViewName};
use crate::interact::brush::set_erase;
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::tools::{About, Does, Press};
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Lasso",
    group: "Paint",
    keys: &[("O", "Lasso: draw around what is to be painted, on a slice"), ("Hold E", "Erase what is drawn around")],
    hint: "Draw around something on a slice: it fills with what the brush paints; hold E to erase",
    icon: &[
        Pen::Closed(&[(8.0, 2.0), (13.0, 3.5), (14.5, 7.0), (12.0, 10.0), (7.0, 10.5), (2.5, 9.0), (1.5, 5.5), (4.0, 3.0)]),
        Pen::Line(&[(7.0, 10.5), (5.0, 12.5), (6.5, 14.5)]),
    ],
    of_parts: false,
    has_shift: false,
};

/// Points nearer to the one before say nothing new, pixels.
const APART_PX: f64 = 1.0;

pub(super) struct Lasso;

impl Does for Lasso {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if e.view == ViewName::ThreeD {
            return Press::Looks;
        }
        let fixed = context.scene.brush.erase;
        Press::begins(Way { view: e.view, size: e.size, points: vec![e.px], erase: e.modifiers.erase && !fixed })
    }

    fn refusal(&self, view: ViewName) -> Option<&'static str> {
        (view == ViewName::ThreeD).then_some("The lasso is drawn on a slice: in 3D a drag turns the view")
    }
}

/// The way of the hand.
#[derive(Debug)]
struct Way {
    view: ViewName,
    size: [u32; 2],
    points: Vec<DVec2>,
    erase: bool,
}

impl Gesture for Way {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        if self.points.last().is_none_or(|last| last.distance(e.px) >= APART_PX) {
            self.points.push(e.px);
        }
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let Self { view, size, points, erase } = *self;
        let far = points.iter().map(|p| p.distance(points[0])).fold(0.0, f64::max);
        if points.len() < 3 || far <= CLICK_PX {
            return Vec::new();
        }
        let place = |px: &DVec2| Place::Pixel { view, px: px.to_array(), size: Some(size) };
        let fill = Command::Stroke(StrokeCommand::Lasso(Contour::of(points.iter().map(place).collect())));
        if erase { vec![set_erase(true), fill, set_erase(false)] } else { vec![fill] }
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != self.view {
            return Vec::new();
        }
        let ink = if self.erase { Ink::Erase } else { Ink::Paint };
        let next = self.points.iter().skip(1).chain(self.points.first());
        self.points.iter().zip(next).map(|(from, to)| Mark::Line { from: *from, to: *to, ink }).collect()
    }
}
