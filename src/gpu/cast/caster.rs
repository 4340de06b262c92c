//! The ray caster: pictures of bodies through the field pools.
//!
//! Owns the kernels, specialised by mode, light, painted fields and merging instead of branching, and group 0. Frames become
//! numbers in `scene`; what a pixel costs is in `shaders/cast/picture.wgsl` (after Bruckner and Gröller 2006, section 4).

use crate::gpu::cast::merging::{Drawn, drawn, resolve};
use crate::gpu::cast::pass::{COLOUR, DEPTH, OBJECT, Targets, data, layout, write};
use crate::gpu::cast::tiles::{Tiles, Window};
use crate::gpu::cast::uniforms::{Scene, View, table};
use crate::gpu::device::constants::{FAR, LIST_WIDTH, MOST_BODIES, MOST_PLANES};
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Draw, Kernel, group};
use crate::gpu::fields::pools::{FieldPools, Fields};
use crate::gpu::picture::frame::{Frame, Mask};
use crate::gpu::picture::image::Image;
use crate::math::DVec2;
use crate::volume::{FieldKind, Mode, Segments, TABLE_ENTRIES};

/// See the module's head.
#[derive(Debug)]
pub struct Caster {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) view: wgpu::Buffer,
    pub(crate) bodies: wgpu::Buffer,
    pub(crate) planes: wgpu::Buffer,
    table: (Vec<[f32; 4]>, wgpu::Texture),
    segments: (Option<Segments>, wgpu::Texture),
    pub(crate) nothing: Targets,
    kernel: Kernel<Draw>,
    pub(crate) visibility: Option<crate::gpu::cast::visibility::Counter>,
    /// Whether empty space is skipped and equal bodies are united; tests turn both off to compare pictures.
    pub shortcuts: bool,
}

impl Caster {
    /// A caster without pipelines; they are made when first needed.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        gpu.scoped("the ray caster", || {
            let uniform = |label, size: usize| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: size as u64,
                    usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            };
            Ok(Self {
                layout: layout(gpu),
                view: uniform("caster view", size_of::<View>()),
                bodies: uniform(
                    "caster bodies",
                    MOST_BODIES as usize * size_of::<crate::gpu::cast::uniforms::CastBody>(),
                ),
                planes: uniform("caster planes", MOST_PLANES as usize * 16),
                table: (Vec::new(), data(gpu, "transfer table", [TABLE_ENTRIES as u32, 1], COLOUR)),
                segments: (None, data(gpu, "segment colours", [256, 1], wgpu::TextureFormat::Rgba8Unorm)),
                nothing: Targets::new(gpu, [1; 2]),
                kernel: Kernel::new(
                    gpu,
                    "cast/picture.wgsl",
                    Draw::cover("march_pixel", &[COLOUR, DEPTH, OBJECT]),
                    &[],
                ),
                visibility: None,
                shortcuts: true,
            })
        })
    }

    /// The picture on the host.
    ///
    /// # Errors
    /// A source that fails, out of memory, a lost device, or more bodies than fit.
    pub fn image(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
    ) -> Result<Image, GpuError> {
        self.part(gpu, pools, fields, frame, &Window::whole(frame.size))
    }

    /// Some rows of the picture, as an image of their own: a window refines band by band.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    pub fn rows(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        rows: std::ops::Range<u32>,
    ) -> Result<Image, GpuError> {
        let size = [frame.size[0], rows.end.min(frame.size[1]).saturating_sub(rows.start)];
        let window = Window { picture: frame.size, origin: DVec2::new(0.0, f64::from(rows.start)), size };
        self.part(gpu, pools, fields, frame, &window)
    }

    /// A window of the picture, as an image of its own.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    pub fn part(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        window: &Window,
    ) -> Result<Image, GpuError> {
        if window.size.contains(&0) {
            return Ok(Image::empty(window.size));
        }
        pools.make_resident(gpu, fields, frame)?;
        self.part_as_held(gpu, pools, fields, frame, window)
    }

    /// The same of what the pools hold already.
    pub(crate) fn part_as_held(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        window: &Window,
    ) -> Result<Image, GpuError> {
        let drawn = self.drawn(pools, fields, frame);
        gpu.scoped("a picture", || {
            let targets = Targets::new(gpu, window.size);
            self.render(gpu, pools, frame, &drawn, window, &targets)?;
            let mut image = crate::gpu::cast::readback::image(gpu, &targets)?;
            resolve(&mut image, &drawn, frame, window);
            Ok(image)
        })
    }

    pub(crate) fn drawn(&self, pools: &FieldPools, fields: &Fields<'_>, frame: &Frame) -> Vec<Drawn> {
        let running = pools.pinned(FieldKind::Selection);
        drawn(&frame.bodies, pools.grid(), fields, &running, self.shortcuts)
    }

    /// Submits a window of the picture.
    fn render(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        frame: &Frame,
        drawn: &[Drawn],
        window: &Window,
        targets: &Targets,
    ) -> Result<(), GpuError> {
        let mut scene = Scene::new(frame, pools.grid(), window, drawn, pools.value_of_texel())?;
        self.set_table(gpu, frame);
        let lists = self.upload(gpu, &scene);
        let other = (scene.passes.len() > 1).then(|| Targets::new(gpu, targets.size));
        let count = scene.passes.len();
        let areas = areas(frame.mode, &scene.tiles, targets.size);
        for (i, [k_from, k_to]) in scene.passes.clone().into_iter().enumerate() {
            // Passes take turns between two sets of targets; the last one ends in the caller's.
            let (to, from) = match &other {
                Some(other) if (count - 1 - i) % 2 == 1 => (other, targets),
                Some(other) => (targets, other),
                None => (targets, &self.nothing),
            };
            scene.view.k_from = k_from;
            scene.view.k_to = k_to;
            gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&scene.view));
            let group = self.group(gpu, &lists, if i == 0 { &self.nothing } else { from });
            let draws = areas
                .iter()
                .map(|(capacity, areas)| {
                    let conditions = self.conditions(gpu, pools, frame, drawn, *capacity, i > 0, i + 1 < count);
                    let groups = [&self.layout, pools.layout()];
                    Ok((self.kernel.pipeline(gpu, &conditions, &groups, &[])?, areas.as_slice()))
                })
                .collect::<Result<Vec<_>, GpuError>>()?;
            // The second pass is the first into its targets.
            self.submit(gpu, pools, &draws, &group, to, i < 2);
        }
        Ok(())
    }

    fn submit(
        &self,
        gpu: &Gpu,
        pools: &FieldPools,
        draws: &[(wgpu::RenderPipeline, &[[u32; 4]])],
        group: &wgpu::BindGroup,
        targets: &Targets,
        clear: bool,
    ) {
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let views = [view(&targets.colour), view(&targets.depth), view(&targets.object)];
        let attachment = |view, nothing: f64| {
            let empty = wgpu::Color { r: nothing, ..wgpu::Color::TRANSPARENT };
            let load = if clear { wgpu::LoadOp::Clear(empty) } else { wgpu::LoadOp::Load };
            let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        let [colour, depth, object] = &views;
        let attachments = [attachment(colour, 0.0), attachment(depth, f64::from(FAR)), attachment(object, 0.0)];
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("cast") });
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("cast"),
                color_attachments: &attachments,
                timestamp_writes: gpu.render_times("cast"),
                ..Default::default()
            });
            pass.set_bind_group(0, group, &[]);
            pass.set_bind_group(1, pools.group(), &[]);
            for (pipeline, areas) in draws {
                pass.set_pipeline(pipeline);
                for &[left, top, right, bottom] in *areas {
                    pass.set_scissor_rect(left, top, right - left, bottom - top);
                    pass.draw(0..3, 0..1);
                }
            }
        }
        gpu.queue.submit([encoder.finish()]);
    }

    /// What the kernel of a frame is compiled for. `capacity`: intervals that are merged per ray; 0: bodies follow one another.
    fn conditions(
        &self,
        gpu: &Gpu,
        pools: &FieldPools,
        frame: &Frame,
        drawn: &[Drawn],
        capacity: u32,
        resume: bool,
        continues: bool,
    ) -> Vec<&'static str> {
        let painted = |kind, opacity: f32| pools.texture(kind).is_some() && opacity > 0.0;
        let lit = frame.lighting.is_some() && frame.mode != Mode::Mip;
        let colour = painted(FieldKind::Colour, frame.overlay.colour);
        let labels = painted(FieldKind::Labels, frame.overlay.labels);
        let masked = drawn.iter().any(|d| d.mask != Mask::None || d.selected.is_some());
        let selection = masked || painted(FieldKind::Selection, frame.overlay.selection);
        let tinted = drawn.iter().any(|d| d.tint.is_some());
        let (dvr, iso) = (frame.mode == Mode::Dvr, matches!(frame.mode, Mode::Iso(_)));
        let own = [
            ("DVR", dvr),
            ("ISO", iso),
            ("MIP", frame.mode == Mode::Mip),
            ("LIT", lit),
            ("COLOUR", colour),
            ("LABELS", labels),
            ("SELECTION", selection),
            // Samples that show nothing are passed over before those that do are looked at closely: for light and paint, and
            // for the one sample in which a surface lies. A maximum is asked of every sample.
            ("STAGED", iso || (dvr && (lit || tinted || colour || labels || selection))),
            ("MERGE", capacity > 0),
            ("UP_TO_16", capacity == 16),
            ("UP_TO_64", capacity == 64),
            ("UP_TO_ALL", capacity == MOST_BODIES),
            ("RESUME", resume),
            ("CONTINUES", continues && frame.mode == Mode::Mip),
            ("PLAIN", !self.shortcuts),
        ];
        let own = own.into_iter().filter(|c| c.1).map(|c| c.0);
        own.chain(pools.defs(gpu).into_iter().map(|d| d.0)).collect()
    }

    pub(crate) fn set_table(&mut self, gpu: &Gpu, frame: &Frame) {
        let entries = table(frame);
        if self.table.0 != entries {
            write(gpu, &self.table.1, bytemuck::cast_slice(&entries), 16);
            self.table.0 = entries;
        }
        if self.segments.0.as_ref() != Some(&frame.overlay.segments) {
            let rows = frame.overlay.segments.0.last().map_or(1, |s| u32::from(s.id) / 256 + 1);
            let mut colours = vec![[0_u8; 4]; rows as usize * 256];
            for s in frame.overlay.segments.0.iter().filter(|s| s.visible) {
                let [r, g, b] = s.colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
                colours[usize::from(s.id)] = [r, g, b, 255];
            }
            self.segments.1 = data(gpu, "segment colours", [256, rows], wgpu::TextureFormat::Rgba8Unorm);
            write(gpu, &self.segments.1, bytemuck::cast_slice(&colours), 4);
            self.segments.0 = Some(frame.overlay.segments.clone());
        }
    }

    /// Writes bodies and planes; answers textures of the tiles' heads and lists.
    pub(crate) fn upload(&self, gpu: &Gpu, scene: &Scene) -> [wgpu::Texture; 2] {
        gpu.queue.write_buffer(&self.bodies, 0, bytemuck::cast_slice(&scene.bodies));
        gpu.queue.write_buffer(&self.planes, 0, bytemuck::cast_slice(&scene.planes));
        let heads = data(gpu, "tile heads", scene.tiles.dims, wgpu::TextureFormat::Rg32Uint);
        write(gpu, &heads, bytemuck::cast_slice(&scene.tiles.heads), 8);
        let rows = (scene.tiles.lists.len() as u32).div_ceil(LIST_WIDTH).max(1);
        let lists = data(gpu, "tile lists", [LIST_WIDTH, rows], OBJECT);
        let mut entries = scene.tiles.lists.clone();
        entries.resize((LIST_WIDTH * rows) as usize, 0);
        write(gpu, &lists, bytemuck::cast_slice(&entries), 4);
        [heads, lists]
    }

    pub(crate) fn group(&self, gpu: &Gpu, lists: &[wgpu::Texture; 2], before: &Targets) -> wgpu::BindGroup {
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let textures =
            [&lists[0], &lists[1], &self.table.1, &self.segments.1, &before.colour, &before.depth, &before.object];
        let views = textures.map(view);
        let buffers = [&self.view, &self.bodies, &self.planes].map(|b| b.as_entire_binding());
        let resources = buffers.into_iter().chain(views.iter().map(wgpu::BindingResource::TextureView));
        group(gpu, "caster", &self.layout, resources)
    }
}

/// What is drawn where: the intervals that a ray must hold (0: bodies follow one another), and rectangles of pixels. A pixel that
/// no body can be met in costs nothing.
fn areas(mode: Mode, tiles: &Tiles, size: [u32; 2]) -> Vec<(u32, Vec<[u32; 4]>)> {
    if mode != Mode::Dvr || tiles.longest_merged == 0 {
        // One pipeline serves all: a box around what it draws costs it less than many small ones.
        let around = |a: [u32; 4], b: [u32; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
        let all = tiles.areas(size, |_| true).into_iter().reduce(around);
        return vec![(0, all.into_iter().collect())];
    }
    // Few capacities, so that few pipelines are made.
    let capacity = [4, 16, 64].into_iter().find(|&c| c as usize >= tiles.longest_merged).unwrap_or(MOST_BODIES);
    let merged = tiles.areas(size, |merges| merges);
    let mut areas = vec![(0, tiles.areas(size, |merges| !merges)), (capacity, merged)];
    areas.retain(|(_, areas)| !areas.is_empty());
    areas
}
