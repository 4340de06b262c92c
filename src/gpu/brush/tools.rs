//! What strokes are laid with: pipelines and buffers that outlive them, and how dabs get onto one volume.
//!
//! Owns nothing of a stroke. A stroke that paints several volumes is laid on each by itself; whoever holds them sees to it that all
//! get the same. Direct Volume Editing (2008) section 3, equations 1 and 2.

use crate::gpu::brush::buffers::{StrokeBuffers, WHOLE_SLOT};
use crate::gpu::brush::kernel;
use crate::gpu::brush::kernel::Variant;
use crate::gpu::brush::live_cells;
use crate::gpu::brush::live_cells::CellReader;
use crate::gpu::brush::plan;
use crate::gpu::brush::plan::met;
use crate::gpu::brush::readback::{Answers, Flags};
use crate::gpu::brush::stroke::{NewSlot, SLOTS_AT_ONCE, Stroke};
use crate::gpu::brush::submit::Dispatcher;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Compute, Kernel};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::{Fields, VolumeFields};
use crate::paint::{Dab, Footprint, IndexBox, Operation};
use crate::volume::{Brick, BrickIndex, Field, VolumeId};

/// Memory that one stroke may take unless it is said otherwise.
const BUDGET: u64 = 512 << 20;
/// Memory kept from stroke to stroke, so that a click does not wait for buffers.
const KEPT: u64 = 64 << 20;

/// See the file's head. Long-lived.
#[derive(Debug)]
pub(crate) struct Tools {
    pub(crate) gpu: Gpu,
    kernel: Kernel<Compute>,
    pub(crate) dispatcher: Dispatcher,
    cells: CellReader,
    answers: Answers,
    spare: Vec<StrokeBuffers>,
    /// Memory that a stroke may take, on all its volumes.
    pub(crate) budget_bytes: u64,
    /// The volume whose locked labels the kernel reads.
    locked_of: Option<VolumeId>,
}

impl Tools {
    /// # Errors
    /// If the device refuses its small buffers.
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        gpu.scoped("the brush's buffers", || {
            Ok(Self {
                kernel: kernel::brush(gpu),
                dispatcher: Dispatcher::new(gpu),
                cells: CellReader::new(gpu),
                answers: Answers::default(),
                gpu: gpu.clone(),
                spare: Vec::new(),
                budget_bytes: BUDGET,
                locked_of: None,
            })
        })
    }

    /// Lays further dabs on a stroke's volume; answers the bricks that they show in, in order. `elsewhere` is what the stroke takes
    /// on other volumes, bytes.
    ///
    /// # Errors
    /// If there is no room for more bricks, the device or the source fails. The stroke is then as it was.
    pub(crate) fn extend(
        &mut self,
        stroke: &mut Stroke,
        pools: &mut FieldPools,
        fields: &VolumeFields<'_>,
        dabs: &[Dab],
        elsewhere: u64,
    ) -> Result<Vec<BrickIndex>, GpuError> {
        let (kind, key, target) = (stroke.kind(), stroke.key(), fields.get(stroke.kind()));
        let footprints = stroke.footprints(dabs);
        let met = met(&footprints, stroke.grid.dims);
        let bricks: Vec<_> = met.keys().copied().collect();
        if bricks.is_empty() {
            stroke.dabs.extend_from_slice(dabs);
            return Ok(bricks);
        }
        if stroke.brush.effective() == Operation::Fill {
            stroke.fill(fields, &footprints)?;
        }
        let new: Vec<_> = bricks.iter().copied().filter(|b| !stroke.slots.contains_key(b)).collect();
        let origins = if new.is_empty() { Vec::new() } else { pools.pin(&self.gpu, key, target, &new)? };
        pools.wrote(key, footprints.iter().map(|f| f.bounds));
        let (texture, variant) = shown(stroke, pools, target)?;
        let begins = stroke.slots.is_empty();
        self.lock(stroke, begins);
        // A dab that is laid twice must find the same voxels open both times.
        let alone = footprints.len() == 1 && new.len() <= SLOTS_AT_ONCE && !stroke.brush.keeps_to_surface();
        let gathers = !(begins && alone);
        let dims = stroke.grid.dims;
        let kept = |brick: BrickIndex| if gathers { WHOLE_SLOT } else { plan::texels(&met[&brick], brick, dims) };
        let slots = new.iter().zip(origins).map(|(&brick, texel)| NewSlot { brick, texel, kept: kept(brick) });
        let slots: Vec<_> = slots.collect();
        let room = stroke.reserve(
            &self.gpu,
            variant,
            fields.density,
            new.len(),
            &mut self.spare,
            (elsewhere, self.budget_bytes),
        );
        let laid = room.and_then(|()| self.lay(stroke, fields, (variant, texture), &footprints, &slots, gathers));
        if let Err(error) = laid {
            stroke.forget(&new);
            return Err(error);
        }
        if gathers {
            stroke.gathered();
        } else {
            stroke.ungathered = footprints.first().copied();
        }
        if live_cells::matters(kind) {
            stroke.live.paint(&met, dims, key, pools);
        }
        stroke.dabs.extend_from_slice(dabs);
        Ok(bricks)
    }

    /// Gives new slots places, with all that the kernel reads of them, and submits the dabs on them and on those that have places.
    fn lay(
        &mut self,
        stroke: &mut Stroke,
        fields: &VolumeFields<'_>,
        (variant, texture): (Variant, &wgpu::Texture),
        footprints: &[Footprint],
        new: &[NewSlot],
        gathers: bool,
    ) -> Result<(), GpuError> {
        let Self { gpu, kernel, dispatcher, cells, .. } = self;
        let pipeline = kernel.pipeline(gpu, &kernel::conditions(variant, gathers, &stroke.brush), &[], &[])?;
        if live_cells::matters(stroke.kind()) {
            cells.prepare(gpu, variant)?;
            stroke.live.begin(fields.get(stroke.kind()), new.iter().map(|slot| (slot.brick, slot.texel)))?;
        }
        let begun = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("dabs") });
        let mut encoder = begun();
        for (i, new) in new.chunks(SLOTS_AT_ONCE).enumerate() {
            if i > 0 {
                gpu.queue.submit([std::mem::replace(&mut encoder, begun()).finish()]);
            }
            stroke.take(gpu, fields, new, gathers, &mut encoder, texture)?;
        }
        stroke.renew(gpu, fields)?;
        let Some(first) = stroke.ungathered else {
            return dispatcher.submit(gpu, (kernel, &pipeline), stroke, footprints, encoder, texture);
        };
        let slots: Vec<_> = met(&[first], stroke.grid.dims).into_keys().collect();
        stroke.begin_gathering(&slots, &mut encoder, texture);
        let all = [&[first], footprints].concat();
        dispatcher.submit(gpu, (kernel, &pipeline), stroke, &all, encoder, texture)
    }

    /// Before a stroke ends that fills in: fills in all that it covers, as one, and lays it anew.
    ///
    /// # Errors
    /// As [`rewind`](Self::rewind).
    pub(crate) fn settle(
        &mut self,
        stroke: &mut Stroke,
        pools: &mut FieldPools,
        fields: &VolumeFields<'_>,
    ) -> Result<(), GpuError> {
        if stroke.brush.effective() != Operation::Fill || stroke.dabs.len() < 2 {
            return Ok(());
        }
        stroke.fill(fields, &stroke.footprints(&stroke.dabs))?;
        stroke.renew(&self.gpu, fields)?;
        self.rewind(stroke, pools, fields)
    }

    /// Takes dabs back that were laid and are no longer among the stroke's: its slots are put back, and those that it has laid anew.
    ///
    /// # Errors
    /// As [`extend`](Self::extend). The stroke is then torn: its slots show more than its dabs, until this succeeds.
    pub(crate) fn rewind(
        &mut self,
        stroke: &mut Stroke,
        pools: &mut FieldPools,
        fields: &VolumeFields<'_>,
    ) -> Result<(), GpuError> {
        stroke.torn = true;
        self.gpu.check()?;
        let touched = stroke.touched();
        if !touched.is_empty() {
            pools.wrote_slots(stroke.key(), &touched);
            let (texture, variant) = shown(stroke, pools, fields.get(stroke.kind()))?;
            let pipeline =
                self.kernel.pipeline(&self.gpu, &kernel::conditions(variant, true, &stroke.brush), &[], &[])?;
            let label = wgpu::CommandEncoderDescriptor { label: Some("dabs taken back") };
            let mut encoder = self.gpu.device.create_command_encoder(&label);
            stroke.begin_gathering(&touched, &mut encoder, texture);
            for buffers in &stroke.buffers {
                buffers.clear_changed(&mut encoder, 0..buffers.bricks.len());
            }
            stroke.gathered();
            self.lock(stroke, false);
            let footprints = stroke.footprints(&stroke.dabs);
            self.dispatcher.submit(&self.gpu, (&self.kernel, &pipeline), stroke, &footprints, encoder, texture)?;
            if live_cells::matters(stroke.kind()) {
                let (dims, key) = (stroke.grid.dims, stroke.key());
                let whole = IndexBox { lo: [0; 3], end: dims };
                stroke.live.paint(&touched.into_iter().map(|brick| (brick, whole)).collect(), dims, key, pools);
            }
        }
        stroke.torn = false;
        Ok(())
    }

    /// Takes what has come of the minima and maxima of a stroke's cells, and asks for those of what was painted since. Never waits.
    pub(crate) fn follow(
        &mut self,
        stroke: &mut Stroke,
        pools: &mut FieldPools,
        fields: &VolumeFields<'_>,
    ) -> Result<(), GpuError> {
        let (key, target) = (stroke.key(), fields.get(stroke.kind()));
        let Some(format) = pools.format(key) else { return Ok(()) };
        let variant = Variant::of(target.format(), format);
        stroke.live.follow(&self.gpu, (key, target), variant, &mut self.cells, pools)?;
        let Some(texture) = pools.texture(key) else { return Ok(()) };
        stroke.live.ask(&self.gpu, variant, &mut self.cells, texture, stroke.grid.dims)
    }

    /// The bricks of a stroke's volume whose own texels differ from those at its start, in order. Waits for the GPU.
    pub(crate) fn changed(
        &mut self,
        stroke: &Stroke,
        pools: &FieldPools,
        fields: &VolumeFields<'_>,
    ) -> Result<Vec<(BrickIndex, Brick)>, GpuError> {
        let touched = stroke.slots.iter().map(|(brick, slot)| (*brick, slot));
        let field = (stroke.key(), fields.get(stroke.kind()));
        self.answers.changed(&self.gpu, pools, field, &stroke.buffers, touched.collect())
    }

    /// A brick as a stroke shows it. Waits for the GPU.
    pub(crate) fn live(
        &self,
        stroke: &Stroke,
        pools: &FieldPools,
        fields: &VolumeFields<'_>,
        brick: BrickIndex,
    ) -> Result<Option<Brick>, GpuError> {
        let wanted = stroke.slots.get(&brick).map(|slot| (brick, slot));
        let field = (stroke.key(), fields.get(stroke.kind()));
        let shown = Answers::default().bricks(&self.gpu, pools, field, wanted.as_slice(), &Flags(&[]))?;
        Ok(shown.into_iter().next().map(|(_, brick)| brick))
    }

    /// Keeps the buffers of a stroke that is over.
    pub(crate) fn keep(&mut self, stroke: Stroke) {
        let mut kept: u64 = self.spare.iter().map(StrokeBuffers::bytes).sum();
        for mut buffers in stroke.buffers {
            if kept + buffers.bytes() <= KEPT {
                kept += buffers.bytes();
                buffers.bricks.clear();
                self.spare.push(buffers);
            }
        }
    }

    /// Lets the kernel read the labels that are locked on a stroke's volume.
    fn lock(&mut self, stroke: &Stroke, begins: bool) {
        if begins || self.locked_of != Some(stroke.volume) {
            self.dispatcher.lock(&self.gpu, &stroke.locked);
            self.locked_of = Some(stroke.volume);
        }
    }
}

/// The texture that a stroke's slots lie in, and how its texels are written.
fn shown<'a>(stroke: &Stroke, pools: &'a FieldPools, target: &Field) -> Result<(&'a wgpu::Texture, Variant), GpuError> {
    let (Some(texture), Some(format)) = (pools.texture(stroke.key()), pools.format(stroke.key())) else {
        return Err(GpuError::Stroke("the pools hold no slots of the field"));
    };
    Ok((texture, Variant::of(target.format(), format)))
}

/// The fields of the volume that is painted.
pub(crate) fn of<'a>(fields: &Fields<'a>, volume: VolumeId) -> Result<VolumeFields<'a>, GpuError> {
    fields.get(volume).copied().ok_or(GpuError::NoVolume { id: volume.0 })
}
