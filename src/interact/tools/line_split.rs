//! The line splitter (Bruckner, Gröller 2006): a line that is dragged cuts all parts that it crosses.

use crate::document::{Command, PartCommand, Scene, Splitter, ViewName};
use crate::explode::{Axis, Cut, Poses, line_plane};
use crate::interact::aim::Aim;
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::Pen;
use crate::interact::slices::{CutSlice, cuts_along, cuts_of, split};
use crate::interact::tools::{About, Does, Press};
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Line split",
    group: "Parts",
    keys: &[("L", "Line split"), ("Click or line on a slice", "Cut there, with the split tools")],
    hint: "Drag a line across the parts to cut, in 3D or on a slice",
    icon: &[
        Pen::Line(&[(1.5, 14.5), (14.5, 1.5)]),
        Pen::Line(&[(2.5, 9.0), (2.5, 2.5), (9.0, 2.5)]),
        Pen::Line(&[(13.5, 7.0), (13.5, 13.5), (7.0, 13.5)]),
    ],
    of_parts: true,
    has_shift: false,
};

pub(super) struct LineSplit;

impl Does for LineSplit {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        let slice = CutSlice::new(context.grid, context.scene, e.view, e.size);
        Press::begins(Line { view: e.view, from: e.px, to: e.px, slice })
    }

    fn cuts(&self, line: Option<[DVec2; 2]>, (scene, poses): (&Scene, &Poses), aim: Aim, _axis: Axis) -> Vec<Cut> {
        let Some([from, to]) = line else { return Vec::new() };
        match aim {
            Aim::Slice { slice, .. } => cuts_along(&slice, scene, from, to),
            Aim::Solid { size, .. } => {
                let camera = &scene.views.camera;
                let parts = scene.explosion.meeting(poses, camera, from, to, size).unwrap_or_default();
                cuts_of((scene, poses), parts, line_plane(camera, from, to, size).ok())
            }
        }
    }
}

/// The line under the hand; on a slice with where that lies.
#[derive(Debug)]
struct Line {
    view: ViewName,
    from: DVec2,
    to: DVec2,
    slice: Option<CutSlice>,
}

impl Gesture for Line {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        Vec::new()
    }

    fn commit(self: Box<Self>, e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        let Self { from, to, slice, .. } = *self;
        if from.distance(to) <= CLICK_PX {
            return Vec::new();
        }
        match slice {
            Some(slice) => split(&cuts_along(&slice, scene, from, to)),
            None => {
                let by = Splitter::Line { from: from.to_array(), to: to.to_array() };
                vec![Command::Part(PartCommand::Split { by, size: Some(e.size) })]
            }
        }
    }

    fn line(&self) -> Option<(ViewName, [DVec2; 2])> {
        Some((self.view, [self.from, self.to]))
    }
}
