//! Burin: a workstation for people who paint, cut and explode volumes.
//!
//! The modules are floors, ground to roof; imports go down only (ARCHITECTURE.md, held by `tests/floors.rs`).

pub mod math;

pub mod volume;

pub mod explode;
pub mod io;
pub mod mesh;
pub mod paint;

pub mod gpu;

pub mod document;

pub mod interact;

pub mod script;
pub mod ui;
