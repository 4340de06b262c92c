//! Kernels and the ray caster against plain references.

mod brush;
mod occupancy;
mod pools;
mod shader;
mod slice;
