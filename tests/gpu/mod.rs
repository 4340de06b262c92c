//! Kernels and the ray caster against plain references.

mod backdrop;
mod brush;
mod cast_bodies;
mod cast_forms;
mod cast_image;
mod cast_layers;
mod cast_limits;
mod cast_modes;
mod cast_near;
mod cast_refine;
mod cast_rings;
mod cast_tiles;
mod device;
mod in_place;
mod looks;
mod many_volumes;
mod occupancy;
mod pools;
mod pools_work;
mod probe;
pub(crate) mod reference;
mod reference_boxes;
mod reference_refined;
mod residency;
mod shader;
mod slice;
mod without;
