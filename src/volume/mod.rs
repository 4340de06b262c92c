//! What a volume is: its grid, its voxels by the brick, their coarser levels, and how they look.
//!
//! Owns `Grid`, `BrickSource` (where unedited voxels come from), `Field` (one quantity over the grid: edits in a sparse
//! map over a source, coarser levels, cell minima and maxima), segments and the transfer function. Knows no file format
//! and no GPU; texels are kept in the GPU's formats so that host, file and GPU hold the same bytes.

mod band;
mod blocks;
mod brick;
mod carry;
mod cells;
mod computed;
mod distance;
mod field;
mod first_transfer;
mod grid;
mod histogram;
mod levels;
mod live;
mod look;
mod number;
mod presets;
mod pyramid;
mod refined;
mod resample;
mod segments;
mod source;
mod standing;
mod texel;
mod total;
mod transfer;
mod values;
#[expect(clippy::module_inception, reason = "the file is named for its type")]
mod volume;
mod voxel_type;
mod voxels;

pub use band::BandBrick;
pub use blocks::Region;
pub use brick::{BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickKey, CELL, CELLS_PER_BRICK, SLOT, SLOT_VOXELS};
pub use carry::Carry;
pub use cells::{BrickSummary, Cells};
pub use computed::{Lies, SubBox};
pub use distance::squared_distances;
pub use field::{Changes, Field, FieldKind, Refresh};
pub use grid::Grid;
pub use histogram::{Histogram, Measured};
pub use live::{LiveCells, SelectedCell, selected_cells};
pub use look::{Lighting, Mode};
pub use number::Number;
pub use presets::Preset;
pub use segments::{Segment, Segments};
pub(crate) use source::check_box;
pub use source::{BrickSource, MemorySource, SourceError};
pub use standing::{Asked, Standing};
pub use texel::{DensityMap, TexelFormat};
pub use total::Total;
pub use transfer::{TABLE_ENTRIES, TransferFunction};
pub use values::Values;
pub(crate) use values::{is_plain, unit};
pub use volume::{FieldKey, Volume, VolumeId};
pub use voxel_type::VoxelType;
pub use voxels::Voxels;
pub use voxels::{Statistics, Value};
