//! A pool's page table: for each brick of level 0 a slot, or one value.
//!
//! Owns what a page means (`page_of` in shaders/lib/field.wgsl reads it) and writes pages that change.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::{Pool, extent};
use crate::volume::{BrickKey, TexelFormat};

/// A page: what a shader reads for a brick of level 0. See `page_of` in shaders/lib/field.wgsl.
pub(crate) type Page = [u32; 2];

/// A page of one value; `bits` is the texel as the shader decodes it.
pub(crate) fn uniform_page(level: u8, bits: u32) -> Page {
    [u32::from(level) << 1, bits]
}

fn held_page(level: u8, slot: [u32; 3]) -> Page {
    [1 | u32::from(level) << 1 | slot[0] << 8 | slot[1] << 16 | slot[2] << 24, 0]
}

/// The page table starts as this, so that the first write covers all of it.
pub(crate) const UNWRITTEN: Page = [u32::MAX; 2];

impl Pool {
    /// The page that draws from a held brick.
    pub(crate) fn page(&self, key: BrickKey) -> Option<Page> {
        self.held.get(&key).map(|h| held_page(key.level, h.slot))
    }

    /// The page of a pinned brick.
    pub(crate) fn pinned_page(&self, key: BrickKey) -> Option<Page> {
        self.held.get(&key).filter(|h| h.pinned).map(|h| held_page(key.level, h.slot))
    }

    /// The bits of a page of one value, from a texel of the host.
    pub(crate) fn bits(&self, texel: [u8; 4]) -> u32 {
        match (self.host, self.format) {
            (TexelFormat::R16Unorm, TexelFormat::R32Float) => {
                (f32::from(u16::from_le_bytes([texel[0], texel[1]])) / 65_535.0).to_bits()
            }
            _ => u32::from_le_bytes(texel),
        }
    }

    /// Sets pages of bricks of level 0, writing what changed. Answers those that changed, in order.
    pub(crate) fn set_pages(&mut self, gpu: &Gpu, pages: &[(usize, Page)]) -> Result<Vec<usize>, GpuError> {
        let [nx, ny, _] = self.bricks.map(|b| b as usize);
        let at = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
        let mut changed = Vec::new();
        let (mut lo, mut end) = ([usize::MAX; 3], [0; 3]);
        for &(i, page) in pages {
            if self.pages[i] == page {
                continue;
            }
            if self.pages[i] != UNWRITTEN {
                self.levels[level_of(self.pages[i])] -= 1;
            }
            self.levels[level_of(page)] += 1;
            self.pages[i] = page;
            changed.push(i);
            for (a, v) in at(i).into_iter().enumerate() {
                lo[a] = lo[a].min(v);
                end[a] = end[a].max(v + 1);
            }
        }
        if changed.is_empty() {
            return Ok(changed);
        }
        gpu.scoped(&format!("pages of {}", self.kind.name()), || {
            // A handful of bricks is written brick by brick, more as the box around them.
            if changed.len() <= 64 && changed.len() * 4 < self.pages.len() {
                for &i in &changed {
                    self.write_pages(gpu, at(i), [1; 3], &self.pages[i..=i]);
                }
            } else {
                let rows = (lo[2]..end[2]).flat_map(|z| (lo[1]..end[1]).map(move |y| nx * (y + ny * z)));
                let box_: Vec<Page> = rows.flat_map(|r| &self.pages[r + lo[0]..r + end[0]]).copied().collect();
                self.write_pages(gpu, lo, std::array::from_fn(|a| (end[a] - lo[a]) as u32), &box_);
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
    pub(crate) fn coarsest(&self) -> u8 {
        self.levels.iter().rposition(|&n| n > 0).unwrap_or(0) as u8
    }

    /// The level that each brick of level 0 is drawn from.
    pub(crate) fn level_of(&self, brick: usize) -> u8 {
        level_of(self.pages[brick]) as u8
    }
}

fn level_of(page: Page) -> usize {
    if page == UNWRITTEN { 0 } else { (page[0] >> 1 & 31) as usize }
}
