//! The kernel of surface particles: its task, its two dispatches and the way back to the host.

use crate::gpu::device::constants::MOST_VOLUMES;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::trace::reach::{TracedVolume, first_mm, reached, traced_volumes};
use crate::gpu::trace::request::{Bend, GridRequest, Heading, TracedGrid, TracedVertex};
use crate::math::DVec3;
use crate::shared_struct;

/// Particles of a workgroup.
const AT_ONCE: u32 = 8;

shared_struct! {
    /// What particles do.
    pub(super) struct TraceTask {
        /// The picked orientation, unit.
        pub orientation: [f32; 3],
        /// Distance of neighbours, mm.
        pub step_mm: f32,
        /// Steps of the middle row, either way.
        pub steps_along: u32,
        /// Steps from it, either way.
        pub steps_across: u32,
        /// Volumes that tell density.
        pub family: u32,
        /// How far from the surface is on it, mm.
        pub tolerance_mm: f32,
        /// How far the picked place may be off, mm.
        pub first_mm: f32,
        /// Whether the surface is to bend least along the middle row.
        pub least: u32,
        /// Unused.
        pub pad_a: u32,
        /// Unused.
        pub pad_b: u32,
    }
}

shared_struct! {
    /// A vertex of the grid.
    pub(super) struct TraceVertex {
        /// World mm from the picked point.
        pub position: [f32; 3],
        /// 1 where the surface goes on as far as here.
        pub on: u32,
        /// Unit, toward lower values.
        pub normal: [f32; 3],
        /// Values per mm against it.
        pub slope: f32,
    }
}

/// Traces grids over iso-surfaces.
#[derive(Debug)]
pub struct Tracer {
    spine: Kernel<Compute>,
    ribs: Kernel<Compute>,
    volumes: wgpu::Buffer,
    task: wgpu::Buffer,
    grown: Grown,
}

/// Buffers for grids of up to so many vertices.
#[derive(Debug)]
struct Grown {
    vertices: wgpu::Buffer,
    across: wgpu::Buffer,
    answer: wgpu::Buffer,
}

fn buffer(gpu: &Gpu, label: &str, size: usize, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let size = size as u64;
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

impl Grown {
    fn new(gpu: &Gpu, vertices: usize, columns: usize) -> Self {
        use wgpu::BufferUsages as Use;
        let bytes = vertices * size_of::<TraceVertex>();
        Self {
            vertices: buffer(gpu, "traced vertices", bytes, Use::STORAGE | Use::COPY_SRC | Use::COPY_DST),
            across: buffer(gpu, "traced directions", columns * 16, Use::STORAGE),
            answer: buffer(gpu, "traced grid", bytes, Use::MAP_READ | Use::COPY_DST),
        }
    }
}

impl Tracer {
    /// Makes what all grids share.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as Use;
        gpu.scoped("surface particles", || {
            let volumes_bytes = MOST_VOLUMES as usize * size_of::<TracedVolume>();
            let bindings = [
                Binding::Uniform(volumes_bytes),
                Binding::Elements { bytes: size_of::<TraceTask>(), written: false },
                Binding::Elements { bytes: size_of::<TraceVertex>(), written: true },
                Binding::Elements { bytes: 16, written: true },
            ];
            let file = shader!("trace/particles.wgsl");
            Ok(Self {
                spine: Kernel::new(gpu, file, Compute("spine"), &bindings),
                ribs: Kernel::new(gpu, file, Compute("ribs"), &bindings),
                volumes: buffer(gpu, "traced volumes", volumes_bytes, Use::UNIFORM | Use::COPY_DST),
                task: buffer(gpu, "surface particles", size_of::<TraceTask>(), Use::STORAGE | Use::COPY_DST),
                grown: Grown::new(gpu, 81 * 81, 81),
            })
        })
    }

    /// Traces a grid from its centre on, as far as the surface goes. Where density is paged, the bricks about the grid are made resident
    /// at full resolution for as long as it takes.
    ///
    /// # Errors
    /// A request of numbers that are none, or of more steps than fit; [`GpuError::GridTooLarge`]; a volume that `fields` has not; a source
    /// that fails; out of memory, or a lost device.
    pub fn grid(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        request: &GridRequest,
    ) -> Result<TracedGrid, GpuError> {
        request.check()?;
        let reached = reached(request, fields)?;
        let done = pools
            .make_reached_resident(gpu, fields, &request.volumes(), &reached)
            .and_then(|()| self.traced(gpu, pools, fields, request));
        pools.let_go_of_reached();
        done
    }

    fn traced(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        fields: &Fields<'_>,
        request: &GridRequest,
    ) -> Result<TracedGrid, GpuError> {
        let volumes = traced_volumes(request, fields, pools)?;
        let voxel_mm = volumes.iter().map(|volume| volume.voxel_mm).fold(f32::INFINITY, f32::min);
        let task = TraceTask {
            orientation: request.along.normalize_or_zero().as_vec3().to_array(),
            step_mm: request.step_mm as f32,
            steps_along: request.steps[0],
            steps_across: request.steps[1],
            family: request.family.len() as u32,
            tolerance_mm: (request.tolerance_mm as f32).max(voxel_mm * 1e-4),
            first_mm: first_mm(request, fields) as f32,
            least: u32::from(request.heading == Heading::Curvature(Bend::Least)),
            pad_a: 0,
            pad_b: 0,
        };
        let mut names: Vec<&'static str> = pools.defs(gpu).into_iter().map(|def| def.0).collect();
        let [spine, ribs] = {
            let family = (request.family.len() > 1).then_some("BOXES");
            let layout = [pools.layout()];
            names.extend(family);
            let ribs = self.ribs.pipeline(gpu, &names, &[], &layout)?;
            names.extend(match request.heading {
                Heading::Straight => None,
                Heading::Vectors(_) => Some("VECTORS"),
                Heading::Curvature(_) => Some("CURVATURE"),
            });
            [self.spine.pipeline(gpu, &names, &[], &layout)?, ribs]
        };
        let [columns, rows] = request.steps.map(|n| 2 * n as usize + 1);
        let bytes = (columns * rows * size_of::<TraceVertex>()) as u64;
        let seen = gpu.scoped("a grid on a surface", || {
            if self.grown.vertices.size() < bytes || self.grown.across.size() < columns as u64 * 16 {
                self.grown = Grown::new(gpu, columns * rows, columns);
            }
            gpu.queue.write_buffer(&self.volumes, 0, bytemuck::cast_slice(&volumes));
            gpu.queue.write_buffer(&self.task, 0, bytemuck::bytes_of(&task));
            let Grown { vertices, across, answer } = &self.grown;
            let mut encoder =
                gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("surface particles") });
            encoder.clear_buffer(vertices, 0, Some(bytes));
            {
                let timestamp_writes = gpu.compute_times("surface particles");
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("surface particles"),
                    timestamp_writes,
                });
                let particles = [2, 2 * columns as u32];
                for ((kernel, pipeline), count) in [(&self.spine, spine), (&self.ribs, ribs)].into_iter().zip(particles)
                {
                    let buffers = [&self.volumes, &self.task, vertices, across];
                    let group = kernel.group(gpu, buffers.map(wgpu::Buffer::as_entire_binding));
                    pass.set_pipeline(&pipeline);
                    pass.set_bind_group(0, group.as_ref(), &[]);
                    pass.set_bind_group(1, pools.group(), &[]);
                    pass.dispatch_workgroups(count.div_ceil(AT_ONCE), 1, 1);
                }
            }
            encoder.copy_buffer_to_buffer(vertices, 0, answer, 0, bytes);
            gpu.queue.submit([encoder.finish()]);
            let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
            gpu.look_into(answer, bytes, "a grid on a surface", |bytes| {
                let vertices = bytes.chunks_exact(size_of::<TraceVertex>()).map(bytemuck::pod_read_unaligned);
                let vertex = |v: TraceVertex| {
                    (v.on != 0).then(|| TracedVertex { at: request.centre + wide(v.position), normal: wide(v.normal) })
                };
                vertices.map(vertex).collect::<Vec<_>>()
            })
        })?;
        Ok(TracedGrid { steps: request.steps, vertices: seen })
    }
}
