//! Painting on the GPU: the life of one stroke, from its first dab to the bricks it changed.
//!
//! Owns what a stroke gathers (coverage, texels at its start) and its dabs, so that it can be taken back, or painted again
//! after a loss of the device. The pools' slots show it in the same frame; the host's fields stay as they are until
//! [`Painter::finish`]. Knows no history. Direct Volume Editing (2008) section 3, equations 1 and 2.

use crate::gpu::brush::buffers::{StrokeBuffers, WHOLE_SLOT};
use crate::gpu::brush::kernel;
use crate::gpu::brush::kernel::{BrushStroke, Variant};
use crate::gpu::brush::live_cells;
use crate::gpu::brush::live_cells::{CellReader, LiveBricks};
use crate::gpu::brush::plan;
use crate::gpu::brush::plan::met;
use crate::gpu::brush::readback::{Answers, Flags};
use crate::gpu::brush::stroke::{NewSlot, SLOTS_AT_ONCE, Stroke, locked_bits};
use crate::gpu::brush::submit::Dispatcher;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Compute, Kernel};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::{Fields, VolumeFields};
use crate::paint::{Brush, Dab, Footprint, Reach, VoxelSet};
use crate::volume::{Brick, BrickIndex, BrickKey, LiveCells, Refresh, Segments, VolumeId};
use std::collections::{BTreeSet, HashMap};

/// Memory that one stroke may take unless [`Painter::set_budget`] says otherwise.
const BUDGET: u64 = 512 << 20;
/// Memory kept from stroke to stroke, so that a click does not wait for buffers.
const KEPT: u64 = 64 << 20;

/// Paints strokes, one at a time. Long-lived: it keeps pipelines and some buffers.
#[derive(Debug)]
pub struct Painter {
    gpu: Gpu,
    kernel: Kernel<Compute>,
    dispatcher: Dispatcher,
    cells: CellReader,
    answers: Answers,
    spare: Vec<StrokeBuffers>,
    budget_bytes: u64,
    stroke: Option<Stroke>,
}

impl Painter {
    /// A painter on this device.
    ///
    /// # Errors
    /// If the device refuses its small buffers.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        gpu.scoped("the brush's buffers", || {
            Ok(Self {
                kernel: kernel::brush(gpu),
                dispatcher: Dispatcher::new(gpu),
                cells: CellReader::new(gpu),
                answers: Answers::default(),
                gpu: gpu.clone(),
                spare: Vec::new(),
                budget_bytes: BUDGET,
                stroke: None,
            })
        })
    }

    /// Sets the memory that one stroke may take on the GPU, in bytes (some 350 kB a touched brick; slots of the pools come on
    /// top).
    pub fn set_budget(&mut self, bytes: u64) {
        self.budget_bytes = bytes;
    }

    /// How often dabs were submitted so far.
    pub fn submits(&self) -> u64 {
        self.dispatcher.submits
    }

    /// Whether a stroke is running.
    pub fn is_painting(&self) -> bool {
        self.stroke.is_some()
    }

    /// The running stroke's dabs so far, in order.
    pub fn dabs(&self) -> &[Dab] {
        self.stroke.as_ref().map_or(&[], |s| &s.dabs)
    }

    /// The bricks that the running stroke shows in, itself or through an apron, in order.
    pub fn touched(&self) -> Vec<BrickIndex> {
        self.stroke.as_ref().map_or_else(Vec::new, Stroke::touched)
    }

    /// Looks at the fields as they were at the running stroke's start, in those of the touched bricks that `under` names: what a
    /// stroke paints must not change where it goes on. Without a stroke it only looks.
    ///
    /// # Errors
    /// Those of the look; as [`finish`](Self::finish).
    pub fn at_start<T>(
        &mut self,
        pools: &mut FieldPools,
        under: impl Fn(VolumeId, BrickIndex) -> bool,
        look: impl FnOnce(&mut FieldPools) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let Some(stroke) = &mut self.stroke else { return look(pools) };
        // What a picture shows, and where, hangs on these two alone.
        let matters = live_cells::matters(stroke.kind());
        let seen = |brick: &BrickIndex| matters && under(stroke.volume, *brick);
        let bricks: Vec<_> = stroke.touched().into_iter().filter(seen).collect();
        if bricks.is_empty() {
            return look(pools);
        }
        stroke.show_start(&self.gpu, pools, &bricks)?;
        let seen = look(pools);
        stroke.show_painted(&self.gpu, pools, &bricks)?;
        seen
    }

    /// Starts a stroke on a volume's fields as they are now; they must stay so until it ends. Labels of locked segments are kept. `reach`
    /// is that of density with what the brush makes.
    ///
    /// # Errors
    /// [`GpuError::Stroke`] if one is running; [`GpuError::Paint`] if the brush is not valid; [`GpuError::BeyondRange`] if
    /// density cannot yet hold what the brush makes: widen its [`DensityMap`](crate::volume::DensityMap) and begin again.
    pub fn begin(
        &mut self,
        volume: VolumeId,
        fields: &Fields<'_>,
        brush: &Brush,
        segments: &Segments,
        reach: Reach,
    ) -> Result<(), GpuError> {
        if self.is_painting() {
            return Err(GpuError::Stroke("one is running; end or cancel it first"));
        }
        brush.check()?;
        let fields = of(fields, volume)?;
        brush.check_on(fields.density)?;
        if let Some(needed) = brush.range_needed(fields.density) {
            let map = fields.density.map();
            return Err(GpuError::BeyondRange { needed, held: [map.lo, map.hi()] });
        }
        let target = fields.get(brush.target.field());
        self.stroke = Some(Stroke {
            brush: *brush,
            volume,
            grid: fields.grid,
            constants: BrushStroke::new(brush, &fields.grid, target, reach),
            locked: locked_bits(segments),
            dabs: Vec::new(),
            buffers: Vec::new(),
            ungathered: None,
            slots: HashMap::new(),
            live: LiveBricks::default(),
            seen: VoxelSet::default(),
            stale: BTreeSet::new(),
        });
        Ok(())
    }

    /// Lets the running stroke paint these voxels besides those that it may already, if it keeps to the visible surface: other
    /// voxels it leaves alone. To be called before the dabs on them.
    pub fn open(&mut self, voxels: &VoxelSet) {
        if let Some(stroke) = self.stroke.as_mut().filter(|s| s.brush.visible_only) {
            stroke.seen.extend(voxels);
            stroke.stale.extend(voxels.slots(stroke.grid.dims));
        }
    }

    /// Paints further dabs: after it the pools' slots show them, without waiting for the GPU. Answers the bricks that the
    /// dabs show in, in order. `fields` are those of [`begin`](Self::begin).
    ///
    /// # Errors
    /// [`GpuError::StrokeTooLarge`] and [`GpuError::PoolFull`] if there is no room for more bricks; [`GpuError::Lost`];
    /// [`GpuError::Source`]. The stroke is then as it was and can be ended, cancelled or replayed.
    pub fn extend(
        &mut self,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        dabs: &[Dab],
    ) -> Result<Vec<BrickIndex>, GpuError> {
        self.gpu.check()?;
        let Some(stroke) = &mut self.stroke else { return Err(NOT_RUNNING) };
        pools.have(&self.gpu, fields, stroke.volume)?;
        let fields = &of(fields, stroke.volume)?;
        let (kind, key, target) = (stroke.kind(), stroke.key(), fields.get(stroke.kind()));
        let laid = |dab: &Dab| dab.footprint(&stroke.brush, &stroke.grid);
        let footprints: Vec<_> = dabs.iter().filter_map(laid).collect();
        let met = met(&footprints, stroke.grid.dims);
        let bricks: Vec<_> = met.keys().copied().collect();
        if bricks.is_empty() {
            stroke.dabs.extend_from_slice(dabs);
            return Ok(bricks);
        }
        let new: Vec<_> = bricks.iter().copied().filter(|b| !stroke.slots.contains_key(b)).collect();
        let origins = if new.is_empty() { Vec::new() } else { pools.pin(&self.gpu, key, target, &new)? };
        let (Some(texture), Some(format)) = (pools.texture(key), pools.format(key)) else {
            return Err(GpuError::Stroke("the pools hold no slots of the field"));
        };
        let begins = stroke.slots.is_empty();
        if begins {
            self.dispatcher.lock(&self.gpu, &stroke.locked);
        }
        // A dab that is laid twice must find the same voxels open both times.
        let alone = footprints.len() == 1 && new.len() <= SLOTS_AT_ONCE && !stroke.brush.visible_only;
        let gathers = !(begins && alone);
        let dims = stroke.grid.dims;
        let kept = |brick: BrickIndex| if gathers { WHOLE_SLOT } else { plan::texels(&met[&brick], brick, dims) };
        let slots = new.iter().zip(origins).map(|(&brick, texel)| NewSlot { brick, texel, kept: kept(brick) });
        let variant = Variant::of(target.format(), format);
        let submitted = self.lay(fields, variant, texture, &footprints, &slots.collect::<Vec<_>>(), gathers);
        let Some(stroke) = &mut self.stroke else { return Err(NOT_RUNNING) };
        if let Err(error) = submitted {
            stroke.forget(&new);
            return Err(error);
        }
        if gathers {
            stroke.gathered();
        } else {
            stroke.ungathered = footprints.first().copied();
        }
        if live_cells::matters(kind) {
            stroke.live.paint(&met, stroke.grid.dims, key, pools);
        }
        stroke.dabs.extend_from_slice(dabs);
        Ok(bricks)
    }

    /// Gives new slots places, with all that the kernel reads of them, and submits the dabs on them and on those that have places.
    fn lay(
        &mut self,
        fields: &VolumeFields<'_>,
        variant: Variant,
        texture: &wgpu::Texture,
        footprints: &[Footprint],
        new: &[NewSlot],
        gathers: bool,
    ) -> Result<(), GpuError> {
        let Self { gpu, kernel, dispatcher, cells, spare, budget_bytes, stroke, .. } = self;
        let Some(stroke) = stroke else { return Err(NOT_RUNNING) };
        let pipeline = kernel.pipeline(gpu, &kernel::conditions(variant, gathers), &[], &[])?;
        if live_cells::matters(stroke.kind()) {
            cells.prepare(gpu, variant)?;
            stroke.live.begin(fields.get(stroke.kind()), new.iter().map(|slot| (slot.brick, slot.texel)))?;
        }
        stroke.reserve(gpu, variant, fields.density, new.len(), spare, *budget_bytes)?;
        let begun = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("dabs") });
        let mut encoder = begun();
        for (i, new) in new.chunks(SLOTS_AT_ONCE).enumerate() {
            if i > 0 {
                gpu.queue.submit([std::mem::replace(&mut encoder, begun()).finish()]);
            }
            stroke.take(gpu, fields, new, gathers, &mut encoder, texture)?;
        }
        stroke.renew_gates(gpu, fields)?;
        let Some(first) = stroke.ungathered else {
            return dispatcher.submit(gpu, (kernel, &pipeline), stroke, footprints, encoder, texture);
        };
        let slots: Vec<_> = met(&[first], stroke.grid.dims).into_keys().collect();
        stroke.begin_gathering(&slots, &mut encoder, texture);
        let all = [&[first], footprints].concat();
        dispatcher.submit(gpu, (kernel, &pipeline), stroke, &all, encoder, texture)
    }

    /// Takes what has come of the minima and maxima of the running stroke's cells, and asks for those of what was painted since:
    /// `pools` skip by them. To be called once a frame. Never waits.
    ///
    /// # Errors
    /// [`GpuError::Lost`] and others of the device.
    pub fn follow(&mut self, pools: &mut FieldPools, fields: &Fields<'_>) -> Result<(), GpuError> {
        let Some(stroke) = &mut self.stroke else { return Ok(()) };
        let (key, target) = (stroke.key(), of(fields, stroke.volume)?.get(stroke.kind()));
        let Some(format) = pools.format(key) else { return Ok(()) };
        let variant = Variant::of(target.format(), format);
        stroke.live.follow(&self.gpu, (key, target), variant, &mut self.cells, pools)?;
        let Some(texture) = pools.texture(key) else { return Ok(()) };
        stroke.live.ask(&self.gpu, variant, &mut self.cells, texture, stroke.grid.dims)
    }

    /// The cells of the running stroke's bricks, of those of which something came since this was last asked. Only strokes on
    /// density and the selection have any.
    pub fn take_live(&mut self) -> Vec<(BrickIndex, LiveCells)> {
        self.stroke.as_mut().map(|s| s.live.take_news()).unwrap_or_default()
    }

    /// Whether something of the running stroke's cells is still to come, or to be taken.
    pub fn is_due(&self) -> bool {
        self.stroke.as_ref().is_some_and(|s| s.live.are_due())
    }

    /// Ends the stroke: waits for the GPU and answers the bricks whose own texels differ from those at its start, in order,
    /// with zeros beyond the volume. None: the stroke changed nothing. The slots show the stroke already; give the bricks to
    /// [`Field::swap`](crate::volume::Field::swap) and the answer to [`FieldPools::refresh_painted`] before anything else is
    /// drawn.
    ///
    /// # Errors
    /// [`GpuError::Lost`] and others of the device. The stroke then goes on and can be replayed or cancelled.
    pub fn finish(
        &mut self,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
    ) -> Result<Vec<(BrickIndex, Brick)>, GpuError> {
        let Some(stroke) = &self.stroke else { return Err(NOT_RUNNING) };
        let target = of(fields, stroke.volume)?.get(stroke.kind());
        let touched = stroke.slots.iter().map(|(brick, slot)| (*brick, slot));
        let bricks =
            self.answers.changed(&self.gpu, pools, (stroke.key(), target), &stroke.buffers, touched.collect())?;
        pools.hand_over(stroke.key());
        self.end();
        Ok(bricks)
    }

    /// Takes the stroke back: the slots are as they were. Answers what the pools showed of it, for
    /// [`FieldPools::refresh_painted`] with the unchanged field.
    ///
    /// # Errors
    /// [`GpuError::Lost`]: then there is nothing left to take back, and the stroke is gone too.
    pub fn cancel(&mut self, pools: &mut FieldPools) -> Result<Refresh, GpuError> {
        let touched = self.touched();
        let Some(stroke) = &self.stroke else { return Err(NOT_RUNNING) };
        let restored = stroke.restore(&self.gpu, pools);
        if restored.is_ok() {
            pools.hand_over(stroke.key());
        } else {
            pools.unpin(stroke.key());
        }
        self.end();
        restored?;
        Ok(Refresh::whole(touched.into_iter().map(|index| BrickKey { level: 0, index })))
    }

    /// A brick as the running stroke shows it. Waits for the GPU.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub fn live(&self, pools: &FieldPools, fields: &Fields<'_>, brick: BrickIndex) -> Result<Option<Brick>, GpuError> {
        let Some(stroke) = &self.stroke else { return Ok(None) };
        let target = of(fields, stroke.volume)?.get(stroke.kind());
        let wanted = stroke.slots.get(&brick).map(|slot| (brick, slot));
        let shown =
            Answers::default().bricks(&self.gpu, pools, (stroke.key(), target), wanted.as_slice(), &Flags(&[]))?;
        Ok(shown.into_iter().next().map(|(_, brick)| brick))
    }

    /// After a loss of the device: paints the running stroke again on a new one, from the host's bricks. Without a running
    /// stroke it only changes over.
    ///
    /// # Errors
    /// As [`extend`](Self::extend); the dabs are kept, so that it can be tried again.
    pub fn replay(&mut self, gpu: &Gpu, pools: &mut FieldPools, fields: &Fields<'_>) -> Result<(), GpuError> {
        let budget_bytes = self.budget_bytes;
        let stroke = self.stroke.take();
        match Self::new(gpu) {
            Ok(new) => *self = Self { budget_bytes, ..new },
            Err(error) => {
                self.stroke = stroke;
                return Err(error);
            }
        }
        let Some(stroke) = stroke else { return Ok(()) };
        let dabs = stroke.dabs;
        self.stroke = Some(Stroke {
            dabs: Vec::new(),
            buffers: Vec::new(),
            ungathered: None,
            slots: HashMap::new(),
            live: LiveBricks::default(),
            ..stroke
        });
        let painted = self.extend(pools, fields, &dabs).map(drop);
        if let (Err(_), Some(stroke)) = (&painted, &mut self.stroke) {
            stroke.dabs = dabs;
        }
        painted
    }

    fn end(&mut self) {
        let Some(stroke) = self.stroke.take() else { return };
        let mut kept: u64 = self.spare.iter().map(StrokeBuffers::bytes).sum();
        for mut buffers in stroke.buffers {
            if kept + buffers.bytes() <= KEPT {
                kept += buffers.bytes();
                buffers.bricks.clear();
                self.spare.push(buffers);
            }
        }
    }
}

const NOT_RUNNING: GpuError = GpuError::Stroke("none is running; begin one first");

/// The fields of the volume that is painted.
fn of<'a>(fields: &Fields<'a>, volume: VolumeId) -> Result<VolumeFields<'a>, GpuError> {
    fields.get(volume).copied().ok_or(GpuError::NoVolume { id: volume.0 })
}
