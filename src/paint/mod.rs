//! Painting, as arithmetic: brushes, strokes, dabs, and how much of a dab a voxel gets.
//!
//! Pure: knows fields and geometry, neither the GPU nor documents. Direct Volume Editing (2008) section 3, equations 1 and 2
//! in the form P′ = P + G·((C op P) − P), G = strength·F(d), F = 0 beyond the support.

mod around;
mod brush;
mod build_up;
mod change;
mod contour;
mod dab;
mod error;
mod falloff;
mod fill;
mod gate;
mod goals;
mod limits;
mod mirror;
mod only;
mod passed;
mod path;
mod reach;
mod room;
mod surface;
mod voxel_set;

pub use around::Block;
pub use brush::{Brush, EraseDensity, Operation, Pressure, Sample, Shape, Target, Tip};
pub use build_up::BuildUpBound;
pub use change::BrushChange;
pub use contour::Contour;
pub use dab::{Along, Dab, Footprint, IndexBox, half_diagonal_mm, image, with_images};
pub use error::PaintError;
pub use falloff::{CURVE_POINTS, EDGE, Falloff, FalloffCurve};
pub use fill::Filled;
pub use gate::{GATE_WORDS, Gate};
pub use goals::{GOALS, Goals};
pub use limits::{Confines, Limit, Limits, margin};
pub use mirror::{Mirror, MirrorAxis};
pub use only::{OfSegment, Only, Side};
pub use path::{MAX_DABS, StrokePath, step_mm};
pub use reach::Reach;
pub use surface::{CLOSE_VOXELS, Seen, SurfaceRule};
pub use voxel_set::{BrickBits, VoxelSet};
