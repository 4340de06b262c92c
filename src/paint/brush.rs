//! What a stroke paints with. All lengths are millimetres, also on anisotropic grids.

use crate::math::DVec3;
use crate::volume::FieldKind;
use serde::{Deserialize, Serialize};

/// The footprint's form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A ball about the sample.
    Sphere,
    /// A disc one voxel thick in the plane of the slice that is painted on.
    Disc,
}

/// F(d/radius): 1 at the centre, 0 beyond the radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// 1 up to the radius (inclusive).
    Hard,
    /// 1 − x.
    Linear,
    /// (1 − x²)².
    Smooth,
}

/// The `op` of equation 1, and how dabs of a stroke add up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Operation {
    /// C op P = C.
    Replace,
    /// C op P = P + C, clamped at the stroke's end.
    Add,
    /// C op P = P − C, clamped at the stroke's end.
    Subtract,
    /// C op P = mix of both by the brush's own opacity.
    Blend,
    /// C op P = the value before any edit: the source's density, no colour, no selection, no label.
    Restore,
}

/// What is painted, and with what.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Density, in the volume's unit (an offset for `Add` and `Subtract`).
    Density(f64),
    /// Display-referred r, g, b, a in 0..1.
    Colour([f32; 4]),
    /// Degree of interest 0..1.
    Selection(f32),
    /// Id of a segment; a voxel takes it where coverage reaches ½. 0 erases.
    Label(u16),
}

impl Target {
    /// The field that it changes.
    pub const fn field(&self) -> FieldKind {
        match self {
            Self::Density(_) => FieldKind::Density,
            Self::Colour(_) => FieldKind::Colour,
            Self::Selection(_) => FieldKind::Selection,
            Self::Label(_) => FieldKind::Labels,
        }
    }
}

/// How dabs of one stroke join.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tip {
    /// The largest G of the stroke counts, whatever passes again.
    Wash,
    /// Every dab adds: 1 − Π(1 − G), or Σ G for `Add` and `Subtract`.
    BuildUp,
}

/// The brush.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Brush {
    /// Form.
    pub shape: Shape,
    /// Radius (support m of equation 2), mm, not negative. 0 paints the one voxel that holds the sample.
    pub radius_mm: f64,
    /// Falloff.
    pub falloff: Falloff,
    /// 0..1.
    pub strength: f32,
    /// Operation.
    pub operation: Operation,
    /// Wash or build-up.
    pub tip: Tip,
    /// What it paints.
    pub target: Target,
    /// Distance of dabs along the stroke as a share of the radius, in (0, ¼].
    pub spacing: f64,
    /// Only voxels whose density before the stroke is in this closed range are painted.
    pub range: Option<[f64; 2]>,
    /// Whether the brush takes away instead: density restores the source, colour, selection and label go to 0.
    pub erase: bool,
}

impl Default for Brush {
    fn default() -> Self {
        Self {
            shape: Shape::Sphere,
            radius_mm: 5.0,
            falloff: Falloff::Smooth,
            strength: 1.0,
            operation: Operation::Replace,
            tip: Tip::Wash,
            target: Target::Selection(1.0),
            spacing: 0.25,
            range: None,
            erase: false,
        }
    }
}

/// One input point of a stroke, in the frame of the voxels at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Sample {
    /// World mm (of the rest pose: a sample on an exploded part is already taken back).
    #[schemars(with = "[f64; 3]")]
    pub position: DVec3,
    /// Unit normal of the slice for a disc; ignored by a sphere.
    #[schemars(with = "[f64; 3]")]
    pub normal: DVec3,
    /// 0..1, scales strength.
    pub pressure: f32,
}
