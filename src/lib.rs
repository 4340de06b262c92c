//! Burin: a workstation for people who paint, cut and explode volumes.
//!
//! The modules are floors, ground to roof; imports go down only (ARCHITECTURE.md, held by `tests/floors.rs`).

// What is public is what a user of the library needs; tests and benches are crates of their own, and name theirs as they like.
#![deny(unreachable_pub)]

pub mod math;

pub mod volume;

pub mod annotate;
pub mod explode;
pub mod io;
pub mod mesh;
pub mod paint;
pub mod segment;

pub mod gpu;

pub mod document;

pub mod interact;

pub mod script;
pub mod ui;
