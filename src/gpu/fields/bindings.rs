//! Group 1: what shaders/lib/field.wgsl binds.
//!
//! Owns the layout, in the order that the shader declares, and [`FieldInfo`]. A field with nothing on the GPU is bound as one
//! texel of zero. Decides nothing.

use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::skip_maps::Skips;
use crate::shared_struct;
use crate::volume::{FieldKind, TexelFormat};

shared_struct! {
    /// What shaders know of the volume; see shaders/lib/field.wgsl.
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
        /// Unused.
        pub pad_a: u32,
        /// 1 / texels of the pool.
        pub selection_texel: [f32; 3],
        /// Unused.
        pub pad_b: u32,
    }
}

/// Whether a sampler may filter the density.
pub(crate) fn filters(gpu: &Gpu, density: &Pool) -> bool {
    density.format() != TexelFormat::R32Float || gpu.filters_float()
}

/// A texel of zero as float, as integer, and as a page.
pub(crate) fn nothing(gpu: &Gpu) -> [wgpu::Texture; 3] {
    [wgpu::TextureFormat::R8Unorm, wgpu::TextureFormat::R8Uint, wgpu::TextureFormat::Rg32Uint].map(|format| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("nothing"),
            size: pool::extent([1; 3]),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    })
}

pub(crate) fn info_buffer(gpu: &Gpu) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("field info"),
        size: size_of::<FieldInfo>() as u64,
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

pub(crate) fn layout(gpu: &Gpu, density_filters: bool) -> wgpu::BindGroupLayout {
    let visibility = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
    let texture = |binding: u32, sample_type: wgpu::TextureSampleType| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        },
        count: None,
    };
    let float = |filterable| wgpu::TextureSampleType::Float { filterable };
    let uint = wgpu::TextureSampleType::Uint;
    let mut entries = vec![
        wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: wgpu::BufferSize::new(size_of::<FieldInfo>() as u64),
            },
            count: None,
        },
        wgpu::BindGroupLayoutEntry {
            binding: 9,
            visibility,
            ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            count: None,
        },
        texture(1, float(density_filters)),
        texture(3, float(true)),
        texture(5, float(true)),
    ];
    entries.extend([2, 4, 6, 7, 8, 10, 11, 12].map(|binding| texture(binding, uint)));
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("fields"), entries: &entries })
}

pub(crate) fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    info: &wgpu::Buffer,
    sampler: &wgpu::Sampler,
    [no_float, no_uint, no_page]: &[wgpu::Texture; 3],
    pools: &[Option<Pool>; 4],
    skips: &Skips,
) -> wgpu::BindGroup {
    let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
    let mut views = Vec::new();
    for kind in FieldKind::ALL {
        let binding = 1 + 2 * kind as usize as u32;
        let none = if kind == FieldKind::Labels { no_uint } else { no_float };
        let pool = pools[kind as usize].as_ref();
        views.push((binding, view(pool.map_or(none, |p| &p.texture))));
        views.push((binding + 1, view(pool.map_or(no_page, |p| &p.page_texture))));
    }
    // Where nothing is selected all matter is background, and a selection that shows nothing may be searched like it.
    let masked = pools[FieldKind::Selection as usize].is_some();
    views.extend((0..3).map(|map| (10 + map as u32, view(&skips.textures[if masked { map } else { 0 }]))));
    let mut entries = vec![
        wgpu::BindGroupEntry { binding: 0, resource: info.as_entire_binding() },
        wgpu::BindGroupEntry { binding: 9, resource: wgpu::BindingResource::Sampler(sampler) },
    ];
    entries.extend(views.iter().map(|(binding, v)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: wgpu::BindingResource::TextureView(v),
    }));
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("fields"), layout, entries: &entries })
}
