//! One field on the GPU: a 3D texture of 34³ slots and the page table that says where each brick of level 0 is drawn from.
//!
//! Owns the texture, the map from bricks to slots, and the host's copy of the page table. Does not decide which bricks to
//! hold (that is `residency`) and knows no camera.

use super::{Gpu, GpuError};
use crate::volume::{BrickKey, Field, FieldKind, SLOT, SLOT_VOXELS, TexelFormat};
use std::collections::{HashMap, HashSet};

mod upload;

/// Slots along an axis: a slot's place is a byte of a page, and textures end at 2048 texels on many adapters.
const MOST_ALONG: u32 = 60;
/// Larger textures fail on common drivers.
const MOST_BYTES: u64 = (2 << 30) - 1;

/// A page: what a shader reads for a brick of level 0. See `page_of` in shaders/lib/field.wgsl.
pub(super) type Page = [u32; 2];

/// A page of one value; `bits` is the texel as the shader decodes it.
pub(super) fn uniform_page(level: u8, bits: u32) -> Page {
    [u32::from(level) << 1, bits]
}

fn held_page(level: u8, slot: [u32; 3]) -> Page {
    [1 | u32::from(level) << 1 | slot[0] << 8 | slot[1] << 16 | slot[2] << 24, 0]
}

#[derive(Clone, Copy, Debug)]
struct Held {
    slot: [u32; 3],
    used: u64,
    pinned: bool,
}

#[derive(Debug)]
pub(super) struct Pool {
    kind: FieldKind,
    host: TexelFormat,
    format: TexelFormat,
    pub(super) texture: wgpu::Texture,
    grid: [u32; 3],
    limit: [u32; 3],
    held: HashMap<BrickKey, Held>,
    free: Vec<[u32; 3]>,
    clock: u64,
    bricks: [u32; 3],
    /// Whether anything was ever written to the texture.
    written: bool,
    pages: Vec<Page>,
    /// The coarsest level that any page draws from.
    coarsest: u8,
    pub(super) page_texture: wgpu::Texture,
    /// Whether a texture was replaced since the bind group was made.
    pub(super) replaced: bool,
}

fn wgpu_format(format: TexelFormat) -> wgpu::TextureFormat {
    match format {
        TexelFormat::R16Unorm => wgpu::TextureFormat::R16Unorm,
        TexelFormat::R32Float => wgpu::TextureFormat::R32Float,
        TexelFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        TexelFormat::R8Unorm => wgpu::TextureFormat::R8Unorm,
        TexelFormat::R16Uint => wgpu::TextureFormat::R16Uint,
    }
}

/// The page table starts as this, so that the first write covers all of it.
const UNWRITTEN: Page = [u32::MAX; 2];

impl Pool {
    /// An empty pool of at most `budget_bytes`; its texture is one slot until something is held.
    pub(super) fn new(
        gpu: &Gpu,
        kind: FieldKind,
        host: TexelFormat,
        bricks: [u32; 3],
        budget_bytes: u64,
    ) -> Result<Self, GpuError> {
        let format = match host {
            TexelFormat::R16Unorm if !gpu.has_unorm16() => TexelFormat::R32Float,
            other => other,
        };
        let slot_bytes = (SLOT_VOXELS * format.bytes()) as u64;
        let along = (gpu.device.limits().max_texture_dimension_3d / SLOT).min(MOST_ALONG);
        let limit = largest_grid((budget_bytes.min(MOST_BYTES) / slot_bytes).max(1), along);
        let (texture, page_texture) = gpu.scoped(&format!("the {} pool", kind.name()), || {
            let pages = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(&format!("{} pages", kind.name())),
                size: extent(bricks),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format: wgpu::TextureFormat::Rg32Uint,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            Ok((slots_texture(gpu, kind, format, [1; 3]), pages))
        })?;
        let count = bricks.iter().map(|&b| b as usize).product();
        Ok(Self {
            kind,
            host,
            format,
            texture,
            grid: [1; 3],
            limit,
            held: HashMap::new(),
            free: vec![[0; 3]],
            clock: 0,
            bricks,
            written: false,
            pages: vec![UNWRITTEN; count],
            coarsest: 0,
            page_texture,
            replaced: true,
        })
    }

    /// Format of the texels on the GPU.
    pub(super) fn format(&self) -> TexelFormat {
        self.format
    }

    /// How many slots the budget allows.
    pub(super) fn most(&self) -> usize {
        self.limit.iter().map(|&n| n as usize).product()
    }

    /// How many bricks are held.
    pub(super) fn held_count(&self) -> usize {
        self.held.len()
    }

    /// 1 / texels along each axis.
    pub(super) fn texel(&self) -> [f32; 3] {
        self.grid.map(|n| 1.0 / (n * SLOT) as f32)
    }

    /// The page that draws from a held brick.
    pub(super) fn page(&self, key: BrickKey) -> Option<Page> {
        self.held.get(&key).map(|h| held_page(key.level, h.slot))
    }

    /// The page of a pinned brick.
    pub(super) fn pinned_page(&self, key: BrickKey) -> Option<Page> {
        self.held.get(&key).filter(|h| h.pinned).map(|h| held_page(key.level, h.slot))
    }

    /// First texel, apron included, of a held brick's slot.
    pub(super) fn texel_origin(&self, key: BrickKey) -> Option<[u32; 3]> {
        self.held.get(&key).map(|h| h.slot.map(|s| s * SLOT))
    }

    /// The bits of a page of one value, from a texel of the host.
    pub(super) fn bits(&self, texel: [u8; 4]) -> u32 {
        match (self.host, self.format) {
            (TexelFormat::R16Unorm, TexelFormat::R32Float) => {
                (f32::from(u16::from_le_bytes([texel[0], texel[1]])) / 65_535.0).to_bits()
            }
            _ => u32::from_le_bytes(texel),
        }
    }

    /// Gives every wanted brick a slot with its texels; bricks not wanted and not pinned make room, the longest unused
    /// first. `wanted` has at most as many bricks as [`most`](Self::most) less the pinned ones. Answers whether anything
    /// was uploaded.
    pub(super) fn hold(&mut self, gpu: &Gpu, field: &Field, wanted: &[BrickKey], pin: bool) -> Result<bool, GpuError> {
        self.clock += 1;
        let mut missing = Vec::new();
        for key in wanted {
            match self.held.get_mut(key) {
                Some(held) => {
                    held.used = self.clock;
                    held.pinned |= pin;
                }
                None => missing.push(*key),
            }
        }
        if missing.is_empty() {
            return Ok(false);
        }
        self.make_room(gpu, missing.len())?;
        let mut uploads = Vec::with_capacity(missing.len());
        for key in missing {
            let Some(slot) = self.free.pop() else {
                return Err(GpuError::PoolFull { field: self.kind.name(), asked: wanted.len(), room: self.most() });
            };
            uploads.push((key, slot));
        }
        self.upload(gpu, field, &uploads)?;
        for (key, slot) in uploads {
            self.held.insert(key, Held { slot, used: self.clock, pinned: pin });
        }
        Ok(true)
    }

    /// Frees slots until `count` are free or nothing more can go.
    fn make_room(&mut self, gpu: &Gpu, count: usize) -> Result<(), GpuError> {
        let total = self.held.len() + self.free.len();
        if self.free.len() < count && total < self.most() {
            let in_use = self.held.values().filter(|h| h.pinned || h.used == self.clock).count();
            let need = in_use + count;
            if need > total {
                // Half as much again, so that painting does not grow the pool stroke by stroke.
                self.grow(gpu, (need + need / 2).min(self.most()))?;
            }
        }
        if self.free.len() < count {
            let mut idle: Vec<_> = self
                .held
                .iter()
                .filter(|(_, h)| !h.pinned && h.used != self.clock)
                .map(|(k, h)| (h.used, *k))
                .collect();
            idle.sort_unstable();
            for (_, key) in idle.into_iter().take(count - self.free.len()) {
                if let Some(held) = self.held.remove(&key) {
                    self.free.push(held.slot);
                }
            }
        }
        Ok(())
    }

    /// A larger texture with the same slots at the same places. Where memory is short, as much as there is: the budget is then
    /// what was reached.
    fn grow(&mut self, gpu: &Gpu, slots: usize) -> Result<(), GpuError> {
        let mut slots = slots;
        loop {
            let grid = grow_grid(self.grid, slots, self.limit);
            if grid == self.grid {
                return Ok(());
            }
            match self.grow_to(gpu, grid) {
                Err(GpuError::OutOfMemory { .. }) => {
                    let now: usize = self.grid.iter().map(|&n| n as usize).product();
                    slots = now + (slots - now) / 2;
                    self.limit = grow_grid(self.grid, slots, self.limit);
                }
                other => return other,
            }
        }
    }

    fn grow_to(&mut self, gpu: &Gpu, grid: [u32; 3]) -> Result<(), GpuError> {
        let (kind, format, old, written) = (self.kind, self.format, &self.texture, self.written);
        let size = old.size();
        self.texture = gpu.scoped(&format!("a {} pool of {grid:?} slots", kind.name()), || {
            let texture = slots_texture(gpu, kind, format, grid);
            if written {
                let mut encoder =
                    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("grow pool") });
                encoder.copy_texture_to_texture(old.as_image_copy(), texture.as_image_copy(), size);
                gpu.queue.submit([encoder.finish()]);
            }
            Ok(texture)
        })?;
        let old = self.grid;
        self.free.extend(places(grid).filter(|s| (0..3).any(|a| s[a] >= old[a])));
        // Taken from the end, so that neighbours along x fill up first.
        self.free.sort_unstable_by_key(|s| std::cmp::Reverse([s[2], s[1], s[0]]));
        self.grid = grid;
        self.replaced = true;
        Ok(())
    }

    /// Lets pinned bricks go; they stay until their slot is needed.
    pub(super) fn unpin(&mut self) {
        self.held.values_mut().for_each(|h| h.pinned = false);
    }

    /// The pinned bricks.
    pub(super) fn pinned(&self) -> HashSet<BrickKey> {
        self.held.iter().filter(|(_, h)| h.pinned).map(|(k, _)| *k).collect()
    }

    /// Replaces the page table by `pages`, writing what changed. Answers the indices that changed.
    pub(super) fn set_pages(&mut self, gpu: &Gpu, pages: Vec<Page>) -> Result<Vec<usize>, GpuError> {
        let changed: Vec<usize> = (0..pages.len()).filter(|&i| pages[i] != self.pages[i]).collect();
        self.pages = pages;
        if changed.is_empty() {
            return Ok(changed);
        }
        self.coarsest = (0..self.pages.len()).map(|i| self.level_of(i)).max().unwrap_or(0);
        let [nx, ny, _] = self.bricks.map(|b| b as usize);
        gpu.scoped(&format!("pages of {}", self.kind.name()), || {
            // A handful of bricks is written brick by brick, more by the whole table.
            if changed.len() <= 64 && changed.len() * 4 < self.pages.len() {
                for &i in &changed {
                    self.write_pages(gpu, [i % nx, i / nx % ny, i / (nx * ny)], [1; 3], &self.pages[i..=i]);
                }
            } else {
                self.write_pages(gpu, [0; 3], self.bricks, &self.pages);
            }
            Ok(())
        })?;
        Ok(changed)
    }

    fn write_pages(&self, gpu: &Gpu, at: [usize; 3], size: [u32; 3], pages: &[Page]) {
        let [x, y, z] = at.map(|v| v as u32);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z }, ..self.page_texture.as_image_copy() },
            bytemuck::cast_slice(pages),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * size[0]), rows_per_image: Some(size[1]) },
            extent(size),
        );
    }

    /// The coarsest level that any brick of level 0 is drawn from.
    pub(super) fn coarsest(&self) -> u8 {
        self.coarsest
    }

    /// The level that each brick of level 0 is drawn from.
    pub(super) fn level_of(&self, brick: usize) -> u8 {
        let [entry, _] = self.pages[brick];
        if entry == u32::MAX { 0 } else { (entry >> 1 & 31) as u8 }
    }
}

pub(super) fn extent([width, height, depth]: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: depth }
}

fn places([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The grid of the most slots that are at most `slots`, of those the nearest to a cube.
fn largest_grid(slots: u64, along: u32) -> [u32; 3] {
    let mut best = (0, 0, [1; 3]);
    for a in 1..=along {
        for b in a..=along {
            let c = (slots / (u64::from(a) * u64::from(b))).min(u64::from(along)) as u32;
            if c >= b {
                best = best.max((a * b * c, u32::MAX - (c - a), [a, b, c]));
            }
        }
    }
    // Fewer slots than any such box: a row.
    if best.0 == 0 { [1, 1, slots.clamp(1, u64::from(along)) as u32] } else { best.2 }
}

/// A grid of at least `slots` places, if `limit` has as many, that contains `old`; the shortest axis grows first.
fn grow_grid(old: [u32; 3], slots: usize, limit: [u32; 3]) -> [u32; 3] {
    let mut grid = old;
    while grid.iter().map(|&n| n as usize).product::<usize>() < slots {
        let Some(axis) = (0..3).filter(|&a| grid[a] < limit[a]).min_by_key(|&a| grid[a]) else { break };
        grid[axis] += 1;
    }
    grid
}

fn slots_texture(gpu: &Gpu, kind: FieldKind, format: TexelFormat, grid: [u32; 3]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&format!("{} pool", kind.name())),
        size: extent(grid.map(|n| n * SLOT)),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu_format(format),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
