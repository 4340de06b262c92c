//! The depth splitter (Bruckner, Gröller 2006): a click takes off what of a part lies before the place, parallel to the picture.

use crate::document::{Scene, Splitter, ViewName};
use crate::explode::{Axis, Cut, Poses, depth_plane};
use crate::interact::aim::Aim;
use crate::interact::click::Click;
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::mark::Pen;
use crate::interact::slices::{CutSlice, cuts_at, cuts_of};
use crate::interact::tools::{About, Does, Press};
use crate::math::DVec2;

pub(super) const ABOUT: About = About {
    name: "Depth split",
    group: "Parts",
    keys: &[("D", "Depth split")],
    hint: "Click a part, in 3D or on a slice, to cut it parallel to the picture",
    icon: &[
        Pen::Closed(&[(2.0, 2.0), (10.0, 2.0), (10.0, 10.0), (2.0, 10.0)]),
        Pen::Line(&[(12.0, 6.0), (14.0, 6.0), (14.0, 14.0), (6.0, 14.0), (6.0, 12.0)]),
    ],
    of_parts: true,
    has_shift: false,
};

pub(super) struct DepthSplit;

impl Does for DepthSplit {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        if e.view == ViewName::ThreeD && e.hit.is_none() {
            return Press::Looks;
        }
        let slice = CutSlice::new(context.grid, context.scene, e.view, e.size);
        let on_slice = slice.map(|slice| (slice, slice.flat()));
        Press::begins(Click { from: e.px, by: Splitter::Depth { px: e.px.to_array() }, on_slice })
    }

    fn cuts(&self, _line: Option<[DVec2; 2]>, (scene, poses): (&Scene, &Poses), aim: Aim, _axis: Axis) -> Vec<Cut> {
        match aim {
            Aim::Slice { px, slice } => cuts_at(&slice, scene, slice.flat(), px),
            Aim::Solid { hit: Some(hit), .. } => {
                let plane = depth_plane(&scene.views.camera, hit.world).ok();
                cuts_of((scene, poses), hit.part, plane)
            }
            Aim::Solid { hit: None, .. } => Vec::new(),
        }
    }

    fn peels(&self) -> bool {
        true
    }
}
