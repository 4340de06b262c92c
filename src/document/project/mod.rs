//! A project on disk: a folder of generations, its arrays, its link to the files that density comes from.
//!
//! Knows the state that it keeps; knows no commands and no windows.

pub(crate) mod arrays;
pub(crate) mod density;
pub(crate) mod fields;
pub(crate) mod first_format;
pub(crate) mod link;
pub(crate) mod manifest;
pub mod read;
pub(crate) mod source;
pub(crate) mod store;

/// A generation's own description.
pub(crate) const MANIFEST: &str = "generation.json";
