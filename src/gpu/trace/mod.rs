//! Surface particles ("Direct Volume Editing", 2008, section 5): grids of points over an iso-surface, as annotations and windows lie on.
//!
//! Owns what is asked for and answered ([`request`]), which voxels that takes ([`reach`]), and the kernel ([`tracer`]). Stands on `fields`;
//! knows no pictures, no textures and no documents.

pub(crate) mod reach;
pub(crate) mod request;
pub(crate) mod tracer;
