//! Strokes on the device: what they touch, their kernel, and what comes back of them.
//!
//! Stands on `fields`; knows no pictures.

pub(crate) mod buffers;
pub(crate) mod kernel;
pub(crate) mod live_cells;
pub(crate) mod painter;
pub(crate) mod plan;
pub(crate) mod readback;
pub(crate) mod stroke;
pub(crate) mod submit;
pub(crate) mod tools;
