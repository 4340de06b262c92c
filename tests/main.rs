//! All tests in one binary. One module per floor; `common` holds what they share and no formula under test.
#![allow(clippy::unwrap_used, missing_docs)]

mod annotate;
mod common;
mod document;
mod explode;
mod floors;
mod gpu;
mod io;
mod math;
mod mesh;
mod modules;
mod paint;
mod segment;
mod ui;
mod volume;
