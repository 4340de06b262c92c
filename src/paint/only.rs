//! Where alone a brush may paint, as it is said: sides of the selection and of a segment.
//!
//! Plain data; what it means for voxels is told where limits are.

use serde::{Deserialize, Serialize};

/// Which side of something may be painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// What is in it.
    Inside,
    /// What is not.
    Outside,
}

/// A side of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfSegment {
    /// Its id; 0: what is of no segment.
    pub id: u16,
    /// Which side.
    pub side: Side,
}

/// Where alone a brush may paint, by what was selected and segmented at the stroke's start; both count where both are said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Only {
    /// Of the selection: a voxel is inside from a half on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub selection: Option<Side>,
    /// Of a segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segment: Option<OfSegment>,
}

impl Only {
    /// Whether it leaves nothing out.
    pub fn is_anything(&self) -> bool {
        *self == Self::default()
    }
}
