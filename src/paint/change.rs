//! A change of the brush: what is said of it, and what is left.
//!
//! Owns how one brush becomes another, so that two changes on their way do not undo each other.

use crate::paint::brush::{Brush, EraseDensity, Operation, Pressure, Shape, Target, Tip};
use crate::paint::falloff::Falloff;
use crate::paint::mirror::Mirror;
use crate::paint::only::Only;
use crate::volume::Number;
use serde::{Deserialize, Serialize};

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
    /// How far an ellipsoid reaches along the normal, as a share of the radius.
    pub ratio: Option<f64>,
    /// How far a contour fills to either side of its slice, mm.
    pub depth_mm: Option<f64>,
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
    /// What the pressure of a pen scales, `{"strength": true, "radius": false}`, as which what is left out counts.
    pub pressure: Option<Pressure>,
    /// How far a voxel's neighbourhood reaches, mm.
    pub reach_mm: Option<f64>,
    /// How far the surface is moved, mm.
    pub height_mm: Option<f64>,
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
            ratio: changed(old.ratio, new.ratio),
            depth_mm: changed(old.depth_mm, new.depth_mm),
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
            pressure: changed(old.pressure, new.pressure),
            reach_mm: changed(old.reach_mm, new.reach_mm).flatten(),
            height_mm: changed(old.height_mm, new.height_mm).flatten(),
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
        // What has no neighbourhoods is painted plainly, unless something else is asked for.
        let kept = match self.target {
            Some(target) if old.operation.looks_around() && !target.has_neighbours() => Operation::Replace,
            _ => old.operation,
        };
        let operation = self.operation.unwrap_or(kept);
        Brush {
            shape: self.shape.unwrap_or(old.shape),
            radius_mm: self.radius_mm.unwrap_or(old.radius_mm),
            falloff,
            falloff_before_labels,
            strength: self.strength.unwrap_or(old.strength),
            operation,
            tip: self.tip.unwrap_or(old.tip),
            target: self.target.unwrap_or(old.target),
            ratio: self.ratio.unwrap_or(old.ratio),
            depth_mm: self.depth_mm.unwrap_or(old.depth_mm),
            spacing: self.spacing.unwrap_or(old.spacing),
            range: self.range.or(if self.any_value { None } else { old.range }),
            erase: self.erase.unwrap_or(old.erase),
            erase_density: self.erase_density.unwrap_or(old.erase_density),
            visible_only: self.visible_only.unwrap_or(old.visible_only),
            within_mm: self.within_mm.or(if self.any_depth { None } else { old.within_mm }),
            only: self.only.unwrap_or(old.only),
            connected: self.connected.unwrap_or(old.connected),
            mirror: self.mirror.as_deref().copied().unwrap_or(old.mirror),
            pressure: self.pressure.unwrap_or(old.pressure),
            reach_mm: self.reach_mm.or(old.reach_mm),
            height_mm: self.height_mm.or(old.height_mm),
        }
    }
}
