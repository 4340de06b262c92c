//! What is written on and about volumes: grids on surfaces, what they show, windows into what lies behind, labels beside the picture.
//!
//! Pure arithmetic over a surface that others tell of, after "Direct Volume Editing" (2008), section 5. Knows no voxels, documents or GPU.

pub mod grid;
pub mod labels;
pub mod path;
pub mod picture;
pub mod relaxing;
pub mod surface;
pub mod window;
