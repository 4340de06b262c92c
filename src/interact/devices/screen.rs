//! Pointers on a screen: a mouse, and a pen that tells how hard it is pressed.

use crate::document::ViewName;
use crate::interact::devices::{Buttons, Pointer, Position, share};
use crate::math::{DVec2, DVec3};

/// A place over a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenPlace {
    /// The view it is over, or where its drag began.
    pub view: ViewName,
    /// Pixels of the view; (0, 0) is its top-left corner.
    pub px: DVec2,
    /// The view's size in pixels.
    pub size: [u32; 2],
}

/// A mouse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mouse {
    /// Where it is.
    pub place: ScreenPlace,
    /// What is held.
    pub buttons: Buttons,
}

impl Pointer for Mouse {
    fn position(&self) -> Position {
        Position::Screen(self.place)
    }

    fn direction(&self) -> Option<DVec3> {
        None
    }

    fn pressure(&self) -> f32 {
        1.0
    }

    fn buttons(&self) -> Buttons {
        self.buttons
    }
}

/// A pen on a tablet, or a finger that tells its force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Where it is.
    pub place: ScreenPlace,
    /// What is held; the tip is the primary one.
    pub buttons: Buttons,
    /// How hard it is pressed, as its driver says it; what lies beyond 0..1 counts as the end.
    pub force: f32,
}

impl Pointer for Pen {
    fn position(&self) -> Position {
        Position::Screen(self.place)
    }

    fn direction(&self) -> Option<DVec3> {
        None
    }

    fn pressure(&self) -> f32 {
        share(self.force)
    }

    fn buttons(&self) -> Buttons {
        self.buttons
    }
}
