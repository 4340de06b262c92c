//! The commands on boxes of a volume that have a resolution of their own; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::volume::{FieldKind, VolumeId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// See [`Command::SubVolume`](crate::document::Command::SubVolume).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SubVolumeCommand {
    /// Divides the voxels of a box: a volume of its own with density, colour, selection and labels, which begin as its parent has them,
    /// smoothly interpolated. Nothing is stored but what is edited. The answer says its number and the memory that it may take. A box
    /// may lie inside another one or around others, which keep all that is edited in them; its scale is then a multiple of the outer
    /// one's.
    Add {
        /// The volume that it is cut out of, the active one if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume: Option<VolumeId>,
        /// The voxel whose centre is the box's first corner, index of the parent.
        lo: [u32; 3],
        /// The voxel whose centre is its last corner: above `lo` along every axis.
        hi: [u32; 3],
        /// Samples a voxel, 1 to 8: one number, or one along each axis.
        scale: Scale,
        /// What it is called.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
    },
    /// Moves the faces of a box or divides it otherwise. What was edited stays where it is in the world; boxes in it stay as they are, and
    /// are in it no longer where its faces leave them outside.
    Set {
        /// The sub-volume.
        volume: VolumeId,
        /// As of `add`; as it is if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lo: Option<[u32; 3]>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        hi: Option<[u32; 3]>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<Scale>,
        /// `true`: edits that lie outside of the new box go. Without it a box that would lose any is refused.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        discard: bool,
    },
    /// Takes a sub-volume away with all that was edited in it. Boxes in it keep what is edited in them and then lie in what it was cut
    /// out of; where they cannot, since they do not lie on its voxels or are more than 8 times as fine, it is refused.
    Remove {
        volume: VolumeId,
        /// `true`: the boxes in it go too.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        inner: bool,
    },
    /// Adds to each voxel of the parent the mean of what was edited in its cell, by volume. The sub-volume stays, with its edits,
    /// unless `remove` says otherwise: baked again they are added again.
    Bake {
        volume: VolumeId,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        remove: bool,
    },
    /// Writes a field at the sub-volume's resolution, as `volume.export` does.
    Export {
        volume: VolumeId,
        field: FieldKind,
        path: PathBuf,
        /// Of a mesh of labels, as of `volume.export`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        label: Option<u16>,
    },
}

/// Samples a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "samples a voxel expected: a whole number from 1 to 8, or three of them along i, j, k")]
pub enum Scale {
    /// Along every axis.
    All(u32),
    /// Along i, j, k.
    Each([u32; 3]),
}

impl Scale {
    /// Along i, j, k.
    pub fn each(self) -> [u32; 3] {
        match self {
            Self::All(scale) => [scale; 3],
            Self::Each(scale) => scale,
        }
    }
}

impl SubVolumeCommand {
    /// The sub-volume that it names; of one that is made its parent.
    pub(crate) fn volume(&self) -> Option<VolumeId> {
        match self {
            Self::Add { volume, .. } => *volume,
            Self::Set { volume, .. }
            | Self::Remove { volume, .. }
            | Self::Bake { volume, .. }
            | Self::Export { volume, .. } => Some(*volume),
        }
    }
}
