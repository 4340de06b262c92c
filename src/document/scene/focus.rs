//! What the 3D view looks at while somebody edits: what lies near the brush as it is, all else faintly or as contours.
//!
//! Owns what a person decided of it. Where the brush is, is not the scene's: see `document::live::aim`.

use crate::document::error::DocumentError;
use crate::document::scene::check::finite;
use crate::gpu::{Context, Focus};
use crate::math::DVec3;
use crate::volume::Grid;
use serde::{Deserialize, Serialize};

/// How what lies farther from the brush is drawn in 3D.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FarMatter {
    /// As it is, but thinner.
    #[default]
    Faded,
    /// Only where surfaces turn away from the eye.
    Contour,
}

impl FarMatter {
    /// The opacity that it has until another is said.
    pub(crate) fn usual_opacity(self) -> f32 {
        match self {
            Self::Faded => 0.25,
            Self::Contour => 0.8,
        }
    }
}

/// Focus and context of the 3D view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ViewFocus {
    /// Whether there is one.
    pub on: bool,
    /// How far about the brush's footprint matter is drawn as it is, mm, 0 or more.
    pub distance_mm: f64,
    /// Opacity of what lies farther, before it and behind it each together, 0..1.
    pub opacity: f32,
    /// How that is drawn.
    #[serde(rename = "as")]
    pub far: FarMatter,
    /// A place that it stays at, world mm at rest; left out: where the brush is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
}

impl Default for ViewFocus {
    fn default() -> Self {
        let far = FarMatter::default();
        Self { on: false, distance_mm: 20.0, opacity: far.usual_opacity(), far, at: None }
    }
}

impl ViewFocus {
    /// Of a document that was just opened: off, and wide enough to see where one is.
    pub(crate) fn of(grid: &Grid) -> Self {
        let reach = grid.world_bounds().half_diagonal() * 0.1;
        Self { distance_mm: if reach.is_finite() { reach } else { 20.0 }, ..Self::default() }
    }

    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if !(self.distance_mm.is_finite() && self.distance_mm >= 0.0) {
            return Err(DocumentError::invalid("distance_mm", self.distance_mm, "a length in mm, 0 or more"));
        }
        if !(0.0..=1.0).contains(&self.opacity) {
            return Err(DocumentError::invalid("opacity", self.opacity, "0 to 1"));
        }
        self.at.iter().flatten().try_for_each(|&at| finite("at", at).map(drop))
    }

    /// What pictures are asked for, about a place of the world as posed; `radius_mm`: the brush's.
    pub(crate) fn about(&self, centre: DVec3, radius_mm: f64) -> Option<Focus> {
        let radius_mm = radius_mm + self.distance_mm;
        let context = match self.far {
            FarMatter::Faded => Context::Faded,
            FarMatter::Contour => Context::Contour,
        };
        let usable = self.on && radius_mm > 0.0 && radius_mm.is_finite() && centre.is_finite();
        usable.then_some(Focus { centre, radius_mm, opacity: self.opacity, context })
    }
}
