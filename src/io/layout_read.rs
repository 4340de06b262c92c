//! Reading a [`Layout`]: its files checked, and its voxels as a source or as statistics.

use crate::io::codec::decode::{Encoding, is_gzip_again};
use crate::io::error::IoError;
use crate::io::layout::{Axis, CHUNK, Layout, Role, Skip};
use crate::io::progress::Progress;
use crate::io::raw::RawSource;
use crate::io::reader::{Contents, Opened};
use crate::io::regular::FileMark;
use crate::io::statistics::Accumulator;
use crate::io::stream::Stream;
use crate::volume::{BrickSource, MemorySource, Statistics, Value};
use crate::with_voxel_type;
use std::io::BufReader;
use std::sync::Arc;

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
