//! What annotations show: texts, shapes and images as textures ("Direct Volume Editing", 2008, section 5.1).

pub mod boundary;
pub mod distance;
pub mod error;
pub mod fonts;
pub mod hatch;
pub mod outline;
pub mod shapes;
pub mod shaping;
pub mod sheet;
pub mod text;
pub mod texture;
