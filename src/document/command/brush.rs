//! The commands of the hand: what the brush is, and its strokes; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::Place;
use crate::paint::{Brush, EraseDensity, Falloff, Operation, Shape, Target, Tip};
use crate::volume::Number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One input point of a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrokePoint {
    /// Where.
    pub at: Place,
    /// 0..1; scales the brush's strength.
    #[serde(default = "one")]
    pub pressure: f32,
    /// Whether the path begins anew here instead of coming from the point before. Where pixels of the 3D view need that it is found.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub breaks: bool,
    /// Of a place in mm or index: where a disc faces, any length; that of the axial slice if left out. A pixel knows it itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
}

fn one() -> f32 {
    1.0
}

/// See [`Command::Brush`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BrushCommand {
    /// Changes what is given and leaves the rest.
    Set {
        #[serde(default)]
        shape: Option<Shape>,
        #[serde(default)]
        radius_mm: Option<f64>,
        /// Hard if left out where `target` becomes a label, and what it was before where it is a label no more; labels are painted
        /// by the hard ball in any case.
        #[serde(default)]
        falloff: Option<Falloff>,
        #[serde(default)]
        strength: Option<f32>,
        #[serde(default)]
        operation: Option<Operation>,
        #[serde(default)]
        tip: Option<Tip>,
        #[serde(default)]
        target: Option<Target>,
        #[serde(default)]
        spacing: Option<f64>,
        /// Closed range of densities that may be painted, compared in the source's own type: integers to the last digit; `"inf"`
        /// and `"-inf"` are ends too.
        #[serde(default)]
        range: Option<[Number; 2]>,
        /// Takes the range away.
        #[serde(default)]
        any_value: bool,
        #[serde(default)]
        erase: Option<bool>,
        /// What erasing does to density: `"restore"` takes edits back, `{"to": value}` removes by painting that value.
        #[serde(default)]
        erase_density: Option<EraseDensity>,
        /// Whether strokes keep to the surface that the 3D view shows.
        #[serde(default)]
        visible_only: Option<bool>,
    },
}

impl BrushCommand {
    /// The brush after the command.
    pub fn applied_to(&self, old: &Brush) -> Brush {
        let Self::Set {
            shape,
            radius_mm,
            falloff,
            strength,
            operation,
            tip,
            target,
            spacing,
            range,
            any_value,
            erase,
            erase_density,
            visible_only,
        } = self;
        let is_label = |target: &Target| matches!(target, Target::Label(_));
        let (was, is) = (is_label(&old.target), target.as_ref().map_or_else(|| is_label(&old.target), is_label));
        let (falloff, falloff_before_labels) = match (*falloff, was, is) {
            (Some(chosen), ..) => (chosen, None),
            (None, false, true) => (Falloff::Hard, Some(old.falloff)),
            (None, true, false) => (old.falloff_before_labels.unwrap_or(old.falloff), None),
            (None, ..) => (old.falloff, old.falloff_before_labels),
        };
        Brush {
            shape: shape.unwrap_or(old.shape),
            radius_mm: radius_mm.unwrap_or(old.radius_mm),
            falloff,
            falloff_before_labels,
            strength: strength.unwrap_or(old.strength),
            operation: operation.unwrap_or(old.operation),
            tip: tip.unwrap_or(old.tip),
            target: target.unwrap_or(old.target),
            spacing: spacing.unwrap_or(old.spacing),
            range: range.or(if *any_value { None } else { old.range }),
            erase: erase.unwrap_or(old.erase),
            erase_density: erase_density.unwrap_or(old.erase_density),
            visible_only: visible_only.unwrap_or(old.visible_only),
        }
    }
}

/// See [`Command::Stroke`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StrokeCommand {
    /// A whole stroke at once.
    Paint { points: Vec<StrokePoint> },
    /// Starts a stroke.
    Begin { points: Vec<StrokePoint> },
    /// Continues it.
    Extend { points: Vec<StrokePoint> },
    /// Ends it: one step of history, none if nothing changed.
    End {},
    /// Takes it back.
    Cancel {},
}
