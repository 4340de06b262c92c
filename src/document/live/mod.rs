//! All that can be made again: the document's GPU and the parts in motion.
//!
//! Nothing here is saved, but where the parts stand, and that as a cache.

pub(crate) mod aim;
pub(crate) mod area;
pub(crate) mod contact;
pub(crate) mod drawings;
pub(crate) mod fonts;
pub(crate) mod graphics;
pub(crate) mod laid;
pub(crate) mod motion;
pub(crate) mod poles;
pub(crate) mod spots;
pub(crate) mod stood;
pub(crate) mod voxel_surface;
pub(crate) mod windows;
