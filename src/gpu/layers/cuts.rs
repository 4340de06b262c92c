//! Closed meshes that cut, as spans of every pixel's ray: shaders/mesh/peel.wgsl and shaders/mesh/spans.wgsl.
//!
//! Faces are peeled one behind another until a peel meets none: how many there are is known only then, so the device is asked
//! between, usually once. Owns how many the last picture needed.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Draw, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::device::textures::COLOUR;
use crate::gpu::layers::meshes::{Held, Meshes, Placed, nearest, orders, raster};
use crate::gpu::layers::{Rays, array_view, layers};
use crate::gpu::picture::layer::CutMesh;

/// Faces of cutting meshes one behind another in any pixel.
const MOST_FACES: u32 = 128;
const FACE: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
/// No face, in every bit: greater than any length.
const NOTHING: f64 = u32::MAX as f64;
const GROUP: u32 = 8;

/// Peels closed meshes and joins their faces into sorted spans of a ray, in mm along it.
#[derive(Debug)]
pub(crate) struct Cuts {
    first: Kernel<Draw>,
    later: Kernel<Draw>,
    join: Kernel<Compute>,
    /// On the device, by class of bodies: what cuts one is another list than what cuts the others.
    meshes: Vec<Meshes>,
    /// Peels of the last picture.
    peels: u32,
}

impl Cuts {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let array = wgpu::TextureViewDimension::D2Array;
        let faces = Binding::Texture(array, wgpu::TextureSampleType::Uint);
        let bindings = |more: &[Binding]| [&Meshes::BINDINGS[..], more].concat();
        let peel = |more| Kernel::new(gpu, shader!("mesh/peel.wgsl"), raster("peel", &[FACE]), &bindings(more));
        let joined = bindings(&[faces, Binding::Written(array, COLOUR)]);
        Self {
            first: peel(&[]),
            later: peel(&[Binding::UINT_2D]),
            join: Kernel::new(gpu, shader!("mesh/spans.wgsl"), Compute("join"), &joined),
            meshes: Vec::new(),
            peels: 3,
        }
    }

    /// Spans as shaders/lib/layers.wgsl reads them; `None` where no ray meets a mesh.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        (class, cuts): (usize, &[CutMesh]),
        rays: &Rays<'_>,
    ) -> Result<Option<wgpu::Texture>, GpuError> {
        let placed: Vec<_> = cuts
            .iter()
            .map(|c| Placed { mesh: &c.mesh, pose: &c.pose, code: 0, colour: [0.0; 3], lighting: None })
            .collect();
        let Self { first, later, join, meshes, peels } = self;
        meshes.resize_with(meshes.len().max(class + 1), Meshes::default);
        let Some(meshes) = meshes[class].bring(gpu, &placed, rays.eye)? else { return Ok(None) };
        let before = [Some(rays.layout), None];
        let pipelines = [first.pipeline(gpu, &[], &before, &[])?, later.pipeline(gpu, &["LATER"], &before, &[])?];
        loop {
            let faces = layers(gpu, "faces", rays.size, *peels, FACE, wgpu::TextureUsages::RENDER_ATTACHMENT);
            let met = peel(gpu, [first, later], &pipelines, meshes, rays, &faces)?;
            match met {
                Some(0) => return Ok(None),
                Some(met) => {
                    *peels = met + 1;
                    return spans(gpu, join, meshes, rays, &faces, met).map(Some);
                }
                None if *peels >= MOST_FACES => return Err(GpuError::TooManyFaces { most: MOST_FACES }),
                None => *peels = (2 * *peels).min(MOST_FACES),
            }
        }
    }
}

/// Peels as many faces as `faces` has layers; answers the number of peels before the first that met none, `None` if all met some.
fn peel(
    gpu: &Gpu,
    kernels: [&Kernel<Draw>; 2],
    pipelines: &[wgpu::RenderPipeline; 2],
    meshes: &Held,
    rays: &Rays<'_>,
    faces: &wgpu::Texture,
) -> Result<Option<u32>, GpuError> {
    let count = faces.depth_or_array_layers();
    let bytes = 8 * u64::from(count);
    let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
        label: Some("faces met"),
        ty: wgpu::QueryType::Occlusion,
        count,
    });
    let buffer = |usage| {
        let label = Some("faces met");
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size: bytes, usage, mapped_at_creation: false })
    };
    let met = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
    let answer = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
    let orders = orders(gpu, rays.size);
    let layer = |i| {
        faces.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: i,
            array_layer_count: Some(1),
            ..Default::default()
        })
    };
    let views: Vec<_> = (0..count).map(layer).collect();
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("peel") });
    for (i, view) in (0..).zip(&views) {
        let kept = (i > 0).then(|| wgpu::BindingResource::TextureView(&views[i as usize - 1]));
        let which = usize::from(i > 0);
        let own = kernels[which].group(gpu, meshes.resources().into_iter().chain(kept));
        let empty = wgpu::Color { r: NOTHING, g: NOTHING, ..wgpu::Color::BLACK };
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(empty), store: wgpu::StoreOp::Store };
        let target = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("peel"),
            color_attachments: &[Some(target)],
            depth_stencil_attachment: Some(nearest(&orders)),
            occlusion_query_set: Some(&queries),
            ..Default::default()
        });
        pass.begin_occlusion_query(i);
        meshes.draw(&mut pass, &pipelines[which], rays.group, own.as_ref());
        pass.end_occlusion_query();
    }
    encoder.resolve_query_set(&queries, 0..count, &met, 0);
    encoder.copy_buffer_to_buffer(&met, 0, &answer, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    let answer = gpu.read_buffer(&answer, "faces met")?;
    let first = answer.chunks_exact(8).position(|met| met.iter().all(|b| *b == 0));
    Ok(first.map(|i| i as u32))
}

/// The sorted spans of every ray that lie inside, of `met` faces at most.
fn spans(
    gpu: &Gpu,
    join: &mut Kernel<Compute>,
    meshes: &Held,
    rays: &Rays<'_>,
    faces: &wgpu::Texture,
    met: u32,
) -> Result<wgpu::Texture, GpuError> {
    // Where the eye is inside its span has no face of entry; and the end is told.
    let count = met.div_ceil(2) + 1;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
    let spans = layers(gpu, "cuts", rays.size, count, COLOUR, usage);
    let pipeline = join.pipeline(gpu, &[], &[Some(rays.layout), None], &[])?;
    let views = [faces, &spans].map(array_view);
    let more = views.iter().map(wgpu::BindingResource::TextureView);
    let own = join.group(gpu, meshes.resources().into_iter().chain(more));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("cuts") });
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, rays.group, &[]);
        pass.set_bind_group(2, own.as_ref(), &[]);
        pass.dispatch_workgroups(rays.size[0].div_ceil(GROUP), rays.size[1].div_ceil(GROUP), 1);
    }
    gpu.queue.submit([encoder.finish()]);
    Ok(spans)
}
