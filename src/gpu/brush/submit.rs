//! Dabs on their way to the GPU: in parts, so that no submission holds the queue for long, however long the stroke.
//!
//! Owns the encoding of a [`Plan`]'s dispatches and copies, and the buffers of a frame's work. Uniforms are written anew for every
//! part, ordered before its submissions by the queue. Reads a stroke that has taken its slots; does not know when one begins or ends.

use crate::gpu::brush::buffers::{StrokeBuffers, at, rows};
use crate::gpu::brush::kernel::{BrushStroke, DABS_BYTES, ITEMS_BYTES};
use crate::gpu::brush::plan::{Dispatch, GROUP_DABS, MOST_COST, Plan, groups};
use crate::gpu::brush::stroke::Stroke;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Compute, Kernel};
use crate::paint::Footprint;
use wgpu::BufferUsages as Use;

/// Dabs that are planned together.
const PART: usize = 16 * GROUP_DABS;

/// See the file's head. Long-lived; nothing in the buffers but the locked labels outlives a frame.
#[derive(Debug)]
pub(crate) struct Dispatcher {
    uniforms: wgpu::Buffer,
    /// New texels of a dispatch, on their way into the slots.
    next: wgpu::Buffer,
    /// What each workgroup does.
    jobs: wgpu::Buffer,
    locked: wgpu::Buffer,
    /// Bound where a stroke has no use for a buffer.
    nothing: wgpu::Buffer,
    /// Submissions so far.
    pub(crate) submits: u64,
}

impl Dispatcher {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            uniforms: buffer(gpu, "brush uniforms", 1 << 16, Use::UNIFORM | Use::COPY_DST),
            next: buffer(gpu, "brush texels", 1 << 20, Use::STORAGE | Use::COPY_SRC),
            jobs: buffer(gpu, "brush jobs", 1 << 14, Use::STORAGE | Use::COPY_DST),
            locked: buffer(gpu, "brush locked", 65_536 / 8, Use::STORAGE | Use::COPY_DST),
            nothing: buffer(gpu, "brush nothing", 16, Use::STORAGE),
            submits: 0,
        }
    }

    /// Which labels are kept from now on, a bit for each.
    pub(crate) fn lock(&self, gpu: &Gpu, locked: &[u32]) {
        gpu.queue.write_buffer(&self.locked, 0, bytemuck::cast_slice(locked));
    }

    /// Submits dabs on slots that the stroke has taken. `encoder` has what is to be done before.
    pub(crate) fn submit(
        &mut self,
        gpu: &Gpu,
        (kernel, pipeline): (&Kernel<Compute>, &wgpu::ComputePipeline),
        stroke: &Stroke,
        footprints: &[Footprint],
        encoder: wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> Result<(), GpuError> {
        let new_encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("dabs") });
        gpu.scoped("dabs", || {
            let mut encoder = encoder;
            let mut cost = 0;
            let mut submits = 0;
            let mut send = |encoder: &mut wgpu::CommandEncoder| {
                let done = std::mem::replace(encoder, new_encoder());
                gpu.queue.submit([done.finish()]);
                submits += 1;
            };
            for (i, part) in footprints.chunks(PART).enumerate() {
                if i > 0 {
                    send(&mut encoder);
                    cost = 0;
                }
                let plan = Plan::new(stroke, &groups(part, stroke.grid.dims));
                grow(gpu, &mut self.uniforms, plan.uniforms.len() as u64, Use::UNIFORM | Use::COPY_DST);
                grow(gpu, &mut self.next, plan.next_bytes, Use::STORAGE | Use::COPY_SRC);
                grow(gpu, &mut self.jobs, plan.jobs.len() as u64 * 4, Use::STORAGE | Use::COPY_DST);
                gpu.queue.write_buffer(&self.uniforms, 0, &plan.uniforms);
                gpu.queue.write_buffer(&self.jobs, 0, bytemuck::cast_slice(&plan.jobs));
                let groups: Vec<_> = stroke.buffers.iter().map(|buffers| self.bind(gpu, kernel, buffers)).collect();
                for dispatch in &plan.dispatches {
                    if cost > 0 && cost + dispatch.cost > MOST_COST {
                        send(&mut encoder);
                        cost = 0;
                    }
                    cost += dispatch.cost;
                    encode(
                        gpu,
                        &mut encoder,
                        dispatch,
                        pipeline,
                        groups[dispatch.buffers].as_ref(),
                        &self.next,
                        texture,
                    );
                }
            }
            send(&mut encoder);
            self.submits += submits;
            Ok(())
        })
    }

    fn bind(&self, gpu: &Gpu, kernel: &Kernel<Compute>, buffers: &StrokeBuffers) -> Option<wgpu::BindGroup> {
        let Self { uniforms, next, jobs, locked, nothing, .. } = self;
        let part = |size: u64| {
            let size = std::num::NonZero::new(size);
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: uniforms, offset: 0, size })
        };
        let resources = [
            part(size_of::<BrushStroke>() as u64),
            part(DABS_BYTES),
            part(ITEMS_BYTES),
            buffers.start.as_entire_binding(),
            buffers.coverage.as_entire_binding(),
            next.as_entire_binding(),
            buffers.changed.as_entire_binding(),
            buffers.base.as_ref().unwrap_or(nothing).as_entire_binding(),
            buffers.gate.as_ref().unwrap_or(nothing).as_entire_binding(),
            locked.as_entire_binding(),
            jobs.as_entire_binding(),
        ];
        kernel.group(gpu, resources)
    }
}

fn encode(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    dispatch: &Dispatch,
    pipeline: &wgpu::ComputePipeline,
    group: Option<&wgpu::BindGroup>,
    next: &wgpu::Buffer,
    texture: &wgpu::Texture,
) {
    {
        let timestamp_writes = gpu.compute_times("dabs");
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("dabs"), timestamp_writes });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[dispatch.dabs_at, dispatch.items_at]);
        pass.dispatch_workgroups(dispatch.workgroups, 1, 1);
    }
    for copy in &dispatch.copies {
        encoder.copy_buffer_to_texture(rows(next, copy.offset, copy.rows), at(texture, copy.to), copy.extent);
    }
}

fn buffer(gpu: &Gpu, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

/// A larger buffer in place of one that is too small; its content does not outlive a frame.
fn grow(gpu: &Gpu, held: &mut wgpu::Buffer, bytes: u64, usage: wgpu::BufferUsages) {
    if held.size() < bytes {
        *held = buffer(gpu, "brush", bytes.next_power_of_two(), usage);
    }
}
