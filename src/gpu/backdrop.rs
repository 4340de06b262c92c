//! Plain rectangles and pictures that a window lays under its controls.
//!
//! Controls are drawn by one general shader, which costs a software driver ten to thirty times as much a pixel as these two:
//! whatever covers much of a window belongs here. Owns the pictures' textures on the window's device, and draws within a pass of
//! the window's. Knows nothing of views or panels.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Draw, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::device::textures::{data, write};
use std::collections::BTreeMap;
use wgpu::util::DeviceExt;

/// A rectangle of one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Left, top, right, bottom in pixels of the target, from its top left.
    pub place: [f32; 4],
    /// Display-referred r, g, b, a, multiplied by alpha.
    pub colour: [f32; 4],
}

/// A rectangle that shows a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackdropPicture {
    /// As of a [`Fill`].
    pub place: [f32; 4],
    /// The number that the picture was given.
    pub picture: u32,
}

const FILE: &str = shader!("backdrop.wgsl");

/// Draws rectangles and pictures in pixels of a target, beneath whatever comes after.
#[derive(Debug)]
pub struct Backdrop {
    gpu: Gpu,
    fill: wgpu::RenderPipeline,
    show: wgpu::RenderPipeline,
    /// Of `show`, which binds a picture and a sampler.
    kernel: Kernel<Draw>,
    /// Where a texel is a pixel, and elsewhere.
    samplers: [wgpu::Sampler; 2],
    pictures: BTreeMap<u32, Held>,
}

#[derive(Debug)]
struct Held {
    size: [u32; 2],
    texture: wgpu::Texture,
    groups: [Option<wgpu::BindGroup>; 2],
}

/// One frame's fills and pictures, ready to be drawn.
#[derive(Clone, Debug)]
pub struct BackdropDraw {
    fill: wgpu::RenderPipeline,
    show: wgpu::RenderPipeline,
    places: wgpu::Buffer,
    under: u32,
    pictures: Vec<Option<wgpu::BindGroup>>,
    over: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Instance {
    place: [f32; 4],
    colour: [f32; 4],
}

impl Backdrop {
    /// For a window's device and the format of its surface.
    ///
    /// # Errors
    /// What the device refuses.
    pub fn new(gpu: Gpu, format: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let conditions: &[&str] = if format.is_srgb() { &["LINEAR_TARGET"] } else { &[] };
        let filtered = wgpu::TextureSampleType::Float { filterable: true };
        let picture = [Binding::Texture(wgpu::TextureViewDimension::D2, filtered), Binding::Sampler];
        gpu.clone().scoped("the window's ground", || {
            let fill = Kernel::new(&gpu, FILE, draw("fill", format), &[]).pipeline(&gpu, conditions, &[], &[])?;
            let mut kernel = Kernel::new(&gpu, FILE, draw("show", format), &picture);
            let show = kernel.pipeline(&gpu, conditions, &[], &[])?;
            let samplers = [wgpu::FilterMode::Nearest, wgpu::FilterMode::Linear].map(|filter| {
                gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                    label: Some("window pictures"),
                    mag_filter: filter,
                    min_filter: filter,
                    ..Default::default()
                })
            });
            Ok(Self { gpu, fill, show, kernel, samplers, pictures: BTreeMap::new() })
        })
    }

    /// Takes in a picture under a number, in place of the one that had it. `rgba` is display-referred, 8 bits each, row by row from
    /// the top; alpha is not looked at.
    ///
    /// # Errors
    /// [`GpuError::Refused`] if the numbers do not fit the size or the device has no textures so large.
    pub fn take(&mut self, picture: u32, size: [u32; 2], rgba: &[u8]) -> Result<(), GpuError> {
        let what = "a window's picture";
        let [width, height] = size;
        if size.contains(&0) || rgba.len() as u64 != u64::from(width) * u64::from(height) * 4 {
            let reason = format!("{} bytes found, 4 for each of {width} × {height} pixels expected", rgba.len());
            return Err(GpuError::Refused { what: what.into(), reason });
        }
        let Self { gpu, kernel, samplers, pictures, .. } = self;
        let held = gpu.scoped(what, || {
            let held = match pictures.remove(&picture).filter(|held| held.size == size) {
                Some(held) => held,
                None => Held::new(gpu, kernel, samplers, size),
            };
            write(gpu, &held.texture, rgba, 4);
            Ok(held)
        })?;
        pictures.insert(picture, held);
        Ok(())
    }

    /// Forgets all pictures.
    pub fn forget(&mut self) {
        self.pictures.clear();
    }

    /// Prepares what is to lie on a target of `size` pixels, under and over the pictures; one that never came is left out.
    ///
    /// # Errors
    /// What the device refuses.
    pub fn prepare(
        &self,
        size: [u32; 2],
        under: &[Fill],
        shown: &[BackdropPicture],
        over: &[Fill],
    ) -> Result<BackdropDraw, GpuError> {
        let clip = |[l, t, r, b]: [f32; 4]| {
            let [w, h] = size.map(|s| s.max(1) as f32);
            [2.0 * l / w - 1.0, 1.0 - 2.0 * t / h, 2.0 * r / w - 1.0, 1.0 - 2.0 * b / h]
        };
        let held = shown.iter().filter_map(|s| Some((s, self.pictures.get(&s.picture)?)));
        let group = |(s, held): (&BackdropPicture, &Held)| {
            let [l, t, r, b] = s.place;
            let same = [r - l, b - t] == held.size.map(|s| s as f32);
            held.groups[usize::from(!same)].clone()
        };
        let filled = |f: &Fill| Instance { place: clip(f.place), colour: f.colour };
        let framed = held.clone().map(|(s, _)| Instance { place: clip(s.place), colour: [0.0; 4] });
        let instances: Vec<Instance> = under.iter().map(filled).chain(framed).chain(over.iter().map(filled)).collect();
        let places = self.gpu.scoped("the window's ground", || {
            Ok(self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("window places"),
                contents: bytemuck::cast_slice(&instances),
                usage: wgpu::BufferUsages::VERTEX,
            }))
        })?;
        let (fill, show) = (self.fill.clone(), self.show.clone());
        let (pictures, under, over) = (held.map(group).collect(), under.len() as u32, over.len() as u32);
        Ok(BackdropDraw { fill, show, places, under, pictures, over })
    }
}

impl BackdropDraw {
    /// Draws it within a pass whose viewport is the whole target.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.places.size() == 0 {
            return;
        }
        pass.set_vertex_buffer(0, self.places.slice(..));
        pass.set_pipeline(&self.fill);
        pass.draw(0..4, 0..self.under);
        pass.set_pipeline(&self.show);
        for (i, group) in (self.under..).zip(&self.pictures) {
            pass.set_bind_group(0, group.as_ref(), &[]);
            pass.draw(0..4, i..i + 1);
        }
        let over = self.under + self.pictures.len() as u32;
        pass.set_pipeline(&self.fill);
        pass.draw(0..4, over..over + self.over);
    }
}

impl Held {
    fn new(gpu: &Gpu, kernel: &Kernel<Draw>, samplers: &[wgpu::Sampler; 2], size: [u32; 2]) -> Self {
        let texture = data(gpu, "window picture", size, wgpu::TextureFormat::Rgba8Unorm);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let groups = [0, 1].map(|i| {
            let sampler = wgpu::BindingResource::Sampler(&samplers[i]);
            kernel.group(gpu, [wgpu::BindingResource::TextureView(&view), sampler])
        });
        Self { size, texture, groups }
    }
}

/// Rectangles, one an instance, over what the target holds.
fn draw(fragment: &'static str, format: wgpu::TextureFormat) -> Draw {
    Draw {
        vertex: "corner",
        fragment,
        buffers: vec![wgpu::VertexBufferLayout {
            array_stride: size_of::<Instance>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &const { wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4] },
        }],
        topology: wgpu::PrimitiveTopology::TriangleStrip,
        targets: vec![wgpu::ColorTargetState {
            format,
            blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
            write_mask: wgpu::ColorWrites::ALL,
        }],
        depth: None,
    }
}
