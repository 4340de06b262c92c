//! Voxels in one block of one file, as NIfTI, NRRD and their like keep them: where it starts, what its axes count, whether it
//! is compressed. Owns the bound that nothing is allocated which the file cannot hold.

use super::inflate::{Inflate, most_inflated, open_file};
use super::raw::RawSource;
use super::statistics::Accumulator;
use super::{Contents, FileMark, IoError, Opened, Progress};
use crate::volume::{BrickSource, Grid, MemorySource, Statistics, Value, VoxelType};
use crate::with_voxel_type;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
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

/// How the block is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// As it is, from this byte of the file.
    Raw { start: u64 },
    /// In a gzip stream from byte `start` of the file, `skip` inflated bytes in.
    Gzip { start: u64, skip: u64 },
}

/// See the module's head.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) path: PathBuf,
    /// The file that the user named, for messages.
    pub(super) file: String,
    pub(super) grid: Grid,
    pub(super) voxel_type: VoxelType,
    pub(super) big_endian: bool,
    pub(super) scaling: (f64, f64),
    /// Fastest first.
    pub(super) axes: Vec<Axis>,
    pub(super) encoding: Encoding,
}

/// Bytes read at once.
const CHUNK: usize = 1 << 20;

impl Layout {
    /// Checks the block against the file that should hold it.
    pub(super) fn opened(self, warnings: Vec<String>) -> Result<Opened, IoError> {
        let count = |role: Role| {
            let n = self.axes.iter().filter(|a| a.role == role).try_fold(1_u64, |n, a| n.checked_mul(a.len));
            n.and_then(|n| u32::try_from(n).ok()).filter(|&n| n > 0)
        };
        let lens: Vec<u64> = self.axes.iter().map(|a| a.len).collect();
        let small = |what| IoError::field(&self.file, what, format!("{lens:?}"), "1 to 4294967295 in all");
        let components = count(Role::Component).ok_or_else(|| small("components"))?;
        let frames = count(Role::Frame).ok_or_else(|| small("frames"))?;
        let data = FileMark::of(&self.path).map_err(IoError::system(&self.path, "open the file"))?;
        let len = data.bytes;
        let short = |found, whole: Option<u64>| IoError::Truncated {
            file: self.file.clone(),
            found,
            expected: match whole {
                Some(whole) => format!("{whole} bytes for {lens:?} voxels of type {}", self.voxel_type.name()),
                None => format!("less than 2^64 bytes for {lens:?} voxels"),
            },
        };
        let bytes = self.bytes().ok_or_else(|| short(format!("a file of {len} bytes"), None))?;
        match self.encoding {
            Encoding::Raw { start } => {
                let whole = start.checked_add(bytes);
                if whole.is_none_or(|whole| whole > len) {
                    return Err(short(format!("a file of {len} bytes"), whole));
                }
            }
            Encoding::Gzip { start, skip } => {
                let whole = skip.checked_add(bytes);
                let most = most_inflated(len.saturating_sub(start));
                if whole.is_none_or(|whole| whole > most) {
                    return Err(short(format!("a compressed file of {len} bytes, which holds at most {most}"), whole));
                }
            }
        }
        Ok(Opened {
            grid: self.grid,
            voxel_type: self.voxel_type,
            scaling: self.scaling,
            components,
            frames,
            warnings,
            files: vec![data],
            labels: Vec::new(),
            file: self.file.clone(),
            contents: Box::new(self),
        })
    }

    /// Number of voxels of all axes.
    fn count(&self) -> Option<u64> {
        self.axes.iter().try_fold(1_u64, |n, a| n.checked_mul(a.len))
    }

    /// Bytes of the block.
    pub(super) fn bytes(&self) -> Option<u64> {
        self.count()?.checked_mul(self.voxel_type.bytes() as u64)
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

    /// A stream from the block's first byte.
    fn stream(&self) -> Result<Stream<'_>, IoError> {
        match self.encoding {
            Encoding::Raw { start } => {
                let mut file = open_file(&self.path)?;
                file.seek(SeekFrom::Start(start)).map_err(IoError::system(&self.path, "read the file"))?;
                Ok(Stream { layout: self, from: Input::File(file), passed: 0 })
            }
            Encoding::Gzip { start, skip } => {
                let inflate = Inflate::open(&self.path, start)?;
                let mut stream = Stream { layout: self, from: Input::Gzip(Box::new(inflate)), passed: 0 };
                stream.skip(skip)?;
                stream.passed = 0;
                Ok(stream)
            }
        }
    }

    fn inflated<T: Value>(&self, component: u32, frame: u32, progress: Progress<'_>) -> Result<Vec<T>, IoError> {
        let total = usize::try_from(self.grid.voxel_count())
            .map_err(|_| IoError::OutOfMemory { file: self.file.clone(), bytes: u64::MAX })?;
        let mut stream = self.stream()?;
        let mut gather = Gather { layout: self, out: Vec::new(), total, progress };
        let picks = self.picks(component, frame);
        gather.walk(&self.axes, &picks, &mut stream)?;
        stream.check_end()?;
        Ok(gather.out)
    }
}

impl Contents for Layout {
    fn source(&self, component: u32, frame: u32, progress: Progress<'_>) -> Result<Arc<dyn BrickSource>, IoError> {
        match self.encoding {
            Encoding::Raw { start } => {
                let mut strides = [0; 3];
                let (mut stride, mut first) = (1, 0);
                for (axis, pick) in self.axes.iter().zip(self.picks(component, frame)) {
                    if let Role::Space(a) = axis.role {
                        strides[a] = stride;
                    }
                    first += pick * stride;
                    stride *= axis.len;
                }
                let start = start + first * self.voxel_type.bytes() as u64;
                Ok(Arc::new(RawSource::open(self, start, strides)?))
            }
            Encoding::Gzip { .. } => {
                let voxels =
                    with_voxel_type!(self.voxel_type, T => T::wrap(self.inflated::<T>(component, frame, progress)?));
                Ok(Arc::new(MemorySource::new(&self.file, self.grid, voxels, self.scaling)?))
            }
        }
    }

    fn statistics(&self, progress: Progress<'_>) -> Result<Statistics, IoError> {
        let mut sum = Accumulator::new(self.scaling);
        let mut stream = self.stream()?;
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

enum Input {
    File(File),
    Gzip(Box<Inflate>),
}

/// The block, read from its first byte on.
struct Stream<'a> {
    layout: &'a Layout,
    from: Input,
    passed: u64,
}

impl Stream<'_> {
    fn failed(&self, error: std::io::Error) -> IoError {
        let file = self.layout.file.clone();
        match error.kind() {
            std::io::ErrorKind::UnexpectedEof => IoError::Truncated {
                file,
                found: format!("an end after less than {} bytes", self.passed),
                expected: format!("{} bytes", self.layout.bytes().unwrap_or(u64::MAX)),
            },
            std::io::ErrorKind::InvalidInput | std::io::ErrorKind::InvalidData => {
                IoError::Damaged { file, reason: error.to_string() }
            }
            _ => IoError::System { file, action: "read the file", source: error },
        }
    }

    fn fill<T: Value>(&mut self, out: &mut [T]) -> Result<(), IoError> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(out);
        self.passed += bytes.len() as u64;
        let read = match &mut self.from {
            Input::File(file) => file.read_exact(bytes),
            Input::Gzip(inflate) => inflate.read_exact(bytes),
        };
        read.map_err(|e| self.failed(e))?;
        to_native(bytes, size_of::<T>(), self.layout.big_endian);
        Ok(())
    }

    fn skip(&mut self, bytes: u64) -> Result<(), IoError> {
        self.passed += bytes;
        let skipped = match &mut self.from {
            Input::File(file) => i64::try_from(bytes)
                .map_err(|_| std::io::ErrorKind::UnexpectedEof.into())
                .and_then(|n| file.seek_relative(n))
                .map(|()| bytes),
            Input::Gzip(inflate) => std::io::copy(&mut inflate.take(bytes), &mut std::io::sink()),
        };
        match skipped {
            Ok(n) if n == bytes => Ok(()),
            Ok(_) => Err(self.failed(std::io::ErrorKind::UnexpectedEof.into())),
            Err(error) => Err(self.failed(error)),
        }
    }

    /// Reads on to the end of a gzip stream, if it is near, so that its checksum is looked at.
    fn check_end(&mut self) -> Result<(), IoError> {
        match &mut self.from {
            Input::File(_) => Ok(()),
            Input::Gzip(inflate) => std::io::copy(&mut inflate.take(CHUNK as u64), &mut std::io::sink())
                .map(|_| ())
                .map_err(|e| self.failed(e)),
        }
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
        let compressed = std::fs::metadata(&self.layout.path).map_or(0, |m| m.len()) as usize;
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
