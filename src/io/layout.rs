//! Voxels in one block of one file, or of several that follow one another, as NIfTI, NRRD and their like keep them: where it
//! starts, what its axes count, how it is encoded. Owns the bound that nothing is allocated which the files cannot hold.

use crate::io::decode::{Encoding, is_gzip_again};
use crate::io::error::IoError;
use crate::io::raw::RawSource;
use crate::io::reader::{Contents, Opened, Progress};
use crate::io::regular::FileMark;
use crate::io::statistics::Accumulator;
use crate::io::stream::Stream;
use crate::volume::{BrickSource, Grid, MemorySource, Statistics, Value, VoxelType};
use crate::with_voxel_type;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;

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
    /// Checks the block against the files that should hold it.
    pub(super) fn opened(mut self, warnings: Vec<String>) -> Result<Opened, IoError> {
        let count = |role: Role| {
            let n = self.axes.iter().filter(|a| a.role == role).try_fold(1_u64, |n, a| n.checked_mul(a.len));
            n.and_then(|n| u32::try_from(n).ok()).filter(|&n| n > 0)
        };
        let small = |what| IoError::field(&self.file, what, format!("{:?}", self.lens()), "1 to 4294967295 in all");
        let components = count(Role::Component).ok_or_else(|| small("components"))?;
        let frames = count(Role::Frame).ok_or_else(|| small("frames"))?;
        let mut files = Vec::with_capacity(self.data.len());
        for n in 0..self.data.len() {
            let path = &self.data[n].path;
            let mark = FileMark::of(path).map_err(IoError::system(path, "open the file"))?;
            self.data[n].start = self.start(&self.data[n], mark.bytes)?;
            files.push(mark);
        }
        if matches!(self.encoding, Encoding::Raw | Encoding::Hex | Encoding::Text) {
            self.skip = Skip::Bytes(0);
        }
        if let (Encoding::Gzip, Some(first)) = (self.encoding, self.data.first())
            && is_gzip_again(BufReader::new(self.encoding.open(&first.path, first.start, self.voxel_type)?))
        {
            let expected = "voxels; it was compressed twice: unpack it once (gunzip) and open the result";
            return Err(IoError::field(&self.file, "voxel data", "gzip inside gzip", expected));
        }
        Ok(Opened {
            format: String::new(),
            grid: self.grid,
            voxel_type: self.voxel_type,
            scaling: self.scaling,
            components,
            frames,
            colour: false,
            warnings,
            files,
            labels: Vec::new(),
            file: self.file.clone(),
            contents: Box::new(self),
        })
    }

    /// Where in a file of `len` bytes its encoded voxels begin, as far as that is known before it is decoded.
    fn start(&self, data: &DataFile, len: u64) -> Result<u64, IoError> {
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
    fn lens(&self) -> Vec<u64> {
        self.axes.iter().map(|a| a.len).collect()
    }

    /// Number of voxels of all axes.
    fn count(&self) -> Option<u64> {
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
    fn picks(&self, component: u32, frame: u32) -> Vec<u64> {
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

    fn decoded<T: Value>(&self, component: u32, frame: u32, progress: Progress<'_>) -> Result<Vec<T>, IoError> {
        let total = usize::try_from(self.grid.voxel_count())
            .map_err(|_| IoError::OutOfMemory { file: self.file.clone(), bytes: u64::MAX })?;
        let mut stream = Stream::new(self)?;
        let mut gather = Gather { layout: self, out: Vec::new(), total, progress };
        let picks = self.picks(component, frame);
        gather.walk(&self.axes, &picks, &mut stream)?;
        stream.check_end()?;
        Ok(gather.out)
    }
}

impl Contents for Layout {
    fn source(&self, component: u32, frame: u32, progress: Progress<'_>) -> Result<Arc<dyn BrickSource>, IoError> {
        if self.encoding == Encoding::Raw {
            let mut strides = [0; 3];
            let (mut stride, mut first) = (1, 0);
            for (axis, pick) in self.axes.iter().zip(self.picks(component, frame)) {
                if let Role::Space(a) = axis.role {
                    strides[a] = stride;
                }
                first += pick * stride;
                stride *= axis.len;
            }
            let start = first * self.voxel_type.bytes() as u64;
            return Ok(Arc::new(RawSource::open(self, start, strides)?));
        }
        let voxels = with_voxel_type!(self.voxel_type, T => T::wrap(self.decoded::<T>(component, frame, progress)?));
        Ok(Arc::new(MemorySource::new(&self.file, self.grid, voxels, self.scaling)?))
    }

    fn statistics(&self, progress: Progress<'_>) -> Result<Statistics, IoError> {
        let mut sum = Accumulator::new(self.scaling);
        let mut stream = Stream::new(self)?;
        let total = self.count().unwrap_or(0);
        let mut left = total;
        while left > 0 {
            if !progress(1.0 - left as f32 / total as f32) {
                return Err(IoError::Cancelled { file: self.file.clone() });
            }
            let run = left.min((CHUNK / self.voxel_type.bytes()) as u64) as usize;
            let voxels = with_voxel_type!(self.voxel_type, T => {
                let mut v: Vec<T> = vec![bytemuck::Zeroable::zeroed(); run];
                stream.fill(&mut v)?;
                T::wrap(v)
            });
            sum.add(&voxels);
            left -= run as u64;
        }
        stream.check_end()?;
        Ok(sum.finish())
    }
}

/// Puts bytes into this machine's order in place.
pub(super) fn to_native(bytes: &mut [u8], width: usize, big_endian: bool) {
    if big_endian != cfg!(target_endian = "big") && width > 1 {
        bytes.chunks_exact_mut(width).for_each(<[u8]>::reverse);
    }
}

/// Collects one component of one frame from the whole block.
struct Gather<'a, T> {
    layout: &'a Layout,
    out: Vec<T>,
    total: usize,
    progress: Progress<'a>,
}

impl<T: Value> Gather<'_, T> {
    /// Reads all of `axes` (fastest first) from the stream and keeps what is picked.
    fn walk(&mut self, axes: &[Axis], picks: &[u64], stream: &mut Stream<'_>) -> Result<(), IoError> {
        let len = |axes: &[Axis]| axes.iter().map(|a| a.len).product::<u64>();
        if axes.iter().all(|a| matches!(a.role, Role::Space(_))) {
            return self.take(len(axes), stream);
        }
        if len(axes) <= (CHUNK / size_of::<T>()) as u64 {
            let mut block: Vec<T> = vec![bytemuck::Zeroable::zeroed(); len(axes) as usize];
            stream.fill(&mut block)?;
            self.grow(self.out.len() + block.len())?;
            pick(axes, picks, &block, &mut self.out);
            return self.going_on();
        }
        let Some((last, inner)) = axes.split_last() else { return Ok(()) };
        if matches!(last.role, Role::Space(_)) {
            for _ in 0..last.len {
                self.walk(inner, picks, stream)?;
            }
            return Ok(());
        }
        let at = picks[inner.len()];
        let bytes = len(inner) * size_of::<T>() as u64;
        stream.skip(at * bytes)?;
        self.walk(inner, picks, stream)?;
        stream.skip((last.len - 1 - at) * bytes)
    }

    fn take(&mut self, mut count: u64, stream: &mut Stream<'_>) -> Result<(), IoError> {
        while count > 0 {
            let run = count.min((CHUNK / size_of::<T>()) as u64) as usize;
            let from = self.out.len();
            self.grow(from + run)?;
            self.out.resize(from + run, bytemuck::Zeroable::zeroed());
            stream.fill(&mut self.out[from..])?;
            self.going_on()?;
            count -= run as u64;
        }
        Ok(())
    }

    /// Room for `len` voxels: at first what a file of this size is likely to hold, then half as much again whenever the data
    /// really came, never more than the grid. A header alone makes nobody allocate.
    fn grow(&mut self, len: usize) -> Result<(), IoError> {
        let len = len.min(self.total);
        if len <= self.out.capacity() {
            return Ok(());
        }
        let files = self.layout.data.iter().map(|d| std::fs::metadata(&d.path).map_or(0, |m| m.len()));
        let compressed = usize::try_from(files.sum::<u64>()).unwrap_or(usize::MAX);
        let likely = compressed.saturating_mul(8).max(self.out.capacity() + self.out.capacity() / 2);
        let room = (likely / size_of::<T>()).max(len).min(self.total);
        self.out.try_reserve_exact(room - self.out.len()).map_err(|_| IoError::OutOfMemory {
            file: self.layout.file.clone(),
            bytes: room as u64 * size_of::<T>() as u64,
        })
    }

    fn going_on(&self) -> Result<(), IoError> {
        if (self.progress)(self.out.len() as f32 / self.total as f32) {
            Ok(())
        } else {
            Err(IoError::Cancelled { file: self.layout.file.clone() })
        }
    }
}

/// Appends the picked voxels of a block in memory.
fn pick<T: Value>(axes: &[Axis], picks: &[u64], block: &[T], out: &mut Vec<T>) {
    let Some((last, inner)) = axes.split_last() else {
        return out.extend_from_slice(block);
    };
    let part = block.len() / last.len as usize;
    if !matches!(last.role, Role::Space(_)) {
        let at = picks[inner.len()] as usize * part;
        return pick(inner, picks, &block[at..at + part], out);
    }
    match inner {
        // The common interleaved row, without a call per voxel.
        [axis] if !matches!(axis.role, Role::Space(_)) => {
            out.extend(block.iter().skip(picks[0] as usize).step_by(part));
        }
        [] => out.extend_from_slice(block),
        _ => block.chunks_exact(part).for_each(|part| pick(inner, picks, part, out)),
    }
}
