//! What is other about the looks of single things: parts, the selection, segments, and which labels are shown at all.
//!
//! Matter is shown with the look of its volume, changed by that of its part or, of the share that is selected, of the selection, then by
//! that of its segment: what a change says replaces what it was laid on, opacities multiply. What a change does not say goes on being
//! inherited. All of it is taken back by undo, with the parts and segments that it is of. Knows no voxels and no pictures.

use crate::document::error::DocumentError;
use crate::document::scene::ViewLook;
use crate::document::scene::check::check_transfer;
use crate::explode::PartId;
use crate::volume::{Lighting, Mode, TransferFunction, VolumeId};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// What is other about a look than about the one that it is laid on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LookChange {
    /// Colour and opacity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferFunction>,
    /// How rays become colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<Mode>,
    /// `null`: unshaded; as inherited if left out.
    #[serde(default, deserialize_with = "said", skip_serializing_if = "Option::is_none")]
    pub lighting: Option<Option<Lighting>>,
    /// 0 to 1: multiplies what is inherited. At 0 the matter is not there: it neither shows nor hides anything.
    #[serde(default = "whole", skip_serializing_if = "is_whole")]
    pub opacity: f32,
}

/// Of a field that may be `null`: that it was said.
pub(crate) fn said<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
}

fn whole() -> f32 {
    1.0
}

fn is_whole(opacity: &f32) -> bool {
    *opacity == 1.0
}

impl Default for LookChange {
    fn default() -> Self {
        Self { transfer: None, mode: None, lighting: None, opacity: 1.0 }
    }
}

impl LookChange {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        self.transfer.as_ref().map_or(Ok(()), check_transfer)?;
        if !(0.0..=1.0).contains(&self.opacity) {
            return Err(DocumentError::invalid("opacity", self.opacity, "0 to 1"));
        }
        let plain = ViewLook::default();
        let (mode, lighting) = (self.mode.unwrap_or(plain.mode), self.lighting.unwrap_or(plain.lighting));
        ViewLook { mode, lighting, ..plain }.check()
    }
}

/// What is other about the looks of single things; nothing of what is not named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OwnLooks {
    /// Of parts, in all volumes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parts: BTreeMap<PartId, LookChange>,
    /// Of the selection of volumes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub selections: BTreeMap<VolumeId, LookChange>,
    /// Of segments of volumes, by label.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub segments: BTreeMap<VolumeId, BTreeMap<u16, LookChange>>,
    /// The only labels of a volume that are shown, 0 among them for what has none; all if there is nothing of the volume here.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub only: BTreeMap<VolumeId, BTreeSet<u16>>,
}

impl OwnLooks {
    /// Whether nothing is other about anything.
    pub fn is_empty(&self) -> bool {
        let Self { parts, selections, segments, only } = self;
        parts.is_empty() && selections.is_empty() && segments.is_empty() && only.is_empty()
    }

    /// Of a segment.
    pub fn segment(&self, volume: VolumeId, label: u16) -> Option<&LookChange> {
        self.segments.get(&volume)?.get(&label)
    }

    /// Whether matter of a label is shown at all, if it has a look.
    pub fn shows_label(&self, volume: VolumeId, label: u16) -> bool {
        self.only.get(&volume).is_none_or(|only| only.contains(&label))
    }

    /// Changes the look of a segment; `None`: it is inherited.
    pub(crate) fn set_segment(&mut self, volume: VolumeId, label: u16, look: Option<LookChange>) {
        let of_volume = self.segments.entry(volume).or_default();
        match look {
            Some(look) => drop(of_volume.insert(label, look)),
            None => drop(of_volume.remove(&label)),
        }
        self.segments.retain(|_, looks| !looks.is_empty());
    }

    /// Whether anything here is of a segment.
    pub(crate) fn names_segment(&self, volume: VolumeId, label: u16) -> bool {
        let alone = self.only.get(&volume).is_some_and(|only| only.contains(&label));
        alone || self.segment(volume, label).is_some()
    }

    /// A segment is gone. Where no other was shown all are.
    pub(crate) fn forget_segment(&mut self, volume: VolumeId, label: u16) {
        self.set_segment(volume, label, None);
        if let Some(only) = self.only.get_mut(&volume)
            && only.remove(&label)
            && only.is_empty()
        {
            self.only.remove(&volume);
        }
    }

    /// Keeps what is of parts and volumes that there are.
    pub(crate) fn keep(&mut self, part: impl Fn(PartId) -> bool, volume: impl Fn(VolumeId) -> bool) {
        self.parts.retain(|id, _| part(*id));
        self.selections.retain(|id, _| volume(*id));
        self.segments.retain(|id, _| volume(*id));
        self.only.retain(|id, _| volume(*id));
    }

    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        let within = |of: String, look: &LookChange| look.check().map_err(|error| error.within(&of));
        self.parts.iter().try_for_each(|(id, look)| within(format!("parts.{}", id.0), look))?;
        self.selections.iter().try_for_each(|(id, look)| within(format!("selections.{id}"), look))?;
        self.segments.iter().try_for_each(|(volume, looks)| {
            looks.iter().try_for_each(|(id, look)| within(format!("segments.{volume}.{id}"), look))
        })
    }
}
