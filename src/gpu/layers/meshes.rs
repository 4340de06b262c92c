//! Meshes on the device: one list of corners and one of triangles for all meshes of a kind, and where each of them stands.
//!
//! Owns what `shaders/lib/mesh.wgsl` binds first. Arrays are uploaded when other meshes come, places with every picture.

use crate::gpu::device::constants::MOST_MESHES;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Draw};
use crate::gpu::device::textures::texture;
use crate::math::{DVec3, Pose};
use crate::mesh::TriangleMesh;
use crate::shared_struct;
use crate::volume::Lighting;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// Triangles of a kind that fit into one picture: their numbers, doubled, are 32-bit.
const MOST_TRIANGLES: usize = 1 << 28;
const ORDER: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

shared_struct! {
    /// Where a mesh lies and how it is drawn.
    pub(crate) struct MeshPlace {
        /// world_from_mesh, first column.
        pub column_x: [f32; 3],
        /// What the picture's object id says.
        pub code: u32,
        /// Second column.
        pub column_y: [f32; 3],
        /// Depth of 1 mm, a power of two so that no two lengths become one.
        pub order: f32,
        /// Third column.
        pub column_z: [f32; 3],
        /// Unused.
        pub unused_a: u32,
        /// Origin of the mesh's space as seen from the eye.
        pub origin: [f32; 3],
        /// Unused.
        pub unused_b: u32,
        /// Display-referred.
        pub colour: [f32; 3],
        /// Unused.
        pub unused_c: u32,
        /// Ambient, diffuse, specular, power.
        pub lighting: [f32; 4],
    }
}

/// A mesh of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub mesh: &'a Arc<TriangleMesh>,
    pub pose: &'a Pose,
    pub code: u32,
    pub colour: [f32; 3],
    pub lighting: Option<Lighting>,
}

/// The corners and triangles of a frame's meshes, in world mm, on the device.
#[derive(Debug, Default)]
pub(crate) struct Meshes {
    held: Option<Held>,
}

/// Meshes of a picture, on the device.
#[derive(Debug)]
pub(crate) struct Held {
    meshes: Vec<Arc<TriangleMesh>>,
    corners: wgpu::Buffer,
    triangles: wgpu::Buffer,
    places: wgpu::Buffer,
    /// Corners of all triangles.
    vertices: u32,
}

impl Meshes {
    /// What a kernel over meshes binds first.
    pub(crate) const BINDINGS: [Binding; 3] = [
        Binding::Uniform(MOST_MESHES as usize * size_of::<MeshPlace>()),
        Binding::Elements { bytes: 4, written: false },
        Binding::Elements { bytes: 16, written: false },
    ];

    /// Brings the meshes of a picture to the device, but for those that are there; `None` if they have no triangle.
    ///
    /// # Errors
    /// More than fit, or more than the device has room for.
    pub(crate) fn bring(&mut self, gpu: &Gpu, placed: &[Placed<'_>], eye: DVec3) -> Result<Option<&Held>, GpuError> {
        let triangles = placed.iter().map(|p| p.mesh.triangles().len()).sum::<usize>();
        if placed.len() > MOST_MESHES as usize || triangles > MOST_TRIANGLES {
            return Err(GpuError::TooManyMeshes { meshes: placed.len(), triangles });
        }
        let same = |h: &Held| h.meshes.iter().map(Arc::as_ptr).eq(placed.iter().map(|p| Arc::as_ptr(p.mesh)));
        let Some(held) = self.held.take().filter(same).or_else(|| Held::new(gpu, placed, triangles as u32)) else {
            return Ok(None);
        };
        let order = order(placed, eye);
        let places: Vec<MeshPlace> = placed.iter().map(|p| place(p, eye, order)).collect();
        gpu.queue.write_buffer(&held.places, 0, bytemuck::cast_slice(&places));
        Ok(Some(self.held.insert(held)))
    }
}

impl Held {
    fn new(gpu: &Gpu, placed: &[Placed<'_>], triangle_count: u32) -> Option<Self> {
        if triangle_count == 0 {
            return None;
        }
        let (mut corners, mut triangles) = (Vec::new(), Vec::with_capacity(triangle_count as usize));
        for (mesh, p) in (0_u32..).zip(placed) {
            let first = corners.len() as u32;
            corners.extend_from_slice(p.mesh.corners());
            triangles.extend(p.mesh.triangles().iter().map(|&[a, b, c]| [first + a, first + b, first + c, mesh]));
        }
        let list = |label, contents| {
            let usage = wgpu::BufferUsages::STORAGE;
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        Some(Self {
            meshes: placed.iter().map(|p| Arc::clone(p.mesh)).collect(),
            corners: list("mesh corners", bytemuck::cast_slice(&corners)),
            triangles: list("mesh triangles", bytemuck::cast_slice(&triangles)),
            places: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("mesh places"),
                size: u64::from(MOST_MESHES) * size_of::<MeshPlace>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            vertices: 3 * triangle_count,
        })
    }

    /// In the order of [`Meshes::BINDINGS`].
    pub(crate) fn resources(&self) -> [wgpu::BindingResource<'_>; 3] {
        [&self.places, &self.corners, &self.triangles].map(wgpu::Buffer::as_entire_binding)
    }

    /// Draws all triangles within a pass: group 0 is the picture's, group 2 the kernel's own.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        rays: &wgpu::BindGroup,
        own: Option<&wgpu::BindGroup>,
    ) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, rays, &[]);
        pass.set_bind_group(2, own, &[]);
        pass.draw(0..self.vertices, 0..1);
    }
}

/// The depths by which the nearest triangle is found.
pub(crate) fn orders(gpu: &Gpu, size: [u32; 2]) -> wgpu::TextureView {
    texture(gpu, "mesh order", size, ORDER, wgpu::TextureUsages::RENDER_ATTACHMENT).create_view(&Default::default())
}

/// A pass begins with nothing, and keeps the nearest of what it draws.
pub(crate) fn nearest(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard };
    wgpu::RenderPassDepthStencilAttachment { view, depth_ops: Some(ops), stencil_ops: None }
}

/// How triangles are drawn: both of their sides, the nearest of them.
pub(crate) fn raster(fragment: &'static str, targets: &[wgpu::TextureFormat]) -> Draw {
    Draw { vertex: "corner", depth: Some(ORDER), ..Draw::cover(fragment, targets) }
}

fn place(p: &Placed<'_>, eye: DVec3, order: f32) -> MeshPlace {
    let narrow = |v: DVec3| v.as_vec3().to_array();
    let world_from_mesh = p.pose.world_from_rest();
    let matrix = world_from_mesh.matrix3;
    // Unlit: all of its colour, and nothing of the light.
    let lighting = p.lighting.map_or([1.0, 0.0, 0.0, 1.0], |l| [l.ambient, l.diffuse, l.specular, l.power]);
    MeshPlace {
        column_x: narrow(matrix.x_axis),
        code: p.code,
        column_y: narrow(matrix.y_axis),
        order,
        column_z: narrow(matrix.z_axis),
        unused_a: 0,
        origin: narrow(world_from_mesh.translation - eye),
        unused_b: 0,
        colour: p.colour,
        unused_c: 0,
        lighting,
    }
}

/// A power of two that brings every length along a ray to a corner below 1: depths then sort as the lengths do, to the last bit.
fn order(placed: &[Placed<'_>], eye: DVec3) -> f32 {
    let reach = |p: &Placed<'_>| p.pose.apply(DVec3::ZERO).distance(eye) + p.mesh.radius_mm();
    let farthest = placed.iter().map(reach).fold(1e-30, f64::max);
    // Twice as far: a ray in orthographic projection begins beside the eye, and numbers are rounded.
    (-farthest.log2().ceil() - 1.0).exp2() as f32
}
