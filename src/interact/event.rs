//! What a user's hand does, free of any window system.

use crate::document::ViewName;
use crate::explode::PartId;
use crate::math::{DVec2, DVec3};

/// A button of the pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Left, or a pen's tip.
    Primary,
    /// Right.
    Secondary,
    /// The wheel.
    Middle,
}

/// Keys that are held while the pointer moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modifiers {
    /// Shift.
    pub shift: bool,
    /// Ctrl, or Cmd where that is the custom.
    pub ctrl: bool,
    /// Alt.
    pub alt: bool,
    /// Space: drags pan.
    pub space: bool,
    /// E: the brush takes away.
    pub erase: bool,
}

impl Modifiers {
    /// Whether a drag moves a view or the crosshair, whatever the tool.
    pub fn pans(self) -> bool {
        self.space || self.alt || self.shift
    }
}

/// What is under the pointer in the 3D view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// World mm, where it is now.
    pub world: DVec3,
    /// The part, if it belongs to one.
    pub part: Option<PartId>,
    /// Distance along the direction of sight in mm.
    pub depth_mm: f64,
}

/// The pointer at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointerEvent {
    /// The view it is over, or where its drag began.
    pub view: ViewName,
    /// Pixels of the view; (0, 0) is its top-left corner.
    pub px: DVec2,
    /// The view's size in pixels.
    pub size: [u32; 2],
    /// Held keys.
    pub modifiers: Modifiers,
    /// 0..1; 1 without a pen.
    pub pressure: f32,
    /// Seconds, any origin.
    pub time_s: f64,
    /// What lies under it; only in the 3D view.
    pub hit: Option<Hit>,
    /// Where it is in the world, of one that moves in space and not over a view.
    pub space: Option<InSpace>,
}

/// Where a pointer is that moves in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InSpace {
    /// World mm, at rest.
    pub mm: DVec3,
    /// Where its tip looks, unit.
    pub direction: Option<DVec3>,
}

/// Turns of the wheel over a view; one notch is 1, away from the user is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// The view.
    pub view: ViewName,
    /// Notches; touchpads give fractions.
    pub notches: f64,
    /// Held keys.
    pub modifiers: Modifiers,
}

/// A key, as far as shortcuts use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A letter or digit, upper case.
    Char(char),
    /// `[`
    BracketLeft,
    /// `]`
    BracketRight,
    /// Escape.
    Escape,
    /// F1, or `?`.
    Help,
    /// Delete.
    Delete,
    /// Home: fit the view.
    Home,
    /// Arrow or page key up: the next slice.
    Up,
    /// Arrow or page key down: the slice before.
    Down,
    /// Arrow left.
    Left,
    /// Arrow right.
    Right,
}

/// What a hand did: positions in pixels of a view, pressure from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A button goes down over a view.
    Press(Button, PointerEvent),
    /// The pointer moves, with or without a button.
    Move(PointerEvent),
    /// The button goes up.
    Release(Button, PointerEvent),
    /// The wheel turns.
    Wheel(Wheel),
    /// Whatever runs is taken back: Escape, a lost window, another tool.
    Abort,
}
