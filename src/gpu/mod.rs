//! The GPU floor: device, brick pools, kernels and the ray caster.

mod body;
mod image;
pub mod order;
pub mod solid;
pub mod tiles;

pub use body::{Body, Frame, Mask, Overlay};
pub use image::{Image, ImageError};
