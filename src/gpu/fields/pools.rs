//! All fields of one volume on the GPU: what is held, what rays may skip, and their one bind group.
//!
//! Owns a [`Pool`] for each field and the maps of empty space, and decides with `residency` what they hold for a frame. The
//! host's fields stay the truth: everything here can be made again from them. Shaders reach it through
//! `shaders/lib/field.wgsl` (group 1).

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::bindings;
use crate::gpu::fields::bindings::FieldInfo;
use crate::gpu::fields::importance::Sight;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pools::marks::Marks;
use crate::gpu::fields::pools::shown::Shown;
use crate::gpu::fields::skip_maps::{Shows, Skips};
use crate::gpu::picture::frame::Frame;
use crate::volume::{
    BRICK, BrickIndex, BrickKey, Cells, DensityMap, Field, FieldKind, Grid, Mode, Refresh, TexelFormat,
    TransferFunction,
};
use std::collections::{HashMap, HashSet};
use std::sync::OnceLock;

pub(crate) mod cells;
pub(crate) mod edit;
pub(crate) mod marks;
pub(crate) mod needs;
pub(crate) mod shown;

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

#[derive(Clone, Debug, PartialEq)]
struct Look {
    transfer: TransferFunction,
    mode: Mode,
    shows: Shows,
}

/// See the module's head.
#[derive(Debug)]
pub struct FieldPools {
    grid: Grid,
    budget: u64,
    /// Bytes up to which density lies in place.
    in_place: u64,
    map: DensityMap,
    bricks: [u32; 3],
    pools: [Option<Pool>; 4],
    skips: Skips,
    look: Option<Look>,
    sight: Option<Sight>,
    /// Rows of bricks that slices run through, by voxel axis.
    slices: [Option<u32>; 3],
    /// By brick of level 0: whether the look shows any of it. Empty: not known.
    visible: Vec<bool>,
    /// By brick of level 0: whether anything draws it.
    needed: Vec<bool>,
    /// Bricks of which that is to be judged anew.
    unsure: Marks,
    /// By brick of level 0: how much it hides. Known once it was needed.
    extinction: OnceLock<Vec<f32>>,
    /// Bricks whose cells are to be renewed.
    stale_cells: Marks,
    /// What cells of a running stroke's bricks hold, of density and of the selection.
    live: [HashMap<usize, Cells>; 2],
    /// Slots that hold what the next refresh of their field brings.
    painted: Option<(FieldKind, HashSet<BrickKey>)>,
    shown: [Shown; 4],
    /// Bricks of a field that one call may upload.
    limit: Option<usize>,
    /// Something changed since pages were last made.
    stale: bool,
    judged: u64,
    info: wgpu::Buffer,
    sampler: wgpu::Sampler,
    nothing: [wgpu::Texture; 3],
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

/// What a field may take of the budget. Density is most of every volume; the others cost only where someone painted.
fn share(budget_bytes: u64, kind: FieldKind) -> u64 {
    budget_bytes / 32
        * match kind {
            FieldKind::Density => 20,
            FieldKind::Colour => 6,
            FieldKind::Selection | FieldKind::Labels => 3,
        }
}

const fn place(kind: FieldKind) -> usize {
    kind as usize
}

impl FieldPools {
    /// Pools for the volume of `density`, together at most `budget_bytes`, five eighths of it for density. Nothing is uploaded yet.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub fn new(gpu: &Gpu, grid: &Grid, density: &Field, budget_bytes: u64) -> Result<Self, GpuError> {
        // Half of density's share: a larger volume had better not be uploaded whole before it is seen.
        Self::with_place(gpu, grid, density, budget_bytes, share(budget_bytes, FieldKind::Density) / 2)
    }

    /// The same with every brick in a slot of its own, as in volumes that do not fit whole: tests and benches compare the two.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn apart(gpu: &Gpu, grid: &Grid, density: &Field, budget_bytes: u64) -> Result<Self, GpuError> {
        Self::with_place(gpu, grid, density, budget_bytes, 0)
    }

    fn with_place(gpu: &Gpu, grid: &Grid, density: &Field, budget_bytes: u64, in_place: u64) -> Result<Self, GpuError> {
        let bricks = density.brick_dims(0);
        let most = share(budget_bytes, FieldKind::Density);
        let pool = Pool::new(gpu, FieldKind::Density, density.format(), bricks, most, in_place)?;
        let skips = Skips::new(gpu, grid.dims, bricks)?;
        gpu.scoped("the fields' bindings", || {
            let nothing = bindings::nothing(gpu);
            let layout = bindings::layout(gpu, bindings::filters(gpu, &pool));
            let info = bindings::info_buffer(gpu);
            let sampler = bindings::linear_sampler(gpu);
            let pools = [Some(pool), None, None, None];
            let group = bindings::group(gpu, &layout, &info, &sampler, &nothing, &pools, &skips);
            Ok(Self {
                grid: *grid,
                budget: budget_bytes,
                in_place,
                map: *density.map(),
                bricks,
                pools,
                skips,
                look: None,
                sight: None,
                slices: [None; 3],
                visible: Vec::new(),
                needed: vec![false; bricks.iter().map(|&b| b as usize).product()],
                unsure: Marks::all(),
                extinction: OnceLock::new(),
                stale_cells: Marks::all(),
                live: Default::default(),
                painted: None,
                shown: Default::default(),
                limit: None,
                stale: true,
                judged: 0,
                info,
                sampler,
                nothing,
                layout,
                group,
            })
        })
    }

    /// Decides which bricks this frame needs and makes them resident: all that the look shows of its bodies if they fit;
    /// otherwise the nearest and most visible finest, the rest at the next coarser level that is held. Never leaves a hole.
    /// Renews the maps of empty space. Answers whether anything changed; the same frame again changes nothing, unless uploads
    /// [are bounded](Self::bound_uploads) and still to come.
    ///
    /// # Errors
    /// Out of memory, a lost device, or a source that fails.
    pub fn make_resident(&mut self, gpu: &Gpu, fields: &Fields<'_>, frame: &Frame) -> Result<bool, GpuError> {
        if self.look.as_ref().is_none_or(|l| l.transfer != frame.transfer || l.mode != frame.mode) {
            let shows = Shows::of(&frame.transfer, frame.mode);
            if self.look.as_ref().is_none_or(|l| l.shows != shows) {
                self.visible.clear();
                self.stale_cells = Marks::all();
            }
            self.extinction.take();
            self.look = Some(Look { transfer: frame.transfer.clone(), mode: frame.mode, shows });
            self.reconsider();
        }
        let sight = Sight { camera: frame.camera, size: frame.size, bodies: frame.bodies.clone() };
        if !self.sight.as_ref().is_some_and(|s| s.sees_like(&sight)) {
            if self.sight.as_ref().is_none_or(|s| !needs::same_matter(&s.bodies, &sight.bodies)) {
                self.unsure = Marks::all();
            }
            self.sight = Some(sight);
            self.reconsider();
        }
        self.settle(gpu, fields)
    }

    fn reconsider(&mut self) {
        self.shown.iter_mut().for_each(Shown::reconsider);
        self.stale = true;
    }

    /// How many bricks of a field one call that makes bricks resident may upload from now on; the rest follows with the next
    /// calls. `None`: as many as it takes, which is what a picture at rest needs.
    pub fn bound_uploads(&mut self, bricks: Option<usize>) {
        self.limit = bricks;
    }

    /// Whether bricks are still to come.
    pub fn is_pending(&self) -> bool {
        self.shown.iter().any(Shown::is_pending)
    }

    /// (bricks looked at, bricks uploaded) so far, all fields together: what the calls cost.
    pub fn work(&self) -> (u64, u64) {
        (self.judged, self.pools.iter().flatten().map(Pool::uploaded).sum())
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
        let row = index.min(self.grid.dims[axis].saturating_sub(1)) / BRICK;
        if self.slices[axis] != Some(row) {
            let old = self.slices[axis].replace(row);
            let mut layer = self.bricks;
            layer[axis] = 1;
            for row in [old, Some(row)].into_iter().flatten() {
                for i in 0..layer.iter().product() {
                    let mut at = [i % layer[0], i / layer[0] % layer[1], i / (layer[0] * layer[1])];
                    at[axis] = row;
                    let brick = self.brick_at(BrickIndex(at));
                    self.unsure.insert(brick);
                }
            }
            self.reconsider();
        }
        self.settle(gpu, fields)
    }

    fn settle(&mut self, gpu: &Gpu, fields: &Fields<'_>) -> Result<bool, GpuError> {
        gpu.check()?;
        if self.map != *fields.density.map() {
            self.remap(fields.density);
        }
        if !self.stale {
            return Ok(false);
        }
        if let Some((kind, keys)) = self.painted.take()
            && let Some(pool) = &mut self.pools[place(kind)]
        {
            // No refresh came: the field is not what the slots hold.
            pool.renew(gpu, fields.get(kind), &Refresh::whole(keys).slots)?;
        }
        self.judge(fields);
        let mut changed = false;
        for kind in FieldKind::ALL {
            let field = fields.get(kind);
            if self.pools[place(kind)].is_none() {
                if field.is_blank() && kind != FieldKind::Density {
                    continue;
                }
                self.begin_pool(gpu, field)?;
            }
            changed |= self.settle_field(gpu, fields, kind)?;
        }
        changed |= self.settle_cells(gpu, fields)?;
        self.rebind(gpu)?;
        self.stale = self.is_pending();
        Ok(changed)
    }

    fn begin_pool(&mut self, gpu: &Gpu, field: &Field) -> Result<(), GpuError> {
        let kind = field.kind();
        // The others are mostly blank: theirs lie apart.
        let in_place = if kind == FieldKind::Density { self.in_place } else { 0 };
        let pool = Pool::new(gpu, kind, field.format(), self.bricks, share(self.budget, kind), in_place)?;
        self.pools[place(kind)] = Some(pool);
        self.shown[place(kind)] = Shown::default();
        if kind == FieldKind::Selection {
            self.stale_cells = Marks::all();
        }
        Ok(())
    }

    fn key_at(&self, brick: usize) -> BrickKey {
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        BrickKey { level: 0, index: BrickIndex([brick % nx, brick / nx % ny, brick / (nx * ny)].map(|b| b as u32)) }
    }

    fn brick_at(&self, b: BrickIndex) -> usize {
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        b.0[0] as usize + nx * (b.0[1] as usize + ny * b.0[2] as usize)
    }

    /// The grid of the volume.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Bricks of level 0 that are pinned: a stroke is changing them.
    pub fn pinned(&self, kind: FieldKind) -> Vec<BrickIndex> {
        self.pools[place(kind)].as_ref().map_or_else(Vec::new, |p| p.pinned().iter().map(|k| k.index).collect())
    }

    /// The 3D texture of a field's slots; `None` while nothing of the field is on the GPU.
    pub fn texture(&self, kind: FieldKind) -> Option<&wgpu::Texture> {
        self.pools[place(kind)].as_ref().map(|p| &p.texture)
    }

    /// Format of a field's texels on the GPU.
    pub fn format(&self, kind: FieldKind) -> Option<TexelFormat> {
        self.pools[place(kind)].as_ref().map(Pool::format)
    }

    /// (bricks held, slots that the budget allows) of a field.
    pub fn room(&self, kind: FieldKind) -> (usize, usize) {
        self.pools[place(kind)].as_ref().map_or((0, 0), |p| (p.held_count(), p.most()))
    }

    /// What shaders that import `burin::field` are composed with.
    pub fn defs(&self, gpu: &Gpu) -> Vec<(&'static str, crate::gpu::device::shader::Def)> {
        let mut defs = Vec::new();
        if self.map.format == TexelFormat::R32Float {
            defs.push(("FLOAT_DENSITY", crate::gpu::device::shader::Def::Bool(true)));
        }
        if !self.pools[0].as_ref().is_none_or(|p| bindings::filters(gpu, p)) {
            defs.push(("MANUAL_FILTER", crate::gpu::device::shader::Def::Bool(true)));
        }
        if self.pools[0].as_ref().is_some_and(Pool::is_in_place) {
            defs.push(("IN_PLACE", crate::gpu::device::shader::Def::Bool(true)));
        }
        defs
    }

    /// (lo, span): value = lo + texel · span for the density that shaders read.
    pub fn value_of_texel(&self) -> (f64, f64) {
        match self.map.format {
            TexelFormat::R32Float => (self.map.lo, 1.0 / self.map.codes_per_unit),
            _ => (self.map.lo, self.map.hi() - self.map.lo),
        }
    }

    /// Layout of group 1.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Group 1, as of the last call that made bricks resident or pinned them.
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
            cell: self.skips.cell,
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
                self.layout = bindings::layout(gpu, bindings::filters(gpu, density));
            }
            let Self { layout, info, sampler, nothing, pools, skips, .. } = &*self;
            self.group = bindings::group(gpu, layout, info, sampler, nothing, pools, skips);
            Ok(())
        })?;
        self.pools.iter_mut().flatten().for_each(|p| p.replaced = false);
        Ok(())
    }
}
