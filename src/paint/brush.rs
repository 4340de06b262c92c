//! What a stroke paints with. All lengths are millimetres, also on anisotropic grids.

use crate::math::DVec3;
use crate::paint::error::PaintError;
use crate::paint::falloff::Falloff;
use crate::paint::mirror::Mirror;
use crate::paint::only::Only;
use crate::volume::{FieldKind, Number};
use serde::{Deserialize, Serialize};

/// The footprint's form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A ball about the sample.
    Sphere,
    /// A disc one voxel thick in the plane of the slice that is painted on.
    Disc,
    /// A ball that is flattened (or drawn out) along the surface's normal: `ratio` of the radius along it, the radius across.
    Ellipsoid,
}

/// The `op` of equation 1, and how dabs of a stroke add up.
///
/// Colours (straight, display-referred r, g, b, a) mix as amounts of paint, that is, multiplied by their alpha: P and C are
/// (r·a, g·a, b·a, a), and the result is divided by its alpha again. So a weak dab on bare ground has the brush's full hue at
/// a low alpha instead of a dark fringe, and fading out keeps the hue. What ends at alpha 0 is 0 in all four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Operation {
    /// C op P = C; a colour brings its alpha with it.
    Replace,
    /// C op P = P + C, clamped to what the field can hold. A label is taken as by `Replace`.
    Add,
    /// C op P = P − C, clamped likewise. From a colour it takes r, g, b times the brush's alpha and leaves the paint's own alpha;
    /// from labels it takes the brush's label and no other.
    Subtract,
    /// C op P = mix of both by the brush's own opacity: a colour lies over the paint by its alpha. Density, selection and labels
    /// have no opacity of their own: as `Replace`.
    Blend,
    /// C op P = the value before any edit: the source's density, no colour, no selection, no label.
    Restore,
    /// C = the mean of the voxel's neighbourhood, weighted by a Gaussian of σ = `reach_mm` that ends at 3 σ along each axis. This and
    /// what follows is told from the field as it was at the stroke's start, and for density and the selection alone.
    Smooth,
    /// C = the median of the voxels whose centres lie within `reach_mm`.
    Median,
    /// C = twice the value less the mean that `Smooth` takes, between the field's least and greatest value.
    Sharpen,
    /// Adds matter on the surface: C = the value that lies `height_mm`, times the coverage, further inside along the normal, which points
    /// toward lower values.
    Raise,
    /// Removes matter from the surface: the value that lies so much further outside.
    Lower,
    /// Pushes the surface in as `Lower`, along the normal of the surface at large (about the brush's radius): what is small on it moves
    /// along.
    Push,
    /// Pulls it out again.
    Pull,
    /// C = what Laplace's equation fills in from the rim of all that the stroke covers: a hole or a streak closes smoothly.
    Fill,
}

/// What is painted, and with what.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Density, in the volume's unit (an offset for `Add` and `Subtract`). It may lie between and beyond what the source's type can
    /// hold: it is kept as it is, and an export rounds it to the nearest that the type has.
    Density(f64),
    /// Display-referred r, g, b, a in 0..1.
    Colour([f32; 4]),
    /// Degree of interest 0..1.
    Selection(f32),
    /// Id of a segment; a voxel takes it where coverage reaches ½. 0 erases.
    Label(u16),
}

impl Target {
    /// Whether neighbourhood operators work on it: density and the selection.
    pub const fn has_neighbours(&self) -> bool {
        matches!(self, Self::Density(_) | Self::Selection(_))
    }

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

/// What erasing does to density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EraseDensity {
    /// Takes edits back: the source's value returns. Where nothing was edited nothing happens.
    #[default]
    Restore,
    /// Removes: this value, in the volume's unit, takes the place of what is there.
    To(f64),
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

/// What the pressure of a pen scales.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Pressure {
    /// The brush's strength.
    pub strength: bool,
    /// Its radius, down to a quarter.
    pub radius: bool,
}

impl Default for Pressure {
    fn default() -> Self {
        Self { strength: true, radius: false }
    }
}

impl Pressure {
    /// The least share of the radius that a light touch leaves.
    pub const LEAST: f64 = 0.25;

    /// Whether it is as it was before there was a choice.
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }
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
    /// The falloff from before it painted labels, which are hard; it comes back with what is painted next.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub falloff_before_labels: Option<Falloff>,
    /// 0..1.
    pub strength: f32,
    /// Operation.
    pub operation: Operation,
    /// Wash or build-up.
    pub tip: Tip,
    /// What it paints.
    pub target: Target,
    /// Of an ellipsoid: how far it reaches along the normal as a share of the radius, above 0 and at most 4.
    #[serde(default = "half", skip_serializing_if = "is_half")]
    pub ratio: f64,
    /// How far a contour drawn on a slice fills to either side, mm, 0 or more; 0: the layer of voxels of the slice.
    #[serde(default, skip_serializing_if = "is_none")]
    pub depth_mm: f64,
    /// Distance of dabs along the stroke as a share of the radius, in (0, ¼].
    pub spacing: f64,
    /// Only voxels whose density before the stroke is in this closed range are painted; see [`Gate`](crate::paint::gate::Gate).
    pub range: Option<[Number; 2]>,
    /// Whether the brush takes away instead: density as `erase_density` says, colour, selection and label go to 0.
    pub erase: bool,
    /// What taking away means for density.
    #[serde(default)]
    pub erase_density: EraseDensity,
    /// Whether a stroke keeps to the surface that the 3D view shows: no voxel behind what is met first, none that the look hides. A
    /// stroke that begins on a slice is drawn where one sees it already, and takes no heed of it.
    #[serde(default)]
    pub visible_only: bool,
    /// How far from the surface that the 3D view shows a voxel may lie to be painted, mm, 0 or more: that surface and what is just
    /// behind it. A stroke that begins on a slice takes no heed of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_mm: Option<f64>,
    /// Where alone it paints: a side of the selection, of a segment.
    #[serde(default, skip_serializing_if = "Only::is_anything")]
    pub only: Only,
    /// Whether only voxels are painted that are connected to where the stroke began, through the faces of voxels that the present looks
    /// show at all.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub connected: bool,
    /// Across what its strokes are mirrored.
    #[serde(default, skip_serializing_if = "Mirror::is_off")]
    pub mirror: Mirror,
    /// What the pressure of a point scales.
    #[serde(default, skip_serializing_if = "Pressure::is_plain")]
    pub pressure: Pressure,
    /// How far a voxel's neighbourhood reaches, mm, more than 0: σ of `Smooth` and `Sharpen` (up to 8 voxels), the radius of `Median` (up
    /// to 5). Until it is said, a voxel of the first volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach_mm: Option<f64>,
    /// How far `Raise`, `Lower`, `Push` and `Pull` move the surface at full coverage, mm, 0 or more (up to 12 voxels). Until it is said, a
    /// voxel of the first volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
}

const fn half() -> f64 {
    0.5
}

fn is_none(depth_mm: &f64) -> bool {
    *depth_mm == 0.0
}

fn is_half(ratio: &f64) -> bool {
    *ratio == half()
}

impl Default for Brush {
    fn default() -> Self {
        Self {
            shape: Shape::Sphere,
            radius_mm: 5.0,
            falloff: Falloff::Smooth,
            falloff_before_labels: None,
            strength: 1.0,
            operation: Operation::Replace,
            tip: Tip::Wash,
            target: Target::Selection(1.0),
            ratio: half(),
            depth_mm: 0.0,
            spacing: 0.25,
            range: None,
            erase: false,
            erase_density: EraseDensity::Restore,
            visible_only: false,
            within_mm: None,
            only: Only::default(),
            connected: false,
            mirror: Mirror::Off,
            pressure: Pressure::default(),
            reach_mm: None,
            height_mm: None,
        }
    }
}

impl Brush {
    /// What it really does: erasing is restoring whatever the operation, or on density replacing by the value that removes.
    pub fn effective(&self) -> Operation {
        match self.removed() {
            Some(_) => Operation::Replace,
            None if self.erase => Operation::Restore,
            None => self.operation,
        }
    }

    /// What it really paints: the value that removes where it removes density.
    pub fn effective_target(&self) -> Target {
        self.removed().map_or(self.target, Target::Density)
    }

    /// The falloff that counts: labels take part by distance ≤ radius, so that the radius shown is the radius painted.
    pub fn effective_falloff(&self) -> Falloff {
        if matches!(self.target, Target::Label(_)) { Falloff::Hard } else { self.falloff }
    }

    /// Whether what it paints is an end (nothing, or what was there before any edit): weak strokes arrive there however often it
    /// takes, also where rounding to the storage's steps would let them stall.
    pub fn ends(&self) -> bool {
        match (self.effective(), self.effective_target()) {
            (Operation::Restore, _) => true,
            (Operation::Add | Operation::Subtract, _) => false,
            (operation, _) if operation.looks_around() => false,
            (_, Target::Density(value)) => self.erase || value == 0.0,
            (_, Target::Selection(value)) => value == 0.0,
            (operation, Target::Colour(rgba)) => operation == Operation::Replace && rgba[3] == 0.0,
            (_, Target::Label(_)) => false,
        }
    }

    fn removed(&self) -> Option<f64> {
        match (self.erase, self.target, self.erase_density) {
            (true, Target::Density(_), EraseDensity::To(value)) => Some(value),
            _ => None,
        }
    }

    /// # Errors
    /// If a setting is outside of its range; names the first.
    pub fn check(&self) -> Result<(), PaintError> {
        let wrong = |field, found: String, expected| Err(PaintError::Brush { field, found, expected });
        if !(self.radius_mm >= 0.0 && self.radius_mm < 1e100) {
            return wrong("radius_mm", self.radius_mm.to_string(), "a finite length in mm, 0 or more");
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return wrong("strength", self.strength.to_string(), "0 to 1");
        }
        if !(self.spacing > 0.0 && self.spacing <= 0.25) {
            return wrong("spacing", self.spacing.to_string(), "a share of the radius above 0 and at most 0.25");
        }
        if !(self.ratio > 0.0 && self.ratio <= 4.0) {
            return wrong("ratio", self.ratio.to_string(), "a share of the radius above 0 and at most 4");
        }
        if !(0.0..1e100).contains(&self.depth_mm) {
            return wrong("depth_mm", self.depth_mm.to_string(), "a finite depth in mm, 0 or more");
        }
        if let EraseDensity::To(value) = self.erase_density
            && !value.is_finite()
        {
            return wrong("erase_density.to", value.to_string(), "a finite value in the volume's unit");
        }
        if let Some(depth) = self.within_mm.filter(|depth| !(0.0..1e100).contains(depth)) {
            return wrong("within_mm", depth.to_string(), "a finite depth in mm, 0 or more");
        }
        self.mirror.check()?;
        if let Some(reach) = self.reach_mm.filter(|reach| !(*reach > 0.0 && *reach < 1e100)) {
            return wrong("reach_mm", reach.to_string(), "a finite length in mm above 0");
        }
        if let Some(height) = self.height_mm.filter(|height| !(0.0..1e100).contains(height)) {
            return wrong("height_mm", height.to_string(), "a finite height in mm, 0 or more");
        }
        if self.operation.looks_around() && !self.target.has_neighbours() {
            let found = format!("{:?} on {}", self.operation, self.target.field().name()).to_lowercase();
            return wrong("operation", found, "for colours and labels: replace, add, subtract, blend or restore");
        }
        match self.target {
            Target::Density(value) if !value.is_finite() => {
                return wrong("target.density", value.to_string(), "a finite value in the volume's unit");
            }
            Target::Colour(rgba) if !rgba.iter().all(|c| (0.0..=1.0).contains(c)) => {
                return wrong("target.colour", format!("{rgba:?}"), "four numbers from 0 to 1");
            }
            Target::Selection(value) if !(0.0..=1.0).contains(&value) => {
                return wrong("target.selection", value.to_string(), "0 to 1");
            }
            _ => {}
        }
        match self.range {
            Some([lo, hi]) if lo.partial_cmp(&hi).is_none_or(std::cmp::Ordering::is_gt) => {
                wrong("range", format!("[{lo}, {hi}]"), "two values, the first not above the second")
            }
            _ => Ok(()),
        }
    }

    /// Whether its dabs lie along the surface, so that their normals are the surface's.
    pub fn lies_along(&self) -> bool {
        self.shape == Shape::Ellipsoid || (self.shape == Shape::Sphere && self.effective().displaces())
    }

    /// Whether dabs of this brush may add up on density beyond one application.
    pub fn piles_up(&self) -> bool {
        let adds = matches!(self.effective(), Operation::Add | Operation::Subtract);
        adds && self.tip == Tip::BuildUp && matches!(self.target, Target::Density(_))
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
    /// Whether the path begins anew here: nothing was hit on the way, another part, or a jump in depth.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub breaks: bool,
}
