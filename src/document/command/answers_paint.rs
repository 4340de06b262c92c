//! What commands that paint say: brush, strokes, selection, segments and labels that were brought in.

#![allow(missing_docs)] // fields: what they are called is what they say

use crate::document::scene::own_looks::LookChange;
use crate::paint::Brush;
use crate::volume::{Segment, VolumeId};
use serde::Serialize;
use std::collections::BTreeSet;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BrushSaid {
    pub brush: Brush,
}

/// `brush.also`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlsoSaid {
    /// What strokes paint besides the active volume.
    pub also: Vec<VolumeId>,
}

/// A stroke that is done.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaintedSaid {
    /// `None` if it changed nothing.
    pub step: Option<String>,
    pub dabs: u64,
    pub missed: u64,
    pub voxels_changed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bricks_touched: Option<usize>,
    /// Why it changed nothing, in a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nothing: Option<String>,
    /// Of each volume, where several were painted; the numbers above are their sums.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub volumes: Vec<PaintedOnSaid>,
}

/// What a stroke on several volumes did to one of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaintedOnSaid {
    pub volume: VolumeId,
    pub dabs: u64,
    pub voxels_changed: u64,
    pub bricks_touched: usize,
    /// Why nothing of it changed, in a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nothing: Option<String>,
}

/// A stroke that runs: what was painted by this command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExtendedSaid {
    pub dabs: usize,
    pub missed: u64,
    pub bricks_touched: usize,
    /// Of the whole stroke.
    pub length_mm: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CancelledSaid {
    pub cancelled: bool,
    /// Always `None`.
    pub step: Option<String>,
}

/// `component.keep`, `component.remove`, `component.select`, `component.label`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentSaid {
    pub volume: VolumeId,
    /// Of the component that was meant.
    pub voxels: u64,
    /// How many components there are.
    pub components: usize,
    /// The component's size.
    pub mm3: f64,
    /// How many pieces are meant, where it is not one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pieces: Option<usize>,
    /// Its voxels of the volume and of each sub-volume, where there are any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub volumes: Vec<ComponentOnSaid>,
    /// What removed voxels became.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Voxels of the component that were left alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kept_locked: Option<u64>,
    /// Why nothing changed, in a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nothing: Option<&'static str>,
}

/// What of a component is in one volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentOnSaid {
    pub volume: VolumeId,
    pub voxels: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SelectedSaid {
    /// Of a file: share of the volume that it covers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covered: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warnings: Option<Vec<String>>,
    pub selected_bricks: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SegmentSaid {
    pub segment: Segment,
    /// What is other about its look.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<LookChange>,
}

/// `selection.set`: what is other about the look of what is selected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SelectionLookSaid {
    pub look: Option<LookChange>,
}

/// `segment.show_only`: the labels that are shown; `null`: all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShownOnlySaid {
    pub only: Option<BTreeSet<u16>>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SegmentRemovedSaid {
    pub removed: u16,
}

/// Labels that were brought in from a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelsSaid {
    pub segments: Vec<BroughtSegment>,
    pub labelled_voxels: u64,
    pub kept_locked: u64,
    pub covered: f64,
    pub resampled: bool,
}

/// A segment that came with labels of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BroughtSegment {
    pub id: u16,
    /// Its number in the file.
    pub value: i128,
    pub name: Option<String>,
    pub voxels: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImportedSegmentsSaid {
    #[serde(flatten)]
    pub labels: LabelsSaid,
    pub warnings: Vec<String>,
}
