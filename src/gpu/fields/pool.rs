//! Slots of one texel format on the GPU: a 3D texture of 34³ slots that bricks of all volumes share.
//!
//! Owns the texture and the map from bricks to slots. Does not decide which bricks to hold (that is `residency`) and knows no
//! camera and no pages. Slots lie apart, or, where all of level 0 of the only volume fits, in place: neighbours then share
//! their aprons, so that the texture is the volume and a ray need not know where bricks end.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::pairs::Pairs;
use crate::gpu::fields::pool::slots::{grow_grid, limit, places, slots_texture, texels};
use crate::gpu::fields::pool::upload::Upload;
use crate::gpu::fields::slot_key::SlotKey;
use crate::volume::{BRICK, BrickIndex, BrickKey, Field, SLOT, TexelFormat, VolumeId};
use std::collections::{HashMap, HashSet};

pub(crate) mod pairs;
pub(crate) mod slots;
pub(crate) mod upload;

/// Where a pool gets the texels of a volume's bricks from.
pub(crate) type FieldOf<'a, 'f> = &'a (dyn Fn(VolumeId) -> Option<&'f Field> + Sync);

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
    name: &'static str,
    format: TexelFormat,
    /// All bricks of level 0 of this volume are held, each where it is in the volume; so many bricks along each axis.
    in_place: Option<(VolumeId, [u32; 3])>,
    budget: u64,
    pub(crate) texture: wgpu::Texture,
    pub(crate) pairs: Option<Pairs>,
    /// There are to be no pairs, or there is no room for them.
    unpaired: bool,
    grid: [u32; 3],
    limit: [u32; 3],
    held: HashMap<SlotKey, Held>,
    pinned: HashSet<SlotKey>,
    free: Vec<[u32; 3]>,
    clock: u64,
    /// Whether anything was ever written to the texture.
    written: bool,
    /// Bricks whose texels were uploaded so far.
    uploaded: u64,
    /// Painting took a slot that a picture draws from.
    disturbed: bool,
    /// Whether the texture was replaced since the bind group was made.
    pub(crate) replaced: bool,
}

/// Whether all of level 0 of a volume may lie in place in a texture of at most so many bytes.
pub(crate) fn fits_in_place(gpu: &Gpu, format: TexelFormat, bricks: [u32; 3], most_bytes: u64) -> bool {
    let longest = gpu.device.limits().max_texture_dimension_3d;
    let whole = texels(bricks, true);
    let bytes = whole.iter().map(|&n| u64::from(n)).product::<u64>() * format.bytes() as u64;
    bytes <= most_bytes.min(slots::MOST_BYTES) && whole.iter().all(|&n| n <= longest)
}

/// Bytes of a slot.
pub(crate) fn slot_bytes(format: TexelFormat) -> u64 {
    slots::bytes(format)
}

impl Pool {
    /// An empty pool of at most `budget_bytes`, and of `least` slots at least; its texture is one slot until something is held.
    /// All bricks of `in_place` lie in place, if it is given.
    pub(crate) fn new(
        gpu: &Gpu,
        name: &'static str,
        format: TexelFormat,
        (budget_bytes, least): (u64, usize),
        in_place: Option<(VolumeId, [u32; 3])>,
    ) -> Result<Self, GpuError> {
        let budget = budget_bytes.max(slots::bytes(format) * least as u64);
        let limit = in_place.map_or_else(|| limit(gpu, format, budget), |(_, bricks)| bricks);
        let texture = gpu.scoped(&format!("the {name} pool"), || {
            Ok(slots_texture(gpu, name, format, texels([1; 3], in_place.is_some())))
        })?;
        Ok(Self {
            name,
            format,
            in_place,
            budget,
            texture,
            pairs: None,
            unpaired: false,
            grid: [1; 3],
            limit,
            held: HashMap::new(),
            pinned: HashSet::new(),
            free: vec![[0; 3]],
            clock: 0,
            written: false,
            uploaded: 0,
            disturbed: false,
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

    /// Another budget from now on, at least what the texture takes already.
    pub(crate) fn set_budget(&mut self, gpu: &Gpu, (budget_bytes, least): (u64, usize)) {
        self.budget = budget_bytes.max(slots::bytes(self.format) * least as u64);
        self.limit = limit(gpu, self.format, self.budget);
    }

    /// Bytes that the texture takes.
    pub(crate) fn bytes(&self) -> u64 {
        let texels = texels(self.grid, self.is_in_place()).into_iter().map(u64::from);
        texels.product::<u64>() * self.format.bytes() as u64
    }

    /// How many bricks are held.
    pub(crate) fn held_count(&self) -> usize {
        self.held.len()
    }

    /// Whether all bricks of level 0 of a volume are held, each where it is in the volume.
    pub(crate) fn is_in_place(&self) -> bool {
        self.in_place.is_some()
    }

    /// 1 / texels along each axis.
    pub(crate) fn texel(&self) -> [f32; 3] {
        texels(self.grid, self.is_in_place()).map(|n| 1.0 / n as f32)
    }

    /// Whether a brick has a slot.
    pub(crate) fn holds(&self, key: SlotKey) -> bool {
        self.held.contains_key(&key)
    }

    /// First texel, apron included, of a held brick's slot.
    pub(crate) fn texel_origin(&self, key: SlotKey) -> Option<[u32; 3]> {
        self.held.get(&key).map(|h| self.origin(h.slot))
    }

    /// First texel, apron included, of a slot.
    fn origin(&self, slot: [u32; 3]) -> [u32; 3] {
        slot.map(|s| s * if self.is_in_place() { BRICK } else { SLOT })
    }

    /// The slot of a held brick, and whether it is pinned.
    pub(crate) fn slot(&self, key: SlotKey) -> Option<([u32; 3], bool)> {
        self.held.get(&key).map(|h| (h.slot, h.pinned))
    }

    /// Gives bricks slots with their texels: for pictures until [`release`](Self::release), or with `pin` for painting until
    /// [`unpin`](Self::unpin). What neither wants makes room, the longest unused first; painting may take what pictures want.
    /// Answers whether anything was uploaded.
    pub(crate) fn hold(
        &mut self,
        gpu: &Gpu,
        field_of: FieldOf<'_, '_>,
        keys: &[SlotKey],
        pin: bool,
    ) -> Result<bool, GpuError> {
        self.clock += 1;
        let filled = self.held.is_empty() && self.fill(gpu, field_of)?;
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
                return Err(GpuError::PoolFull { field: self.name, asked: keys.len(), room: self.most() });
            };
            let places = self.free[left..].iter().rev();
            let uploads: Vec<_> = missing.iter().zip(places).map(|(&key, &slot)| Upload::whole(key, slot)).collect();
            self.upload(gpu, field_of, &uploads)?;
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

    /// Holds all of level 0 of the volume that lies in place, if one does. Answers false, and lies apart from then on, where
    /// memory is short.
    fn fill(&mut self, gpu: &Gpu, field_of: FieldOf<'_, '_>) -> Result<bool, GpuError> {
        let Some((volume, bricks)) = self.in_place else { return Ok(false) };
        match self.grow_to(gpu, bricks) {
            Err(GpuError::OutOfMemory { .. }) => {
                self.in_place = None;
                self.limit = limit(gpu, self.format, self.budget);
                (self.grid, self.free, self.written) = ([1; 3], vec![[0; 3]], false);
                self.texture = gpu.scoped(&format!("the {} pool", self.name), || {
                    Ok(slots_texture(gpu, self.name, self.format, texels(self.grid, false)))
                })?;
                self.replaced = true;
                return Ok(false);
            }
            other => other?,
        }
        self.free.clear();
        let key = |at| SlotKey::new(volume, BrickKey { level: 0, index: BrickIndex(at) });
        let all: Vec<_> = places(bricks).map(|at| Upload::whole(key(at), at)).collect();
        self.upload(gpu, field_of, &all)?;
        let held = |slot| Held { slot, used: 0, wanted: true, pinned: false };
        self.held = all.into_iter().map(|u| (u.key, held(u.slot))).collect();
        Ok(true)
    }

    /// Pictures no longer draw from these bricks; they stay until their slot is needed.
    pub(crate) fn release(&mut self, keys: impl IntoIterator<Item = SlotKey>) {
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
        let (name, format, old, written) = (self.name, self.format, &self.texture, self.written);
        let size = old.size();
        let larger = texels(grid, self.is_in_place());
        self.texture = gpu.scoped(&format!("a {name} pool of {grid:?} slots"), || {
            let texture = slots_texture(gpu, name, format, larger);
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

    /// Lets a volume's pinned bricks go; they stay until their slot is needed. Answers which they were.
    pub(crate) fn unpin(&mut self, volume: VolumeId) -> HashSet<BrickKey> {
        let (gone, left): (HashSet<_>, HashSet<_>) = self.pinned.drain().partition(|key| key.volume == volume);
        self.pinned = left;
        for key in &gone {
            if let Some(held) = self.held.get_mut(key) {
                held.pinned = false;
            }
        }
        gone.into_iter().map(|key| key.brick).collect()
    }

    /// Gives up all slots of a volume.
    pub(crate) fn forget(&mut self, volume: VolumeId) {
        self.pinned.retain(|key| key.volume != volume);
        let free = &mut self.free;
        self.held.retain(|key, held| {
            if key.volume == volume {
                free.push(held.slot);
            }
            key.volume != volume
        });
        if self.in_place.is_some_and(|(of, _)| of == volume) {
            // What is in place is held whole or not at all.
            self.held.clear();
        }
    }

    /// Whether a brick is pinned.
    pub(crate) fn is_pinned(&self, key: SlotKey) -> bool {
        self.pinned.contains(&key)
    }

    /// The pinned bricks.
    pub(crate) fn pinned(&self) -> &HashSet<SlotKey> {
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
