//! Commands, history, journal, projects.

mod exploded;
mod fixtures;
mod history;
mod keep;
mod keep_faults;
mod keep_journal;
mod keep_kill;
mod keep_program;
mod keep_support;
mod keep_zarr;
mod labels;
pub mod maker;
pub mod maker_gpu;
mod memory;
mod motion;
mod nouns;
mod parts;
mod past;
mod pictures;
mod program;
mod projects;
mod script;
mod selection;
mod strokes;
mod views;
mod volumes;
