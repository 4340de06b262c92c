//! What tools have drawn, as plain data: strokes of icons and marks over a picture. Whoever has a window draws them.

use crate::math::DVec2;

/// A stroke of an icon, on a grid of 16 by 16 whose first corner is top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pen {
    /// From point to point.
    Line(&'static [(f32, f32)]),
    /// From point to point and back to the first.
    Closed(&'static [(f32, f32)]),
    /// About a centre.
    Circle((f32, f32), f32),
    /// About a centre, half as wide and as high as the two numbers; a finer line.
    Ellipse((f32, f32), f32, f32),
}

/// The colour of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Of what the brush paints.
    Paint,
    /// Of what takes away.
    Erase,
    /// Of what is about to happen.
    Accent,
}

/// Something drawn over a view's picture; places and lengths are pixels of the view.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A straight line.
    Line {
        /// One end.
        from: DVec2,
        /// The other.
        to: DVec2,
        /// Colour.
        ink: Ink,
    },
    /// A circle; never too small to be seen.
    Ring {
        /// Centre.
        at: DVec2,
        /// Radius.
        radius_px: f64,
        /// Colour.
        ink: Ink,
        /// Hardly seen: how far something would reach.
        faint: bool,
    },
    /// A point, as small on every screen.
    Dot {
        /// Where.
        at: DVec2,
        /// Colour.
        ink: Ink,
    },
    /// Words beside the hand, as large on every screen.
    Note {
        /// The hand.
        at: DVec2,
        /// What is said.
        text: String,
    },
    /// The sign of taking away, as small on every screen.
    Minus {
        /// Its middle.
        at: DVec2,
        /// Colour.
        ink: Ink,
    },
}
