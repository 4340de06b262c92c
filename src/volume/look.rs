//! How a volume is drawn, apart from its transfer function.

use serde::{Deserialize, Serialize};

/// How rays become colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Direct volume rendering by the transfer function.
    Dvr,
    /// The surface at a density, in the volume's unit.
    Iso(f64),
    /// Maximum intensity projection.
    Mip,
}

/// Headlight, Blinn-Phong, lit on both sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Lighting {
    /// Share that needs no light.
    pub ambient: f32,
    /// Lambert's share.
    pub diffuse: f32,
    /// Highlight's share.
    pub specular: f32,
    /// Highlight's exponent.
    pub power: f32,
}

impl Default for Lighting {
    fn default() -> Self {
        Self { ambient: 0.2, diffuse: 0.8, specular: 0.2, power: 20.0 }
    }
}
