//! 2D textures: what pictures are drawn into, small data for shaders, one triangle over all of a target.
//!
//! Knows formats and labels, nothing of what is drawn.

use crate::gpu::device::constants::FAR;
use crate::gpu::device::gpu::Gpu;

/// Colour, depth and object of a picture on the GPU.
#[derive(Debug)]
pub(crate) struct Targets {
    pub size: [u32; 2],
    pub colour: wgpu::Texture,
    pub depth: wgpu::Texture,
    pub object: wgpu::Texture,
}

pub(crate) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
pub(crate) const OBJECT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

impl Targets {
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST;
        let texture = |label, format| texture(gpu, label, size, format, usage);
        Self {
            size,
            colour: texture("picture colour", COLOUR),
            depth: texture("picture depth", DEPTH),
            object: texture("picture objects", OBJECT),
        }
    }

    fn all(&self) -> [&wgpu::Texture; 3] {
        [&self.colour, &self.depth, &self.object]
    }

    /// Views of colour, depth and object.
    pub(crate) fn views(&self) -> [wgpu::TextureView; 3] {
        self.all().map(|t| t.create_view(&wgpu::TextureViewDescriptor::default()))
    }

    /// What a pass draws into, by [`views`](Self::views); it begins with nothing if `clear`.
    pub(crate) fn attachments(
        views: &[wgpu::TextureView; 3],
        clear: bool,
    ) -> [Option<wgpu::RenderPassColorAttachment<'_>>; 3] {
        let nothing = [0.0, f64::from(FAR), 0.0];
        std::array::from_fn(|i| {
            let empty = wgpu::Color { r: nothing[i], ..wgpu::Color::TRANSPARENT };
            let load = if clear { wgpu::LoadOp::Clear(empty) } else { wgpu::LoadOp::Load };
            let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view: &views[i], depth_slice: None, resolve_target: None, ops })
        })
    }

    /// Takes over all of another picture of the same size.
    pub(crate) fn take_over(&self, encoder: &mut wgpu::CommandEncoder, other: &Self) {
        for (to, from) in self.all().into_iter().zip(other.all()) {
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), to.size());
        }
    }
}

/// Draws one triangle over all of a target.
pub(crate) fn draw_over(
    gpu: &Gpu,
    label: &str,
    target: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    groups: &[Option<&wgpu::BindGroup>],
) {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) });
    {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops,
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        for (i, group) in (0..).zip(groups) {
            pass.set_bind_group(i, *group, &[]);
        }
        pass.draw(0..3, 0..1);
    }
    gpu.queue.submit([encoder.finish()]);
}

/// A plain 2D texture.
pub(crate) fn texture(
    gpu: &Gpu,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// A texture that shaders load from and the host writes.
pub(crate) fn data(gpu: &Gpu, label: &str, size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    texture(gpu, label, size, format, wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST)
}

pub(crate) fn write(gpu: &Gpu, texture: &wgpu::Texture, bytes: &[u8], bytes_per_texel: u32) {
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(texture.width() * bytes_per_texel),
            rows_per_image: None,
        },
        texture.size(),
    );
}
