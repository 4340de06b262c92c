//! The ray caster: pictures of bodies through the field pools.
//!
//! Owns group 0 and what the kernel is compiled for: mode, light, painted fields and merging, instead of branching. Frames become
//! numbers in `uniforms`; what a pixel costs is in `shaders/cast/picture.wgsl` (after Bruckner and Gröller 2006, section 4).

use crate::gpu::cast::focus::draw_focused;
use crate::gpu::cast::forms::{Begins, Form, Forms, Groups, Share, Work};
use crate::gpu::cast::higher::Higher;
use crate::gpu::cast::holes::{Hole, bounds_of, boxed_bodies, lay_through, posed_boxes};
use crate::gpu::cast::look_tables::{LookTables, LookTextures};
use crate::gpu::cast::looks::{Kind, Looks, MOST_LOOKS};
use crate::gpu::cast::merging::{MergedBody, Uniting, resolve, unite};
use crate::gpu::cast::sticking::stuck_on;
use crate::gpu::cast::tiles::{Tiles, Window};
use crate::gpu::cast::uniforms::{BodyMatter, CastBody, FrameUniforms, View};
use crate::gpu::device::constants::{LIST_WIDTH, MOST_BODIES, MOST_HOLES, MOST_PLANES};
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, group, group_layout};
use crate::gpu::device::textures::{OBJECT, Targets, data, write};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::layers::{DrawnLayers, LayerRaster, Rays};
use crate::gpu::picture::frame::{Frame, Mask, Overlay};
use crate::gpu::picture::image::Image;
use crate::math::DVec2;
use crate::volume::{FieldKey, FieldKind};
use std::sync::Arc;

/// Makes pictures, picks and measurements of [`Frame`]s: keeps the kernels, the buffers that a frame is written into and the tables
/// of looks, so that the next picture costs only what changed. Lives as long as its device.
#[derive(Debug)]
pub struct Caster {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) view: wgpu::Buffer,
    pub(crate) bodies: wgpu::Buffer,
    pub(crate) planes: wgpu::Buffer,
    matters: wgpu::Buffer,
    holes: wgpu::Buffer,
    looks: LookTables,
    pub(crate) nothing: Targets,
    forms: Forms,
    /// Made when a picture first holds a mesh.
    pub(crate) layers: Option<LayerRaster>,
    pub(crate) visibility: Option<crate::gpu::cast::counting::Counter>,
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
                bodies: uniform("caster bodies", MOST_BODIES as usize * size_of::<CastBody>()),
                planes: uniform("caster planes", MOST_PLANES as usize * 16),
                matters: uniform("caster matters", MOST_BODIES as usize * size_of::<BodyMatter>()),
                holes: uniform("caster holes", MOST_HOLES as usize * size_of::<Hole>()),
                looks: LookTables::new(gpu),
                nothing: Targets::new(gpu, [1; 2]),
                forms: Forms::new(gpu),
                layers: None,
                visibility: None,
                shortcuts: true,
            })
        })
    }

    /// How pixels are marched. Pictures are the same.
    pub fn form(&self) -> Form {
        self.forms.form
    }

    /// Chooses it; what is best for the adapter is chosen already.
    pub fn set_form(&mut self, form: Form) {
        self.forms.form = form;
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
        let window = Window { picture: frame.size, origin: DVec2::new(0.0, f64::from(rows.start)), size, only: None };
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
        let mut draw = |frame: &Frame, window: &Window| self.all_alike(gpu, pools, fields, frame, window);
        match &frame.focus {
            Some(focus) if focus.changes() => draw_focused(focus, frame, window, &mut draw),
            _ => draw(frame, window),
        }
    }

    /// A picture without a focus.
    fn all_alike(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        window: &Window,
    ) -> Result<Image, GpuError> {
        // What no finer box is met in is drawn as if there were none: those pixels do not change by a bit.
        let plain = frame.without_boxes();
        let uniting = if self.shortcuts { Uniting::Yes } else { Uniting::No };
        let mut drawn = unite(&plain, fields, pools, uniting)?;
        let (mut image, mut codes) = self.picture(gpu, pools, fields, &plain, &drawn, window)?;
        if !frame.boxes.is_empty() {
            let inside = Frame { bodies: boxed_bodies(frame), ..frame.clone() };
            let uniting = if self.shortcuts { Uniting::As(&drawn) } else { Uniting::No };
            let fine = unite(&inside, fields, pools, uniting)?;
            let boxes = posed_boxes(frame, fields);
            let around = bounds_of(boxes.iter().map(|b| &b.solid), &frame.camera, window);
            drawn.extend(fine);
            if let Some((around, at)) = around {
                let (through, of_through) = self.picture(gpu, pools, fields, frame, &drawn, &around)?;
                lay_through((&mut image, &mut codes), (&through, &of_through), at);
            }
        }
        resolve(&mut image, &codes, &drawn, frame, window);
        Ok(image)
    }

    /// A window of bodies and what each pixel's object is said to be.
    fn picture(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        drawn: &[MergedBody],
        window: &Window,
    ) -> Result<(Image, Vec<u32>), GpuError> {
        gpu.scoped("a picture", || {
            let targets = Targets::new(gpu, window.size);
            let scene = self.scene(gpu, pools, fields, frame, drawn, window)?;
            self.render(gpu, pools, frame, drawn, scene, &targets)?;
            crate::gpu::cast::readback::image(gpu, &targets)
        })
    }

    /// The numbers of a frame, its volumes bound and what rays may skip made ready.
    pub(crate) fn scene(
        &self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        drawn: &[MergedBody],
        window: &Window,
    ) -> Result<FrameUniforms, GpuError> {
        let looks = Looks::of(frame, drawn);
        if looks.rows.len() > MOST_LOOKS {
            return Err(GpuError::TooManyLooks { looks: looks.rows.len(), most: MOST_LOOKS });
        }
        let mut matters: Vec<_> = drawn.iter().map(|d| d.matter(frame)).collect();
        pools.bind(gpu, &frame.volumes())?;
        pools.pair(gpu)?;
        let higher = if looks.kind == Kind::Mip { Higher::of(fields, pools, drawn) } else { None };
        matters.extend(higher.iter().flat_map(Higher::matters));
        let skips = pools.skip_maps(gpu, fields, &matters)?;
        let (skips, above) = skips.split_at(drawn.len());
        let mut uniforms = FrameUniforms::new(frame, fields, pools, window, drawn, looks, skips)?;
        if let Some(higher) = higher {
            higher.tell(&mut uniforms.view, above);
        }
        Ok(uniforms)
    }

    /// Submits a window of the picture.
    fn render(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        frame: &Frame,
        drawn: &[MergedBody],
        mut scene: FrameUniforms,
        targets: &Targets,
    ) -> Result<(), GpuError> {
        self.set_looks(gpu, pools, frame, &scene);
        let lists = self.upload(gpu, &scene);
        let layers = self.draw_layers(gpu, frame, drawn, &mut scene, &lists, targets.size)?;
        let other = (scene.passes.len() > 1).then(|| Targets::new(gpu, targets.size));
        let count = scene.passes.len();
        let opaque = layers.as_ref().and_then(|l| l.opaque.as_ref());
        let marked = layers.as_ref().is_some_and(|l| l.marked);
        let most = layers.as_ref().map_or(1, |l| l.pieces);
        let shares = shares(scene.looks.kind, &scene.tiles, (most, scene.pieces));
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
            let group = self.group(gpu, &lists, scene.looks.own, if i == 0 { &self.nothing } else { from });
            let continues = i + 1 < count && (scene.looks.kind == Kind::Mip || opaque.is_some() || marked);
            let work = |&(share, capacity): &(Share, u32)| {
                let mut conditions =
                    self.conditions(gpu, pools, frame, (drawn, &scene.looks), capacity, i > 0, continues);
                conditions.extend(layers.iter().flat_map(DrawnLayers::conditions));
                conditions.extend(of_events(scene.looks.kind, capacity, marked));
                Work { share, conditions }
            };
            let work: Vec<Work> = shares.iter().map(work).collect();
            let groups = Groups {
                caster: (&self.layout, &group),
                fields: (pools.layout(), pools.group()),
                layers: self.layers.as_ref().zip(layers.as_ref()).map(|(raster, drawn)| (&raster.layout, &drawn.group)),
            };
            // The second pass is the first into its targets.
            let begins = if i < 2 { Begins::With(opaque) } else { Begins::AsItIs };
            self.forms.submit(gpu, &scene.tiles, &work, groups, to, begins)?;
        }
        Ok(())
    }

    /// Draws the meshes among a frame's bodies, as rays meet them, and what is stuck on the bodies.
    pub(crate) fn draw_layers(
        &mut self,
        gpu: &Gpu,
        frame: &Frame,
        drawn: &[MergedBody],
        scene: &mut FrameUniforms,
        lists: &[wgpu::Texture; 2],
        size: [u32; 2],
    ) -> Result<Option<DrawnLayers>, GpuError> {
        let stuck = stuck_on(frame, drawn);
        if frame.layers.opaque.is_empty() && frame.layers.cuts.is_empty() && stuck.is_empty() {
            return Ok(None);
        }
        gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&scene.view));
        let group = self.group(gpu, lists, scene.looks.own, &self.nothing);
        let rays = Rays { layout: &self.layout, group: &group, eye: frame.camera.eye, size };
        let mut classes: Vec<Arc<[u32]>> = Vec::new();
        let class = |body: &MergedBody| {
            let known = classes.iter().position(|spared| *spared == body.spared_by);
            known.unwrap_or_else(|| {
                classes.push(body.spared_by.clone());
                classes.len() - 1
            })
        };
        let of: Vec<usize> = drawn.iter().map(class).collect();
        let raster = self.layers.get_or_insert_with(|| LayerRaster::new(gpu));
        let layers = raster.draw(gpu, &frame.layers, &stuck, &classes, &rays)?;
        if let Some(layers) = &layers
            && layers.pieces > 1
        {
            for (body, class) in scene.bodies.iter_mut().zip(of) {
                body.mask |= layers.firsts[class].map_or(0, |first| (first + 1) << 2);
            }
            gpu.queue.write_buffer(&self.bodies, 0, bytemuck::cast_slice(&scene.bodies));
        }
        Ok(layers)
    }

    /// What the kernel of a frame is compiled for. `capacity`: intervals that are merged per ray; 0: bodies follow one another.
    fn conditions(
        &self,
        gpu: &Gpu,
        pools: &FieldPools,
        frame: &Frame,
        (drawn, looks): (&[MergedBody], &Looks),
        capacity: u32,
        resume: bool,
        continues: bool,
    ) -> Vec<&'static str> {
        let painted = |kind, opacity: fn(&Overlay) -> f32| {
            let shows = |d: &MergedBody| pools.texture(FieldKey::new(d.volume, kind)).is_some();
            drawn.iter().any(|d| opacity(frame.overlay_of(d.volume)) > 0.0 && shows(d))
        };
        let lit = looks.lit;
        let colour = painted(FieldKind::Colour, |overlay| overlay.colour);
        let labels = painted(FieldKind::Labels, |overlay| overlay.labels);
        let [tells_selection, tells_labels] =
            [FieldKind::Selection, FieldKind::Labels].map(|kind| painted(kind, |_| 1.0));
        let masked = drawn.iter().any(|d| d.mask != Mask::None);
        let selection = masked || painted(FieldKind::Selection, |overlay| overlay.selection);
        let tinted = drawn.iter().any(|d| d.tint.is_some());
        let (dvr, iso) = (looks.kind == Kind::Dvr, looks.kind == Kind::Iso);
        let modes = looks.kind == Kind::Modes;
        let ball = frame.layers.ball;
        let contour = ball.is_some_and(|b| b.contour);
        let dear = lit || contour || tinted || colour || labels || selection;
        let holes = !frame.boxes.is_empty();
        let staged = iso || modes || (dvr && (looks.refines || dear || holes));
        let own = [
            ("DVR", dvr),
            ("ISO", iso),
            ("MIP", looks.kind == Kind::Mip),
            ("MODES", modes),
            ("TELLS_SELECTION", tells_selection),
            ("TELLS_LABELS", tells_labels),
            ("LIT", lit),
            ("PAIRS", pools.reads_pairs()),
            ("COLOUR", colour),
            ("LABELS", labels),
            ("SELECTION", selection),
            // Samples that show nothing are passed over before those that do are looked at closely: for light and paint, and
            // for the one sample in which a surface lies. A maximum is asked of every sample.
            ("STAGED", staged),
            ("REFINE", looks.refines),
            ("HOLES", holes),
            ("FOUND_AT", holes || looks.refines),
            ("MERGE", capacity > 0),
            ("UP_TO_16", capacity == 16),
            ("UP_TO_64", capacity == 64),
            ("UP_TO_ALL", capacity == MOST_BODIES),
            ("RESUME", resume),
            ("CONTINUES", continues),
            ("BALL", ball.is_some()),
            ("CONTOUR", contour),
            ("PLAIN", !self.shortcuts),
        ];
        let own = own.into_iter().filter(|c| c.1).map(|c| c.0);
        let of_looks = looks.conditions(pools.has_labels_in_place());
        own.chain(of_looks).chain(pools.defs(gpu).into_iter().map(|d| d.0)).collect()
    }

    /// Has the tables of a frame's looks, labels and segment colours.
    pub(crate) fn set_looks(&mut self, gpu: &Gpu, pools: &FieldPools, frame: &Frame, scene: &FrameUniforms) {
        self.looks.set(gpu, pools, frame, &scene.looks);
    }

    /// Writes bodies and planes; answers textures of the tiles' heads and lists.
    pub(crate) fn upload(&self, gpu: &Gpu, scene: &FrameUniforms) -> [wgpu::Texture; 2] {
        gpu.queue.write_buffer(&self.bodies, 0, bytemuck::cast_slice(&scene.bodies));
        gpu.queue.write_buffer(&self.matters, 0, bytemuck::cast_slice(&scene.matters));
        gpu.queue.write_buffer(&self.planes, 0, bytemuck::cast_slice(&scene.planes));
        gpu.queue.write_buffer(&self.holes, 0, bytemuck::cast_slice(&scene.holes));
        let heads = data(gpu, "tile heads", scene.tiles.dims, wgpu::TextureFormat::Rg32Uint);
        write(gpu, &heads, bytemuck::cast_slice(&scene.tiles.heads), 8);
        let rows = (scene.tiles.lists.len() as u32).div_ceil(LIST_WIDTH).max(1);
        let lists = data(gpu, "tile lists", [LIST_WIDTH, rows], OBJECT);
        let mut entries = scene.tiles.lists.clone();
        entries.resize((LIST_WIDTH * rows) as usize, 0);
        write(gpu, &lists, bytemuck::cast_slice(&entries), 4);
        [heads, lists]
    }

    /// Group 0. `own`: bodies have looks of their own.
    pub(crate) fn group(&self, gpu: &Gpu, lists: &[wgpu::Texture; 2], own: bool, before: &Targets) -> wgpu::BindGroup {
        let LookTextures { table, label_looks, segments } = self.looks.textures(own);
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let textures = [&lists[0], &lists[1], table, segments, &before.colour, &before.depth, &before.object];
        let views = textures.map(view);
        let buffers = [&self.view, &self.bodies, &self.planes].map(|b| b.as_entire_binding());
        let textures = views.iter().map(wgpu::BindingResource::TextureView);
        let label_looks = view(label_looks);
        let label_looks = wgpu::BindingResource::TextureView(&label_looks);
        let resources = buffers.into_iter().chain(textures).chain([
            self.matters.as_entire_binding(),
            label_looks,
            self.holes.as_entire_binding(),
        ]);
        group(gpu, "caster", &self.layout, resources)
    }
}

/// How what lies between bodies' samples is found: surfaces and maxima among others, marks of decals.
fn of_events(kind: Kind, capacity: u32, marked: bool) -> impl Iterator<Item = &'static str> {
    let merges = capacity > 0;
    let all = [
        ("EVENTS", kind == Kind::Modes || marked && merges),
        ("BETWEEN_MARKS", marked && kind == Kind::Dvr && !merges),
        ("MARKED_AFTER", marked && matches!(kind, Kind::Iso | Kind::Mip)),
    ];
    all.into_iter().filter(|c| c.1).map(|c| c.0)
}

/// Group 0 of everything that marches, as shaders/lib/body.wgsl, shaders/lib/look.wgsl and resumed pictures number it.
fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    use Binding::Uniform;
    let stages = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
    let lists = [Binding::UINT_2D; 2];
    let colours = [Binding::FLOAT_2D; 2];
    let before = [Binding::FLOAT_2D, Binding::FLOAT_2D, Binding::UINT_2D];
    let bindings = [Uniform(0); 3].into_iter().chain(lists).chain(colours).chain(before);
    let bindings: Vec<_> = bindings.chain([Uniform(0), Binding::FLOAT_2D, Uniform(0)]).collect();
    group_layout(gpu, "caster", stages, &bindings)
}

/// Which tiles are drawn by which pipeline: by the intervals that a ray must hold there (0: bodies follow one another). A pixel that
/// no body can be met in costs nothing. `cut`: into how many an interval may be cut; `more`: how many more holes make of them.
fn shares(kind: Kind, tiles: &Tiles, (cut, more): (usize, usize)) -> Vec<(Share, u32)> {
    // Few capacities, so that few pipelines are made.
    let capacity = |longest: usize| {
        let most = (longest + more) * cut;
        [4, 16, 64].into_iter().find(|&c| c as usize >= most).unwrap_or(MOST_BODIES)
    };
    if kind == Kind::Modes {
        return vec![(Share::All, capacity(tiles.longest_merged.max(tiles.longest_ordered)))];
    }
    if kind != Kind::Dvr || tiles.longest_merged == 0 {
        return vec![(Share::All, 0)];
    }
    let ordered = (tiles.longest_ordered > 0).then_some((Share::Ordered, 0));
    ordered.into_iter().chain([(Share::Merged, capacity(tiles.longest_merged))]).collect()
}
