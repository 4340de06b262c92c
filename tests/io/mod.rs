//! Readers and writers.

mod axes;
mod export;
mod files;
mod places;
mod types;
