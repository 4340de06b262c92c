//! All fields of one volume on the GPU, and their one bind group.
//!
//! Owns a [`Pool`] for each field and decides with `residency` what they hold for a frame. The host's fields stay the truth:
//! everything here can be made again from them. Shaders reach it through `shaders/lib/field.wgsl` (group 1).

use super::pool::{self, Page, Pool};
use super::residency::{self, Need};
use super::{Frame, Gpu, GpuError};
use crate::shared_struct;
use crate::volume::{
    BrickIndex, BrickKey, DensityMap, Field, FieldKind, Grid, Mode, Refresh, TexelFormat, TransferFunction,
};
use std::collections::HashSet;

/// The fields of one volume; blank ones cost nothing.
#[derive(Clone, Copy, Debug)]
pub struct Fields<'a> {
    /// Density.
    pub density: &'a Field,
    /// Painted colour.
    pub colour: &'a Field,
    /// Selection.
    pub selection: &'a Field,
    /// Labels.
    pub labels: &'a Field,
}

impl<'a> Fields<'a> {
    /// The field of a kind.
    pub fn get(&self, kind: FieldKind) -> &'a Field {
        match kind {
            FieldKind::Density => self.density,
            FieldKind::Colour => self.colour,
            FieldKind::Selection => self.selection,
            FieldKind::Labels => self.labels,
        }
    }
}

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

/// What decides which bricks are needed, of the last frame.
#[derive(Clone, Debug, PartialEq)]
struct Sight {
    camera: crate::math::Camera,
    size: [u32; 2],
    bodies: Vec<super::Body>,
}

/// See the module's head.
#[derive(Debug)]
pub struct FieldPools {
    grid: Grid,
    budget: u64,
    map: DensityMap,
    bricks: [u32; 3],
    pools: [Option<Pool>; 4],
    look: Option<(TransferFunction, Mode)>,
    sight: Option<Sight>,
    slices: [Option<u32>; 3],
    /// By brick of level 0: whether the look shows any of it.
    visible: Vec<bool>,
    /// Something changed since pages were last made.
    stale: bool,
    /// Whether all needed bricks are held at level 0, so that the camera decides nothing.
    complete: bool,
    info: wgpu::Buffer,
    sampler: wgpu::Sampler,
    nothing: [wgpu::Texture; 3],
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

/// Share of the budget that a field may take, in eighths.
fn eighths(kind: FieldKind) -> u64 {
    match kind {
        FieldKind::Density => 4,
        FieldKind::Colour => 2,
        FieldKind::Selection | FieldKind::Labels => 1,
    }
}

const fn place(kind: FieldKind) -> usize {
    kind as usize
}

impl FieldPools {
    /// Pools for the volume of `density`, together at most `budget_bytes`, half of it for density. Nothing is uploaded yet.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub fn new(gpu: &Gpu, grid: &Grid, density: &Field, budget_bytes: u64) -> Result<Self, GpuError> {
        let bricks = density.brick_dims(0);
        let pool = Pool::new(
            gpu,
            FieldKind::Density,
            density.format(),
            bricks,
            budget_bytes / 8 * eighths(FieldKind::Density),
        )?;
        gpu.scoped("the fields' bindings", || {
            let nothing = [wgpu::TextureFormat::R8Unorm, wgpu::TextureFormat::R8Uint, wgpu::TextureFormat::Rg32Uint]
                .map(|format| nothing(gpu, format));
            let layout = layout(gpu, filters(gpu, &pool));
            let info = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("field info"),
                size: size_of::<FieldInfo>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("linear"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            });
            let pools = [Some(pool), None, None, None];
            let group = group(gpu, &layout, &info, &sampler, &nothing, &pools);
            Ok(Self {
                grid: *grid,
                budget: budget_bytes,
                map: *density.map(),
                bricks,
                pools,
                look: None,
                sight: None,
                slices: [None; 3],
                visible: Vec::new(),
                stale: true,
                complete: false,
                info,
                sampler,
                nothing,
                layout,
                group,
            })
        })
    }

    /// Decides which bricks this frame needs and makes them resident: all that the look shows if they fit; otherwise the
    /// nearest and most visible finest, the rest at the next coarser level that is held. Never leaves a hole. Answers whether
    /// anything changed; the same frame again changes nothing.
    ///
    /// # Errors
    /// Out of memory, a lost device, or a source that fails.
    pub fn make_resident(&mut self, gpu: &Gpu, fields: &Fields<'_>, frame: &Frame) -> Result<bool, GpuError> {
        let look = (frame.transfer.clone(), frame.mode);
        if self.look.as_ref() != Some(&look) {
            self.look = Some(look);
            self.visible.clear();
            self.stale = true;
        }
        let sight = Sight { camera: frame.camera, size: frame.size, bodies: frame.bodies.clone() };
        if self.sight.as_ref() != Some(&sight) {
            self.sight = Some(sight);
            self.stale |= !self.complete;
        }
        self.settle(gpu, fields)
    }

    /// The same for the slice `index` along voxel axis `axis`, whatever the look shows.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn make_slice_resident(
        &mut self,
        gpu: &Gpu,
        fields: &Fields<'_>,
        axis: usize,
        index: u32,
    ) -> Result<bool, GpuError> {
        let row = index.min(self.grid.dims[axis].saturating_sub(1)) / crate::volume::BRICK;
        if self.slices[axis] != Some(row) {
            self.slices[axis] = Some(row);
            self.stale = true;
        }
        self.settle(gpu, fields)
    }

    fn settle(&mut self, gpu: &Gpu, fields: &Fields<'_>) -> Result<bool, GpuError> {
        gpu.check()?;
        if self.map != *fields.density.map() {
            self.map = *fields.density.map();
            self.pools[0] = None;
            self.stale = true;
        }
        if !self.stale {
            return Ok(false);
        }
        if self.visible.is_empty() {
            self.visible = self.shown(fields.density);
        }
        let needed: Vec<bool> = self.needed();
        let mut changed = false;
        self.complete = true;
        for kind in FieldKind::ALL {
            let field = fields.get(kind);
            if self.pools[place(kind)].is_none() {
                if field.is_blank() && kind != FieldKind::Density {
                    continue;
                }
                self.pools[place(kind)] = Some(self.new_pool(gpu, field)?);
            }
            changed |= self.settle_field(gpu, field, &needed)?;
        }
        self.rebind(gpu)?;
        self.stale = false;
        Ok(changed)
    }

    fn settle_field(&mut self, gpu: &Gpu, field: &Field, needed: &[bool]) -> Result<bool, GpuError> {
        let kind = field.kind();
        let urgency = || self.urgency();
        let Some(pool) = self.pools[place(kind)].as_ref() else { return Ok(false) };
        let pinned = pool.pinned();
        let mut wanted = needed.to_vec();
        for key in &pinned {
            wanted[self.brick_at(key.index)] = false;
        }
        let cut = residency::choose(&Need {
            field,
            urgency: &urgency,
            needed: &wanted,
            room: pool.most().saturating_sub(pinned.len()),
        });
        let complete = cut.uniform.is_empty() && cut.held.iter().all(|k| k.level == 0);
        let Some(pool) = self.pools[place(kind)].as_mut() else { return Ok(false) };
        let uploaded = pool.hold(gpu, field, &cut.held, false)?;
        let held: HashSet<BrickKey> = cut.held.into_iter().collect();
        let pages = field
            .brick_indices(0)
            .into_iter()
            .zip(needed)
            .map(|(index, needed)| page(pool, field, &held, &cut.uniform, index, *needed))
            .collect();
        let changed = !pool.set_pages(gpu, pages)?.is_empty();
        self.complete &= complete;
        Ok(uploaded || changed)
    }

    fn new_pool(&self, gpu: &Gpu, field: &Field) -> Result<Pool, GpuError> {
        Pool::new(gpu, field.kind(), field.format(), self.bricks, self.budget / 8 * eighths(field.kind()))
    }

    fn brick_at(&self, b: BrickIndex) -> usize {
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        b.0[0] as usize + nx * (b.0[1] as usize + ny * b.0[2] as usize)
    }

    /// By brick of level 0: whether the look shows any of it.
    fn shown(&self, density: &Field) -> Vec<bool> {
        let Some((transfer, mode)) = &self.look else { return vec![false; density.brick_indices(0).len()] };
        let shows = |min: f32, max: f32| match *mode {
            Mode::Iso(value) => f64::from(min) <= value && value <= f64::from(max),
            _ => transfer.max_opacity_in(f64::from(min), f64::from(max)) > 0.0,
        };
        density
            .brick_indices(0)
            .into_iter()
            .map(|index| {
                let about = density.summary(BrickKey { level: 0, index });
                shows(about.min, about.max)
            })
            .collect()
    }

    /// What the look shows and what slices run through.
    fn needed(&self) -> Vec<bool> {
        let mut needed = self.visible.clone();
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        for (i, needed) in needed.iter_mut().enumerate() {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            *needed |= (0..3).any(|a| self.slices[a].is_some_and(|row| row as usize == at[a]));
        }
        needed
    }

    /// By brick of level 0: pixels of its voxels on the screen.
    fn urgency(&self) -> Vec<f32> {
        let [nx, ny, nz] = self.bricks;
        let mut out = Vec::with_capacity((nx * ny * nz) as usize);
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let centre = crate::math::DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * 32.0 + 15.5;
                    let world = self.grid.world_from_index.transform_point3(centre);
                    out.push(match &self.sight {
                        Some(s) => 1.0 / (1.0 + (world - s.camera.eye).length() as f32),
                        None => 1.0,
                    });
                }
            }
        }
        out
    }

    /// After [`Field::swap`]: uploads what is held and marks the rest for the next frame.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn refresh(&mut self, gpu: &Gpu, kind: FieldKind, field: &Field, refresh: &Refresh) -> Result<(), GpuError> {
        if let Some(pool) = &mut self.pools[place(kind)] {
            pool.renew(gpu, field, &refresh.slots)?;
        }
        if kind == FieldKind::Density {
            self.visible.clear();
        }
        self.stale = true;
        Ok(())
    }

    /// For painting: these bricks of level 0 get slots of their own, also where they are of one value, and keep them until
    /// [`unpin`](Self::unpin). Answers the first texel of each slot, apron included. The texture may be a new one
    /// afterwards, with the same texels at the same places: take [`texture`](Self::texture) again.
    ///
    /// # Errors
    /// [`GpuError::PoolFull`] if they are more than three quarters of the pool; else as [`make_resident`](Self::make_resident).
    pub fn pin(&mut self, gpu: &Gpu, field: &Field, bricks: &[BrickIndex]) -> Result<Vec<[u32; 3]>, GpuError> {
        let kind = field.kind();
        if self.pools[place(kind)].is_none() {
            self.pools[place(kind)] = Some(self.new_pool(gpu, field)?);
        }
        let Some(pool) = &mut self.pools[place(kind)] else { return Ok(Vec::new()) };
        let keys: Vec<_> = bricks.iter().map(|&index| BrickKey { level: 0, index }).collect();
        let mut pinned = pool.pinned();
        pinned.extend(keys.iter().copied());
        let room = (pool.most() * 3 / 4).max(1);
        if pinned.len() > room {
            return Err(GpuError::PoolFull { field: kind.name(), asked: pinned.len(), room });
        }
        pool.hold(gpu, field, &keys, true)?;
        self.stale = true;
        self.rebind(gpu)?;
        let pool = self.pools[place(kind)].as_ref();
        Ok(keys.iter().filter_map(|k| pool.and_then(|p| p.texel_origin(*k))).collect())
    }

    /// Ends the keep of pinned bricks.
    pub fn unpin(&mut self, kind: FieldKind) {
        if let Some(pool) = &mut self.pools[place(kind)] {
            pool.unpin();
            self.stale = true;
        }
    }

    /// The 3D texture of a field's slots; `None` while nothing of the field is on the GPU.
    pub fn texture(&self, kind: FieldKind) -> Option<&wgpu::Texture> {
        self.pools[place(kind)].as_ref().map(|p| &p.texture)
    }

    /// Format of a field's texels on the GPU.
    pub fn format(&self, kind: FieldKind) -> Option<TexelFormat> {
        self.pools[place(kind)].as_ref().map(Pool::format)
    }

    /// (bricks held, slots the budget allows) of a field.
    pub fn occupancy_of(&self, kind: FieldKind) -> (usize, usize) {
        self.pools[place(kind)].as_ref().map_or((0, 0), |p| (p.held_count(), p.most()))
    }

    /// What shaders that import `burin::field` are composed with.
    pub fn defs(&self, gpu: &Gpu) -> Vec<(&'static str, super::shader::Def)> {
        let mut defs = Vec::new();
        if self.map.format == TexelFormat::R32Float {
            defs.push(("FLOAT_DENSITY", super::shader::Def::Bool(true)));
        }
        if !self.pools[0].as_ref().is_none_or(|p| filters(gpu, p)) {
            defs.push(("MANUAL_FILTER", super::shader::Def::Bool(true)));
        }
        defs
    }

    /// value = lo + texel · span for the density that shaders read.
    pub fn value_of_texel(&self) -> (f64, f64) {
        match self.map.format {
            TexelFormat::R32Float => (0.0, 1.0),
            _ => (self.map.lo, self.map.hi() - self.map.lo),
        }
    }

    /// Layout of group 1.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Group 1, as of the last call that made bricks resident.
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    fn rebind(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        if !self.pools.iter().flatten().any(|p| p.replaced) {
            return Ok(());
        }
        let (lo, span) = self.value_of_texel();
        let texel = |kind: FieldKind| self.pools[place(kind)].as_ref().map_or([1.0; 3], Pool::texel);
        let info = FieldInfo {
            dims: self.grid.dims,
            cell: crate::volume::CELL,
            bricks: self.bricks,
            value_lo: lo as f32,
            density_texel: texel(FieldKind::Density),
            value_span: span as f32,
            colour_texel: texel(FieldKind::Colour),
            pad_a: 0,
            selection_texel: texel(FieldKind::Selection),
            pad_b: 0,
        };
        gpu.scoped("the fields' bindings", || {
            gpu.queue.write_buffer(&self.info, 0, bytemuck::bytes_of(&info));
            if let Some(density) = &self.pools[0] {
                self.layout = layout(gpu, filters(gpu, density));
            }
            self.group = group(gpu, &self.layout, &self.info, &self.sampler, &self.nothing, &self.pools);
            Ok(())
        })?;
        self.pools.iter_mut().flatten().for_each(|p| p.replaced = false);
        Ok(())
    }
}

/// Where a brick of level 0 is drawn from.
fn page(
    pool: &Pool,
    field: &Field,
    held: &HashSet<BrickKey>,
    uniform: &HashSet<BrickKey>,
    index: BrickIndex,
    needed: bool,
) -> Page {
    let mut key = BrickKey { level: 0, index };
    if let Some(page) = pool.pinned_page(key) {
        return page;
    }
    let about = field.summary(key);
    if let Some(texel) = about.uniform {
        return pool::uniform_page(pool.bits(texel));
    }
    if !needed {
        // Invisible under the look, as is its least value.
        let texel = if field.kind() == FieldKind::Density { field.map().encode(f64::from(about.min)) } else { [0; 4] };
        return pool::uniform_page(pool.bits(texel));
    }
    while key.level < field.level_count() {
        if held.contains(&key) {
            if let Some(page) = pool.page(key) {
                return page;
            }
        } else if uniform.contains(&key)
            && let Some(texel) = field.summary(key).uniform
        {
            return pool::uniform_page(pool.bits(texel));
        }
        key = BrickKey { level: key.level + 1, index: key.index.parent() };
    }
    pool::uniform_page(0)
}

/// Whether a sampler may filter the density.
fn filters(gpu: &Gpu, density: &Pool) -> bool {
    density.format() != TexelFormat::R32Float || gpu.filters_float()
}

fn nothing(gpu: &Gpu, format: wgpu::TextureFormat) -> wgpu::Texture {
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
}

fn layout(gpu: &Gpu, density_filters: bool) -> wgpu::BindGroupLayout {
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

fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    info: &wgpu::Buffer,
    sampler: &wgpu::Sampler,
    [no_float, no_uint, no_page]: &[wgpu::Texture; 3],
    pools: &[Option<Pool>; 4],
) -> wgpu::BindGroup {
    let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
    let mut views = Vec::new();
    for kind in FieldKind::ALL {
        let binding = 1 + 2 * place(kind) as u32;
        let none = if kind == FieldKind::Labels { no_uint } else { no_float };
        let pool = pools[place(kind)].as_ref();
        views.push((binding, view(pool.map_or(none, |p| &p.texture))));
        views.push((binding + 1, view(pool.map_or(no_page, |p| &p.page_texture))));
    }
    views.extend([10, 11, 12].map(|binding| (binding, view(no_uint))));
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
