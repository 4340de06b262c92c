//! Where rays can skip: for every cell of 4³ voxels the distance to the next cell that may show something.
//!
//! Owns a map for each [`Matter`] that is asked for, all of them boxes of one 3D texture of 8-bit distances in cells, by the
//! largest coordinate difference, capped. Built from the fields' cell minima and maxima at the level that each brick is drawn
//! from, so that no sample that shows is ever skipped. Maps that nothing asks for any more wait a while, for pictures take
//! turns. Knows no camera.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::dirty_bricks::DirtyBricks;
use crate::gpu::fields::matter::Matter;
use crate::gpu::fields::pool::extent;
use crate::gpu::fields::slot_key::{brick_of, count_of};
use crate::volume::{BRICK, CELL, FieldKey, VolumeId};
use rayon::prelude::*;

/// Largest distance kept, in cells: an edit renews the map this far around it.
pub(crate) const CAP: u32 = 15;
/// Maps of a volume that wait although nothing asked for them lately.
const IDLE: usize = 3;

#[derive(Debug)]
struct SkipMap {
    matter: Matter,
    /// Voxels along an edge of a cell.
    cell: u32,
    cells: [u32; 3],
    bricks: [u32; 3],
    occupied: Vec<u8>,
    /// Its first cell in the texture.
    place: [u32; 3],
    /// Bricks whose cells are to be renewed.
    dirty: DirtyBricks,
    /// When it was last asked for.
    used: u64,
}

/// The maps that are made, each a box of one 3D texture of distances in cells (0 to [`CAP`]), and when each was last asked for.
#[derive(Debug)]
pub(crate) struct SkipMaps {
    maps: Vec<SkipMap>,
    clock: u64,
    pub(crate) texture: wgpu::Texture,
    /// Whether the texture was replaced since the bind group was made.
    pub(crate) replaced: bool,
}

/// Voxels along an edge of a cell: 4, or more where a map would pass so many cells along an axis.
pub(crate) fn cell_of(dims: [u32; 3], most: u32) -> u32 {
    let mut cell = CELL;
    while cell < BRICK && dims.iter().any(|d| d.div_ceil(cell) > most) {
        cell *= 2;
    }
    cell
}

/// Where boxes of these sizes lie in one, and its size: on end along z as far as that goes, in columns beside each other.
fn arrange(sizes: &[[u32; 3]], most: u32) -> (Vec<[u32; 3]>, [u32; 3]) {
    let mut at = [0_u32; 3];
    // How far the column, the row of columns, and all of them reach.
    let (mut wide, mut high, mut all) = (0, 0, [1; 3]);
    let mut places = Vec::with_capacity(sizes.len());
    for size in sizes {
        if at[2] + size[2] > most {
            at = [at[0] + wide, at[1], 0];
            wide = 0;
        }
        if at[0] + size[0] > most {
            at = [0, at[1] + high, 0];
            (wide, high) = (0, 0);
        }
        places.push(at);
        (wide, high) = (wide.max(size[0]), high.max(size[1]));
        all = std::array::from_fn(|a| all[a].max(at[a] + size[a]));
        at[2] += size[2];
    }
    (places, all)
}

impl SkipMaps {
    /// No maps.
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let texture = gpu.scoped("the maps of empty space", || Ok(texture(gpu, [1; 3])))?;
        Ok(Self { maps: Vec::new(), clock: 0, texture, replaced: true })
    }

    /// Bricks of a field have other cells: the maps that hang on it follow.
    pub(crate) fn dirty(&mut self, key: FieldKey, bricks: impl IntoIterator<Item = usize> + Clone) {
        for map in self.maps.iter_mut().filter(|map| map.matter.hangs_on(key)) {
            map.dirty.extend(bricks.clone());
        }
    }

    /// All cells of a volume are others.
    pub(crate) fn dirty_all(&mut self, volume: VolumeId) {
        for map in self.maps.iter_mut().filter(|map| map.matter.volume == volume) {
            map.dirty = DirtyBricks::all();
        }
    }

    /// A volume is gone.
    pub(crate) fn forget(&mut self, volume: VolumeId) {
        self.maps.retain(|map| map.matter.volume != volume);
    }

    /// Has a map for each matter; `shape` are the voxels and bricks of each one's volume. Answers the maps' numbers. What of a
    /// map is dirty is still to be [renewed](Self::renew).
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub(crate) fn have(
        &mut self,
        gpu: &Gpu,
        wanted: &[Matter],
        shape: &dyn Fn(VolumeId) -> ([u32; 3], [u32; 3]),
    ) -> Result<Vec<usize>, GpuError> {
        self.clock += 1;
        let most = gpu.device.limits().max_texture_dimension_3d;
        let mut numbers = Vec::with_capacity(wanted.len());
        for matter in wanted {
            if let Some(map) = self.maps.iter_mut().find(|map| map.matter == *matter) {
                map.used = self.clock;
            }
        }
        let mut grown = false;
        for matter in wanted {
            if let Some(i) = self.maps.iter().position(|map| map.matter == *matter) {
                numbers.push(i);
                continue;
            }
            let idle = |(i, map): (usize, &SkipMap)| {
                (map.matter.volume == matter.volume && map.used != self.clock).then_some((map.used, i))
            };
            let idle: Vec<_> = self.maps.iter().enumerate().filter_map(idle).collect();
            let old = idle.iter().min().filter(|_| idle.len() >= IDLE).map(|&(_, i)| i);
            let at = match old {
                Some(at) => at,
                None => {
                    let (dims, bricks) = shape(matter.volume);
                    let cell = cell_of(dims, most);
                    let cells = dims.map(|d| d.div_ceil(cell));
                    let (matter, occupied) = (matter.clone(), vec![0; count_of(cells)]);
                    let (dirty, place) = (DirtyBricks::all(), [0; 3]);
                    self.maps.push(SkipMap { matter, cell, cells, bricks, occupied, place, dirty, used: 0 });
                    grown = true;
                    self.maps.len() - 1
                }
            };
            let map = &mut self.maps[at];
            (map.matter, map.dirty, map.used) = (matter.clone(), DirtyBricks::all(), self.clock);
            numbers.push(at);
        }
        if grown {
            self.lay_out(gpu, most)?;
        }
        Ok(numbers)
    }

    /// Lays the maps out anew, with what the texture has of them.
    fn lay_out(&mut self, gpu: &Gpu, most: u32) -> Result<(), GpuError> {
        let sizes: Vec<_> = self.maps.iter().map(|map| map.cells).collect();
        let (places, size) = arrange(&sizes, most);
        let old = self.texture.clone();
        self.texture = gpu.scoped("the maps of empty space", || {
            let new = texture(gpu, size);
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("maps of empty space") });
            for (map, place) in self.maps.iter().zip(&places).filter(|(map, _)| map.dirty.is_some()) {
                let of = |texture, [x, y, z]: [u32; 3]| wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x, y, z },
                    aspect: wgpu::TextureAspect::All,
                };
                encoder.copy_texture_to_texture(of(&old, map.place), of(&new, *place), extent(map.cells));
            }
            gpu.queue.submit([encoder.finish()]);
            Ok(new)
        })?;
        for (map, place) in self.maps.iter_mut().zip(places) {
            map.place = place;
        }
        self.replaced = true;
        Ok(())
    }

    /// The first cell of a map in the texture.
    pub(crate) fn place(&self, map: usize) -> [u32; 3] {
        self.maps[map].place
    }

    /// Renews the dirty cells of a map and the distances around them. `of` answers for a brick of level 0, by its cells of 4³ in
    /// order, whether each may show something. Answers whether anything was dirty.
    ///
    /// # Errors
    /// As [`have`](Self::have).
    pub(crate) fn renew(
        &mut self,
        gpu: &Gpu,
        map: usize,
        of: &(dyn Fn(usize) -> [bool; 512] + Sync),
    ) -> Result<bool, GpuError> {
        let Some(map) = self.maps.get_mut(map) else { return Ok(false) };
        let count = count_of(map.bricks);
        let dirty = map.dirty.take(count);
        if dirty.is_empty() {
            return Ok(false);
        }
        let fresh: Vec<[bool; 512]> = dirty.par_iter().map(|&b| of(b)).collect();
        let per = BRICK / map.cell;
        let shrink = map.cell / CELL;
        let mut changed: Option<[[u32; 3]; 2]> = None;
        for (&brick, bits) in dirty.iter().zip(&fresh) {
            let first = brick_of(map.bricks, brick).0.map(|b| b * per);
            let last: [u32; 3] = std::array::from_fn(|a| (first[a] + per).min(map.cells[a]));
            for z in first[2]..last[2] {
                for y in first[1]..last[1] {
                    for x in first[0]..last[0] {
                        let now = u8::from(merged(bits, [x - first[0], y - first[1], z - first[2]], shrink));
                        let at = index([x, y, z], map.cells);
                        if map.occupied[at] != now {
                            map.occupied[at] = now;
                            let [lo, hi] = changed.get_or_insert([[x, y, z], [x, y, z]]);
                            for (a, v) in [x, y, z].into_iter().enumerate() {
                                lo[a] = lo[a].min(v);
                                hi[a] = hi[a].max(v);
                            }
                        }
                    }
                }
            }
        }
        let touched = if dirty.len() == count { Some([[0; 3], map.cells.map(|n| n - 1)]) } else { changed };
        let Some([lo, hi]) = touched else { return Ok(true) };
        let lo = lo.map(|v| v.saturating_sub(CAP));
        let hi: [u32; 3] = std::array::from_fn(|a| (hi[a] + 1 + CAP).min(map.cells[a]));
        let size: [u32; 3] = std::array::from_fn(|a| hi[a] - lo[a]);
        let distances = distances(&map.occupied, map.cells, lo, size);
        let [x, y, z] = std::array::from_fn(|a| map.place[a] + lo[a]);
        gpu.scoped("the maps of empty space", || {
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z }, ..self.texture.as_image_copy() },
                &distances,
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(size[0]), rows_per_image: Some(size[1]) },
                extent(size),
            );
            Ok(())
        })?;
        Ok(true)
    }
}

fn texture(gpu: &Gpu, size: [u32; 3]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("maps of empty space"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::R8Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Any of the 4³ cells that a larger cell of `shrink` of them along each axis covers.
fn merged(bits: &[bool; 512], at: [u32; 3], shrink: u32) -> bool {
    let n = BRICK / CELL;
    let mut any = false;
    for z in at[2] * shrink..(at[2] + 1) * shrink {
        for y in at[1] * shrink..(at[1] + 1) * shrink {
            for x in at[0] * shrink..(at[0] + 1) * shrink {
                any |= bits[(x + n * (y + n * z)) as usize];
            }
        }
    }
    any
}

fn index(at: [u32; 3], dims: [u32; 3]) -> usize {
    at[0] as usize + dims[0] as usize * (at[1] as usize + dims[1] as usize * at[2] as usize)
}

/// Distances in a box of cells to the next occupied one, at most [`CAP`]: one axis after another, since the largest of three
/// differences is least where each axis' is.
pub fn distances(occupied: &[u8], cells: [u32; 3], lo: [u32; 3], size: [u32; 3]) -> Vec<u8> {
    let from = lo.map(|v| v.saturating_sub(CAP));
    let wide: [u32; 3] = std::array::from_fn(|a| (lo[a] + size[a] + CAP).min(cells[a]) - from[a]);
    let [wx, wy, wz] = wide.map(|n| n as usize);
    let [sx, sy, sz] = size.map(|n| n as usize);
    let skip: [usize; 3] = std::array::from_fn(|a| (lo[a] - from[a]) as usize);
    let mut along_x = vec![CAP as u8; sx * wy * wz];
    along_x.par_chunks_exact_mut(sx * wy).enumerate().for_each(|(z, slab)| {
        let mut row = vec![0; wx];
        for (y, out) in slab.chunks_exact_mut(sx).enumerate() {
            let at = index([from[0], from[1] + y as u32, from[2] + z as u32], cells);
            let mut last = CAP as u8;
            for (d, &o) in row.iter_mut().zip(&occupied[at..at + wx]) {
                last = if o != 0 { 0 } else { (last + 1).min(CAP as u8) };
                *d = last;
            }
            last = CAP as u8;
            for (d, &o) in row.iter_mut().zip(&occupied[at..at + wx]).rev() {
                last = if o != 0 { 0 } else { (last + 1).min(CAP as u8) };
                *d = last.min(*d);
            }
            out.copy_from_slice(&row[skip[0]..skip[0] + sx]);
        }
    });
    let mut along_y = vec![CAP as u8; sx * sy * wz];
    along_y.par_chunks_exact_mut(sx * sy).enumerate().for_each(|(z, slab)| {
        let source = &along_x[z * sx * wy..(z + 1) * sx * wy];
        nearest_rows(source, slab, sx, wy, skip[1]);
    });
    let mut out = vec![CAP as u8; sx * sy * sz];
    // The same along z, a row being a whole slab.
    nearest_rows(&along_y, &mut out, sx * sy, wz, skip[2]);
    out
}

/// `out[row] = min over r of max(|row − r|, source[r])`, rows of `width` values, the first row of `out` being row `skip`.
fn nearest_rows(source: &[u8], out: &mut [u8], width: usize, rows: usize, skip: usize) {
    out.par_chunks_exact_mut(width).enumerate().for_each(|(i, out)| {
        let row = i + skip;
        let first = row.saturating_sub(CAP as usize);
        for r in first..(row + CAP as usize + 1).min(rows) {
            let away = row.abs_diff(r) as u8;
            for (o, &d) in out.iter_mut().zip(&source[r * width..(r + 1) * width]) {
                *o = (*o).min(d.max(away));
            }
        }
    });
}
