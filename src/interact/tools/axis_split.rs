//! The axis splitter (Bruckner, Gröller 2006): a click cuts a part along the sight and the picture's width, with Shift its height.

use crate::document::{Scene, Splitter, ViewName};
use crate::explode::{Axis, Cut, Poses, axis_plane};
use crate::interact::aim::Aim;
use crate::interact::click::Click;
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::mark::Pen;
use crate::interact::slices::{CutSlice, cuts_at, cuts_of};
use crate::interact::tools::{About, Does, Press};
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Axis split",
    group: "Parts",
    keys: &[("X", "Axis split (Shift: vertical)")],
    hint: "Click a part, in 3D or on a slice, to cut it along a horizontal plane; Shift: vertical",
    icon: &[
        Pen::Closed(&[(3.0, 2.0), (13.0, 2.0), (13.0, 6.0), (3.0, 6.0)]),
        Pen::Closed(&[(3.0, 10.0), (13.0, 10.0), (13.0, 14.0), (3.0, 14.0)]),
        Pen::Line(&[(0.5, 8.0), (15.5, 8.0)]),
    ],
    of_parts: true,
    has_shift: true,
};

pub(super) struct AxisSplit;

impl Does for AxisSplit {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if e.view == ViewName::ThreeD && e.hit.is_none() {
            return Press::Looks;
        }
        let axis = if e.modifiers.shift { Axis::Vertical } else { Axis::Horizontal };
        let slice = CutSlice::new(context.grid, context.scene, e.view, e.size);
        let on_slice = slice.map(|slice| (slice, slice.across(e.px, axis)));
        Press::begins(Click { from: e.px, by: Splitter::Axis { px: e.px.to_array(), axis }, on_slice })
    }

    fn cuts(&self, _line: Option<[DVec2; 2]>, (scene, poses): (&Scene, &Poses), aim: Aim, axis: Axis) -> Vec<Cut> {
        match aim {
            Aim::Slice { px, slice } => cuts_at(&slice, scene, slice.across(px, axis), px),
            Aim::Solid { px, size, hit: Some(hit) } => {
                let plane = axis_plane(&scene.views.camera, px, size, axis, hit.world).ok();
                cuts_of((scene, poses), hit.part, plane)
            }
            Aim::Solid { hit: None, .. } => Vec::new(),
        }
    }
}
