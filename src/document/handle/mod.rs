//! What each command does: one file per noun, every one a part of `Document`.
//!
//! A handler changes the state through an `Edit`, which remembers what was there; whoever calls it makes the step of history and
//! the record of the journal.

pub(in crate::document) mod ask;
pub(in crate::document) mod brush;
pub(in crate::document) mod explosion;
pub(in crate::document) mod labels;
pub(in crate::document) mod overlap;
pub(in crate::document) mod part;
pub(in crate::document) mod project;
pub(in crate::document) mod render;
pub(in crate::document) mod segment;
pub(in crate::document) mod selection;
pub(in crate::document) mod selection_import;
pub(in crate::document) mod stroke;
mod stroke_nothing;
pub(in crate::document) mod transfer;
pub(in crate::document) mod undo;
pub(in crate::document) mod view;
pub(in crate::document) mod volume;

use super::*;
