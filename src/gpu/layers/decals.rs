//! Decals as lists of marks that every pixel's ray meets: shaders/mesh/decal.wgsl and shaders/mesh/sort_marks.wgsl.
//!
//! All are drawn in one pass, each piece where a body of the picture holds it. How many marks a picture has is known only then: where
//! there was no room for all it is drawn once more. Owns how much room the last picture needed. Meshes and pictures are uploaded when other
//! ones come.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Draw, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::device::textures::texture;
use crate::gpu::layers::Rays;
use crate::gpu::picture::decal::{Decal, DecalCorner as DecalCornerOf, DecalMesh, DecalPicture, Texels};
use crate::math::{DVec3, Pose};
use crate::shared_struct;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// Of the pass that lays marks: nothing is kept of it.
const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;
const GROUP: u32 = 8;
const MARK: usize = size_of::<Mark>();

shared_struct! {
    /// See shaders/mesh/decal.wgsl.
    pub(crate) struct DecalPlace {
        /// World from the mesh's space, first column.
        pub column_x: [f32; 3],
        /// The body that it is on.
        pub body: u32,
        /// Second column.
        pub column_y: [f32; 3],
        /// Its picture's first texel.
        pub first_texel: u32,
        /// Third column.
        pub column_z: [f32; 3],
        /// Levels of its picture.
        pub level_count: u32,
        /// Origin of the mesh's space as seen from the eye.
        pub origin: [f32; 3],
        /// 1 if texels are distances.
        pub is_shape: u32,
        /// Display-referred.
        pub fill: [f32; 3],
        /// 0..1.
        pub opacity: f32,
        /// Display-referred.
        pub halo: [f32; 3],
        /// 1 if there is one.
        pub has_halo: u32,
        /// Ambient, diffuse, specular, power.
        pub lighting: [f32; 4],
        /// Texels of the finest level.
        pub size: [u32; 2],
        /// Mm along the ray.
        pub toward_mm: f32,
        /// 1 if meshes that cut take it away.
        pub is_cut: u32,
        /// Place in the picture by u, then by v.
        pub turn: [f32; 4],
        /// Of (0, 0).
        pub shift: [f32; 2],
        /// 1 if the picture repeats.
        pub repeats: u32,
        /// Texels of the finest level a mm of the surface, on the mean.
        pub texels_per_mm: f32,
    }
}

shared_struct! {
    /// See [`crate::gpu::DecalCorner`].
    pub(crate) struct DecalCorner {
        /// Mm from the mesh's origin.
        pub place: [f32; 3],
        /// Across.
        pub u: f32,
        /// Outward.
        pub normal: [f32; 3],
        /// Down.
        pub v: f32,
    }
}

shared_struct! {
    /// What a ray meets of a decal.
    pub(crate) struct Mark {
        /// Steps along the ray.
        pub at: f32,
        /// Colour times opacity, and opacity: red lowest.
        pub colour: u32,
        /// The body that it is on; the highest bit: meshes that cut take it away.
        pub body: u32,
        /// The number of the next one and 1; 0: the last one.
        pub next: u32,
    }
}

/// A decal where a body holds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stuck<'a> {
    /// What is drawn.
    pub decal: &'a Decal,
    /// Place of the body in the picture's list.
    pub body: u32,
    /// `world_from_rest` of the body.
    pub pose: Pose,
}

/// What the rays of a picture meet of decals.
#[derive(Debug)]
pub(crate) struct Marks {
    /// How many there are; then by pixel the number of its first one and 1.
    pub heads: wgpu::Buffer,
    /// The marks.
    pub marks: wgpu::Buffer,
}

/// Meshes and pictures on the device.
#[derive(Debug)]
struct Held {
    meshes: Vec<Arc<DecalMesh>>,
    pictures: Vec<Arc<DecalPicture>>,
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    texels: wgpu::Buffer,
    /// By mesh: its first corner, its first index, how many indices.
    ranges: Vec<(u32, u32, u32)>,
    /// By mesh: area of its picture by mm² of surface.
    scales: Vec<f64>,
    /// By picture: its first texel.
    firsts: Vec<u32>,
}

/// Draws decals.
#[derive(Debug)]
pub(crate) struct Decals {
    lay: Kernel<Draw>,
    sort: Kernel<Compute>,
    held: Option<Held>,
    /// Marks that there is room for.
    room: u32,
}

impl Decals {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let read = |bytes| Binding::Elements { bytes, written: false };
        let written = |bytes| Binding::Elements { bytes, written: true };
        let lay = [read(size_of::<DecalPlace>()), read(size_of::<DecalCorner>()), read(4), written(4), written(MARK)];
        let entry = Draw { vertex: "corner", ..Draw::cover("lay", &[TARGET]) };
        Self {
            lay: Kernel::new(gpu, shader!("mesh/decal.wgsl"), entry, &lay),
            sort: Kernel::new(gpu, shader!("mesh/sort_marks.wgsl"), Compute("sort"), &[written(4), written(MARK)]),
            held: None,
            room: 1 << 16,
        }
    }

    /// What every ray meets, nearest first; `None` where none meets any.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub(crate) fn draw(&mut self, gpu: &Gpu, stuck: &[Stuck<'_>], rays: &Rays<'_>) -> Result<Option<Marks>, GpuError> {
        let held = match self.held.take().filter(|held| held.has_all(stuck)).or_else(|| Held::new(gpu, stuck)) {
            Some(held) => self.held.insert(held),
            None => return Ok(None),
        };
        let drawn: Vec<_> = stuck.iter().filter_map(|s| Some((held.place(s, rays.eye)?, held.range(s)?))).collect();
        let places: Vec<DecalPlace> = drawn.iter().map(|(place, _)| *place).collect();
        if places.is_empty() {
            return Ok(None);
        }
        let places = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("decal places"),
            contents: bytemuck::cast_slice(&places),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let before = [Some(rays.layout), None];
        let lay = self.lay.pipeline(gpu, &[], &before, &[])?;
        let sort = self.sort.pipeline(gpu, &[], &before, &[])?;
        let [width, height] = rays.size;
        let buffer = |label, size, more| {
            let usage = wgpu::BufferUsages::STORAGE | more;
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let target = texture(gpu, "decals", rays.size, TARGET, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let target = target.create_view(&Default::default());
        loop {
            // New buffers are empty.
            let heads =
                buffer("mark heads", 4 * (1 + u64::from(width) * u64::from(height)), wgpu::BufferUsages::COPY_SRC);
            let marks = buffer("marks", MARK as u64 * u64::from(self.room), wgpu::BufferUsages::empty());
            let count = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("mark count"),
                size: 4,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let laid = [&places, &held.corners, &held.texels, &heads, &marks].map(wgpu::Buffer::as_entire_binding);
            let sorted = [&heads, &marks].map(wgpu::Buffer::as_entire_binding);
            let (laid, sorted) = (self.lay.group(gpu, laid), self.sort.group(gpu, sorted));
            let mut encoder =
                gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("decals") });
            {
                let ops =
                    wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Discard };
                let view = &target;
                let to = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("decals"),
                    color_attachments: &[Some(to)],
                    ..Default::default()
                });
                pass.set_pipeline(&lay);
                pass.set_bind_group(0, rays.group, &[]);
                pass.set_bind_group(2, laid.as_ref(), &[]);
                pass.set_index_buffer(held.indices.slice(..), wgpu::IndexFormat::Uint32);
                for (i, (_, (corner, index, indices))) in (0..).zip(&drawn) {
                    pass.draw_indexed(*index..index + indices, *corner as i32, i..i + 1);
                }
            }
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&sort);
                pass.set_bind_group(0, rays.group, &[]);
                pass.set_bind_group(2, sorted.as_ref(), &[]);
                pass.dispatch_workgroups(width.div_ceil(GROUP), height.div_ceil(GROUP), 1);
            }
            encoder.copy_buffer_to_buffer(&heads, 0, &count, 0, 4);
            gpu.queue.submit([encoder.finish()]);
            let counted = gpu.read_buffer(&count, "marks")?;
            let counted = counted.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
            match counted {
                0 => return Ok(None),
                n if n <= self.room => return Ok(Some(Marks { heads, marks })),
                n => self.room = n.next_power_of_two(),
            }
        }
    }
}

/// Area that a mesh covers of its picture for a mm² of its own.
fn scale(mesh: &DecalMesh) -> f64 {
    let (mut flat, mut whole) = (0.0, 0.0);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.corners[i as usize]);
        let at = |corner: DecalCornerOf| DVec3::from_array(corner.place.map(f64::from));
        whole += (at(b) - at(a)).cross(at(c) - at(a)).length();
        let uv = |corner: DecalCornerOf| [f64::from(corner.u - a.u), f64::from(corner.v - a.v)];
        let ([bu, bv], [cu, cv]) = (uv(b), uv(c));
        flat += (bu * cv - bv * cu).abs();
    }
    if whole > 0.0 { flat / whole } else { 0.0 }
}

impl Held {
    fn new(gpu: &Gpu, stuck: &[Stuck<'_>]) -> Option<Self> {
        let (mut meshes, mut pictures): (Vec<Arc<DecalMesh>>, Vec<Arc<DecalPicture>>) = (Vec::new(), Vec::new());
        let (mut corners, mut indices, mut texels): (Vec<DecalCorner>, Vec<u32>, Vec<u32>) = Default::default();
        let (mut ranges, mut scales, mut firsts) = (Vec::new(), Vec::new(), Vec::new());
        for Stuck { decal, .. } in stuck {
            if !meshes.iter().any(|mesh| Arc::ptr_eq(mesh, &decal.mesh)) {
                let own: Vec<u32> = decal.mesh.triangles.iter().flatten().copied().collect();
                ranges.push((corners.len() as u32, indices.len() as u32, own.len() as u32));
                corners.extend(bytemuck::cast_slice::<_, DecalCorner>(&decal.mesh.corners));
                indices.extend(own);
                scales.push(scale(&decal.mesh));
                meshes.push(Arc::clone(&decal.mesh));
            }
            if !pictures.iter().any(|picture| Arc::ptr_eq(picture, &decal.picture)) {
                firsts.push(texels.len() as u32);
                texels.extend(decal.picture.levels.iter().flat_map(|(_, texels)| texels));
                pictures.push(Arc::clone(&decal.picture));
            }
        }
        if indices.is_empty() || texels.is_empty() {
            return None;
        }
        let list = |label, contents, usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let storage = wgpu::BufferUsages::STORAGE;
        Some(Self {
            meshes,
            pictures,
            corners: list("decal corners", bytemuck::cast_slice(&corners), storage),
            indices: list("decal triangles", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            texels: list("decal texels", bytemuck::cast_slice(&texels), storage),
            ranges,
            scales,
            firsts,
        })
    }

    fn has_all(&self, stuck: &[Stuck<'_>]) -> bool {
        stuck.iter().all(|s| self.mesh(s).is_some() && self.picture(s).is_some())
    }

    fn mesh(&self, stuck: &Stuck<'_>) -> Option<usize> {
        self.meshes.iter().position(|mesh| Arc::ptr_eq(mesh, &stuck.decal.mesh))
    }

    fn picture(&self, stuck: &Stuck<'_>) -> Option<usize> {
        self.pictures.iter().position(|picture| Arc::ptr_eq(picture, &stuck.decal.picture))
    }

    fn range(&self, stuck: &Stuck<'_>) -> Option<(u32, u32, u32)> {
        self.ranges.get(self.mesh(stuck)?).copied().filter(|range| range.2 > 0)
    }

    fn place(&self, stuck: &Stuck<'_>, eye: DVec3) -> Option<DecalPlace> {
        let Stuck { decal, body, pose } = stuck;
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let (size, _) = decal.picture.levels.first()?;
        let turn = pose.world_from_rest().matrix3;
        let [u, v, shift] = decal.picture.picture_from_uv;
        let mesh = self.mesh(stuck)?;
        let texels = f64::from(size[0]) * f64::from(size[1]) * f64::from((u[0] * v[1] - u[1] * v[0]).abs());
        let lighting = decal.lighting.map_or([1.0, 0.0, 0.0, 1.0], |l| [l.ambient, l.diffuse, l.specular, l.power]);
        Some(DecalPlace {
            column_x: narrow(turn.x_axis),
            body: *body,
            column_y: narrow(turn.y_axis),
            first_texel: *self.firsts.get(self.picture(stuck)?)?,
            column_z: narrow(turn.z_axis),
            level_count: decal.picture.levels.len() as u32,
            origin: narrow(pose.world_from_rest().transform_point3(decal.mesh.origin) - eye),
            is_shape: u32::from(decal.picture.texels == Texels::Distances),
            fill: decal.fill,
            opacity: decal.opacity,
            halo: decal.halo.unwrap_or_default(),
            has_halo: u32::from(decal.halo.is_some()),
            lighting,
            size: *size,
            toward_mm: decal.toward_mm as f32,
            is_cut: u32::from(decal.is_cut),
            turn: [u[0], u[1], v[0], v[1]],
            shift,
            repeats: u32::from(decal.picture.repeats),
            texels_per_mm: (self.scales.get(mesh)? * texels).sqrt() as f32,
        })
    }
}
