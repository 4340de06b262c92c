//! The tool that lays annotations on surfaces: a press is the centre, the drag their direction; what is there is moved, turned and scaled.
//!
//! What a new one shows is said in the panel. Where pixels lie on the surface is the document's to find.

use crate::document::{AnnotationChange, AnnotationCommand, Command, Scene, ViewName};
use crate::interact::context::Context;
use crate::interact::event::{Hit, PointerEvent};
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::tools::{About, Does, Press};
use crate::interact::writing::{WritingKind, Written};
use crate::interact::written::{pixel, said, three_digits};
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Annotate",
    group: "Annotate",
    keys: &[
        ("A", "Annotate: press at the centre, drag where it goes"),
        ("Click or drag a centre", "Pick or move what is there"),
        ("Shift, Ctrl + drag a centre", "Turn it, scale it"),
        ("Delete", "Remove what is picked"),
    ],
    hint: "In the 3D view press at the centre and drag where it goes; drag a centre to move it (Shift: turn, Ctrl: size)",
    icon: &[
        Pen::Line(&[(2.0, 13.5), (6.5, 2.5), (11.0, 13.5)]),
        Pen::Line(&[(3.7, 9.5), (9.3, 9.5)]),
        Pen::Line(&[(12.0, 13.5), (14.5, 13.5)]),
    ],
    of_parts: false,
    has_shift: true,
};

pub(super) struct Annotate;

impl Does for Annotate {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if let Some(press) = Press::on_written(e, context, of_tool) {
            return press;
        }
        match e.hit {
            Some(first) if !e.modifiers.shift => {
                let (kind, change) = (context.writing.kind, context.writing.annotation());
                Press::begins(New { kind, change, size: e.size, from: (e.px, first), to: e.px, on: (e.px, first) })
            }
            // Shift is for what is there.
            _ if e.modifiers.shift => Press::Nothing,
            _ => Press::Looks,
        }
    }

    fn picks(&self) -> Option<fn(Written) -> bool> {
        Some(of_tool)
    }

    fn refusal(&self, view: ViewName) -> Option<&'static str> {
        (view != ViewName::ThreeD).then_some("Annotations are laid in the 3D view")
    }
}

fn of_tool(one: Written) -> bool {
    matches!(one, Written::Annotation(_))
}

/// One that is being drawn.
#[derive(Debug)]
struct New {
    kind: WritingKind,
    change: AnnotationChange,
    size: [u32; 2],
    /// Where the button went down.
    from: (DVec2, Hit),
    to: DVec2,
    /// The last place of the way that shows something.
    on: (DVec2, Hit),
}

impl New {
    fn length_mm(&self) -> f64 {
        self.from.1.world.distance(self.on.1.world)
    }

    fn has_end(&self) -> bool {
        matches!(self.kind, WritingKind::Arrow | WritingKind::Ruler)
    }
}

impl Gesture for New {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        self.on = e.hit.map_or(self.on, |hit| (e.px, hit));
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let (from, to) = (self.from.0, self.on.0);
        let drawn = from.distance(to) > CLICK_PX;
        // What has two ends is nothing without the second.
        if self.has_end() && !drawn {
            return Vec::new();
        }
        let (end, length_mm) = (drawn.then(|| pixel(to, self.size)), self.length_mm());
        let mut change = self.change;
        match self.kind {
            WritingKind::Ruler => (change.at, change.to) = (Some(pixel(from, self.size)), end),
            // It lies about its middle.
            WritingKind::Arrow => {
                (change.at, change.toward) = (Some(pixel(from.midpoint(to), self.size)), end);
                change.size_mm = Some(three_digits(length_mm));
            }
            _ => (change.at, change.toward) = (Some(pixel(from, self.size)), end),
        }
        vec![Command::Annotation(AnnotationCommand::Add(change))]
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != ViewName::ThreeD {
            return Vec::new();
        }
        let (from, to, ink) = (self.from.0, self.to, Ink::Accent);
        let mut marks = vec![Mark::Ring { at: from, radius_px: 4.0, ink, faint: false }];
        if from.distance(to) <= CLICK_PX {
            return marks;
        }
        marks.push(Mark::Line { from, to, ink });
        if self.has_end() {
            // The head of an arrow, so that it is seen which way it goes.
            if self.kind == WritingKind::Arrow {
                let back = (from - to).normalize_or_zero() * 10.0;
                let side = back.perp() * 0.5;
                marks.extend([side, -side].map(|side| Mark::Line { from: to, to: to + back + side, ink }));
            }
            marks.push(Mark::Note { at: to, text: format!("{} straight", said(self.length_mm())) });
        }
        marks
    }
}
