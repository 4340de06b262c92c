//! The tool for labels: a click names a place of the 3D view, and the text stands beside the picture with a leader to it.

use crate::document::{Command, LabelChange, LabelCommand, Scene, ViewName};
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::tools::{About, Does, Press};
use crate::interact::writing::Written;
use crate::interact::written::pixel;
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Label",
    group: "Annotate",
    keys: &[("T", "Label: click at what is named")],
    hint: "Click at a place in the 3D view to name it; drag the end of a label's line to another place",
    icon: &[
        Pen::Circle((3.5, 12.5), 1.5),
        Pen::Line(&[(4.8, 11.3), (8.0, 5.0), (9.0, 5.0)]),
        Pen::Closed(&[(9.0, 2.5), (15.0, 2.5), (15.0, 7.5), (9.0, 7.5)]),
    ],
    of_parts: false,
    has_shift: false,
};

pub(super) struct Label;

impl Does for Label {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if let Some(press) = Press::on_written(e, context, of_tool) {
            return press;
        }
        match e.hit {
            Some(_) => Press::begins(New { change: context.writing.label(), size: e.size, at: e.px }),
            None => Press::Looks,
        }
    }

    fn picks(&self) -> Option<fn(Written) -> bool> {
        Some(of_tool)
    }

    fn refusal(&self, view: ViewName) -> Option<&'static str> {
        (view != ViewName::ThreeD).then_some("Labels name places of the 3D view")
    }
}

fn of_tool(one: Written) -> bool {
    matches!(one, Written::Label(_))
}

/// One that waits for its click to end.
#[derive(Debug)]
struct New {
    change: LabelChange,
    size: [u32; 2],
    at: DVec2,
}

impl Gesture for New {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        Vec::new()
    }

    fn commit(self: Box<Self>, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        if self.at.distance(e.px) > CLICK_PX {
            return Vec::new();
        }
        let at = Some(pixel(self.at, self.size));
        vec![Command::Label(LabelCommand::Add(LabelChange { at, ..self.change }))]
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        let ring = Mark::Ring { at: self.at, radius_px: 4.0, ink: Ink::Accent, faint: false };
        (view == ViewName::ThreeD).then_some(ring).into_iter().collect()
    }
}
