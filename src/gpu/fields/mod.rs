//! Voxels of all volumes on the device: pools of slots, page tables, what is needed of them, and where rays may skip.
//!
//! Owns group 1 of the shaders that look at voxels. The host's fields stay the truth.

pub(crate) mod bindings;
pub(crate) mod demand;
pub(crate) mod dirty_bricks;
pub(crate) mod importance;
pub(crate) mod matter;
pub(crate) mod page_tables;
pub(crate) mod pool;
pub(crate) mod pools;
pub(crate) mod residency;
pub(crate) mod skip_maps;
pub(crate) mod slot_key;
pub(crate) mod visible_values;
pub(crate) mod volumes;
