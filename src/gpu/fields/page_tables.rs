//! The page tables of all fields: for each brick of level 0 a slot, or one value.
//!
//! Owns what a page means (`page_of` in shaders/lib/field.wgsl reads it), the one texture in which the tables lie one after
//! another, and where each begins. Page 0 belongs to nobody: fields with nothing on the GPU read it, a texel of zero.

use crate::gpu::device::constants::{NO_PAGES, PAGES_WIDTH};
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::slot_key::count_of;
use crate::volume::FieldKey;
use std::collections::BTreeMap;

/// A page: what a shader reads for a brick of level 0. See `page_of` in shaders/lib/field.wgsl.
pub(crate) type Page = [u32; 2];

/// A page of one value; `texel` is the host's.
pub(crate) fn uniform_page(level: u8, texel: [u8; 4]) -> Page {
    [u32::from(level) << 1, u32::from_le_bytes(texel)]
}

/// A page that draws from a slot.
pub(crate) fn held_page(level: u8, slot: [u32; 3]) -> Page {
    [1 | u32::from(level) << 1 | slot[0] << 8 | slot[1] << 16 | slot[2] << 24, 0]
}

/// What a table starts as: a page that nothing has.
const UNWRITTEN: Page = [u32::MAX; 2];

fn level_of(page: Page) -> usize {
    if page == UNWRITTEN { 0 } else { (page[0] >> 1 & 31) as usize }
}

#[derive(Debug)]
struct Table {
    first: usize,
    count: usize,
    /// How many pages draw from each level.
    levels: [usize; 32],
}

/// The pages of all fields one after another, on the host as they are in the texture, and how many draw from each level.
#[derive(Debug)]
pub(crate) struct PageTables {
    pages: Vec<Page>,
    tables: BTreeMap<FieldKey, Table>,
    pub(crate) texture: wgpu::Texture,
    /// All of the texture is to be written: tables came or went.
    moved: bool,
    /// Whether texture or places were replaced since the bind group was made.
    pub(crate) replaced: bool,
}

impl PageTables {
    /// No tables.
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let texture = gpu.scoped("page tables", || Ok(texture(gpu, 1)))?;
        Ok(Self { pages: vec![[0; 2]], tables: BTreeMap::new(), texture, moved: true, replaced: true })
    }

    /// Whether a field has a table.
    pub(crate) fn has(&self, key: FieldKey) -> bool {
        self.tables.contains_key(&key)
    }

    /// The fields that have tables.
    pub(crate) fn keys(&self) -> impl Iterator<Item = FieldKey> {
        self.tables.keys().copied()
    }

    /// The number of a field's first page.
    pub(crate) fn first(&self, key: FieldKey) -> u32 {
        self.tables.get(&key).map_or(NO_PAGES, |table| table.first as u32)
    }

    /// A table for a field, its pages still to be set.
    pub(crate) fn begin(&mut self, key: FieldKey, bricks: [u32; 3]) {
        self.end(key);
        let (first, count) = (self.pages.len(), count_of(bricks));
        self.pages.resize(first + count, UNWRITTEN);
        self.tables.insert(key, Table { first, count, levels: [0; 32] });
        self.moved = true;
    }

    /// Takes a field's table away; those behind it move up.
    pub(crate) fn end(&mut self, key: FieldKey) {
        let Some(gone) = self.tables.remove(&key) else { return };
        self.pages.drain(gone.first..gone.first + gone.count);
        for table in self.tables.values_mut().filter(|table| table.first > gone.first) {
            table.first -= gone.count;
        }
        self.moved = true;
    }

    /// Sets pages of bricks of level 0 of a field. Answers those that changed, in order. The texture follows with
    /// [`write`](Self::write) where tables came or went, otherwise at once.
    pub(crate) fn set(&mut self, gpu: &Gpu, key: FieldKey, pages: &[(usize, Page)]) -> Result<Vec<usize>, GpuError> {
        let Some(table) = self.tables.get_mut(&key) else { return Ok(Vec::new()) };
        let mut changed = Vec::new();
        for &(i, page) in pages {
            let old = &mut self.pages[table.first + i];
            if *old == page {
                continue;
            }
            if *old != UNWRITTEN {
                table.levels[level_of(*old)] -= 1;
            }
            table.levels[level_of(page)] += 1;
            *old = page;
            changed.push(i);
        }
        let first = table.first;
        if let (Some(&lo), Some(&hi), false) = (changed.first(), changed.last(), self.moved) {
            gpu.scoped("page tables", || {
                // A handful is written page by page, more as the rows around them.
                if changed.len() <= 64 && changed.len() * 4 < self.pages.len() {
                    for &i in &changed {
                        self.write_some(gpu, first + i, 1);
                    }
                } else {
                    let width = PAGES_WIDTH as usize;
                    let from = (first + lo) / width * width;
                    self.write_some(gpu, from, first + hi + 1 - from);
                }
                Ok(())
            })?;
        }
        Ok(changed)
    }

    /// Writes the texture whole if tables came or went.
    pub(crate) fn write(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        if !self.moved {
            return Ok(());
        }
        let rows = (self.pages.len() as u32).div_ceil(PAGES_WIDTH);
        gpu.scoped("page tables", || {
            if self.texture.height() != rows {
                self.texture = texture(gpu, rows);
            }
            self.write_some(gpu, 0, self.pages.len());
            Ok(())
        })?;
        self.moved = false;
        self.replaced = true;
        Ok(())
    }

    /// Writes pages that are one, or begin a row.
    fn write_some(&self, gpu: &Gpu, from: usize, count: usize) {
        let width = PAGES_WIDTH as usize;
        let seen = |page: &Page| if *page == UNWRITTEN { [0; 2] } else { *page };
        let mut texels: Vec<Page> = self.pages[from..from + count].iter().map(seen).collect();
        let (x, y) = (from % width, from / width);
        let across = if count == 1 { 1 } else { width };
        texels.resize(count.next_multiple_of(across), [0; 2]);
        let end = (y + texels.len() / across) * width;
        // What else lies in the last row stays.
        let rest = count + from..end.min(self.pages.len());
        if across > 1 {
            texels[count..count + rest.len()].copy_from_slice(&self.pages[rest].iter().map(seen).collect::<Vec<_>>());
        }
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: x as u32, y: y as u32, z: 0 },
                ..self.texture.as_image_copy()
            },
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * across as u32), rows_per_image: None },
            wgpu::Extent3d { width: across as u32, height: (texels.len() / across) as u32, depth_or_array_layers: 1 },
        );
    }

    /// The coarsest level that any brick of level 0 of a field is drawn from.
    pub(crate) fn coarsest(&self, key: FieldKey) -> u8 {
        let levels = self.tables.get(&key).and_then(|table| table.levels.iter().rposition(|&n| n > 0));
        levels.unwrap_or(0) as u8
    }

    /// The level that a brick of level 0 is drawn from.
    pub(crate) fn level_of(&self, key: FieldKey, brick: usize) -> u8 {
        self.tables.get(&key).map_or(0, |table| level_of(self.pages[table.first + brick]) as u8)
    }
}

fn texture(gpu: &Gpu, rows: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("page tables"),
        size: wgpu::Extent3d { width: PAGES_WIDTH, height: rows, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rg32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}
