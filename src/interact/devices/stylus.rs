//! A pointer with six degrees of freedom: the tip of a stylus in the world, which feels the surface it touches.

use crate::document::ContactField;
use crate::interact::devices::{Buttons, Feel, Pointer, Position, Touch, share};
use crate::math::{DVec3, Pose};

/// A stylus in the hand; its driver says where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Stylus {
    /// Of the tip in the world at rest, mm; without a turn it looks along −z.
    pub pose: Pose,
    /// What is held; its own button is the primary one.
    pub buttons: Buttons,
    /// 0..1; 1 of one that cannot tell.
    pub force: f32,
    /// What it feels.
    pub feel: Feel,
}

impl Stylus {
    /// One that feels so, at the world's middle.
    pub fn new(feel: Feel) -> Self {
        Self { pose: Pose::IDENTITY, buttons: Buttons::default(), force: 1.0, feel }
    }

    /// The tip, world mm at rest.
    pub fn tip(&self) -> DVec3 {
        self.pose.translation
    }

    /// What it feels of a surface now, `dt_s` after the last time: see [`Feel::step`].
    pub fn touch(&mut self, field: &ContactField, value: f64, dt_s: f64) -> Touch {
        let tip = self.tip();
        self.feel.step(field, tip, value, dt_s)
    }
}

impl Pointer for Stylus {
    fn position(&self) -> Position {
        Position::World(self.tip())
    }

    fn direction(&self) -> Option<DVec3> {
        Some(self.pose.rotation * DVec3::NEG_Z)
    }

    fn pressure(&self) -> f32 {
        share(self.force)
    }

    fn buttons(&self) -> Buttons {
        self.buttons
    }
}
