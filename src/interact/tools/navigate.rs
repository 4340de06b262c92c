//! No tool in hand: the 3D view turns, on slices the crosshair follows.

use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::mark::Pen;
use crate::interact::tools::{About, Does, Press};

pub(super) const ABOUT: About = About {
    name: "Navigate",
    group: "Look",
    keys: &[("N", "Navigate")],
    hint: "Drag turns the 3D view, on slices it moves the crosshair",
    icon: &[Pen::Ellipse((8.0, 8.0), 6.5, 2.6), Pen::Ellipse((8.0, 8.0), 2.6, 6.5), Pen::Circle((8.0, 8.0), 6.5)],
    of_parts: false,
    has_shift: false,
};

pub(super) struct Navigate;

impl Does for Navigate {
    fn press(&self, _e: &PointerEvent, _context: &Context<'_>) -> Press {
        Press::Looks
    }
}
