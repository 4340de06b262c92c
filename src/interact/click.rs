//! A splitter that waits for its click to end.

use crate::document::{Command, PartCommand, Scene, Splitter};
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::slices::{CutSlice, cuts_at, split};
use crate::math::{DVec2, Plane};

/// Cuts the part that was clicked: as the splitter says in the 3D view, on a slice along a plane at rest.
#[derive(Debug)]
pub(super) struct Click {
    /// Where the button went down.
    pub(super) from: DVec2,
    /// In the 3D view.
    pub(super) by: Splitter,
    /// On a slice; `None` in the 3D view.
    pub(super) on_slice: Option<(CutSlice, Option<Plane>)>,
}

impl Gesture for Click {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        Vec::new()
    }

    fn commit(self: Box<Self>, e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        if self.from.distance(e.px) > CLICK_PX {
            return Vec::new();
        }
        match self.on_slice {
            Some((slice, plane)) => split(&cuts_at(&slice, scene, plane, self.from)),
            None => vec![Command::Part(PartCommand::Split { by: self.by, size: Some(e.size) })],
        }
    }
}
