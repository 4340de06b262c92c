//! Folders and files that the document keeps things in: locks, what lies inside a folder, files made true by one rename, and the
//! files that volumes come from.
//!
//! Knows neither scenes nor voxels.

pub(crate) mod error;
pub(crate) mod files;
pub(crate) mod inside;
pub(crate) mod lock;
pub mod source_files;
