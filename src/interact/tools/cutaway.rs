//! The tool for cutaways: a drag from the middle opens a window into what lies behind a surface.

use crate::document::{Command, CutawayChange, CutawayCommand, Scene, ViewName};
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::tools::{About, Does, Press};
use crate::interact::writing::Written;
use crate::interact::written::{pixel, said, three_digits};
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Cutaway",
    group: "Annotate",
    keys: &[("C", "Cutaway: drag from its middle to a corner")],
    hint: "In the 3D view drag from the middle to a corner to cut a window; drag a middle to move it (Shift: turn, Ctrl: size)",
    icon: &[
        Pen::Closed(&[(1.5, 2.5), (14.5, 2.5), (14.5, 13.5), (1.5, 13.5)]),
        Pen::Closed(&[(4.5, 5.0), (11.5, 5.0), (11.5, 11.0), (4.5, 11.0)]),
        Pen::Line(&[(4.5, 5.0), (6.5, 7.0), (6.5, 11.0)]),
        Pen::Line(&[(6.5, 7.0), (11.5, 7.0)]),
    ],
    of_parts: false,
    has_shift: true,
};

/// A narrower one than this many pixels is none.
const LEAST_PX: f64 = 3.0;

pub(super) struct Cutaway;

impl Does for Cutaway {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if let Some(press) = Press::on_written(e, context, of_tool) {
            return press;
        }
        match e.hit {
            Some(hit) if !e.modifiers.shift => {
                let mm_per_px = context.scene.views.camera.mm_per_pixel(hit.depth_mm, e.size[1]);
                let change = context.writing.cutaway();
                Press::begins(New { change, size: e.size, mm_per_px, from: e.px, to: e.px })
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
        (view != ViewName::ThreeD).then_some("Cutaways are opened in the 3D view")
    }
}

fn of_tool(one: Written) -> bool {
    matches!(one, Written::Cutaway(_))
}

/// One that is being drawn.
#[derive(Debug)]
struct New {
    change: CutawayChange,
    size: [u32; 2],
    mm_per_px: f64,
    from: DVec2,
    to: DVec2,
}

impl New {
    /// From the middle to the corner under the hand.
    fn half(&self) -> DVec2 {
        (self.to - self.from).abs().max(DVec2::splat(LEAST_PX))
    }

    fn size_mm(&self) -> [f64; 2] {
        (self.half() * 2.0 * self.mm_per_px).to_array().map(three_digits)
    }
}

impl Gesture for New {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        if self.from.distance(self.to) <= CLICK_PX {
            return Vec::new();
        }
        let (at, [width, height]) = (Some(pixel(self.from, self.size)), self.size_mm());
        let (width_mm, height_mm) = (Some(width), Some(height));
        vec![Command::Cutaway(CutawayCommand::Add(CutawayChange { at, width_mm, height_mm, ..self.change }))]
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != ViewName::ThreeD {
            return Vec::new();
        }
        let ink = Ink::Accent;
        let mut marks = vec![Mark::Ring { at: self.from, radius_px: 4.0, ink, faint: false }];
        if self.from.distance(self.to) > CLICK_PX {
            let half = self.half();
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let corners = corners.map(|(x, y)| self.from + DVec2::new(x, y) * half);
            marks.extend((0..4).map(|i| Mark::Line { from: corners[i], to: corners[(i + 1) % 4], ink }));
            let [width, height] = self.size_mm().map(said);
            marks.push(Mark::Note { at: self.to, text: format!("{width} wide, {height} high") });
        }
        marks
    }
}
