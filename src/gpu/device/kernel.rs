//! A kernel: an entry of a shader file, what it binds, and its pipelines by what they are compiled for.
//!
//! Every pipeline of this floor is made and kept here, once: a new kernel is its shader, one file that holds a [`Kernel`], and that
//! file's line in its folder. Knows no field, frame or stroke.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::shader;
use crate::gpu::device::shader::Def;
use std::collections::HashMap;

/// What a kernel binds.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Binding {
    /// A uniform buffer of at least so many bytes.
    Uniform(usize),
    /// A uniform buffer of which so many bytes are bound at an offset that each dispatch gives.
    UniformAt(usize),
    /// A storage buffer that is read and written.
    Storage,
    /// A storage buffer of elements of so many bytes, written by the kernel or not.
    Elements {
        /// Bytes of the largest element.
        bytes: usize,
        /// Whether the kernel writes it.
        written: bool,
    },
    /// A texture that is loaded from, or sampled where the sample type says so.
    Texture(wgpu::TextureViewDimension, wgpu::TextureSampleType),
    /// A texture that is only written.
    Written(wgpu::TextureViewDimension, wgpu::TextureFormat),
    /// A filtering sampler.
    Sampler,
}

impl Binding {
    /// A 2D texture of integers.
    pub(crate) const UINT_2D: Self = Self::Texture(wgpu::TextureViewDimension::D2, wgpu::TextureSampleType::Uint);
    /// A 2D texture of floats that no sampler filters.
    pub(crate) const FLOAT_2D: Self =
        Self::Texture(wgpu::TextureViewDimension::D2, wgpu::TextureSampleType::Float { filterable: false });

    fn entry(self, binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
        let buffer = |ty, bytes: usize| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: matches!(self, Self::UniformAt(_)),
            min_binding_size: wgpu::BufferSize::new(bytes as u64),
        };
        let ty = match self {
            Self::Uniform(bytes) | Self::UniformAt(bytes) => buffer(wgpu::BufferBindingType::Uniform, bytes),
            Self::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: false }, 4),
            Self::Elements { bytes, written } => {
                buffer(wgpu::BufferBindingType::Storage { read_only: !written }, bytes)
            }
            Self::Texture(view_dimension, sample_type) => {
                wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
            }
            Self::Written(view_dimension, format) => {
                let access = wgpu::StorageTextureAccess::WriteOnly;
                wgpu::BindingType::StorageTexture { access, format, view_dimension }
            }
            Self::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        };
        // Corners are not what writes: few devices let them.
        let writes = matches!(self, Self::Storage | Self::Elements { written: true, .. } | Self::Written(..));
        let visibility = if writes { visibility.difference(wgpu::ShaderStages::VERTEX) } else { visibility };
        wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
    }
}

/// The layout of a group whose bindings are numbered in order.
pub(crate) fn group_layout(
    gpu: &Gpu,
    label: &str,
    visibility: wgpu::ShaderStages,
    bindings: &[Binding],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..).zip(bindings).map(|(i, b)| b.entry(i, visibility)).collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A group of resources that are numbered in order.
pub(crate) fn group<'a>(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// How a kernel's entries become a pipeline.
pub(crate) trait Entry {
    /// Compute or render pipeline.
    type Pipeline: Clone + std::fmt::Debug;
    /// Where the kernel's own bindings are seen.
    const VISIBILITY: wgpu::ShaderStages;
    /// Makes it.
    fn pipeline(
        &self,
        gpu: &Gpu,
        label: &str,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
    ) -> Self::Pipeline;
}

/// A compute entry by its name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compute(pub &'static str);

impl Entry for Compute {
    type Pipeline = wgpu::ComputePipeline;
    const VISIBILITY: wgpu::ShaderStages = wgpu::ShaderStages::COMPUTE;

    fn pipeline(
        &self,
        gpu: &Gpu,
        label: &str,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
    ) -> Self::Pipeline {
        gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(layout),
            module,
            entry_point: Some(self.0),
            compilation_options: Default::default(),
            cache: None,
        })
    }
}

/// Vertex and fragment entries by their names, and what they draw from and into.
#[derive(Clone, Debug)]
pub(crate) struct Draw {
    /// Vertex entry.
    pub vertex: &'static str,
    /// Fragment entry.
    pub fragment: &'static str,
    /// Vertex buffers.
    pub buffers: Vec<wgpu::VertexBufferLayout<'static>>,
    /// How corners become triangles.
    pub topology: wgpu::PrimitiveTopology,
    /// Formats and blending.
    pub targets: Vec<wgpu::ColorTargetState>,
    /// Where the nearest of what is drawn is kept by its depth: the depths' format.
    pub depth: Option<wgpu::TextureFormat>,
}

impl Draw {
    /// One triangle over all of the targets, by the vertex entry `cover`.
    pub(crate) fn cover(fragment: &'static str, targets: &[wgpu::TextureFormat]) -> Self {
        Self {
            vertex: "cover",
            fragment,
            buffers: Vec::new(),
            topology: wgpu::PrimitiveTopology::TriangleList,
            targets: targets.iter().map(|&format| format.into()).collect(),
            depth: None,
        }
    }
}

impl Entry for Draw {
    type Pipeline = wgpu::RenderPipeline;
    const VISIBILITY: wgpu::ShaderStages = wgpu::ShaderStages::VERTEX_FRAGMENT;

    fn pipeline(
        &self,
        gpu: &Gpu,
        label: &str,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
    ) -> Self::Pipeline {
        let buffers: Vec<_> = self.buffers.iter().cloned().map(Some).collect();
        let targets: Vec<_> = self.targets.iter().cloned().map(Some).collect();
        let depth = self.depth.map(|format| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        });
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(self.vertex),
                compilation_options: Default::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState { topology: self.topology, ..Default::default() },
            depth_stencil: depth,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(self.fragment),
                compilation_options: Default::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// See the file's head.
#[derive(Debug)]
pub(crate) struct Kernel<E: Entry> {
    file: &'static str,
    entry: E,
    layout: Option<wgpu::BindGroupLayout>,
    pipelines: HashMap<Vec<&'static str>, E::Pipeline>,
}

impl<E: Entry> Kernel<E> {
    /// A kernel without pipelines; they are made when first needed. `file` is its shader's under `shaders/`; `bindings` are those of
    /// the group that is its alone, none if it has no such group.
    pub(crate) fn new(gpu: &Gpu, file: &'static str, entry: E, bindings: &[Binding]) -> Self {
        let layout = (!bindings.is_empty()).then(|| group_layout(gpu, file, E::VISIBILITY, bindings));
        Self { file, entry, layout, pipelines: HashMap::new() }
    }

    /// The kernel's own group, its resources in the order of its bindings; `None` for a kernel that has no group.
    pub(crate) fn group<'a>(
        &self,
        gpu: &Gpu,
        resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
    ) -> Option<wgpu::BindGroup> {
        Some(group(gpu, self.file, self.layout.as_ref()?, resources))
    }

    /// The pipeline under these conditions (`#ifdef`), in an order that is always the same. Its groups are those of `before`, the
    /// kernel's own, and those of `after`; under the same conditions they must always be the same.
    ///
    /// # Errors
    /// A shader that does not compile; what the device refuses.
    pub(crate) fn pipeline(
        &mut self,
        gpu: &Gpu,
        conditions: &[&'static str],
        before: &[Option<&wgpu::BindGroupLayout>],
        after: &[&wgpu::BindGroupLayout],
    ) -> Result<E::Pipeline, GpuError> {
        if let Some(pipeline) = self.pipelines.get(conditions) {
            return Ok(pipeline.clone());
        }
        let defs: Vec<_> = conditions.iter().map(|&name| (name, Def::Bool(true))).collect();
        let module = shader::compile(gpu, self.file, &defs)?;
        let own = self.layout.as_ref();
        let mut groups = before.to_vec();
        if own.is_some() || !after.is_empty() {
            groups.push(own);
        }
        groups.extend(after.iter().copied().map(Some));
        let pipeline = gpu.scoped(self.file, || {
            let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(self.file),
                bind_group_layouts: &groups,
                immediate_size: 0,
            });
            Ok(self.entry.pipeline(gpu, self.file, &module, &layout))
        })?;
        self.pipelines.insert(conditions.to_vec(), pipeline.clone());
        Ok(pipeline)
    }
}
