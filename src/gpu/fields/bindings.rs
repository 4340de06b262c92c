//! Group 1: what shaders/lib/field.wgsl binds.
//!
//! Owns the layout, in the order that the shader declares, and [`FieldInfo`]. A field with nothing on the GPU is bound as one
//! texel of zero. Decides nothing.

use crate::gpu::device::constants::MOST_VOLUMES;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool;
use crate::shared_struct;

shared_struct! {
    /// What shaders know of a volume; see shaders/lib/field.wgsl.
    pub struct FieldInfo {
        /// Voxels of level 0.
        pub dims: [u32; 3],
        /// Voxels along an edge of a cell of the skip maps.
        pub cell: u32,
        /// Bricks of level 0.
        pub bricks: [u32; 3],
        /// Density of texel 0.
        pub value_lo: f32,
        /// 1 / texels of the pool.
        pub density_texel: [f32; 3],
        /// Density of texel 1 less that of texel 0.
        pub value_span: f32,
        /// 1 / texels of the pool.
        pub colour_texel: [f32; 3],
        /// Whether texels are the values themselves and not codes.
        pub floats: u32,
        /// 1 / texels of the pool.
        pub selection_texel: [f32; 3],
        /// The pool of density's texels: 0 codes, 1 floats, 2 and 3 those of boxes.
        pub pool: u32,
        /// The number of its first page of density.
        pub density_pages: u32,
        /// Of colour.
        pub colour_pages: u32,
        /// Of the selection.
        pub selection_pages: u32,
        /// Of labels.
        pub label_pages: u32,
        /// Whether density lies in place.
        pub density_placed: u32,
        /// Whether labels do.
        pub labels_placed: u32,
        /// Whether labels lie in the pool of boxes.
        pub fine_labels: u32,
        /// Unused.
        pub unused: u32,
    }
}

/// What group 1 binds besides buffers and sampler: density, density as floats (many volumes), colour, selection, labels, pages,
/// maps of empty space, density's pairs of voxels; of boxes density, density as floats, labels.
pub(crate) type Textures<'a> = [&'a wgpu::Texture; 11];

/// A texel of zero as float and as integer, and as float in a layer.
pub(crate) fn nothing(gpu: &Gpu) -> [wgpu::Texture; 3] {
    use wgpu::TextureDimension::{D2, D3};
    use wgpu::TextureFormat::{R8Uint, R8Unorm};
    [(R8Unorm, D3), (R8Uint, D3), (R8Unorm, D2)].map(|(format, dimension)| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("nothing"),
            size: pool::extent([1; 3]),
            mip_level_count: 1,
            sample_count: 1,
            dimension,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    })
}

pub(crate) fn info_buffer(gpu: &Gpu) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("field infos"),
        size: (MOST_VOLUMES as usize * size_of::<FieldInfo>()) as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

pub(crate) fn linear_sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("linear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

/// `first_filters`: whether a sampler may filter what is bound as density.
pub(crate) fn layout(gpu: &Gpu, first_filters: bool) -> wgpu::BindGroupLayout {
    use wgpu::TextureViewDimension::{D2, D2Array, D3};
    let visibility = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let texture =
        |sample_type, view_dimension| wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false };
    let float = |filterable| wgpu::TextureSampleType::Float { filterable };
    let uint = wgpu::TextureSampleType::Uint;
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        // Pictures of one volume read one FieldInfo, those of several an array of them.
        min_binding_size: None,
    };
    let types = [
        uniform,
        texture(float(first_filters), D3),
        texture(float(gpu.filters_float()), D3),
        texture(float(true), D3),
        texture(float(true), D3),
        texture(uint, D3),
        texture(uint, D2),
        texture(uint, D3),
        texture(float(true), D2Array),
        wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        texture(float(true), D3),
        texture(float(gpu.filters_float()), D3),
        texture(uint, D3),
    ];
    let entries: Vec<_> = (0..).zip(types).map(|(binding, ty)| entry(binding, ty)).collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("fields"), entries: &entries })
}

pub(crate) fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    info: &wgpu::Buffer,
    sampler: &wgpu::Sampler,
    textures: Textures<'_>,
) -> wgpu::BindGroup {
    let mut views = textures.map(|t| t.create_view(&wgpu::TextureViewDescriptor::default()));
    let layers =
        wgpu::TextureViewDescriptor { dimension: Some(wgpu::TextureViewDimension::D2Array), ..Default::default() };
    views[7] = textures[7].create_view(&layers);
    let mut entries = vec![
        wgpu::BindGroupEntry { binding: 0, resource: info.as_entire_binding() },
        wgpu::BindGroupEntry { binding: 9, resource: wgpu::BindingResource::Sampler(sampler) },
    ];
    entries.extend(
        (1..=8)
            .chain(10..)
            .zip(&views)
            .map(|(binding, v)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(v) }),
    );
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("fields"), layout, entries: &entries })
}
