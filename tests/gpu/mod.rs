//! Kernels and the ray caster against plain references.

mod cast_image;
mod cast_tiles;
