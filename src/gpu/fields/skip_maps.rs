//! Where rays can skip: for every cell of 4³ voxels the distance to the next cell that may show something.
//!
//! Owns three maps (all matter; what the selection shows; what it leaves) as 3D textures of 8-bit distances in cells, by the
//! largest coordinate difference, capped. Built from the fields' cell minima and maxima at the level that each brick is drawn
//! from, so that no sample that shows is ever skipped. Knows no camera.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::extent;
use crate::volume::{BRICK, CELL, Mode, TABLE_ENTRIES, TransferFunction};
use rayon::prelude::*;

/// Largest distance kept, in cells: an edit renews the map this far around it.
pub(crate) const CAP: u32 = 15;

/// The values that show nothing under a look.
#[derive(Clone, Debug, PartialEq)]
pub struct Shows {
    clear: Vec<(f64, f64)>,
}

impl Shows {
    /// Under a transfer function and mode. Iso: below the surface's value. What lies above it shows where a cut opens it.
    /// MIP: up to the first value with opacity. Values within half an entry of the caster's table count as showing.
    pub fn of(transfer: &TransferFunction, mode: Mode) -> Self {
        let points = &transfer.opacity;
        let (lo, hi) = transfer.domain();
        let guard = (hi - lo) / (TABLE_ENTRIES - 1) as f64 * 0.51;
        let mut clear: Vec<(f64, f64)> = Vec::new();
        if let Mode::Iso(value) = mode {
            // What is less by no more than the GPU's rounding may pass for the value.
            return Self { clear: vec![(f64::NEG_INFINITY, value - value.abs() * 4e-7)] };
        }
        let mut start = None;
        for (i, &(value, opacity)) in points.iter().enumerate() {
            if opacity > 0.0 {
                if let Some(from) = start.take() {
                    // Opacity rises from the point before on.
                    clear.push((from, points[i - 1].0 - guard));
                }
            } else if start.is_none() {
                start = Some(if i == 0 { f64::NEG_INFINITY } else { value + guard });
            }
        }
        if let Some(from) = start {
            clear.push((from, f64::INFINITY));
        }
        if mode == Mode::Mip {
            clear.retain(|c| c.0 == f64::NEG_INFINITY);
        }
        Self { clear }
    }

    /// Whether anything in `[min, max]` may show; an empty interval holds no value.
    pub fn any(&self, min: f32, max: f32) -> bool {
        let (min, max) = (f64::from(min), f64::from(max));
        min <= max && !self.clear.iter().any(|&(from, to)| from <= min && max <= to)
    }
}

/// The three maps, in the order of their bindings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Map {
    Matter,
    Selection,
    Background,
}

impl Map {
    pub(crate) const ALL: [Self; 3] = [Self::Matter, Self::Selection, Self::Background];
}

/// See the module's head.
#[derive(Debug)]
pub(crate) struct Skips {
    /// Voxels along an edge of a cell: 4, or more where the map would pass 2048 cells along an axis.
    pub(crate) cell: u32,
    cells: [u32; 3],
    bricks: [u32; 3],
    occupied: [Vec<u8>; 3],
    pub(crate) textures: [wgpu::Texture; 3],
}

impl Skips {
    /// Maps over a volume of `dims` voxels in `bricks`. Empty until [`update`](Self::update) was called for all bricks.
    pub(crate) fn new(gpu: &Gpu, dims: [u32; 3], bricks: [u32; 3]) -> Result<Self, GpuError> {
        let most = gpu.device.limits().max_texture_dimension_3d;
        let mut cell = CELL;
        while cell < BRICK && dims.iter().any(|d| d.div_ceil(cell) > most) {
            cell *= 2;
        }
        let cells = dims.map(|d| d.div_ceil(cell));
        let count = cells.iter().map(|&n| n as usize).product();
        let textures = gpu.scoped("the maps of empty space", || {
            Ok(Map::ALL.map(|map| {
                gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(&format!("skips: {map:?}")),
                    size: extent(cells),
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D3,
                    format: wgpu::TextureFormat::R8Uint,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                })
            }))
        })?;
        Ok(Self { cell, cells, bricks, occupied: std::array::from_fn(|_| vec![0; count]), textures })
    }

    /// Renews the cells of some bricks of level 0 and the distances around them. `of` answers for a brick, by its cells of 4³
    /// in order, one bit per [`Map`] for whether it may show something.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        bricks: &[usize],
        of: &(dyn Fn([u32; 3]) -> [u8; 512] + Sync),
    ) -> Result<(), GpuError> {
        let [nx, ny, _] = self.bricks.map(|b| b as usize);
        let places: Vec<[u32; 3]> =
            bricks.iter().map(|&i| [i % nx, i / nx % ny, i / (nx * ny)].map(|v| v as u32)).collect();
        let fresh: Vec<[u8; 512]> = places.par_iter().map(|&b| of(b)).collect();
        let per = BRICK / self.cell;
        let shrink = self.cell / CELL;
        let mut changed: [Option<[[u32; 3]; 2]>; 3] = [None; 3];
        for (brick, bits) in places.iter().zip(&fresh) {
            let first = brick.map(|b| b * per);
            let last: [u32; 3] = std::array::from_fn(|a| (first[a] + per).min(self.cells[a]));
            for z in first[2]..last[2] {
                for y in first[1]..last[1] {
                    for x in first[0]..last[0] {
                        let bits = merged(bits, [x - first[0], y - first[1], z - first[2]], shrink);
                        let at = index([x, y, z], self.cells);
                        for (map, changed) in changed.iter_mut().enumerate() {
                            let now = bits >> map & 1;
                            if self.occupied[map][at] != now {
                                self.occupied[map][at] = now;
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
        }
        let all = bricks.len() == self.bricks.iter().map(|&b| b as usize).product::<usize>();
        for (map, changed) in changed.into_iter().enumerate() {
            let touched = if all { Some([[0; 3], self.cells.map(|n| n - 1)]) } else { changed };
            let Some([lo, hi]) = touched else { continue };
            let lo = lo.map(|v| v.saturating_sub(CAP));
            let hi: [u32; 3] = std::array::from_fn(|a| (hi[a] + 1 + CAP).min(self.cells[a]));
            let size: [u32; 3] = std::array::from_fn(|a| hi[a] - lo[a]);
            let distances = distances(&self.occupied[map], self.cells, lo, size);
            gpu.scoped("the maps of empty space", || {
                gpu.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        origin: wgpu::Origin3d { x: lo[0], y: lo[1], z: lo[2] },
                        ..self.textures[map].as_image_copy()
                    },
                    &distances,
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(size[0]),
                        rows_per_image: Some(size[1]),
                    },
                    extent(size),
                );
                Ok(())
            })?;
        }
        Ok(())
    }
}

/// Any of the 4³ cells that a larger cell of `shrink` of them along each axis covers.
fn merged(bits: &[u8; 512], at: [u32; 3], shrink: u32) -> u8 {
    let n = BRICK / CELL;
    let mut any = 0;
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
