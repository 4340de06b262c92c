//! What of an explosion a person decides, and so what is saved and undone: parts, what a hand holds, degree and forces.
//!
//! Where forces take the parts is not here: see [`Poses`](crate::explode::poses::Poses). Owns the parts' JSON, the same in projects and in answers.

use crate::math::{DVec3, Plane, Pose};
use serde::{Deserialize, Serialize};

/// Names a part for as long as it lives; a split gives both halves new ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(transparent)]
pub struct PartId(pub u32);

impl std::fmt::Display for PartId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// A screen axis of the axis splitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The plane holds the screen's horizontal axis.
    Horizontal,
    /// The plane holds the screen's vertical axis.
    Vertical,
}

/// A bounding plane of a part at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Face {
    /// Outward, world mm at rest.
    pub plane: Plane,
    /// Whether a splitter made it; faces of the volume's box are not cuts and give no direction to a force.
    pub cut: bool,
}

/// Where a part is cut.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cut {
    /// The part.
    pub part: PartId,
    /// The plane at rest, world mm; the half that it points away from comes first.
    pub plane: Plane,
}

/// A convex part of the background, as it was decided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(from = "PartRecord", into = "PartRecord")]
pub struct Part {
    /// Identity.
    pub id: PartId,
    /// Name, as the user gave it.
    pub name: String,
    /// Display-referred tint, `None` for the transfer function's own colours.
    pub colour: Option<[f32; 3]>,
    /// Whether it is drawn.
    pub visible: bool,
    /// Where a hand put it or had it pinned: forces leave it there (infinite importance). `None`: forces decide where it is.
    pub held: Option<Pose>,
    /// Multiplies the return force's constant; positive.
    pub importance: f64,
    /// Bounding planes.
    pub faces: Vec<Face>,
    /// Corners at rest, world mm: each where at least three faces meet, none twice.
    pub vertices: Vec<DVec3>,
}

/// A part in JSON, with where it is: in answers that is where it stands now, in what is kept the hand's pose of a pinned part and
/// rest of any other. Projects of before have where forces had taken it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PartRecord {
    /// Identity.
    pub id: PartId,
    /// Name.
    pub name: String,
    /// Tint.
    pub colour: Option<[f32; 3]>,
    /// Whether it is drawn.
    pub visible: bool,
    /// Whether forces leave it where it is.
    pub pinned: bool,
    /// Multiplies the return force's constant.
    pub importance: f64,
    /// Bounding planes.
    pub faces: Vec<Face>,
    /// Corners at rest, world mm.
    #[schemars(with = "Vec<[f64; 3]>")]
    pub vertices: Vec<DVec3>,
    /// Where it is.
    pub pose: Pose,
}

impl PartRecord {
    /// A part that stands in `pose`.
    pub fn of(part: &Part, pose: Pose) -> Self {
        let Part { id, name, colour, visible, held, importance, faces, vertices } = part.clone();
        Self { id, name, colour, visible, pinned: held.is_some(), importance, faces, vertices, pose }
    }
}

impl From<Part> for PartRecord {
    fn from(part: Part) -> Self {
        Self::of(&part, part.held.unwrap_or_default())
    }
}

impl From<PartRecord> for Part {
    fn from(record: PartRecord) -> Self {
        let PartRecord { id, name, colour, visible, pinned, importance, faces, vertices, pose } = record;
        Self { id, name, colour, visible, held: pinned.then_some(pose), importance, faces, vertices }
    }
}

/// Constants of the forces. Lengths in half-diagonals of the volume's box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Forces {
    /// Relative share of the explosion force, δ_e.
    pub delta_explosion: f64,
    /// Relative share of the viewing force, δ_v.
    pub delta_viewing: f64,
    /// Relative share of the spacing force, δ_s.
    pub delta_spacing: f64,
    /// c_r of the return force.
    pub return_constant: f64,
    /// ℓ_r of the return force.
    pub return_length: f64,
    /// λ_e of the explosion force.
    pub explosion_length: f64,
    /// ε of the viewing and spacing forces.
    pub softening: f64,
    /// Whether the viewing force acts at all.
    pub viewing: bool,
    /// Whether it is weighted by the gain measured with `visibility` (otherwise plain equation 3).
    pub measured_gain: bool,
}

impl Default for Forces {
    fn default() -> Self {
        Self {
            delta_explosion: 1.0 / 2.0,
            delta_viewing: 1.0 / 3.0,
            delta_spacing: 1.0 / 6.0,
            return_constant: 0.25,
            return_length: 0.10,
            explosion_length: 0.20,
            softening: 0.05,
            viewing: true,
            measured_gain: true,
        }
    }
}

/// Parts and how far they are apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Explosion {
    /// In order of id.
    pub parts: Vec<Part>,
    /// Degree of explosion, 0..1 (larger is allowed); 0 is the identity exactly.
    pub degree: f64,
    /// Constants.
    pub forces: Forces,
    /// Seed of the explosion points' jitter.
    pub seed: u64,
    /// The id that the next part gets.
    pub next_id: u32,
}
