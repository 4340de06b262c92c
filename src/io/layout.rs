//! Voxels in one block of one file, or of several that follow one another, as NIfTI, NRRD and their like keep them: where it
//! starts, what its axes count, how it is encoded. Owns the bound that nothing is allocated which the files cannot hold.

use crate::io::codec::decode::Encoding;
use crate::io::error::IoError;
use crate::volume::{Grid, VoxelType};
use std::path::PathBuf;

/// What an axis of the file counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Voxels along i (0), j (1) or k (2); these come in this order.
    Space(usize),
    /// Numbers per voxel. Several such axes count together, the first fastest.
    Component,
    /// Volumes. Likewise.
    Frame,
}

/// One axis of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) len: u64,
    pub(super) role: Role,
}

/// A file that holds the block, or its share of it.
#[derive(Clone, Debug)]
pub(super) struct DataFile {
    pub(super) path: PathBuf,
    /// Byte at which the encoded voxels begin.
    pub(super) start: u64,
}

/// Bytes to pass over before the voxels, of what a file holds once it is decoded; of hex and text as they are in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    /// So many from the beginning.
    Bytes(u64),
    /// As many as leave the voxels and so many behind them. Not for hex and text.
    AllBut(u64),
}

/// Where the voxels of a file lie: first byte, numbers and strides of each axis, type, byte order, encoding.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// In order; each holds the same share of the block.
    pub(super) data: Vec<DataFile>,
    /// The file that the user named, for messages.
    pub(super) file: String,
    pub(super) grid: Grid,
    pub(super) voxel_type: VoxelType,
    pub(super) big_endian: bool,
    pub(super) scaling: (f64, f64),
    /// Fastest first.
    pub(super) axes: Vec<Axis>,
    pub(super) encoding: Encoding,
    pub(super) skip: Skip,
}

/// Bytes read at once.
pub(super) const CHUNK: usize = 1 << 20;

impl Layout {
    /// Where in a file of `len` bytes its encoded voxels begin, as far as that is known before it is decoded.
    pub(super) fn start(&self, data: &DataFile, len: u64) -> Result<u64, IoError> {
        let (lens, start) = (self.lens(), data.start);
        let of = if self.data.len() == 1 { String::new() } else { format!(" ({})", data.path.display()) };
        let short = |found: String, expected: String| IoError::Truncated {
            file: self.file.clone(),
            found: found + &of,
            expected: format!("{expected} for {lens:?} voxels of type {}", self.voxel_type.name()),
        };
        let Some(bytes) = self.file_bytes() else {
            return Err(short(format!("a file of {len} bytes"), "less than 2^64 bytes".into()));
        };
        let left = len.saturating_sub(start);
        match (self.encoding, self.skip) {
            (Encoding::Raw, Skip::AllBut(behind)) => {
                let needed = bytes.checked_add(behind).filter(|&n| n <= left);
                let needed = needed.ok_or_else(|| {
                    short(format!("{left} bytes after the header"), format!("{bytes} bytes and {behind} behind them"))
                })?;
                Ok(len - needed)
            }
            (Encoding::Raw, Skip::Bytes(skip)) => {
                let whole = start.checked_add(skip).and_then(|from| from.checked_add(bytes));
                match whole.filter(|&whole| whole <= len) {
                    Some(whole) => Ok(whole - bytes),
                    None => {
                        let asked = whole.map_or("less than 2^64 bytes".into(), |whole| format!("{whole} bytes"));
                        Err(short(format!("a file of {len} bytes"), asked))
                    }
                }
            }
            (encoding, skip) => {
                let skip = match skip {
                    Skip::Bytes(n) | Skip::AllBut(n) => n,
                };
                let is_text = matches!(encoding, Encoding::Hex | Encoding::Text);
                let (before, within) = if is_text { (skip, 0) } else { (0, skip) };
                let most = encoding.most(left.saturating_sub(before), self.voxel_type);
                let whole = within.checked_add(bytes);
                if whole.is_none_or(|whole| whole > most) {
                    let kind = if is_text { encoding.name() } else { "compressed" };
                    let found = format!("a {kind} file of {len} bytes, which holds at most {most}");
                    let asked = whole.map_or("less than 2^64 bytes".into(), |whole| format!("{whole} bytes"));
                    return Err(short(found, asked));
                }
                Ok(start + before)
            }
        }
    }

    /// Lengths of all axes, fastest first.
    pub(super) fn lens(&self) -> Vec<u64> {
        self.axes.iter().map(|a| a.len).collect()
    }

    /// Number of voxels of all axes.
    pub(super) fn count(&self) -> Option<u64> {
        self.axes.iter().try_fold(1_u64, |n, a| n.checked_mul(a.len))
    }

    /// Bytes of the block.
    pub(super) fn bytes(&self) -> Option<u64> {
        self.count()?.checked_mul(self.voxel_type.bytes() as u64)
    }

    /// Bytes of each file's share of it.
    pub(super) fn file_bytes(&self) -> Option<u64> {
        Some(self.bytes()? / self.data.len() as u64)
    }

    /// For each axis, which of it belongs to a component of a frame; 0 for axes of space.
    pub(super) fn picks(&self, component: u32, frame: u32) -> Vec<u64> {
        let (mut c, mut f) = (u64::from(component), u64::from(frame));
        let mut pick = |axis: &Axis| {
            let rest = match axis.role {
                Role::Space(_) => return 0,
                Role::Component => &mut c,
                Role::Frame => &mut f,
            };
            let at = *rest % axis.len;
            *rest /= axis.len;
            at
        };
        self.axes.iter().map(&mut pick).collect()
    }
}

/// Puts bytes into this machine's order in place.
pub(super) fn to_native(bytes: &mut [u8], width: usize, big_endian: bool) {
    if big_endian != cfg!(target_endian = "big") && width > 1 {
        bytes.chunks_exact_mut(width).for_each(<[u8]>::reverse);
    }
}
