//! Kernels and the ray caster against plain references.

mod pools;
