//! What commands do beyond the scene, which `reduce` has: with voxels, the disk or the GPU. One file per noun, every one a part of
//! `Document`.
//!
//! A handler changes the state through an `Edit`, which remembers what was there; whoever calls it makes the step of history and
//! the record of the journal.

mod along;
pub(crate) mod anchoring;
pub(crate) mod annotation;
pub(crate) mod ask;
pub(crate) mod bake;
pub(crate) mod colours;
pub(crate) mod component;
mod connected;
mod contact;
pub(crate) mod explosion;
pub(crate) mod export;
mod focus;
pub(crate) mod label;
pub(crate) mod labels;
mod lasso;
pub(crate) mod matter;
mod nesting;
mod on_device;
pub(crate) mod open;
pub(crate) mod overlap;
pub(crate) mod painting;
pub(crate) mod part;
pub(crate) mod project;
pub(crate) mod render;
pub(crate) mod segment;
pub(crate) mod selection;
pub(crate) mod selection_import;
pub(crate) mod stroke;
pub(crate) mod stroke_nothing;
pub(crate) mod sub_volume;
pub(crate) mod trail;
pub(crate) mod undo;
pub(crate) mod view;
pub(crate) mod visible;
pub(crate) mod volume;
