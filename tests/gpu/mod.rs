//! Kernels and the ray caster against plain references.

mod occupancy;
mod pools;
mod shader;
mod slice;
