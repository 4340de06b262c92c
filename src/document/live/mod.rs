//! All that can be made again: the document's GPU and the parts in motion.
//!
//! Nothing here is saved.

pub(crate) mod area;
pub(crate) mod graphics;
pub(crate) mod motion;
pub(crate) mod stood;
