//! Uncompressed voxels left in their files and read box by box, in any byte order and with any strides.
//!
//! Positioned reads, not a memory map: a map of a file that another program shortens kills the process at the next touch;
//! a read answers with an error. A file that changed since it was opened (length or time) is an error too, since edits lie
//! over the voxels that were there.

use crate::io::codec::inflate::open_file;
use crate::io::error::IoError;
use crate::io::layout::{Layout, to_native};
use crate::io::regular::read_exact_at;
use crate::volume::{BrickSource, Grid, SourceError, VoxelType, Voxels, check_box};
use std::fs::File;
use std::path::PathBuf;
use std::time::SystemTime;

/// Bytes between two wanted rows that are read along rather than skipped by another call: a call costs what copying
/// about this much costs.
const GAP: u64 = 3 << 10;

/// The most bytes read in one call when rows are gathered.
const SPAN: u64 = 1 << 20;

/// Files of a series that are held open; of more, each is opened when it is read.
const HELD: usize = 128;

/// What is said of a file that is not what it was.
const CHANGED: &str = "it changed since it was opened";

/// A file with its share of the block.
#[derive(Debug)]
struct Share {
    path: PathBuf,
    held: Option<File>,
    /// Byte at which its voxels begin.
    start: u64,
    seen: (u64, Option<SystemTime>),
}

/// One component of one frame of uncompressed files.
#[derive(Debug)]
pub(super) struct RawSource {
    shares: Vec<Share>,
    /// Bytes of the block in each of them.
    share_bytes: u64,
    name: String,
    grid: Grid,
    voxel_type: VoxelType,
    big_endian: bool,
    scaling: (f64, f64),
    /// Byte of the block where voxel (0, 0, 0) is.
    start: u64,
    /// Voxels from one to the next along i, j, k.
    strides: [u64; 3],
}

impl RawSource {
    /// `layout` was checked against the files' lengths.
    pub(super) fn open(layout: &Layout, start: u64, strides: [u64; 3]) -> Result<Self, IoError> {
        let hold = layout.data.len() <= HELD;
        let share = |data: &crate::io::layout::DataFile| {
            let file = open_file(&data.path)?;
            let seen = state(&file).map_err(IoError::system(&data.path, "read the file"))?;
            Ok(Share { path: data.path.clone(), held: hold.then_some(file), start: data.start, seen })
        };
        Ok(Self {
            shares: layout.data.iter().map(share).collect::<Result<_, IoError>>()?,
            share_bytes: layout.file_bytes().unwrap_or(0),
            name: layout.file.clone(),
            grid: layout.grid,
            voxel_type: layout.voxel_type,
            big_endian: layout.big_endian,
            scaling: layout.scaling,
            start,
            strides,
        })
    }

    fn unreadable(&self, reason: impl ToString) -> SourceError {
        SourceError::Unreadable {
            name: self.name.clone(),
            reason: crate::io::words::without_numbers(&reason.to_string()),
        }
    }

    /// Bytes of the block, from whichever files they are in.
    fn read_at(&self, mut bytes: &mut [u8], mut at: u64) -> Result<(), SourceError> {
        while !bytes.is_empty() {
            // A block of no bytes has no voxels to be asked for.
            let (n, within) = (at / self.share_bytes.max(1), at % self.share_bytes.max(1));
            let run = (bytes.len() as u64).min(self.share_bytes - within) as usize;
            let (part, rest) = bytes.split_at_mut(run);
            let share = self.shares.get(n as usize).ok_or_else(|| self.unreadable("it has no such voxels"))?;
            let read = match &share.held {
                Some(file) => read_exact_at(file, part, share.start + within),
                None => crate::io::regular::open_regular(&share.path).and_then(|file| {
                    // Looked at again: meanwhile the name may lead to another file.
                    let same = state(&file)? == share.seen;
                    let changed = || std::io::Error::other(format!("{}: {CHANGED}", share.path.display()));
                    if same { read_exact_at(&file, part, share.start + within) } else { Err(changed()) }
                }),
            };
            read.map_err(|e| self.unreadable(e))?;
            bytes = rest;
            at += run as u64;
        }
        Ok(())
    }

    /// Fails if a file with one of these bytes of the block changed since it was opened.
    fn check_unchanged(&self, from: u64, to: u64) -> Result<(), SourceError> {
        let of = |at: u64| (at / self.share_bytes.max(1)) as usize;
        for share in self.shares.iter().take(of(to) + 1).skip(of(from)) {
            if let Some(file) = &share.held
                && state(file).map_err(|e| self.unreadable(e))? != share.seen
            {
                return Err(self.unreadable(CHANGED));
            }
        }
        Ok(())
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
        self.check_unchanged(place(0, 0), place(ny - 1, nz - 1) + row - 1)?;
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
