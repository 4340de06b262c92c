//! Uncompressed voxels left in their file and read box by box, in any byte order and with any strides.
//!
//! Positioned reads, not a memory map: a map of a file that another program shortens kills the process at the next touch;
//! a read answers with an error. A file that changed since it was opened (length or time) is an error too, since edits lie
//! over the voxels that were there.

use super::IoError;
use super::inflate::open_file;
use super::layout::{Layout, to_native};
use super::regular::read_exact_at;
use crate::volume::{BrickSource, Grid, SourceError, VoxelType, Voxels, check_box};
use std::fs::File;
use std::time::SystemTime;

/// Bytes between two wanted rows that are read along rather than skipped by another call: a call costs what copying
/// about this much costs.
const GAP: u64 = 3 << 10;

/// The most bytes read in one call when rows are gathered.
const SPAN: u64 = 1 << 20;

/// One component of one frame of an uncompressed file.
#[derive(Debug)]
pub(super) struct RawSource {
    file: File,
    name: String,
    grid: Grid,
    voxel_type: VoxelType,
    big_endian: bool,
    scaling: (f64, f64),
    /// Byte of voxel (0, 0, 0).
    start: u64,
    /// Voxels from one to the next along i, j, k.
    strides: [u64; 3],
    seen: (u64, Option<SystemTime>),
}

impl RawSource {
    /// `layout` was checked against the file's length.
    pub(super) fn open(layout: &Layout, start: u64, strides: [u64; 3]) -> Result<Self, IoError> {
        let file = open_file(&layout.path)?;
        let seen = state(&file).map_err(IoError::system(&layout.path, "read the file"))?;
        Ok(Self {
            file,
            name: layout.file.clone(),
            grid: layout.grid,
            voxel_type: layout.voxel_type,
            big_endian: layout.big_endian,
            scaling: layout.scaling,
            start,
            strides,
            seen,
        })
    }

    fn unreadable(&self, reason: impl ToString) -> SourceError {
        SourceError::Unreadable { name: self.name.clone(), reason: reason.to_string() }
    }

    fn read_at(&self, bytes: &mut [u8], at: u64) -> Result<(), SourceError> {
        read_exact_at(&self.file, bytes, at).map_err(|e| self.unreadable(e))
    }
}

impl BrickSource for RawSource {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    fn scaling(&self) -> (f64, f64) {
        self.scaling
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        check_box(lo, size, self.grid.dims)?;
        if state(&self.file).map_err(|e| self.unreadable(e))? != self.seen {
            return Err(self.unreadable("it changed since it was opened"));
        }
        let [nx, ny, nz] = size.map(u64::from);
        let width = self.voxel_type.bytes();
        let count = nx * ny * nz;
        let mut voxels = Voxels::try_zeroed(self.voxel_type, count as usize)
            .map_err(|_| SourceError::OutOfMemory { bytes: count * width as u64 })?;
        if count == 0 {
            return Ok(voxels);
        }
        let w = width as u64;
        let [sx, sy, sz] = self.strides;
        let span_of = |n: u64, stride: u64| (n - 1) * stride;
        // Bytes from a row's first voxel to its last one's end.
        let row = (span_of(nx, sx) + 1) * w;
        let place = |y: u64, z: u64| {
            let voxel = u64::from(lo[0]) * sx + (u64::from(lo[1]) + y) * sy + (u64::from(lo[2]) + z) * sz;
            self.start + voxel * w
        };
        let out = voxels.as_bytes_mut();
        let out_row = nx as usize * width;
        if sx > 1 && sx * w > GAP {
            // Voxels far apart: rows of them would be mostly other components.
            for (i, voxel) in out.chunks_exact_mut(width).enumerate() {
                let (x, y, z) = (i as u64 % nx, i as u64 / nx % ny, i as u64 / (nx * ny));
                self.read_at(voxel, place(y, z) + x * sx * w)?;
            }
        } else if sx == 1 && (ny == 1 || sy == nx) && (nz == 1 || sz == nx * ny) {
            self.read_at(out, place(0, 0))?;
        } else {
            // Rows gathered into one call: as many as lie close together.
            let close = ny > 1 && (sy * w).saturating_sub(row) <= GAP;
            let rows = if close { (SPAN / (sy * w)).clamp(1, ny) } else { 1 };
            let mut block = vec![0; usize::try_from(span_of(rows, sy) * w + row).map_err(|e| self.unreadable(e))?];
            for z in 0..nz {
                for y in (0..ny).step_by(rows as usize) {
                    let rows = rows.min(ny - y);
                    let block = &mut block[..(span_of(rows, sy) * w + row) as usize];
                    self.read_at(block, place(y, z))?;
                    for r in 0..rows {
                        let to = (y + r + ny * z) as usize * out_row;
                        let to = &mut out[to..to + out_row];
                        let from = &block[(r * sy * w) as usize..];
                        if sx == 1 {
                            to.copy_from_slice(&from[..out_row]);
                        } else {
                            let voxels = from.chunks(sx as usize * width);
                            to.chunks_exact_mut(width).zip(voxels).for_each(|(t, f)| t.copy_from_slice(&f[..width]));
                        }
                    }
                }
            }
        }
        to_native(out, width, self.big_endian);
        Ok(voxels)
    }
}

/// What tells a changed file from an unchanged one.
fn state(file: &File) -> std::io::Result<(u64, Option<SystemTime>)> {
    let about = file.metadata()?;
    Ok((about.len(), about.modified().ok()))
}
