//! Dabs on their way to the GPU: in parts, so that no submission holds the queue for long, however long the stroke.
//!
//! Owns the encoding of a [`Plan`]'s dispatches and copies. Uniforms are written anew for every part, ordered before its
//! submissions by the queue.

use crate::gpu::brush::buffers::{Chunk, at, rows};
use crate::gpu::brush::kernel::{BrushStroke, DABS_BYTES, ITEMS_BYTES, Variant};
use crate::gpu::brush::painter::{NOT_RUNNING, Painter};
use crate::gpu::brush::plan::{Dispatch, GROUP_DABS, MOST_COST, Plan, groups};
use crate::gpu::brush::stroke::Stroke;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::paint::{Dab, Footprint, IndexBox};
use crate::volume::BrickIndex;
use std::collections::BTreeMap;

/// Dabs that are planned together.
const PART: usize = 16 * GROUP_DABS;

/// By brick whose slot shows any of the dabs: a box of voxels around what they change in it.
pub(crate) fn met(dabs: &[Dab], stroke: &Stroke) -> BTreeMap<BrickIndex, IndexBox> {
    let mut met: BTreeMap<BrickIndex, IndexBox> = BTreeMap::new();
    for footprint in footprints(dabs, stroke) {
        for brick in footprint.bounds.slots(stroke.grid.dims) {
            met.entry(brick).and_modify(|b| *b = b.union(&footprint.bounds)).or_insert(footprint.bounds);
        }
    }
    met
}

fn footprints(dabs: &[Dab], stroke: &Stroke) -> impl Iterator<Item = Footprint> {
    dabs.iter().filter_map(|d| d.footprint(&stroke.brush, &stroke.grid))
}

impl Painter {
    /// Submits dabs on slots that the stroke has taken. `encoder` has what is to be done before.
    pub(crate) fn submit(
        &mut self,
        encoder: wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        pipeline: &wgpu::ComputePipeline,
        variant: Variant,
        dabs: &[Dab],
        begins: bool,
    ) -> Result<(), GpuError> {
        use wgpu::BufferUsages as Use;
        let Self { gpu, kernels, uniforms, next, jobs, locked, nothing, stroke, submits, .. } = self;
        let Some(stroke) = stroke else { return Err(NOT_RUNNING) };
        let new_encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("dabs") });
        gpu.scoped("dabs", || {
            let mut encoder = encoder;
            let mut send = |encoder: &mut wgpu::CommandEncoder| {
                let done = std::mem::replace(encoder, new_encoder());
                gpu.queue.submit([done.finish()]);
                *submits += 1;
            };
            if begins {
                gpu.queue.write_buffer(locked, 0, bytemuck::cast_slice(&stroke.locked));
            }
            let mut cost = 0;
            for (i, part) in dabs.chunks(PART).enumerate() {
                if i > 0 {
                    send(&mut encoder);
                    cost = 0;
                }
                let footprints: Vec<_> = footprints(part, stroke).collect();
                let plan = Plan::new(stroke, &groups(&footprints, stroke.grid.dims), variant);
                grow(gpu, uniforms, plan.uniforms.len() as u64, Use::UNIFORM | Use::COPY_DST);
                grow(gpu, next, plan.next_bytes, Use::STORAGE | Use::COPY_SRC);
                grow(gpu, jobs, plan.jobs.len() as u64 * 4, Use::STORAGE | Use::COPY_DST);
                gpu.queue.write_buffer(uniforms, 0, &plan.uniforms);
                gpu.queue.write_buffer(jobs, 0, bytemuck::cast_slice(&plan.jobs));
                let groups: Vec<_> = stroke
                    .chunks
                    .iter()
                    .map(|chunk| bind(gpu, &kernels.layout, chunk, [&*uniforms, next, jobs, locked, nothing]))
                    .collect();
                for dispatch in &plan.dispatches {
                    if cost > 0 && cost + dispatch.cost > MOST_COST {
                        send(&mut encoder);
                        cost = 0;
                    }
                    cost += dispatch.cost;
                    encode(&mut encoder, dispatch, pipeline, &groups[dispatch.chunk], next, texture);
                }
            }
            send(&mut encoder);
            Ok(())
        })
    }
}

fn encode(
    encoder: &mut wgpu::CommandEncoder,
    dispatch: &Dispatch,
    pipeline: &wgpu::ComputePipeline,
    group: &wgpu::BindGroup,
    next: &wgpu::Buffer,
    texture: &wgpu::Texture,
) {
    {
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("dabs"), timestamp_writes: None });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[dispatch.dabs_at, dispatch.items_at]);
        pass.dispatch_workgroups(dispatch.workgroups, 1, 1);
    }
    for copy in &dispatch.copies {
        encoder.copy_buffer_to_texture(rows(next, copy.offset, copy.rows), at(texture, copy.to), copy.extent);
    }
}

fn bind(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    chunk: &Chunk,
    [uniforms, next, jobs, locked, nothing]: [&wgpu::Buffer; 5],
) -> wgpu::BindGroup {
    let part = |size: u64| {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: uniforms,
            offset: 0,
            size: std::num::NonZero::new(size),
        })
    };
    let resources = [
        part(size_of::<BrushStroke>() as u64),
        part(DABS_BYTES),
        part(ITEMS_BYTES),
        chunk.start.as_entire_binding(),
        chunk.coverage.as_entire_binding(),
        next.as_entire_binding(),
        chunk.changed.as_entire_binding(),
        chunk.base.as_ref().unwrap_or(nothing).as_entire_binding(),
        chunk.gate.as_ref().unwrap_or(nothing).as_entire_binding(),
        locked.as_entire_binding(),
        jobs.as_entire_binding(),
    ];
    let entries: Vec<_> =
        (0_u32..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("brush"), layout, entries: &entries })
}

pub(crate) fn buffer(gpu: &Gpu, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

/// A larger buffer in place of one that is too small; its content does not outlive a frame.
fn grow(gpu: &Gpu, held: &mut wgpu::Buffer, bytes: u64, usage: wgpu::BufferUsages) {
    if held.size() < bytes {
        *held = buffer(gpu, "brush", bytes.next_power_of_two(), usage);
    }
}
