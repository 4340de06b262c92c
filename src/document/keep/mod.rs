//! How a document is kept: the project folder of generations, the journal of steps since the last save, and what is found of a
//! document whose program ended without saving.
//!
//! Knows what is saved, not the commands that changed it. A save writes the next generation beside the last, hard-links what did
//! not change, syncs, and names it by one rename.

pub(in crate::document) mod inside;
pub(in crate::document) mod journal;
pub(in crate::document) mod journal_record;
pub(in crate::document) mod journal_replay;
pub(in crate::document) mod keep_error;
pub(in crate::document) mod keeper;
pub(in crate::document) mod kept;
pub mod recovery;
pub mod source_files;
pub(in crate::document) mod store;
pub(in crate::document) mod store_arrays;
pub(in crate::document) mod store_fields;
pub(in crate::document) mod store_files;
pub(in crate::document) mod store_link;
pub(in crate::document) mod store_lock;
pub(in crate::document) mod store_manifest;
pub mod store_read;
pub(in crate::document) mod store_source;

use super::*;
