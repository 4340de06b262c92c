//! Opaque meshes as a picture of their own: shaders/mesh/opaque.wgsl.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Draw, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::device::textures::{COLOUR, DEPTH, OBJECT, Targets};
use crate::gpu::layers::meshes::{Meshes, Placed, nearest, orders, raster};
use crate::gpu::layers::{MESH_CODE, Rays};
use crate::gpu::picture::layer::OpaqueMesh;

/// Draws opaque meshes into colour, depth along the ray in mm, and number of the mesh.
#[derive(Debug)]
pub(crate) struct Opaque {
    kernel: Kernel<Draw>,
    meshes: Meshes,
}

impl Opaque {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let entry = raster("surface", &[COLOUR, DEPTH, OBJECT]);
        Self {
            kernel: Kernel::new(gpu, shader!("mesh/opaque.wgsl"), entry, &Meshes::BINDINGS),
            meshes: Meshes::default(),
        }
    }

    /// The nearest surfaces, nothing elsewhere; `None` if there are no triangles.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        meshes: &[OpaqueMesh],
        rays: &Rays<'_>,
    ) -> Result<Option<Targets>, GpuError> {
        let placed: Vec<_> = (0..)
            .zip(meshes)
            .map(|(i, m)| Placed {
                mesh: &m.mesh,
                pose: &m.pose,
                code: MESH_CODE | i,
                colour: m.colour,
                lighting: m.lighting,
            })
            .collect();
        let Some(meshes) = self.meshes.bring(gpu, &placed, rays.eye)? else { return Ok(None) };
        let pipeline = self.kernel.pipeline(gpu, &[], &[Some(rays.layout), None], &[])?;
        let own = self.kernel.group(gpu, meshes.resources());
        let targets = Targets::new(gpu, rays.size);
        let orders = orders(gpu, rays.size);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("opaque") });
        {
            let views = targets.views();
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("opaque"),
                color_attachments: &Targets::attachments(&views, true),
                depth_stencil_attachment: Some(nearest(&orders)),
                ..Default::default()
            });
            meshes.draw(&mut pass, &pipeline, rays.group, own.as_ref());
        }
        gpu.queue.submit([encoder.finish()]);
        Ok(Some(targets))
    }
}
