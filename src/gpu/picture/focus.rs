//! What of a picture is looked at: a ball whose matter is drawn as it is, among a context that is drawn faintly or as contours.
//!
//! Plain data. What lies outside the ball is a layer of its own before and behind it, of one opacity as a whole: solid matter of a tenth
//! of its opacity would still be solid a few voxels on. Knows nothing of how it is drawn.

use crate::math::DVec3;

/// How what lies outside the ball is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Context {
    /// As it is, but thinner.
    Faded,
    /// Only where surfaces turn away from the eye.
    Contour,
}

/// A ball in the world, as posed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// World mm.
    pub centre: DVec3,
    /// Positive.
    pub radius_mm: f64,
    /// Opacity of everything before the ball together, and of everything behind it: 0 to 1.
    pub opacity: f32,
    /// How that is drawn.
    pub context: Context,
}

impl Focus {
    /// Whether a picture with it is another one than without.
    pub fn changes(&self) -> bool {
        self.context == Context::Contour || self.opacity < 1.0
    }
}
