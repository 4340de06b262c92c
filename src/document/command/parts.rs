//! The commands that cut the background into parts and move them; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::looks::LookSetting;
use crate::explode::{Axis, Cut, Forces, PartId};
use crate::math::Pose;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a splitter cuts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Splitter {
    /// Through the picked point, along the viewing ray and a screen axis; cuts the part that is hit first.
    Axis { px: [f64; 2], axis: Axis },
    /// Through the picked point, parallel to the picture; cuts the part that is hit first.
    Depth { px: [f64; 2] },
    /// Through the eye and a line on the screen; cuts every part whose silhouette meets it.
    Line { from: [f64; 2], to: [f64; 2] },
    /// A plane in world mm at rest; cuts every part, or only `part`.
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
        #[serde(default)]
        part: Option<PartId>,
    },
    /// Single parts, one after another, each by a plane at rest: what splitters by pixels come to.
    Cuts {
        cuts: Vec<Cut>,
        /// What the step is called.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
    },
}

impl Splitter {
    /// What a step of it is called.
    pub(crate) fn step_name(&self) -> &str {
        match self {
            Self::Axis { .. } => "Axis split",
            Self::Depth { .. } => "Depth split",
            Self::Line { .. } => "Line split",
            Self::Plane { .. } => "Plane split",
            Self::Cuts { name, .. } => name.as_deref().unwrap_or("Split"),
        }
    }
}

/// See [`Command::Part`](crate::document::command::Command::Part).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PartCommand {
    /// Cuts; pixels are of the 3D view.
    Split {
        by: Splitter,
        #[serde(default)]
        size: Option<[u32; 2]>,
    },
    /// Changes what is given of a part.
    Set {
        id: PartId,
        #[serde(default)]
        name: Option<String>,
        #[serde(default)]
        colour: Option<[f32; 3]>,
        /// Takes the colour away.
        #[serde(default)]
        own_colour: bool,
        #[serde(default)]
        visible: Option<bool>,
        #[serde(default)]
        pinned: Option<bool>,
        #[serde(default)]
        importance: Option<f64>,
        /// A look for itself in all volumes, or `"inherit"`: what is left out stays as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        look: Option<LookSetting>,
    },
    /// Moves a part by hand and pins it there.
    Move { id: PartId, pose: Pose },
    /// One part again.
    Reset {},
}

/// See [`Command::Explosion`](crate::document::command::Command::Explosion).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ExplosionCommand {
    /// Sets the degree; the window animates towards it, a script says `settle`.
    Degree { value: f64 },
    /// Replaces the forces' constants.
    Forces { forces: Forces },
    /// Seed of the explosion points' jitter.
    Seed { value: u64 },
    /// Lets the forces take the parts to rest. That is no change of the scene and no step of history.
    Settle {},
    /// The same for some steps of 1/60 s (what the window does every frame).
    Step { steps: u32 },
}
