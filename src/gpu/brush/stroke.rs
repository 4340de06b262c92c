//! A stroke while it runs on a volume: its constants, its dabs, and where each brick it touched is kept.

use crate::gpu::brush::buffers::{Extras, StrokeBuffers, StrokeSlot, WHOLE_SLOT, next_capacity, slot_bytes};
use crate::gpu::brush::kernel::{BrushStroke, Variant, tight_bytes};
use crate::gpu::brush::live_cells::LiveBricks;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::VolumeFields;
use crate::paint::{Brush, Confines, Dab, Filled, Footprint, GOALS, Goals, Limits, Operation, Reach, Target, VoxelSet};
use crate::volume::{
    BrickIndex, Field, FieldKey, FieldKind, Grid, Region, SLOT_VOXELS, Segments, SourceError, VolumeId,
};
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// Slots whose texels one submission copies.
pub(crate) const SLOTS_AT_ONCE: usize = 128;

/// See the file's head.
#[derive(Debug)]
pub(crate) struct Stroke {
    pub(crate) brush: Brush,
    /// The volume that it paints on.
    pub(crate) volume: VolumeId,
    pub(crate) grid: Grid,
    pub(crate) constants: BrushStroke,
    /// A bit for every label.
    pub(crate) locked: Vec<u32>,
    pub(crate) dabs: Vec<Dab>,
    pub(crate) buffers: Vec<StrokeBuffers>,
    /// The first dab, if coverage was not gathered of it.
    pub(crate) ungathered: Option<Footprint>,
    /// By touched brick.
    pub(crate) slots: HashMap<BrickIndex, StrokeSlot>,
    pub(crate) live: LiveBricks,
    /// What it may paint, if it keeps to the visible surface.
    pub(crate) seen: VoxelSet,
    /// Bricks whose slots show some of it that their gates do not have yet.
    pub(crate) stale: BTreeSet<BrickIndex>,
    /// Sets of voxels that it keeps within.
    pub(crate) confines: Confines,
    /// What it fills in, if it does.
    pub(crate) filled: Filled,
    /// Whether its slots show dabs that were taken from it.
    pub(crate) torn: bool,
}

/// A slot that a stroke touches for the first time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewSlot {
    pub(crate) brick: BrickIndex,
    /// Its first texel in the pool.
    pub(crate) texel: [u32; 3],
    /// What of it is to be kept.
    pub(crate) kept: Region,
}

impl Stroke {
    /// One that has no dabs yet; the brush may be painted with.
    pub(crate) fn new(
        volume: VolumeId,
        fields: &VolumeFields<'_>,
        brush: &Brush,
        segments: &Segments,
        reach: Reach,
    ) -> Self {
        Self {
            brush: *brush,
            volume,
            grid: fields.grid,
            constants: BrushStroke::new(
                brush,
                (&fields.grid, fields.density.sub_box()),
                fields.get(brush.target.field()),
                reach,
            ),
            locked: locked_bits(segments),
            dabs: Vec::new(),
            buffers: Vec::new(),
            ungathered: None,
            slots: HashMap::new(),
            live: LiveBricks::default(),
            seen: VoxelSet::default(),
            stale: BTreeSet::new(),
            confines: Confines::new(),
            filled: Filled::default(),
            torn: false,
        }
    }

    /// The same stroke before its first dab, with nothing on the device, and its dabs.
    pub(crate) fn anew(self) -> (Self, Vec<Dab>) {
        let fresh = Self {
            dabs: Vec::new(),
            buffers: Vec::new(),
            ungathered: None,
            slots: HashMap::new(),
            live: LiveBricks::default(),
            torn: false,
            ..self
        };
        (fresh, self.dabs)
    }

    /// Dabs laid on its volume; those that do not meet it are left out.
    pub(crate) fn footprints(&self, dabs: &[Dab]) -> Vec<Footprint> {
        dabs.iter().filter_map(|dab| dab.footprint(&self.brush, &self.grid)).collect()
    }

    /// Memory that it takes on the GPU.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffers.iter().map(StrokeBuffers::bytes).sum()
    }

    /// Whether it may leave voxels alone that its dabs cover.
    pub(crate) fn is_gated(&self) -> bool {
        self.brush.is_limited() || !self.confines.is_empty()
    }

    pub(crate) fn kind(&self) -> FieldKind {
        self.brush.target.field()
    }

    /// The field that it paints.
    pub(crate) fn key(&self) -> FieldKey {
        FieldKey::new(self.volume, self.kind())
    }

    /// Room for further slots, in spare buffers or new ones; of the budget so much is taken elsewhere.
    pub(crate) fn reserve(
        &mut self,
        gpu: &Gpu,
        variant: Variant,
        density: &Field,
        count: usize,
        spare: &mut Vec<StrokeBuffers>,
        (elsewhere, budget): (u64, u64),
    ) -> Result<(), GpuError> {
        let on_density = matches!(self.brush.target, Target::Density(_));
        let restores = on_density && self.brush.effective() == Operation::Restore;
        let extras = Extras {
            base: match self.brush.effective().looks_around() {
                true => Some((SLOT_VOXELS * GOALS * 4) as u64),
                false => restores.then(|| tight_bytes(density.format())),
            },
            gate: self.is_gated(),
        };
        loop {
            let room: usize = self.buffers.iter().map(StrokeBuffers::room).sum();
            if room >= count {
                return Ok(());
            }
            if let Some(i) = spare.iter().position(|c| c.serves(variant, extras)) {
                self.buffers.push(spare.swap_remove(i));
                continue;
            }
            // What does not serve makes room for what does.
            spare.clear();
            let capacity = next_capacity(count - room, self.slots.len());
            let needed = elsewhere + self.bytes() + u64::from(capacity) * slot_bytes(variant, extras);
            if needed > budget {
                return Err(GpuError::StrokeTooLarge { needed, budget });
            }
            self.buffers.push(StrokeBuffers::new(gpu, variant, extras, capacity)?);
        }
    }

    /// Places for new slots, of which `kept` is all that will change, with what the kernel reads of them.
    pub(crate) fn take(
        &mut self,
        gpu: &Gpu,
        fields: &VolumeFields<'_>,
        new: &[NewSlot],
        gathers: bool,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> Result<(), GpuError> {
        let (density, new_slots) = (fields.density, new.par_iter());
        let around = self.brush.effective().looks_around();
        let base = match self.buffers.iter().any(|b| b.base.is_some()) {
            true if around => {
                new_slots.clone().map(|n| self.goals_of(fields, n.brick)).collect::<Result<Vec<_>, _>>()?
            }
            true => new_slots.clone().map(|n| density.base_slot(n.brick)).collect::<Result<Vec<_>, _>>()?,
            false => Vec::new(),
        };
        let gate = match self.is_gated() {
            true => new_slots.map(|n| self.limits(fields).slot(n.brick)).collect::<Result<Vec<_>, _>>()?,
            false => Vec::new(),
        };
        let held: Vec<_> = self.buffers.iter().map(|b| b.bricks.len()).collect();
        for (i, &NewSlot { brick, texel, kept }) in new.iter().enumerate() {
            let Some(number) = self.buffers.iter().position(|b| b.room() > 0) else { continue };
            let buffers = &mut self.buffers[number];
            let slot = StrokeSlot { buffers: number, place: buffers.place(brick), texel, kept };
            buffers.keep(encoder, &slot, texture);
            let base = base.get(i).map(Vec::as_slice);
            let gate = gate.get(i).map(|bits| bytemuck::cast_slice(bits));
            for (buffer, bytes) in [(&buffers.base, base), (&buffers.gate, gate)] {
                if let (Some(buffer), Some(bytes)) = (buffer, bytes) {
                    gpu.queue.write_buffer(buffer, u64::from(slot.place) * bytes.len() as u64, bytes);
                }
            }
            self.slots.insert(brick, slot);
            self.stale.remove(&brick);
        }
        for (buffers, held) in self.buffers.iter().zip(held) {
            buffers.clear_changed(encoder, held..buffers.bricks.len());
            if gathers {
                buffers.clear_coverage(encoder, held..buffers.bricks.len());
            }
        }
        Ok(())
    }

    /// Before dabs are gathered after a first one that was not: its slots as they were at the start, and all of them kept. It is to
    /// be laid again in the same submission; [`gathered`](Self::gathered) then.
    pub(crate) fn begin_gathering(
        &self,
        first: &[BrickIndex],
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) {
        let slots: Vec<_> = first.iter().filter_map(|brick| self.slots.get(brick)).collect();
        // All before the first is kept: slots in place share their aprons.
        slots.iter().for_each(|slot| self.buffers[slot.buffers].restore(encoder, slot, texture));
        for slot in slots {
            let whole = StrokeSlot { kept: WHOLE_SLOT, ..*slot };
            self.buffers[slot.buffers].keep(encoder, &whole, texture);
            let place = slot.place as usize;
            self.buffers[slot.buffers].clear_coverage(encoder, place..place + 1);
        }
    }

    /// All dabs are gathered from now on, and all of every slot is kept.
    pub(crate) fn gathered(&mut self) {
        self.ungathered = None;
        self.slots.values_mut().for_each(|slot| slot.kept = WHOLE_SLOT);
    }

    /// What it may touch.
    fn limits<'a>(&'a self, fields: &VolumeFields<'a>) -> Limits<'a> {
        let Self { brush, grid, seen, confines, .. } = self;
        let VolumeFields { density, selection, labels, .. } = *fields;
        Limits { brush, grid, density, selection, labels, seen, confines }
    }

    /// Where each texel of a slot is led to.
    fn goals_of(&self, fields: &VolumeFields<'_>, brick: BrickIndex) -> Result<Vec<u8>, SourceError> {
        let Self { brush, grid, filled, .. } = self;
        let goals = Goals { brush, grid, field: fields.get(self.kind()), filled }.slot(brick)?;
        Ok(bytemuck::cast_slice(&goals).to_vec())
    }

    /// Fills in what these footprints cover and the brush may touch; slots that show it have it when their limits are next renewed.
    pub(crate) fn fill(&mut self, fields: &VolumeFields<'_>, footprints: &[Footprint]) -> Result<(), SourceError> {
        let mut domain = VoxelSet::default();
        let mut open: HashMap<BrickIndex, VoxelSet> = HashMap::new();
        for footprint in footprints {
            for brick in footprint.bounds.bricks() {
                if let (true, std::collections::hash_map::Entry::Vacant(place)) = (self.is_gated(), open.entry(brick)) {
                    place.insert(VoxelSet::of_slot(brick, &self.limits(fields).slot(brick)?));
                }
                let of_brick = footprint.bounds.within(brick);
                for voxel in of_brick.voxels().filter(|v| footprint.coverage(*v) > 0.0) {
                    if open.get(&brick).is_none_or(|open| open.contains(voxel)) {
                        domain.insert(voxel);
                    }
                }
            }
        }
        let filled = Filled::solve(fields.get(self.kind()), self.grid.spacing(), &domain)?;
        self.filled.extend(filled);
        self.stale.extend(domain.slots(self.grid.dims, [0; 3]));
        Ok(())
    }

    /// Writes the limits and goals of slots anew in which more is known by now.
    pub(crate) fn renew(&mut self, gpu: &Gpu, fields: &VolumeFields<'_>) -> Result<(), GpuError> {
        while let Some(&brick) = self.stale.first() {
            let Some(slot) = self.slots.get(&brick) else {
                self.stale.pop_first();
                continue;
            };
            let StrokeBuffers { gate, base, .. } = &self.buffers[slot.buffers];
            if let Some(gate) = gate {
                let bits = self.limits(fields).slot(brick)?;
                let at = u64::from(slot.place) * (bits.len() * 4) as u64;
                gpu.queue.write_buffer(gate, at, bytemuck::cast_slice(&bits));
            }
            if let (Some(base), Operation::Fill) = (base, self.brush.effective()) {
                let goals = self.goals_of(fields, brick)?;
                gpu.queue.write_buffer(base, u64::from(slot.place) * goals.len() as u64, &goals);
            }
            self.stale.pop_first();
        }
        Ok(())
    }

    /// Takes places back that were given last.
    pub(crate) fn forget(&mut self, new: &[BrickIndex]) {
        self.live.forget(new);
        for brick in new {
            if let Some(slot) = self.slots.remove(brick) {
                let bricks = &mut self.buffers[slot.buffers].bricks;
                bricks.truncate(bricks.len().min(slot.place as usize));
            }
        }
    }

    /// Puts all slots back.
    pub(crate) fn restore(&self, gpu: &Gpu, pools: &mut FieldPools) -> Result<(), GpuError> {
        self.copy(gpu, pools, "a cancelled stroke", &self.touched(), StrokeBuffers::restore)
    }

    /// Lets the slots of touched bricks show what they held at the stroke's start, until [`show_painted`](Self::show_painted).
    pub(crate) fn show_start(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        bricks: &[BrickIndex],
    ) -> Result<(), GpuError> {
        let held: BTreeSet<_> = bricks.iter().filter_map(|brick| Some(self.slots.get(brick)?.buffers)).collect();
        held.into_iter().try_for_each(|number| self.buffers[number].make_aside(gpu))?;
        // All before the first is put back: slots in place share their aprons.
        self.copy(gpu, pools, "a stroke put aside", bricks, StrokeBuffers::put_aside)?;
        self.copy(gpu, pools, "a stroke's start", bricks, StrokeBuffers::restore)
    }

    /// Lets them show the stroke again.
    pub(crate) fn show_painted(
        &self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        bricks: &[BrickIndex],
    ) -> Result<(), GpuError> {
        self.copy(gpu, pools, "a stroke put back", bricks, StrokeBuffers::put_back)
    }

    /// Copies between the slots of touched bricks and what is kept of them.
    fn copy(
        &self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        what: &str,
        bricks: &[BrickIndex],
        copy: impl Fn(&StrokeBuffers, &mut wgpu::CommandEncoder, &StrokeSlot, &wgpu::Texture),
    ) -> Result<(), GpuError> {
        pools.wrote_slots(self.key(), bricks);
        let Some(texture) = pools.texture(self.key()) else { return Ok(()) };
        let slots: Vec<_> = bricks.iter().filter_map(|brick| self.slots.get(brick)).collect();
        gpu.scoped(what, || {
            for part in slots.chunks(SLOTS_AT_ONCE) {
                let mut encoder =
                    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(what) });
                for slot in part {
                    copy(&self.buffers[slot.buffers], &mut encoder, slot, texture);
                }
                gpu.queue.submit([encoder.finish()]);
            }
            Ok(())
        })
    }

    /// The bricks whose slots it shows in, in order.
    pub(crate) fn touched(&self) -> Vec<BrickIndex> {
        let mut touched: Vec<_> = self.slots.keys().copied().collect();
        touched.sort_unstable();
        touched
    }
}

/// A bit for every label, set for those of locked segments.
fn locked_bits(segments: &Segments) -> Vec<u32> {
    let mut locked = vec![0_u32; 65_536 / 32];
    for segment in segments.0.iter().filter(|s| s.locked) {
        locked[usize::from(segment.id) / 32] |= 1 << (segment.id % 32);
    }
    locked
}
