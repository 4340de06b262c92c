//! The density of a project as a source: read by the chunk from its Zarr array, so that a reopened project needs neither
//! the original file nor room for the whole volume.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::document::disk::inside::Files;
use crate::document::project::arrays::{Layout, check_hash, damaged_chunk};
use crate::document::project::fields::{DENSITY, Shards, place_name};
use crate::volume::{BRICK, BrickSource, Grid, SourceError, VoxelType, Voxels};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use zarrs::array::{Array, ArrayBytes, ArrayShardedReadableExt, ArrayShardedReadableExtCache, CodecOptions};

/// Memory for decoded chunks.
const CACHE_BYTES: usize = 64 << 20;

/// A project's density, as its source stored it.
pub struct ZarrSource {
    name: String,
    grid: Grid,
    scaling: (f64, f64),
    opened: RwLock<Arc<OpenArray>>,
    voxel_type: VoxelType,
    /// Hashes of its files by place, as far as they are known, and which of them were looked at.
    hashes: HashMap<[u32; 3], String>,
    looked_at: Mutex<HashSet<[u32; 3]>>,
    /// Of a project that holds the voxels no more.
    instead: RwLock<Option<Arc<dyn BrickSource>>>,
    cache: Mutex<Cache>,
}

struct OpenArray {
    dir: PathBuf,
    layout: Layout,
    array: Array<Files>,
    shards: ArrayShardedReadableExtCache,
}

impl ZarrSource {
    /// Opens the density array of a generation.
    ///
    /// # Errors
    /// If a shard is missing: the array was written whole, so a missing one is damage and not emptiness.
    pub(crate) fn open(
        dir: &Path,
        name: String,
        grid: Grid,
        voxel_type: VoxelType,
        scaling: (f64, f64),
        place: &str,
        shards: &Shards,
    ) -> Result<Self, KeepError> {
        let layout = density_layout(place, voxel_type, grid.dims);
        for file in layout.files() {
            let name = layout.file_name(file);
            inside::check_file(dir, &name).map_err(KeepError::io("read", &dir.join(&name)))?;
        }
        let known = |file: [u32; 3]| Some((file, shards.get(&place_name(file))?.file()?.to_owned()));
        let hashes = layout.files().filter_map(known).collect();
        let opened = RwLock::new(Arc::new(OpenArray::new(dir, layout)?));
        let (instead, looked_at, cache) = (RwLock::default(), Mutex::default(), Mutex::default());
        Ok(Self { name, grid, scaling, opened, voxel_type, hashes, looked_at, instead, cache })
    }

    /// Reads from another generation's folder from now on, below `place` in it; its density is the same.
    pub(crate) fn move_to(&self, dir: &Path, place: &str) -> Result<(), KeepError> {
        let layout = density_layout(place, self.voxel_type, self.grid.dims);
        let opened = Arc::new(OpenArray::new(dir, layout)?);
        *self.opened.write().unwrap_or_else(PoisonError::into_inner) = opened;
        *self.instead.write().unwrap_or_else(PoisonError::into_inner) = None;
        Ok(())
    }

    /// Reads from another source from now on, which has the same voxels.
    pub(crate) fn read_from(&self, source: Arc<dyn BrickSource>) {
        *self.instead.write().unwrap_or_else(PoisonError::into_inner) = Some(source);
    }

    fn chunk(&self, index: [u32; 3]) -> Result<Arc<[u8]>, SourceError> {
        if let Some(chunk) = lock(&self.cache).get(index) {
            return Ok(chunk);
        }
        let opened = self.opened.read().unwrap_or_else(PoisonError::into_inner).clone();
        self.look_at(&opened, index)?;
        let [x, y, z] = index.map(u64::from);
        let bytes = opened
            .array
            .retrieve_subchunk_opt::<ArrayBytes<'static>>(&opened.shards, &[z, y, x], &CodecOptions::default())
            .map_err(|e| e.to_string())
            .and_then(|bytes| bytes.into_fixed().map_err(|e| e.to_string()));
        let expected = (BRICK as usize).pow(3) * self.voxel_type.bytes();
        let chunk: Arc<[u8]> = match bytes {
            Ok(bytes) if bytes.len() == expected => bytes.into_owned().into(),
            Ok(bytes) => return Err(self.damaged(&opened, index, &format!("{} decoded bytes", bytes.len()))),
            Err(reason) => return Err(self.damaged(&opened, index, &reason)),
        };
        lock(&self.cache).put(index, chunk.clone());
        Ok(chunk)
    }

    /// Whether the file of a chunk has the bytes that were written, once for each.
    fn look_at(&self, opened: &OpenArray, chunk: [u32; 3]) -> Result<(), SourceError> {
        let file = opened.layout.file_of(chunk);
        let Some(expected) = self.hashes.get(&file) else { return Ok(()) };
        let mut looked_at = lock(&self.looked_at);
        if looked_at.contains(&file) {
            return Ok(());
        }
        let name = opened.layout.file_name(file);
        let read = inside::read(&opened.dir, &name, opened.layout.most_bytes());
        let checked = read.and_then(|bytes| check_hash(&opened.dir.join(&name), &bytes, expected));
        checked.map_err(|e| SourceError::Unreadable { name: self.name.clone(), reason: e.to_string() })?;
        looked_at.insert(file);
        Ok(())
    }

    fn damaged(&self, opened: &OpenArray, chunk: [u32; 3], reason: &str) -> SourceError {
        let path = opened.dir.join(opened.layout.file_name(opened.layout.file_of(chunk)));
        let length = std::fs::metadata(&path).map_or(0, |m| m.len() as usize);
        let reason = damaged_chunk(&path, length, reason).to_string();
        SourceError::Unreadable { name: self.name.clone(), reason }
    }
}

impl OpenArray {
    fn new(dir: &Path, layout: Layout) -> Result<Self, KeepError> {
        let array = layout.open(dir)?;
        Ok(Self { dir: dir.to_owned(), layout, shards: ArrayShardedReadableExtCache::new(&array), array })
    }
}

/// The density array: the source's own type and numbers.
pub(crate) fn density_layout(place: &str, voxel_type: VoxelType, dims: [u32; 3]) -> Layout {
    Layout::field(&format!("{place}{DENSITY}"), voxel_type, 1, dims)
}

impl std::fmt::Debug for ZarrSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ZarrSource").field("name", &self.name).field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl BrickSource for ZarrSource {
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
        let dims = self.grid.dims;
        if (0..3).any(|a| lo[a].checked_add(size[a]).is_none_or(|hi| hi > dims[a])) {
            return Err(SourceError::OutOfBounds { lo, size, dims });
        }
        if let Some(source) = self.instead.read().unwrap_or_else(PoisonError::into_inner).clone() {
            return source.read(lo, size);
        }
        let count: usize = size.iter().map(|&s| s as usize).product();
        let bytes = self.voxel_type.bytes();
        let mut voxels = Voxels::try_zeroed(self.voxel_type, count)
            .map_err(|_| SourceError::OutOfMemory { bytes: (count * bytes) as u64 })?;
        if count == 0 {
            return Ok(voxels);
        }
        let first = lo.map(|v| v / BRICK);
        let last: [u32; 3] = std::array::from_fn(|a| (lo[a] + size[a] - 1) / BRICK);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let chunk = self.chunk([x, y, z])?;
                    copy_chunk(&chunk, [x, y, z], voxels.as_bytes_mut(), lo, size, bytes);
                }
            }
        }
        Ok(voxels)
    }
}

/// Copies what a chunk shares with the box.
fn copy_chunk(chunk: &[u8], index: [u32; 3], out: &mut [u8], lo: [u32; 3], size: [u32; 3], bytes: usize) {
    let origin = index.map(|i| i * BRICK);
    let from: [u32; 3] = std::array::from_fn(|a| lo[a].max(origin[a]));
    let to: [u32; 3] = std::array::from_fn(|a| (lo[a] + size[a]).min(origin[a] + BRICK));
    let row = (to[0] - from[0]) as usize * bytes;
    let at = |v: [u32; 3], origin: [u32; 3], dims: [u32; 3]| {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| (v[a] - origin[a]) as usize);
        (x + dims[0] as usize * (y + dims[1] as usize * z)) * bytes
    };
    for z in from[2]..to[2] {
        for y in from[1]..to[1] {
            let a = at([from[0], y, z], origin, [BRICK; 3]);
            let b = at([from[0], y, z], lo, size);
            out[b..b + row].copy_from_slice(&chunk[a..a + row]);
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The chunks used last.
#[derive(Default)]
struct Cache {
    chunks: HashMap<[u32; 3], (Arc<[u8]>, u64)>,
    bytes: usize,
    clock: u64,
}

impl Cache {
    fn get(&mut self, index: [u32; 3]) -> Option<Arc<[u8]>> {
        self.clock += 1;
        let (chunk, used) = self.chunks.get_mut(&index)?;
        *used = self.clock;
        Some(chunk.clone())
    }

    fn put(&mut self, index: [u32; 3], chunk: Arc<[u8]>) {
        self.clock += 1;
        self.bytes += chunk.len();
        if let Some((old, _)) = self.chunks.insert(index, (chunk, self.clock)) {
            self.bytes -= old.len();
        }
        while self.bytes > CACHE_BYTES {
            let Some(oldest) = self.chunks.iter().min_by_key(|(_, (_, used))| *used).map(|(&i, _)| i) else { return };
            if let Some((old, _)) = self.chunks.remove(&oldest) {
                self.bytes -= old.len();
            }
        }
    }
}
