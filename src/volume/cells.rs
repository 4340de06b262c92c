//! What is known of a brick without its voxels: its one value, its least and largest, and those of its cells of 8³.

use std::sync::Arc;

/// What is known of a slot (a brick and its apron) without reading it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickSummary {
    /// The bytes that all 34³ texels share, if they do: such a brick needs no slot.
    pub uniform: Option<[u8; 4]>,
    /// Smallest value (density: the volume's unit; selection, alpha: 0..1; label: id); above `max` if all are NaN.
    pub min: f32,
    /// Largest value.
    pub max: f32,
}

/// Minima and maxima of a brick's 8³ cells of 4³ voxels, each over every tap that a sample in the cell can meet.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// All cells have this (min, max).
    Uniform([f32; 2]),
    /// x fastest; min > max where all is NaN.
    Dense(Arc<[[f32; 2]]>),
}
