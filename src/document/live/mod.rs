//! All that can be made again: the document's GPU and the parts in motion.
//!
//! Nothing here is saved, but where the parts stand, and that as a cache.

pub(crate) mod aim;
pub(crate) mod area;
pub(crate) mod graphics;
pub(crate) mod motion;
pub(crate) mod stood;
