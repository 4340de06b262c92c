//! The GPU floor: device, brick pools, kernels and the ray caster.

mod body;

pub use body::{Body, Frame, Mask, Overlay};
