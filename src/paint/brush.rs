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
            spacing: 0.25,
            range: None,
            erase: false,
            erase_density: EraseDensity::Restore,
            visible_only: false,
            within_mm: None,
            only: Only::default(),
            connected: false,
            mirror: Mirror::Off,
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
        if let EraseDensity::To(value) = self.erase_density
            && !value.is_finite()
        {
            return wrong("erase_density.to", value.to_string(), "a finite value in the volume's unit");
        }
        if let Some(depth) = self.within_mm.filter(|depth| !(0.0..1e100).contains(depth)) {
            return wrong("within_mm", depth.to_string(), "a finite depth in mm, 0 or more");
        }
        self.mirror.check()?;
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

    /// Whether dabs of this brush may add up on density beyond one application.
    pub fn piles_up(&self) -> bool {
        let adds = matches!(self.effective(), Operation::Add | Operation::Subtract);
        adds && self.tip == Tip::BuildUp && matches!(self.target, Target::Density(_))
    }
}

/// A change of the brush: what is given is changed, the rest is left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BrushChange {
    /// Form.
    pub shape: Option<Shape>,
    /// Radius, mm.
    pub radius_mm: Option<f64>,
    /// Hard if left out where `target` becomes a label, and what it was before where it is a label no more; labels are painted
    /// by the hard ball in any case.
    pub falloff: Option<Falloff>,
    /// 0..1.
    pub strength: Option<f32>,
    /// Operation.
    pub operation: Option<Operation>,
    /// Wash or build-up.
    pub tip: Option<Tip>,
    /// What it paints.
    pub target: Option<Target>,
    /// Distance of dabs as a share of the radius.
    pub spacing: Option<f64>,
    /// Closed range of densities that may be painted, compared in the source's own type: integers to the last digit; `"inf"`
    /// and `"-inf"` are ends too.
    pub range: Option<[Number; 2]>,
    /// Takes the range away.
    pub any_value: bool,
    /// Whether the brush takes away.
    pub erase: Option<bool>,
    /// What erasing does to density: `"restore"` takes edits back, `{"to": value}` removes by painting that value.
    pub erase_density: Option<EraseDensity>,
    /// Whether strokes keep to the surface that the 3D view shows.
    pub visible_only: Option<bool>,
    /// How far from that surface a voxel may lie, mm.
    pub within_mm: Option<f64>,
    /// Takes that limit away.
    pub any_depth: bool,
    /// Where alone it paints, instead of what was said before: `{"selection": "inside"}`, `{"segment": {"id": 3, "side":
    /// "outside"}}`, both, or `{}` for everywhere.
    pub only: Option<Only>,
    /// Whether it paints only what is connected to where the stroke began.
    pub connected: Option<bool>,
    /// Across what strokes are mirrored: `"off"`, `{"axis": "x"}`, `{"points": [a, b, c]}`, `{"plane": …}`, `{"face": {"part": 2,
    /// "face": 6}}`.
    pub mirror: Option<Box<Mirror>>,
}

impl BrushChange {
    /// What makes `new` of `old`.
    pub fn between(old: &Brush, new: &Brush) -> Self {
        fn changed<T: PartialEq + Copy>(old: T, new: T) -> Option<T> {
            (old != new).then_some(new)
        }
        Self {
            shape: changed(old.shape, new.shape),
            radius_mm: changed(old.radius_mm, new.radius_mm),
            falloff: changed(old.falloff, new.falloff),
            strength: changed(old.strength, new.strength),
            operation: changed(old.operation, new.operation),
            tip: changed(old.tip, new.tip),
            target: changed(old.target, new.target),
            spacing: changed(old.spacing, new.spacing),
            range: changed(old.range, new.range).flatten(),
            any_value: old.range.is_some() && new.range.is_none(),
            erase: changed(old.erase, new.erase),
            erase_density: changed(old.erase_density, new.erase_density),
            visible_only: changed(old.visible_only, new.visible_only),
            within_mm: changed(old.within_mm, new.within_mm).flatten(),
            any_depth: old.within_mm.is_some() && new.within_mm.is_none(),
            only: changed(old.only, new.only),
            connected: changed(old.connected, new.connected),
            mirror: changed(old.mirror, new.mirror).map(Box::new),
        }
    }

    /// The brush after it.
    #[must_use]
    pub fn applied_to(&self, old: &Brush) -> Brush {
        let is_label = |target: &Target| matches!(target, Target::Label(_));
        let (was, is) = (is_label(&old.target), is_label(&self.target.unwrap_or(old.target)));
        let (falloff, falloff_before_labels) = match (self.falloff, was, is) {
            (Some(chosen), ..) => (chosen, None),
            (None, false, true) => (Falloff::Hard, Some(old.falloff)),
            (None, true, false) => (old.falloff_before_labels.unwrap_or(old.falloff), None),
            (None, ..) => (old.falloff, old.falloff_before_labels),
        };
        Brush {
            shape: self.shape.unwrap_or(old.shape),
            radius_mm: self.radius_mm.unwrap_or(old.radius_mm),
            falloff,
            falloff_before_labels,
            strength: self.strength.unwrap_or(old.strength),
            operation: self.operation.unwrap_or(old.operation),
            tip: self.tip.unwrap_or(old.tip),
            target: self.target.unwrap_or(old.target),
            spacing: self.spacing.unwrap_or(old.spacing),
            range: self.range.or(if self.any_value { None } else { old.range }),
            erase: self.erase.unwrap_or(old.erase),
            erase_density: self.erase_density.unwrap_or(old.erase_density),
            visible_only: self.visible_only.unwrap_or(old.visible_only),
            within_mm: self.within_mm.or(if self.any_depth { None } else { old.within_mm }),
            only: self.only.unwrap_or(old.only),
            connected: self.connected.unwrap_or(old.connected),
            mirror: self.mirror.as_deref().copied().unwrap_or(old.mirror),
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
    /// Whether the path begins anew here: nothing was hit on the way, another part, or a jump in depth.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub breaks: bool,
}
