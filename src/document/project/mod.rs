//! A project on disk: a folder of generations, its arrays, its link to the files that density comes from.
//!
//! Knows the state that it keeps; knows no commands and no windows.

pub(crate) mod arrays;
pub(crate) mod error;
pub(crate) mod fields;
pub(crate) mod files;
pub(crate) mod inside;
pub(crate) mod link;
pub(crate) mod lock;
pub(crate) mod manifest;
pub mod read;
pub(crate) mod source;
pub mod source_files;
pub(crate) mod store;
