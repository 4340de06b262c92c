//! Painting, as arithmetic: brushes, strokes, dabs, and how much of a dab a voxel gets.
//!
//! Pure: knows fields and geometry, neither the GPU nor documents. Direct Volume Editing (2008) section 3, equations 1 and 2
//! in the form P′ = P + G·((C op P) − P), G = strength·F(d), F = 0 beyond the support.

mod brush;
mod build_up;
mod connected;
mod dab;
mod error;
mod falloff;
mod gate;
mod limits;
mod mirror;
mod only;
mod passed;
mod path;
mod reach;
mod room;
mod surface;
mod voxel_set;

pub use brush::{Brush, BrushChange, EraseDensity, Operation, Sample, Shape, Target, Tip};
pub use build_up::BuildUpBound;
pub use connected::connected;
pub use dab::{Dab, Footprint, IndexBox, half_diagonal_mm, image, with_images};
pub use error::PaintError;
pub use falloff::{CURVE_POINTS, EDGE, Falloff, FalloffCurve};
pub use gate::{GATE_WORDS, Gate};
pub use limits::{Confines, Limit, Limits, margin};
pub use mirror::{Mirror, MirrorAxis};
pub use only::{OfSegment, Only, Side};
pub use path::{MAX_DABS, StrokePath, step_mm};
pub use reach::Reach;
pub use surface::{CLOSE_VOXELS, Seen, SurfaceRule};
pub use voxel_set::{BrickBits, VoxelSet};
