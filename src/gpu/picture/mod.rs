//! What is asked for and what comes back: frames, bodies, images. Plain data.
//!
//! Knows no device, but that images are read back from one.

pub(crate) mod decal;
pub(crate) mod focus;
pub(crate) mod frame;
pub(crate) mod image;
pub(crate) mod layer;
pub(crate) mod object_id;
