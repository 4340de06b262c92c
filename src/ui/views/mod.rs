//! The four views: their pictures, what lies over them, and the pointer in them.

pub(crate) mod boxes;
pub(crate) mod footprint;
pub(crate) mod labels;
pub(crate) mod outlines;
pub(crate) mod overlay;
pub(crate) mod pointer;
pub(crate) mod trail;
pub(crate) mod viewport;
