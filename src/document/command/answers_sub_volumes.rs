//! What commands on sub-volumes and questions for them say.

#![allow(missing_docs)] // fields: what they are called is what they say

use crate::document::scene::volumes::SubVolume;
use crate::volume::VolumeId;
use serde::Serialize;

/// A sub-volume: `sub_volume.add`, `sub_volume.set`, one of `ask.sub_volumes`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SubVolumeSaid {
    /// Its number.
    pub volume: VolumeId,
    pub name: String,
    #[serde(flatten)]
    pub place: SubVolume,
    /// Samples along i, j, k.
    pub dims: [u32; 3],
    /// Distance of its samples.
    pub spacing_mm: [f64; 3],
    /// Once all of it is edited, density, colour, selection and labels.
    pub most_bytes: u64,
    /// What is edited now.
    pub held_bytes: u64,
    /// The sub-volumes that came to lie in it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub around: Vec<VolumeId>,
}

/// `ask.sub_volumes`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SubVolumesSaid {
    pub sub_volumes: Vec<SubVolumeSaid>,
}

/// `ask.sub_volume_fit`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitSaid {
    #[serde(flatten)]
    pub place: SubVolume,
    /// The sub-volumes that would come to lie in it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub around: Vec<VolumeId>,
    pub dims: [u32; 3],
    pub spacing_mm: [f64; 3],
    pub most_bytes: u64,
    /// Memory that there is for it; unknown on some systems.
    pub available_bytes: Option<u64>,
}

/// `sub_volume.bake`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BakedSaid {
    pub baked: VolumeId,
    pub parent: VolumeId,
}
