//! The device and what every kernel needs of it: errors, the shader composer, structs shared with shaders, reading back.
//!
//! The lowest folder of the floor; knows no fields and no pictures.

pub(crate) mod adapter;
pub mod constants;
pub(crate) mod error;
pub(crate) mod gpu;
pub(crate) mod kernel;
pub(crate) mod pass_queries;
pub mod shader;
pub mod shared;
pub(crate) mod stopwatch;
pub(crate) mod textures;
