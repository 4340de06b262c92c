//! What counting how much of the selection is seen keeps on the GPU: its kernel and the buffers of its answer.

use crate::gpu::device::constants::MOST_BODIES;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::Binding;
use crate::gpu::device::kernel::Compute;
use crate::gpu::device::kernel::Kernel;
use crate::gpu::device::shader::shader;

/// What counting needs on the GPU.
#[derive(Debug)]
pub(crate) struct Counter {
    pub(crate) kernel: Kernel<Compute>,
    pub(crate) counts: wgpu::Buffer,
    pub(crate) answer: wgpu::Buffer,
}

impl Counter {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let size = 4 * (u64::from(MOST_BODIES) + 2);
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        Self {
            kernel: Kernel::new(gpu, shader!("cast/visibility.wgsl"), Compute("count"), &[Binding::Storage]),
            counts: buffer("visibility counts", usage),
            answer: buffer("visibility answer", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
        }
    }
}
