//! What a tool may look at.

use crate::document::Scene;
use crate::explode::Poses;
use crate::interact::boxes::BoxCorners;
use crate::interact::writing::Writing;
use crate::volume::{Grid, VolumeId};
use std::collections::BTreeMap;

/// What a tool may look at.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// The scene as last seen.
    pub scene: &'a Scene,
    /// Where its parts stand.
    pub poses: &'a Poses,
    /// The volume's lattice, which says where slices lie.
    pub grid: &'a Grid,
    /// Sub-volumes that are shown.
    pub boxes: &'a BoxCorners,
    /// Bytes that an edited sample takes in each volume.
    pub sample_bytes: &'a BTreeMap<VolumeId, u64>,
    /// What is written on surfaces, and what new things will be.
    pub writing: &'a Writing,
    /// The smallest spacing in mm: the smallest brush that one can still grow is half of it.
    pub voxel_mm: f64,
}
