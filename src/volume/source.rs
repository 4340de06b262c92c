//! Where unedited voxels come from.

use crate::volume::Voxels;
use crate::volume::grid::Grid;
use crate::volume::voxel_type::VoxelType;
use crate::with_voxels;

/// Why voxels could not be had.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The file behind the volume failed or changed.
    #[error("cannot read voxels from {name}: {reason}; check that the file is still there and unchanged")]
    Unreadable {
        /// File.
        name: String,
        /// What the system or the decoder said.
        reason: String,
    },
    /// The box asked for is not inside the volume.
    #[error("box at {lo:?} of size {size:?} is not inside a volume of {dims:?} voxels")]
    OutOfBounds {
        /// First voxel.
        lo: [u32; 3],
        /// Voxels per axis.
        size: [u32; 3],
        /// The volume's dimensions.
        dims: [u32; 3],
    },
    /// Not enough memory for the box.
    #[error("out of memory for {bytes} bytes of voxels; close other volumes or lower the memory budget")]
    OutOfMemory {
        /// Bytes asked for.
        bytes: u64,
    },
}

/// One component of one frame of a volume, readable box by box, so that it need not be in memory.
pub trait BrickSource: Send + Sync + std::fmt::Debug {
    /// Dimensions and place.
    fn grid(&self) -> &Grid;
    /// Type of the voxels as stored.
    fn voxel_type(&self) -> VoxelType;
    /// `value = slope · stored + intercept`.
    fn scaling(&self) -> (f64, f64);
    /// What to call it in messages: normally the file.
    fn name(&self) -> &str;
    /// The voxels of the box that starts at `lo` (index space), x fastest, as stored.
    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError>;
}

/// A source that holds all of its voxels.
#[derive(Debug)]
pub struct MemorySource {
    name: String,
    grid: Grid,
    voxels: Voxels,
    scaling: (f64, f64),
}

impl MemorySource {
    /// `voxels` in index order, x fastest; `value = scaling.0 · stored + scaling.1`.
    ///
    /// # Errors
    /// If the number of voxels is not that of the grid.
    pub fn new(name: impl Into<String>, grid: Grid, voxels: Voxels, scaling: (f64, f64)) -> Result<Self, SourceError> {
        let name = name.into();
        if voxels.len() as u64 != grid.voxel_count() {
            return Err(SourceError::Unreadable {
                reason: format!("{} voxels found, {} expected", voxels.len(), grid.voxel_count()),
                name,
            });
        }
        Ok(Self { name, grid, voxels, scaling })
    }

    /// All voxels, x fastest.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }
}

impl BrickSource for MemorySource {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn voxel_type(&self) -> VoxelType {
        self.voxels.voxel_type()
    }

    fn scaling(&self) -> (f64, f64) {
        self.scaling
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        let dims = self.grid.dims;
        check_box(lo, size, dims)?;
        fn gather<T: crate::volume::voxels::Value>(all: &[T], lo: [u32; 3], size: [u32; 3], dims: [u32; 3]) -> Voxels {
            let mut out = Vec::with_capacity(size.iter().map(|&s| s as usize).product());
            for z in lo[2]..lo[2] + size[2] {
                for y in lo[1]..lo[1] + size[1] {
                    let row = lo[0] as usize + dims[0] as usize * (y as usize + dims[1] as usize * z as usize);
                    out.extend_from_slice(&all[row..row + size[0] as usize]);
                }
            }
            T::wrap(out)
        }
        Ok(with_voxels!(&self.voxels, v => gather(v, lo, size, dims)))
    }
}

/// Fails unless the box is inside a volume of `dims` voxels.
pub(crate) fn check_box(lo: [u32; 3], size: [u32; 3], dims: [u32; 3]) -> Result<(), SourceError> {
    let inside = (0..3).all(|a| lo[a].checked_add(size[a]).is_some_and(|hi| hi <= dims[a]));
    if inside { Ok(()) } else { Err(SourceError::OutOfBounds { lo, size, dims }) }
}
