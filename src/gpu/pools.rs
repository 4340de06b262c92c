//! All fields of one volume on the GPU: what is held, what rays may skip, and their one bind group.
//!
//! Owns a [`Pool`] for each field and the maps of empty space, and decides with `residency` what they hold for a frame. The
//! host's fields stay the truth: everything here can be made again from them. Shaders reach it through
//! `shaders/lib/field.wgsl` (group 1).

use super::bindings::{self, FieldInfo};
use super::occupancy::{Map, Shows, Skips};
use super::pool::{self, Page, Pool};
use super::residency::{self, Need};
use super::sight::{self, Sight};
use super::{Frame, Gpu, GpuError};
use crate::volume::{
    BRICK, BrickIndex, BrickKey, Cells, DensityMap, Field, FieldKind, Grid, Mode, Refresh, TexelFormat,
    TransferFunction,
};
use std::collections::{BTreeSet, HashSet};

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
    /// Bricks whose cells are to be renewed; `None`: all.
    stale_cells: Option<BTreeSet<usize>>,
    /// Bricks of a running stroke, of density and of the selection: they may show anything.
    forced: [HashSet<usize>; 2],
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
        let share = budget_bytes / 8 * eighths(FieldKind::Density);
        let pool = Pool::new(gpu, FieldKind::Density, density.format(), bricks, share)?;
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
                map: *density.map(),
                bricks,
                pools,
                skips,
                look: None,
                sight: None,
                slices: [None; 3],
                visible: Vec::new(),
                stale_cells: None,
                forced: Default::default(),
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
    /// nearest and most visible finest, the rest at the next coarser level that is held. Never leaves a hole. Renews the maps
    /// of empty space. Answers whether anything changed; the same frame again changes nothing.
    ///
    /// # Errors
    /// Out of memory, a lost device, or a source that fails.
    pub fn make_resident(&mut self, gpu: &Gpu, fields: &Fields<'_>, frame: &Frame) -> Result<bool, GpuError> {
        if self.look.as_ref().is_none_or(|l| l.transfer != frame.transfer || l.mode != frame.mode) {
            let shows = Shows::of(&frame.transfer, frame.mode);
            if self.look.as_ref().is_none_or(|l| l.shows != shows) {
                self.visible.clear();
                self.stale_cells = None;
                self.stale = true;
            }
            self.stale |= !self.complete;
            self.look = Some(Look { transfer: frame.transfer.clone(), mode: frame.mode, shows });
        }
        let same = self
            .sight
            .as_ref()
            .is_some_and(|s| s.camera == frame.camera && s.size == frame.size && s.bodies == frame.bodies);
        if !same {
            self.sight = Some(Sight { camera: frame.camera, size: frame.size, bodies: frame.bodies.clone() });
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
        let row = index.min(self.grid.dims[axis].saturating_sub(1)) / BRICK;
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
            self.visible.clear();
            self.stale_cells = None;
            self.stale = true;
        }
        if !self.stale {
            return Ok(false);
        }
        if self.visible.is_empty() {
            let bricks = fields.density.brick_indices(0);
            self.visible = bricks.into_iter().map(|b| self.shows(fields.density, b)).collect();
        }
        let needed = self.needed();
        let mut changed = false;
        self.complete = true;
        for kind in FieldKind::ALL {
            let field = fields.get(kind);
            if self.pools[place(kind)].is_none() {
                if field.is_blank() && kind != FieldKind::Density {
                    continue;
                }
                self.pools[place(kind)] = Some(self.new_pool(gpu, field)?);
                if kind == FieldKind::Selection {
                    self.stale_cells = None;
                }
            }
            changed |= self.settle_field(gpu, fields.density, field, &needed)?;
        }
        changed |= self.settle_cells(gpu, fields)?;
        self.rebind(gpu)?;
        self.stale = false;
        Ok(changed)
    }

    fn settle_field(&mut self, gpu: &Gpu, density: &Field, field: &Field, needed: &[bool]) -> Result<bool, GpuError> {
        let kind = field.kind();
        let urgency = || self.urgency(density);
        let Some(pool) = self.pools[place(kind)].as_ref() else { return Ok(false) };
        let pinned = pool.pinned();
        let mut wanted = needed.to_vec();
        for key in &pinned {
            wanted[self.brick_at(key.index)] = false;
        }
        let room = pool.most().saturating_sub(pinned.len());
        let cut = residency::choose(&Need { field, urgency: &urgency, needed: &wanted, room });
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
        let changed = pool.set_pages(gpu, pages)?;
        self.complete &= complete;
        if let (Some(stale), FieldKind::Density | FieldKind::Selection) = (&mut self.stale_cells, kind) {
            stale.extend(&changed);
        }
        Ok(uploaded || !changed.is_empty())
    }

    /// Renews the maps of empty space where bricks changed or are drawn from another level.
    fn settle_cells(&mut self, gpu: &Gpu, fields: &Fields<'_>) -> Result<bool, GpuError> {
        let bricks: Vec<usize> = match &self.stale_cells {
            Some(some) => some.iter().copied().collect(),
            None => (0..self.visible.len()).collect(),
        };
        self.stale_cells = Some(BTreeSet::new());
        let (Some(look), [Some(density), _, selection, _]) = (&self.look, &self.pools) else {
            self.stale_cells = None;
            return Ok(false);
        };
        if bricks.is_empty() {
            return Ok(false);
        }
        let (row, slab) = (self.bricks[0] as usize, (self.bricks[0] * self.bricks[1]) as usize);
        let forced = &self.forced;
        let of = |b: [u32; 3]| {
            let i = b[0] as usize + row * b[1] as usize + slab * b[2] as usize;
            let matter = CellsOf::new(fields.density, density.level_of(i), b);
            let chosen = selection.as_ref().map(|pool| CellsOf::new(fields.selection, pool.level_of(i), b));
            let (any, mixed) = (forced[0].contains(&i), forced[1].contains(&i));
            std::array::from_fn(|cell| {
                let [lo, hi] = matter.range(cell);
                if !(any || look.shows.any(lo, hi)) {
                    return 0;
                }
                let [least, most] = chosen.as_ref().map_or([0.0, 0.0], |c| c.range(cell));
                let selected = u8::from(most > 0.0 || mixed) << Map::Selection as u8;
                let left = u8::from(least < 1.0 || mixed) << Map::Background as u8;
                1 << Map::Matter as u8 | selected | left
            })
        };
        self.skips.update(gpu, &bricks, &of)?;
        Ok(true)
    }

    fn new_pool(&self, gpu: &Gpu, field: &Field) -> Result<Pool, GpuError> {
        let kind = field.kind();
        Pool::new(gpu, kind, field.format(), self.bricks, self.budget / 8 * eighths(kind))
    }

    fn brick_at(&self, b: BrickIndex) -> usize {
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        b.0[0] as usize + nx * (b.0[1] as usize + ny * b.0[2] as usize)
    }

    /// Whether the look shows any of a brick of level 0.
    fn shows(&self, density: &Field, index: BrickIndex) -> bool {
        let about = density.summary(BrickKey { level: 0, index });
        self.look.as_ref().is_some_and(|l| l.shows.any(about.min, about.max))
    }

    /// What the look shows, what slices run through, and what is being painted.
    fn needed(&self) -> Vec<bool> {
        let mut needed = self.visible.clone();
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        for (i, needed) in needed.iter_mut().enumerate() {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            *needed |= (0..3).any(|a| self.slices[a].is_some_and(|row| row as usize == at[a]));
            *needed |= self.forced[0].contains(&i);
        }
        needed
    }

    fn urgency(&self, density: &Field) -> Vec<f32> {
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        let mut urgency = match (&self.sight, &self.look) {
            (Some(sight), Some(look)) => {
                let extinction = sight::extinctions(density, &self.grid, &look.transfer);
                sight::urgency(sight, &self.grid, self.bricks, &extinction)
            }
            _ => vec![0.0; self.bricks.iter().map(|&b| b as usize).product()],
        };
        for (i, urgency) in urgency.iter_mut().enumerate() {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            // A slice shows its voxels at about a pixel each.
            if (0..3).any(|a| self.slices[a].is_some_and(|row| row as usize == at[a])) {
                *urgency = urgency.max(1.0);
            }
        }
        urgency
    }

    /// After [`Field::swap`]: uploads what is held and marks pages and cells for the next frame.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn refresh(&mut self, gpu: &Gpu, kind: FieldKind, field: &Field, refresh: &Refresh) -> Result<(), GpuError> {
        if let Some(pool) = &mut self.pools[place(kind)] {
            pool.renew(gpu, field, &refresh.slots)?;
        }
        self.stale = true;
        for key in &refresh.slots {
            let below = key.index.0.map(|b| b << key.level);
            let end: [u32; 3] = std::array::from_fn(|a| ((key.index.0[a] + 1) << key.level).min(self.bricks[a]));
            for z in below[2]..end[2] {
                for y in below[1]..end[1] {
                    for x in below[0]..end[0] {
                        self.renew_brick(field, BrickIndex([x, y, z]), key.level);
                    }
                }
            }
        }
        Ok(())
    }

    fn renew_brick(&mut self, field: &Field, index: BrickIndex, level: u8) {
        let kind = field.kind();
        let i = self.brick_at(index);
        if level == 0 && kind == FieldKind::Density && !self.visible.is_empty() {
            self.visible[i] = self.shows(field, index);
        }
        let map = match kind {
            FieldKind::Density => 0,
            FieldKind::Selection => 1,
            FieldKind::Colour | FieldKind::Labels => return,
        };
        let drawn = self.pools[place(kind)].as_ref().map_or(0, |p| p.level_of(i));
        if level == 0 {
            self.forced[map].remove(&i);
        }
        if level == 0 || level == drawn {
            if let Some(stale) = &mut self.stale_cells {
                stale.insert(i);
            }
        }
    }

    /// While a stroke runs: these bricks' cells may show anything, until [`refresh`](Self::refresh) or
    /// [`unpin`](Self::unpin). `bricks` are all whose slots the stroke writes, aprons included.
    pub fn mark_occupied(&mut self, kind: FieldKind, bricks: &[BrickIndex]) {
        let map = match kind {
            FieldKind::Density => 0,
            FieldKind::Selection => 1,
            FieldKind::Colour | FieldKind::Labels => return,
        };
        for &brick in bricks {
            let i = self.brick_at(brick);
            if self.forced[map].insert(i) {
                self.stale = true;
                if let Some(stale) = &mut self.stale_cells {
                    stale.insert(i);
                }
            }
        }
    }

    /// For painting: these bricks of level 0 get slots of their own, also where they are of one value, and keep them until
    /// [`unpin`](Self::unpin). Answers the first texel of each slot, apron included. The texture may be a new one
    /// afterwards, with the same texels at the same places: take [`texture`](Self::texture) again. Pages follow with the
    /// next call that makes bricks resident.
    ///
    /// # Errors
    /// [`GpuError::PoolFull`] if they are more than three quarters of the pool; else as [`make_resident`](Self::make_resident).
    pub fn pin(&mut self, gpu: &Gpu, field: &Field, bricks: &[BrickIndex]) -> Result<Vec<[u32; 3]>, GpuError> {
        gpu.check()?;
        let kind = field.kind();
        if self.pools[place(kind)].is_none() {
            self.pools[place(kind)] = Some(self.new_pool(gpu, field)?);
            if kind == FieldKind::Selection {
                self.stale_cells = None;
            }
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
        let origins = keys.iter().filter_map(|k| pool.texel_origin(*k)).collect();
        self.stale = true;
        self.rebind(gpu)?;
        Ok(origins)
    }

    /// Ends the keep of pinned bricks and of cells marked as occupied.
    pub fn unpin(&mut self, kind: FieldKind) {
        if let Some(pool) = &mut self.pools[place(kind)] {
            pool.unpin();
        }
        self.stale = true;
        let map = match kind {
            FieldKind::Density => 0,
            FieldKind::Selection => 1,
            FieldKind::Colour | FieldKind::Labels => return,
        };
        let forced = std::mem::take(&mut self.forced[map]);
        if let Some(stale) = &mut self.stale_cells {
            stale.extend(forced);
        }
    }

    /// The grid of the volume.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Bricks of level 0 that are pinned: a stroke is changing them.
    pub fn pinned(&self, kind: FieldKind) -> Vec<BrickIndex> {
        self.pools[place(kind)].as_ref().map_or_else(Vec::new, |p| p.pinned().into_iter().map(|k| k.index).collect())
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
    pub fn defs(&self, gpu: &Gpu) -> Vec<(&'static str, super::shader::Def)> {
        let mut defs = Vec::new();
        if self.map.format == TexelFormat::R32Float {
            defs.push(("FLOAT_DENSITY", super::shader::Def::Bool(true)));
        }
        if !self.pools[0].as_ref().is_none_or(|p| bindings::filters(gpu, p)) {
            defs.push(("MANUAL_FILTER", super::shader::Def::Bool(true)));
        }
        defs
    }

    /// (lo, span): value = lo + texel · span for the density that shaders read.
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

/// The cells of 4³ voxels of a brick of level 0, as the level that it is drawn from has them.
struct CellsOf {
    cells: Cells,
    level: u8,
    /// First cell of the brick within the coarse brick, in cells of level 0.
    first: [u32; 3],
}

impl CellsOf {
    fn new(field: &Field, level: u8, brick: [u32; 3]) -> Self {
        let index = BrickIndex(brick.map(|b| b >> level));
        let first = std::array::from_fn(|a| (brick[a] - (index.0[a] << level)) * 8);
        Self { cells: field.cells(BrickKey { level, index }), level, first }
    }

    fn range(&self, cell: usize) -> [f32; 2] {
        match &self.cells {
            Cells::Uniform(range) => *range,
            Cells::Dense(cells) => {
                let at = [cell % 8, cell / 8 % 8, cell / 64];
                let [x, y, z] = std::array::from_fn(|a| (self.first[a] as usize + at[a]) >> self.level);
                cells[x + 8 * (y + 8 * z)]
            }
        }
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
        return pool::uniform_page(0, pool.bits(texel));
    }
    if !needed {
        // Nothing of it shows under the look, its least value neither.
        let texel = if field.kind() == FieldKind::Density { field.map().encode(f64::from(about.min)) } else { [0; 4] };
        return pool::uniform_page(0, pool.bits(texel));
    }
    while key.level < field.level_count() {
        if held.contains(&key)
            && let Some(page) = pool.page(key)
        {
            return page;
        }
        if uniform.contains(&key)
            && let Some(texel) = field.summary(key).uniform
        {
            return pool::uniform_page(key.level, pool.bits(texel));
        }
        key = BrickKey { level: key.level + 1, index: key.index.parent() };
    }
    // The cut covers every needed brick, so this is not reached.
    pool::uniform_page(0, 0)
}
