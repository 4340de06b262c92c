//! One field on the GPU: a 3D texture of 34³ slots and the page table that says where each brick of level 0 is drawn from.
//!
//! Owns the texture, the map from bricks to slots, and the host's copy of the page table. Does not decide which bricks to
//! hold (that is `residency`) and knows no camera. Slots lie apart, or, where all of level 0 fits, in place: neighbours then
//! share their aprons, so that the texture is the volume and a ray need not know where bricks end.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::volume::{BRICK, BrickIndex, BrickKey, Field, FieldKind, SLOT, TexelFormat};
use std::collections::{HashMap, HashSet};

pub(crate) mod pages;
pub(crate) mod slots;
pub(crate) mod upload;

use crate::gpu::fields::pool::pages::Page;
use crate::gpu::fields::pool::pages::UNWRITTEN;
use crate::gpu::fields::pool::slots::{grow_grid, limit, places, slots_texture, texels};
use crate::gpu::fields::pool::upload::Upload;

#[derive(Clone, Copy, Debug)]
struct Held {
    slot: [u32; 3],
    /// When it was last asked for.
    used: u64,
    /// A picture draws from it.
    wanted: bool,
    pinned: bool,
}

#[derive(Debug)]
pub(crate) struct Pool {
    kind: FieldKind,
    host: TexelFormat,
    format: TexelFormat,
    /// All bricks of level 0 are held, each where it is in the volume.
    in_place: bool,
    budget: u64,
    pub(crate) texture: wgpu::Texture,
    grid: [u32; 3],
    limit: [u32; 3],
    held: HashMap<BrickKey, Held>,
    pinned: HashSet<BrickKey>,
    free: Vec<[u32; 3]>,
    clock: u64,
    bricks: [u32; 3],
    /// Whether anything was ever written to the texture.
    written: bool,
    pages: Vec<Page>,
    /// How many pages draw from each level.
    levels: [usize; 32],
    /// Bricks whose texels were uploaded so far.
    uploaded: u64,
    /// Painting took a slot that a picture draws from.
    disturbed: bool,
    pub(crate) page_texture: wgpu::Texture,
    /// Whether a texture was replaced since the bind group was made.
    pub(crate) replaced: bool,
}

impl Pool {
    /// An empty pool of at most `budget_bytes`; its texture is one slot until something is held. Bricks lie in place if all
    /// of level 0 then takes at most `in_place_bytes`.
    pub(crate) fn new(
        gpu: &Gpu,
        kind: FieldKind,
        host: TexelFormat,
        bricks: [u32; 3],
        budget_bytes: u64,
        in_place_bytes: u64,
    ) -> Result<Self, GpuError> {
        let format = match host {
            TexelFormat::R16Unorm if !gpu.has_unorm16() => TexelFormat::R32Float,
            other => other,
        };
        let longest = gpu.device.limits().max_texture_dimension_3d;
        let whole = texels(bricks, true);
        let bytes = whole.iter().map(|&n| u64::from(n)).product::<u64>() * format.bytes() as u64;
        let in_place =
            bytes <= in_place_bytes.min(budget_bytes).min(slots::MOST_BYTES) && whole.iter().all(|&n| n <= longest);
        let limit = if in_place { bricks } else { limit(gpu, format, budget_bytes) };
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
            Ok((slots_texture(gpu, kind, format, texels([1; 3], in_place)), pages))
        })?;
        let count = bricks.iter().map(|&b| b as usize).product();
        Ok(Self {
            kind,
            host,
            format,
            in_place,
            budget: budget_bytes,
            texture,
            grid: [1; 3],
            limit,
            held: HashMap::new(),
            pinned: HashSet::new(),
            free: vec![[0; 3]],
            clock: 0,
            bricks,
            written: false,
            pages: vec![UNWRITTEN; count],
            levels: [0; 32],
            uploaded: 0,
            disturbed: false,
            page_texture,
            replaced: true,
        })
    }

    /// Format of the texels on the GPU.
    pub(crate) fn format(&self) -> TexelFormat {
        self.format
    }

    /// How many slots the budget allows.
    pub(crate) fn most(&self) -> usize {
        self.limit.iter().map(|&n| n as usize).product()
    }

    /// How many bricks are held.
    pub(crate) fn held_count(&self) -> usize {
        self.held.len()
    }

    /// Whether all bricks of level 0 are held, each where it is in the volume.
    pub(crate) fn is_in_place(&self) -> bool {
        self.in_place
    }

    /// 1 / texels along each axis.
    pub(crate) fn texel(&self) -> [f32; 3] {
        texels(self.grid, self.in_place).map(|n| 1.0 / n as f32)
    }

    /// Whether a brick has a slot.
    pub(crate) fn holds(&self, key: BrickKey) -> bool {
        self.held.contains_key(&key)
    }

    /// First texel, apron included, of a held brick's slot.
    pub(crate) fn texel_origin(&self, key: BrickKey) -> Option<[u32; 3]> {
        self.held.get(&key).map(|h| self.origin(h.slot))
    }

    /// First texel, apron included, of a slot.
    fn origin(&self, slot: [u32; 3]) -> [u32; 3] {
        slot.map(|s| s * if self.in_place { BRICK } else { SLOT })
    }

    /// Gives bricks slots with their texels: for pictures until [`release`](Self::release), or with `pin` for painting until
    /// [`unpin`](Self::unpin). What neither wants makes room, the longest unused first; painting may take what pictures want.
    /// Answers whether anything was uploaded.
    pub(crate) fn hold(&mut self, gpu: &Gpu, field: &Field, keys: &[BrickKey], pin: bool) -> Result<bool, GpuError> {
        self.clock += 1;
        let filled = self.in_place && self.held.is_empty() && self.fill(gpu, field)?;
        let mut missing = Vec::new();
        for key in keys {
            match self.held.get_mut(key) {
                Some(held) => held.used = self.clock,
                None => missing.push(*key),
            }
        }
        if !missing.is_empty() {
            self.make_room(gpu, missing.len(), pin)?;
            let Some(left) = self.free.len().checked_sub(missing.len()) else {
                return Err(GpuError::PoolFull { field: self.kind.name(), asked: keys.len(), room: self.most() });
            };
            let places = self.free[left..].iter().rev();
            let uploads: Vec<_> = missing.iter().zip(places).map(|(&key, &slot)| Upload::whole(key, slot)).collect();
            self.upload(gpu, field, &uploads)?;
            self.free.truncate(left);
            let fresh = |slot| Held { slot, used: self.clock, wanted: false, pinned: false };
            self.held.extend(uploads.into_iter().map(|u| (u.key, fresh(u.slot))));
        }
        for key in keys {
            if let Some(held) = self.held.get_mut(key) {
                held.pinned |= pin;
                held.wanted |= !pin;
            }
        }
        if pin {
            self.pinned.extend(keys);
        }
        Ok(filled || !missing.is_empty())
    }

    /// Holds all of level 0 in place. Answers false, and lies apart from then on, where memory is short.
    fn fill(&mut self, gpu: &Gpu, field: &Field) -> Result<bool, GpuError> {
        match self.grow_to(gpu, self.bricks) {
            Err(GpuError::OutOfMemory { .. }) => {
                self.in_place = false;
                self.limit = limit(gpu, self.format, self.budget);
                (self.grid, self.free, self.written) = ([1; 3], vec![[0; 3]], false);
                self.texture = gpu.scoped(&format!("the {} pool", self.kind.name()), || {
                    Ok(slots_texture(gpu, self.kind, self.format, texels(self.grid, false)))
                })?;
                self.replaced = true;
                return Ok(false);
            }
            other => other?,
        }
        self.free.clear();
        let whole = |at| Upload::whole(BrickKey { level: 0, index: BrickIndex(at) }, at);
        let all: Vec<_> = places(self.bricks).map(whole).collect();
        self.upload(gpu, field, &all)?;
        let held = |slot| Held { slot, used: 0, wanted: true, pinned: false };
        self.held = all.into_iter().map(|u| (u.key, held(u.slot))).collect();
        Ok(true)
    }

    /// Pictures no longer draw from these bricks; they stay until their slot is needed.
    pub(crate) fn release(&mut self, keys: impl IntoIterator<Item = BrickKey>) {
        for key in keys {
            if let Some(held) = self.held.get_mut(&key) {
                held.wanted = false;
            }
        }
    }

    /// The same for all bricks.
    pub(crate) fn release_all(&mut self) {
        self.held.values_mut().for_each(|h| h.wanted = false);
    }

    /// Whether painting took slots that pictures draw from.
    pub(crate) fn is_disturbed(&self) -> bool {
        self.disturbed
    }

    /// The same since it was last asked.
    pub(crate) fn take_disturbed(&mut self) -> bool {
        std::mem::take(&mut self.disturbed)
    }

    /// Frees slots until `count` are free or nothing more can go.
    fn make_room(&mut self, gpu: &Gpu, count: usize, pin: bool) -> Result<(), GpuError> {
        let total = self.held.len() + self.free.len();
        if self.free.len() < count && total < self.most() {
            let in_use = self.held.values().filter(|h| h.pinned || h.wanted || h.used == self.clock).count();
            let need = in_use + count;
            if need > total {
                // Half as much again, so that painting does not grow the pool stroke by stroke.
                self.grow(gpu, (need + need / 2).min(self.most()))?;
            }
        }
        if self.free.len() < count {
            let now = self.clock;
            let idle = |h: &Held| !h.pinned && h.used != now && (pin || !h.wanted);
            let mut idle: Vec<_> =
                self.held.iter().filter(|(_, h)| idle(h)).map(|(k, h)| (h.wanted, h.used, *k)).collect();
            idle.sort_unstable();
            for (wanted, _, key) in idle.into_iter().take(count - self.free.len()) {
                if let Some(held) = self.held.remove(&key) {
                    self.disturbed |= wanted;
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
        let larger = texels(grid, self.in_place);
        self.texture = gpu.scoped(&format!("a {} pool of {grid:?} slots", kind.name()), || {
            let texture = slots_texture(gpu, kind, format, larger);
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

    /// Lets pinned bricks go; they stay until their slot is needed. Answers which they were.
    pub(crate) fn unpin(&mut self) -> HashSet<BrickKey> {
        for key in &self.pinned {
            if let Some(held) = self.held.get_mut(key) {
                held.pinned = false;
            }
        }
        std::mem::take(&mut self.pinned)
    }

    /// Whether a brick is pinned.
    pub(crate) fn is_pinned(&self, key: BrickKey) -> bool {
        self.pinned.contains(&key)
    }

    /// The pinned bricks.
    pub(crate) fn pinned(&self) -> &HashSet<BrickKey> {
        &self.pinned
    }

    /// Bricks whose texels were uploaded so far.
    pub(crate) fn uploaded(&self) -> u64 {
        self.uploaded
    }
}

pub(crate) fn extent([width, height, depth]: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: depth }
}
