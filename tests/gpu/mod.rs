//! Kernels and the ray caster against plain references.

mod occupancy;
mod pools;
