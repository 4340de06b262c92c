//! The ray caster: bodies merged and ordered, tiles, uniforms, pictures, picks and how much is seen.
//!
//! Stands on `fields` and `picture`; knows no strokes.

pub(crate) mod caster;
pub(crate) mod counting;
pub(crate) mod focus;
pub(crate) mod forms;
pub(crate) mod higher;
pub mod holes;
pub(crate) mod look_tables;
pub(crate) mod looks;
pub(crate) mod merging;
pub mod order;
pub(crate) mod probe;
pub(crate) mod readback;
pub mod solid;
pub(crate) mod sticking;
pub mod tiles;
pub mod uniforms;
pub(crate) mod visibility;
