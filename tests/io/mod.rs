//! Readers and writers.

mod files;
mod types;
