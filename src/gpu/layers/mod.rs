//! Layers of a picture: meshes that are drawn before its rays.
//!
//! Owns the kernels under `shaders/mesh` and group 3 of what marches. Opaque meshes become a picture of their own, behind which no ray
//! goes; closed meshes that cut become, per pixel, the sorted spans of the ray that lie inside; decals become sorted marks. Knows no voxel.

mod cuts;
pub(crate) mod decals;
pub(crate) mod meshes;
mod opaque;

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, group, group_layout};
use crate::gpu::device::textures::{COLOUR, Targets};
use crate::gpu::layers::cuts::Cuts;
use crate::gpu::layers::decals::{Decals, Mark, Marks, Stuck};
use crate::gpu::layers::opaque::Opaque;
use crate::gpu::picture::layer::{CutMesh, Layers};
use crate::math::DVec3;
use std::sync::Arc;

/// Set in the code of an object that is a mesh: the rest is its place in the frame's list.
pub(crate) const MESH_CODE: u32 = 1 << 31;

/// What is drawn of a frame's layers.
#[derive(Debug)]
pub(crate) struct DrawnLayers {
    /// Opaque meshes: their picture, nothing elsewhere.
    pub opaque: Option<Targets>,
    /// Into how many pieces an interval may be cut; 1: nothing is cut away.
    pub pieces: usize,
    /// Whether any ray meets a decal.
    pub marked: bool,
    /// In which layer what cuts each class of bodies begins; `None`: nothing cuts it.
    pub firsts: Vec<Option<u32>>,
    /// Group 3.
    pub group: wgpu::BindGroup,
}

impl DrawnLayers {
    /// What kernels that march are compiled for.
    pub(crate) fn conditions(&self) -> impl Iterator<Item = &'static str> {
        let own = [("OPAQUE", self.opaque.is_some()), ("CUTS", self.pieces > 1), ("MARKS", self.marked)];
        own.into_iter().filter(|c| c.1).map(|c| c.0)
    }
}

/// From where a picture's rays come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays<'a> {
    /// Layout of group 0.
    pub layout: &'a wgpu::BindGroupLayout,
    /// Group 0, of which `view` is read.
    pub group: &'a wgpu::BindGroup,
    /// World mm.
    pub eye: DVec3,
    /// Pixels.
    pub size: [u32; 2],
}

/// What draws a frame's meshes, kept from picture to picture.
#[derive(Debug)]
pub(crate) struct LayerRaster {
    /// Of group 3.
    pub layout: wgpu::BindGroupLayout,
    opaque: Opaque,
    cuts: Cuts,
    decals: Decals,
    nothing: (Targets, wgpu::Texture, Marks),
}

impl LayerRaster {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let float = wgpu::TextureSampleType::Float { filterable: false };
        let spans = Binding::Texture(wgpu::TextureViewDimension::D2Array, float);
        let read = |bytes| Binding::Elements { bytes, written: false };
        let bindings =
            [Binding::FLOAT_2D, Binding::FLOAT_2D, Binding::UINT_2D, spans, read(4), read(size_of::<Mark>())];
        let stages = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let none = |label| {
            let (size, usage) = (size_of::<Mark>() as u64, wgpu::BufferUsages::STORAGE);
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let no_spans = layers(gpu, "no cuts", [1; 2], 1, COLOUR, wgpu::TextureUsages::empty());
        Self {
            layout: group_layout(gpu, "layers", stages, &bindings),
            opaque: Opaque::new(gpu),
            cuts: Cuts::new(gpu),
            decals: Decals::new(gpu),
            nothing: (
                Targets::new(gpu, [1; 2]),
                no_spans,
                Marks { heads: none("no mark heads"), marks: none("no marks") },
            ),
        }
    }

    /// Draws the meshes of a frame, and its decals where bodies hold them; `None` where none shows.
    ///
    /// # Errors
    /// Too many meshes or faces, out of memory, or a lost device.
    /// `classes`: the names of the cutting meshes that leave one class of bodies or another as it is.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        frame: &Layers,
        stuck: &[Stuck<'_>],
        classes: &[Arc<[u32]>],
        rays: &Rays<'_>,
    ) -> Result<Option<DrawnLayers>, GpuError> {
        let opaque = self.opaque.draw(gpu, &frame.opaque, rays)?;
        let (spans, firsts) = self.spans(gpu, &frame.cuts, classes, rays)?;
        let marks = self.decals.draw(gpu, stuck, rays)?;
        if opaque.is_none() && spans.is_none() && marks.is_none() {
            return Ok(None);
        }
        let marked = marks.is_some();
        let Marks { heads, marks } = marks.as_ref().unwrap_or(&self.nothing.2);
        let targets = opaque.as_ref().unwrap_or(&self.nothing.0).views();
        let spans_view = array_view(spans.as_ref().unwrap_or(&self.nothing.1));
        let views = targets.iter().chain([&spans_view]).map(wgpu::BindingResource::TextureView);
        let lists = [heads, marks].map(wgpu::Buffer::as_entire_binding);
        let group = group(gpu, "layers", &self.layout, views.chain(lists));
        // The last of the spans only ends them.
        let pieces = spans.map_or(1, |s| s.depth_or_array_layers() as usize);
        Ok(Some(DrawnLayers { opaque, pieces, marked, firsts, group }))
    }

    /// What cuts, as spans of rays: one list of layers after another, one for each set of meshes that spare something; and in which layer
    /// each begins, `None` where nothing is left to cut.
    fn spans(
        &mut self,
        gpu: &Gpu,
        cuts: &[CutMesh],
        classes: &[Arc<[u32]>],
        rays: &Rays<'_>,
    ) -> Result<(Option<wgpu::Texture>, Vec<Option<u32>>), GpuError> {
        let mut lists = Vec::new();
        let (mut firsts, mut count) = (Vec::new(), 0);
        for (class, spared) in classes.iter().enumerate() {
            let left: Vec<CutMesh> = cuts.iter().filter(|cut| !spared.contains(&cut.id)).cloned().collect();
            let spans = self.cuts.draw(gpu, (class, &left), rays)?;
            firsts.push(spans.as_ref().map(|_| count));
            count += spans.as_ref().map_or(0, wgpu::Texture::depth_or_array_layers);
            lists.extend(spans);
        }
        if lists.len() < 2 {
            return Ok((lists.pop(), firsts));
        }
        let all = layers(gpu, "cuts of all", rays.size, count, COLOUR, wgpu::TextureUsages::COPY_DST);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("cuts") });
        let mut z = 0;
        for list in &lists {
            let to = wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y: 0, z }, ..all.as_image_copy() };
            encoder.copy_texture_to_texture(list.as_image_copy(), to, list.size());
            z += list.depth_or_array_layers();
        }
        gpu.queue.submit([encoder.finish()]);
        Ok((Some(all), firsts))
    }
}

/// A 2D array that shaders load from.
fn layers(
    gpu: &Gpu,
    label: &str,
    [width, height]: [u32; 2],
    count: u32,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: count },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let dimension = Some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
}
