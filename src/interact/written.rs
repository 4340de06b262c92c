//! What is written on surfaces, under the hand: shifted, turned about its middle or scaled.
//!
//! Nothing changes before the button goes up, since what is laid anew takes its time.

use crate::document::{
    AnnotationChange, AnnotationCommand, Command, CutawayChange, CutawayCommand, LabelChange, LabelCommand, Outline,
    Place, Scene, ViewName,
};
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark};
use crate::interact::writing::Written;
use crate::math::DVec2;

/// Pixels of a drag that double a size.
const DOUBLES_PX: f64 = 120.0;

/// What a drag does with it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum How {
    Move,
    Turn,
    Scale,
}

/// A thing under the hand.
#[derive(Debug)]
pub(super) struct HeldThing {
    one: Written,
    how: How,
    /// Its middle in the picture.
    at: DVec2,
    from: DVec2,
    to: DVec2,
    /// The last pixel of the way that shows something.
    on: Option<DVec2>,
    size: [u32; 2],
}

impl HeldThing {
    /// Shift turns, Ctrl scales.
    pub(super) fn new(e: &PointerEvent, (one, at): (Written, DVec2)) -> Self {
        let how = match (e.modifiers.shift, e.modifiers.ctrl, one) {
            (_, _, Written::Label(_)) => How::Move,
            (true, ..) => How::Turn,
            (_, true, _) => How::Scale,
            _ => How::Move,
        };
        Self { one, how, at, from: e.px, to: e.px, on: None, size: e.size }
    }

    fn factor(&self) -> f64 {
        let by = self.to - self.from;
        ((by.x - by.y) / DOUBLES_PX).exp2()
    }

    fn change(&self, scene: &Scene) -> Option<Command> {
        let place = self.on.map(|px| pixel(px, self.size));
        let (at, toward) = match self.how {
            How::Move => (Some(place?), None),
            How::Turn => (None, Some(place?)),
            How::Scale => (None, None),
        };
        let scaled = |mm: f64| (self.how == How::Scale).then(|| three_digits(mm * self.factor()));
        Some(match self.one {
            Written::Annotation(id) => {
                let size_mm = scaled(scene.annotations.all.get(&id)?.size_mm);
                let change = AnnotationChange { id: Some(id), at, toward, size_mm, ..AnnotationChange::default() };
                Command::Annotation(AnnotationCommand::Set(change))
            }
            Written::Cutaway(id) => {
                let mut change = CutawayChange { id: Some(id), at, toward, ..CutawayChange::default() };
                match (self.how, &scene.cutaways.all.get(&id)?.outline) {
                    (How::Scale, Outline::Grid { width_mm, height_mm }) => {
                        (change.width_mm, change.height_mm) = (scaled(*width_mm), scaled(*height_mm));
                    }
                    (How::Scale, Outline::Lasso { .. }) => return None,
                    _ => {}
                }
                Command::Cutaway(CutawayCommand::Set(change))
            }
            Written::Label(id) => {
                Command::Label(LabelCommand::Set(LabelChange { id: Some(id), at, ..LabelChange::default() }))
            }
        })
    }
}

impl Gesture for HeldThing {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        self.on = e.hit.map(|_| e.px).or(self.on);
        Vec::new()
    }

    fn commit(self: Box<Self>, e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        if self.from.distance(e.px) <= CLICK_PX {
            return Vec::new();
        }
        self.change(scene).into_iter().collect()
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != ViewName::ThreeD || self.from.distance(self.to) <= CLICK_PX {
            return Vec::new();
        }
        let text = match self.how {
            How::Move => "Move".to_owned(),
            How::Turn => "Turn".to_owned(),
            How::Scale => format!("Size × {:.2}", self.factor()),
        };
        let mut marks = vec![Mark::Note { at: self.to, text }];
        if self.how != How::Scale {
            marks.push(Mark::Line { from: self.at, to: self.to, ink: Ink::Accent });
        }
        marks
    }
}

/// A pixel of the 3D view.
pub(super) fn pixel(px: DVec2, size: [u32; 2]) -> Place {
    Place::Pixel { view: ViewName::ThreeD, px: px.to_array(), size: Some(size) }
}

/// A length as a hand would have typed it.
pub(super) fn three_digits(mm: f64) -> f64 {
    let digits = 10.0_f64.powf(2.0 - mm.abs().max(1e-12).log10().floor());
    (mm * digits).round() / digits
}

/// A length in words.
pub(super) fn said(mm: f64) -> String {
    format!("{} mm", three_digits(mm))
}
