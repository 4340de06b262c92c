//! Slices: one voxel deep, along a voxel axis, linear in the plane, through the same pools as the 3D picture.
//!
//! Owns [`SliceFrame`] (what is drawn) and [`SliceCaster`] (its kernel). Where a slice's pixels lie in the world is the
//! caller's: a frame takes any affine map from pixels to the slice. Knows no window.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Draw, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::device::textures::{COLOUR, data, draw_over, texture, write};
use crate::gpu::fields::demand::SliceCut;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::Overlay;
use crate::math::{DVec2, DVec3};
use crate::shared_struct;
use crate::volume::{FieldKey, FieldKind, Grid, Segments, VolumeId};

/// One slice picture.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceFrame {
    /// The voxel axis (0 i, 1 j, 2 k) that the slice is normal to.
    pub axis: usize,
    /// The slice's voxel along that axis.
    pub index: u32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The volume whose slice it is, on the slice's voxels.
    pub own: SliceLayer,
    /// Other volumes under it, the first one lowest.
    pub under: Vec<SliceLayer>,
    /// Other volumes over it, the first one lowest.
    pub over: Vec<SliceLayer>,
}

/// A volume on the plane of a slice: each pixel shows what lies at its place in the world. Values are linear between voxels, labels
/// those of the voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceLayer {
    /// Whose voxels they are.
    pub volume: VolumeId,
    /// The picture's top-left corner in its voxels.
    pub top_left: DVec3,
    /// Its voxels per pixel to the right.
    pub per_x: DVec3,
    /// Its voxels per pixel down.
    pub per_y: DVec3,
    /// Density shown as black and as white; `None`: its painted fields alone are shown.
    pub window: Option<[f64; 2]>,
    /// 0 to 1: how much of what lies under it it hides. At 0 nothing of it is looked at.
    pub opacity: f32,
    /// Painted fields.
    pub overlay: Overlay,
}

/// Where a picture lies in a grid: its top-left corner, and voxels per pixel to the right and down.
fn lie(grid: &Grid, size: [u32; 2], world: impl Fn(DVec2) -> DVec3) -> [DVec3; 3] {
    let to_index = grid.index_from_world();
    let at = |x: f64, y: f64| to_index.transform_point3(world(DVec2::new(x, y)));
    let (w, h) = (f64::from(size[0].max(1)), f64::from(size[1].max(1)));
    let top_left = at(0.0, 0.0);
    [top_left, (at(w, 0.0) - top_left) / w, (at(0.0, h) - top_left) / h]
}

fn window_of((level, width): (f64, f64)) -> [f64; 2] {
    let half = 0.5 * width.max(f64::MIN_POSITIVE);
    [level - half, level + half]
}

impl SliceLayer {
    /// A volume on the plane of a slice of `size` pixels. `world` is that of the slice; `grey` as there, `None` where its values are
    /// not shown.
    pub fn new(
        (volume, grid): (VolumeId, &Grid),
        size: [u32; 2],
        world: impl Fn(DVec2) -> DVec3,
        grey: Option<(f64, f64)>,
        opacity: f32,
        overlay: Overlay,
    ) -> Self {
        let [top_left, per_x, per_y] = lie(grid, size, world);
        Self { volume, top_left, per_x, per_y, window: grey.map(window_of), opacity, overlay }
    }
}

impl SliceFrame {
    /// The slice whose pixels lie where `world` says (mm, pixel (0, 0) at the top left, an affine map onto the slice).
    /// `grey` are level and width of the grey window, in the density's unit. It is one of [`VolumeId::FIRST`] alone.
    pub fn new(
        grid: &Grid,
        (axis, index): (usize, u32),
        size: [u32; 2],
        world: impl Fn(DVec2) -> DVec3,
        grey: (f64, f64),
        overlay: Overlay,
    ) -> Self {
        let mut own = SliceLayer::new((VolumeId::FIRST, grid), size, world, Some(grey), 1.0, overlay);
        // Exactly on the voxels' centres, whatever rounding left.
        own.top_left[axis] = f64::from(index.min(grid.dims[axis].saturating_sub(1)));
        own.per_x[axis] = 0.0;
        own.per_y[axis] = 0.0;
        Self { axis, index, size, own, under: Vec::new(), over: Vec::new() }
    }

    /// The layers from the lowest up; whether it is the slice's own.
    fn layers(&self) -> impl Iterator<Item = (&SliceLayer, bool)> {
        let other = |layers| <[SliceLayer]>::iter(layers).map(|layer| (layer, false));
        other(&self.under).chain([(&self.own, true)]).chain(other(&self.over))
    }

    /// A rectangle of the picture, as a picture of its own: its top-left corner in pixels, and its size.
    #[must_use]
    pub fn part(&self, corner: [u32; 2], size: [u32; 2]) -> Self {
        let shift = |per_x: DVec3, per_y: DVec3| per_x * f64::from(corner[0]) + per_y * f64::from(corner[1]);
        let mut part = self.clone();
        part.size = size;
        for layer in part.under.iter_mut().chain([&mut part.own]).chain(&mut part.over) {
            layer.top_left += shift(layer.per_x, layer.per_y);
        }
        part
    }
}

shared_struct! {
    /// One volume in a slice.
    pub(super) struct Slice {
        /// The picture's corner in voxels, on the slice.
        pub top_left: [f32; 3],
        /// Density that is black, as a texel.
        pub black: f32,
        /// Voxels per pixel to the right.
        pub per_x: [f32; 3],
        /// Density that is white, as a texel.
        pub white: f32,
        /// Voxels per pixel down.
        pub per_y: [f32; 3],
        /// 0..1.
        pub colour_opacity: f32,
        /// Display-referred.
        pub selection_colour: [f32; 3],
        /// 0..1.
        pub selection_opacity: f32,
        /// 0..1.
        pub label_opacity: f32,
        /// How much of what lies under it it hides.
        pub opacity: f32,
        /// Unused.
        pub pad_b: u32,
        /// Unused.
        pub pad_c: u32,
    }
}

/// Draws [`SliceFrame`]s: the kernel, its numbers and the segments' colours, kept from slice to slice.
#[derive(Debug)]
pub struct SliceCaster {
    kernel: Kernel<Draw>,
    uniform: wgpu::Buffer,
    colours: wgpu::Texture,
    segments: Option<Segments>,
}

impl SliceCaster {
    /// Makes what all slices share.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        gpu.scoped("slices", || {
            let bindings = [Binding::Uniform(size_of::<Slice>()), Binding::FLOAT_2D];
            let kernel = Kernel::new(gpu, shader!("slice.wgsl"), Draw::cover("draw", &[COLOUR]), &bindings);
            let uniform = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("slice"),
                size: size_of::<Slice>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let colours = data(gpu, "segment colours", [256; 2], wgpu::TextureFormat::Rgba8Unorm);
            Ok(Self { kernel, uniform, colours, segments: None })
        })
    }

    /// Draws a layer over all of a target of the frame's size. Its voxels must be resident, its volume bound.
    fn draw(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        layer: &SliceLayer,
        target: &wgpu::TextureView,
    ) -> Result<(), GpuError> {
        let pipeline = self.kernel.pipeline(gpu, &conditions(gpu, pools, layer), &[], &[pools.layout()])?;
        gpu.scoped("a slice", || {
            if self.segments.as_ref() != Some(&layer.overlay.segments) {
                write_colours(gpu, &self.colours, &layer.overlay.segments);
                self.segments = Some(layer.overlay.segments.clone());
            }
            gpu.queue.write_buffer(
                &self.uniform,
                0,
                bytemuck::bytes_of(&uniform(layer, pools.value_of_texel(layer.volume))),
            );
            let colours = self.colours.create_view(&wgpu::TextureViewDescriptor::default());
            let colours = wgpu::BindingResource::TextureView(&colours);
            let group = self.kernel.group(gpu, [self.uniform.as_entire_binding(), colours]);
            draw_over(gpu, "slice", target, &pipeline, &[group.as_ref(), Some(pools.group())]);
            Ok(())
        })
    }

    /// A slice as display-referred red, green, blue, multiplied by alpha, and alpha (0 where there is no voxel), row by row
    /// from the top.
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub fn pixels(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &SliceFrame,
    ) -> Result<Vec<[f32; 4]>, GpuError> {
        if frame.size.contains(&0) {
            return Ok(Vec::new());
        }
        let mut picture: Option<Vec<[f32; 4]>> = None;
        for (layer, is_own) in frame.layers().filter(|(layer, _)| layer.opacity > 0.0) {
            let cut = if is_own {
                SliceCut::Row { axis: frame.axis, index: frame.index }
            } else {
                let across = layer.per_x * f64::from(frame.size[0]);
                let down = layer.per_y * f64::from(frame.size[1]);
                SliceCut::Plane { view: frame.axis, corner: layer.top_left, across, down }
            };
            pools.make_slice_resident(gpu, fields, layer.volume, cut)?;
            let over = self.layer(gpu, pools, layer, frame.size)?;
            match &mut picture {
                Some(picture) => {
                    for (under, over) in picture.iter_mut().zip(over) {
                        *under = std::array::from_fn(|i| over[i] + under[i] * (1.0 - over[3]));
                    }
                }
                None => picture = Some(over),
            }
        }
        Ok(picture.unwrap_or_else(|| vec![[0.0; 4]; frame.size[0] as usize * frame.size[1] as usize]))
    }

    /// A layer's pixels, as [`pixels`](Self::pixels) has them.
    fn layer(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        layer: &SliceLayer,
        size: [u32; 2],
    ) -> Result<Vec<[f32; 4]>, GpuError> {
        let [width, height] = size;
        // Rows of copies are padded to 256 bytes.
        let pitch = (width * 16).next_multiple_of(256);
        let (target, buffer) = gpu.scoped("a slice's picture", || {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
            let target = texture(gpu, "slice picture", size, COLOUR, usage);
            let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("slice picture"),
                size: u64::from(pitch) * u64::from(height),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            Ok((target, buffer))
        })?;
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.draw(gpu, pools, layer, &view)?;
        let bytes = gpu.scoped("a slice's picture", || {
            let mut encoder =
                gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("slice picture") });
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None };
            encoder.copy_texture_to_buffer(
                target.as_image_copy(),
                wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
                target.size(),
            );
            gpu.queue.submit([encoder.finish()]);
            gpu.read_buffer(&buffer, "a slice's picture")
        })?;
        let row = |y: u32| &bytes[(y * pitch) as usize..(y * pitch + width * 16) as usize];
        Ok((0..height).flat_map(|y| row(y).chunks_exact(16).map(bytemuck::pod_read_unaligned)).collect())
    }
}

/// What the shader is compiled for.
fn conditions(gpu: &Gpu, pools: &FieldPools, layer: &SliceLayer) -> Vec<&'static str> {
    let fields = [
        ("COLOUR", FieldKind::Colour, layer.overlay.colour),
        ("LABELS", FieldKind::Labels, layer.overlay.labels),
        ("SELECTION", FieldKind::Selection, layer.overlay.selection),
    ];
    let drawn = fields
        .iter()
        .filter(|(_, kind, opacity)| *opacity > 0.0 && pools.texture(FieldKey::new(layer.volume, *kind)).is_some());
    let bare = layer.window.is_none().then_some("BARE");
    pools.defs(gpu).into_iter().map(|d| d.0).chain(drawn.map(|l| l.0)).chain(bare).collect()
}

fn uniform(layer: &SliceLayer, (lo, span): (f64, f64)) -> Slice {
    let [black, white] = in_floats(layer.window.unwrap_or([0.0, 1.0]).map(|value| (value - lo) / span));
    let narrow = |v: DVec3| v.as_vec3().to_array();
    Slice {
        top_left: narrow(layer.top_left),
        black,
        per_x: narrow(layer.per_x),
        white,
        per_y: narrow(layer.per_y),
        colour_opacity: layer.overlay.colour,
        selection_colour: layer.overlay.selection_colour,
        selection_opacity: layer.overlay.selection,
        label_opacity: layer.overlay.labels,
        opacity: layer.opacity,
        pad_b: 0,
        pad_c: 0,
    }
}

/// A window as 32-bit floats hold it, the difference of its ends too: where it leads out of them it is narrowed about its middle, which
/// stays as grey as it is.
fn in_floats([black, white]: [f64; 2]) -> [f32; 2] {
    let largest = f64::from(f32::MAX) * 0.99;
    let (level, half) = (black * 0.5 + white * 0.5, white * 0.5 - black * 0.5);
    if black.abs().max(white.abs()).max(half * 2.0) <= largest || !level.is_finite() {
        return [black as f32, white as f32];
    }
    let level = level.clamp(-largest, largest);
    let room = (largest - level.abs()).max(largest * 0.005).min(largest * 0.5);
    let half = half.min(room);
    [(level - half) as f32, (level + half) as f32]
}

/// A texel for each label: the visible segment's colour, or nothing.
fn write_colours(gpu: &Gpu, texture: &wgpu::Texture, segments: &Segments) {
    let mut texels = vec![[0_u8; 4]; 1 << 16];
    for segment in segments.0.iter().filter(|s| s.visible && s.id != 0) {
        let [r, g, b] = segment.colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
        texels[usize::from(segment.id)] = [r, g, b, 255];
    }
    write(gpu, texture, bytemuck::cast_slice(&texels), 4);
}
