//! The fields of any number of volumes on the GPU: what is held, what rays may skip, and their one bind group.
//!
//! Owns a [`Pool`] for each texel format, which the volumes share by need, the page tables and the maps of empty space. What
//! is needed is said by each volume's [`Demand`]; what is held of it is decided in `residency`. The host's fields stay the
//! truth: everything here can be made again from them. Shaders reach it through `shaders/lib/field.wgsl` (group 1).

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::bindings::{self, FieldInfo};
use crate::gpu::fields::demand::{Asked, Demand, SliceCut};
use crate::gpu::fields::importance::Viewing;
use crate::gpu::fields::page_tables::PageTables;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pool::pairs::PairsKernel;
use crate::gpu::fields::pools::field_residency::FieldResidency;
use crate::gpu::fields::skip_maps::SkipMaps;
use crate::gpu::fields::slot_key::{SlotKey, brick_of};
use crate::gpu::fields::visible_values::VisibleValues;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::Frame;
use crate::volume::{
    BrickIndex, BrickKey, DensityMap, Field, FieldKey, FieldKind, Grid, Refresh, TexelFormat, VolumeId,
};
use std::collections::{BTreeMap, HashSet};

pub(crate) mod binding;
pub(crate) mod cells;
pub(crate) mod edit;
pub(crate) mod field_residency;
pub(crate) mod pairs;
pub(crate) mod reached;
pub(crate) mod sharing;

/// Pools by what they hold: density as codes, density as floats, colour, selection, labels; density as codes and as floats and labels
/// of boxes of a volume, so that what they are cut out of may lie in place.
pub(crate) const POOLS: usize = 8;
pub(crate) const CODES: usize = 0;
pub(crate) const FLOATS: usize = 1;
pub(crate) const LABELS: usize = 4;
pub(crate) const FINE_CODES: usize = 5;
pub(crate) const FINE_FLOATS: usize = 6;
pub(crate) const FINE_LABELS: usize = 7;

/// A volume on the device.
#[derive(Debug)]
pub(crate) struct OnDevice {
    demand: Demand,
    map: DensityMap,
    /// Whether it is a box of another.
    fine: bool,
}

/// Everything of the volumes' fields that is on the device, within a budget of bytes: slots, pages, maps of empty space and the bind
/// group that shaders read them by.
#[derive(Debug)]
pub struct FieldPools {
    budget: u64,
    /// Whether density and labels may lie in place.
    places: bool,
    /// Whether labels that come do so: a picture has asked for those of every sample.
    places_labels: bool,
    /// Whether 16-bit texels are floats on this device.
    widens: bool,
    volumes: BTreeMap<VolumeId, OnDevice>,
    pools: [Option<Pool>; POOLS],
    residency: [FieldResidency; POOLS],
    pages: PageTables,
    skips: SkipMaps,
    pairs: PairsKernel,
    /// Slots that hold what the next refresh of their field brings.
    painted: BTreeMap<FieldKey, HashSet<BrickKey>>,
    /// Bricks of a pool that one call may upload.
    limit: Option<usize>,
    /// Something changed since pages were last made.
    stale: bool,
    /// Uploads of pools that are gone.
    uploaded: u64,
    /// Judged bricks of volumes that are gone, and bricks whose pages were looked at.
    judged: u64,
    /// The volumes of the picture that is drawn, in order of their infos.
    bound: Vec<VolumeId>,
    infos: Vec<FieldInfo>,
    info: wgpu::Buffer,
    sampler: wgpu::Sampler,
    nothing: [wgpu::Texture; 3],
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

/// What the pools of a field may take of the budget together. Density is most of every volume; the others cost only where
/// someone painted.
pub(crate) fn share(budget_bytes: u64, kind: FieldKind) -> u64 {
    budget_bytes / 32
        * match kind {
            FieldKind::Density => 20,
            FieldKind::Colour => 6,
            FieldKind::Selection | FieldKind::Labels => 3,
        }
}

impl FieldPools {
    /// Pools of at most `budget_bytes` together, five eighths of it for density. No volume is on the device yet.
    ///
    /// # Errors
    /// Out of memory, or a lost device.
    pub fn empty(gpu: &Gpu, budget_bytes: u64) -> Result<Self, GpuError> {
        let (pages, skips) = (PageTables::new(gpu)?, SkipMaps::new(gpu)?);
        gpu.scoped("the fields' bindings", || {
            let nothing = bindings::nothing(gpu);
            let layout = bindings::layout(gpu, true);
            let info = bindings::info_buffer(gpu);
            let sampler = bindings::linear_sampler(gpu);
            let [float, uint, layer] = &nothing;
            let textures =
                [float, float, float, float, uint, &pages.texture, &skips.texture, layer, float, float, uint];
            let group = bindings::group(gpu, &layout, &info, &sampler, textures);
            Ok(Self {
                budget: budget_bytes,
                places: true,
                places_labels: false,
                widens: !gpu.has_unorm16(),
                volumes: BTreeMap::new(),
                pools: [const { None }; POOLS],
                residency: Default::default(),
                pages,
                skips,
                pairs: PairsKernel::new(gpu),
                painted: BTreeMap::new(),
                limit: None,
                stale: true,
                uploaded: 0,
                judged: 0,
                bound: Vec::new(),
                infos: Vec::new(),
                info,
                sampler,
                nothing,
                layout,
                group,
            })
        })
    }

    /// The same with one volume, [`VolumeId::FIRST`]. Nothing is uploaded yet.
    ///
    /// # Errors
    /// As [`empty`](Self::empty).
    pub fn new(gpu: &Gpu, grid: &Grid, density: &Field, budget_bytes: u64) -> Result<Self, GpuError> {
        let mut pools = Self::empty(gpu, budget_bytes)?;
        pools.enter(gpu, VolumeId::FIRST, grid, density)?;
        pools.bind(gpu, &[VolumeId::FIRST])?;
        Ok(pools)
    }

    /// The same with every brick in a slot of its own, as where several volumes are drawn or one does not fit whole: tests and
    /// benches compare the two.
    ///
    /// # Errors
    /// As [`empty`](Self::empty).
    pub fn apart(gpu: &Gpu, grid: &Grid, density: &Field, budget_bytes: u64) -> Result<Self, GpuError> {
        let mut pools = Self { places: false, ..Self::empty(gpu, budget_bytes)? };
        pools.enter(gpu, VolumeId::FIRST, grid, density)?;
        pools.bind(gpu, &[VolumeId::FIRST])?;
        Ok(pools)
    }

    fn on_device(&self, format: TexelFormat) -> TexelFormat {
        if format == TexelFormat::R16Unorm && self.widens { TexelFormat::R32Float } else { format }
    }

    /// The number of the pool that a field of a volume on the device lies in.
    fn pool_of(&self, key: FieldKey) -> Option<usize> {
        let volume = self.volumes.get(&key.volume)?;
        Some(match (key.kind, volume.fine) {
            (FieldKind::Density, fine) => match (self.on_device(volume.map.format), fine) {
                (TexelFormat::R32Float, false) => FLOATS,
                (TexelFormat::R32Float, true) => FINE_FLOATS,
                (_, false) => CODES,
                (_, true) => FINE_CODES,
            },
            (FieldKind::Colour, _) => 2,
            (FieldKind::Selection, _) => 3,
            (FieldKind::Labels, false) => LABELS,
            (FieldKind::Labels, true) => FINE_LABELS,
        })
    }

    fn pool(&self, key: FieldKey) -> Option<&Pool> {
        self.pages.has(key).then(|| self.pools[self.pool_of(key)?].as_ref()).flatten()
    }

    /// Decides which bricks this frame needs and makes them resident: all that the looks show of its bodies if they fit;
    /// otherwise the nearest and most visible finest, the rest at the next coarser level that is held. Never leaves a hole.
    /// Answers whether anything changed; the same frame again changes nothing, unless uploads [are bounded](Self::bound_uploads)
    /// and still to come.
    ///
    /// # Errors
    /// Out of memory, a lost device, a source that fails, or a volume that `fields` has not.
    pub fn make_resident(&mut self, gpu: &Gpu, fields: &Fields<'_>, frame: &Frame) -> Result<bool, GpuError> {
        gpu.check()?;
        self.follow_volumes(gpu, fields, frame.volumes().into_iter())?;
        if frame.bodies.iter().any(|body| body.labels.is_some()) {
            self.place_labels();
        }
        let mut other = false;
        for (id, volume) in &mut self.volumes {
            let bodies: Vec<_> = frame.bodies.iter().filter(|b| b.volume == *id).cloned().collect();
            let (mut values, mut transfer) = (Vec::new(), None);
            for look in bodies.iter().flat_map(|body| frame.looks_of(body)) {
                let shown = VisibleValues::of_look(look);
                if !values.contains(&shown) {
                    values.push(shown);
                }
                transfer.get_or_insert_with(|| look.transfer.clone());
            }
            let viewing = Viewing { camera: frame.camera, size: frame.size, bodies };
            other |= volume.demand.ask(Asked { viewing, values, transfer });
        }
        if other {
            self.reconsider();
        }
        let changed = self.catch_up(gpu, fields)?;
        self.bind(gpu, &frame.volumes())?;
        Ok(changed)
    }

    fn reconsider(&mut self) {
        self.residency.iter_mut().for_each(FieldResidency::reconsider);
        self.stale = true;
    }

    /// How many bricks of a pool one call that makes bricks resident may upload from now on; the rest follows with the next
    /// calls. `None`: as many as it takes, which is what a picture at rest needs.
    pub fn bound_uploads(&mut self, bricks: Option<usize>) {
        self.limit = bricks;
    }

    /// Whether bricks are still to come.
    pub fn is_pending(&self) -> bool {
        self.residency.iter().any(FieldResidency::is_pending)
    }

    /// (bricks looked at, bricks uploaded) so far, all fields together: what the calls cost.
    pub fn work(&self) -> (u64, u64) {
        let judged: u64 = self.volumes.values().map(|volume| volume.demand.judged()).sum();
        let uploaded: u64 = self.pools.iter().flatten().map(Pool::uploaded).sum();
        (self.judged + judged, self.uploaded + uploaded)
    }

    /// The same as [`make_resident`](Self::make_resident) for a slice of a volume, whatever its looks show.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn make_slice_resident(
        &mut self,
        gpu: &Gpu,
        fields: &Fields<'_>,
        id: VolumeId,
        cut: SliceCut,
    ) -> Result<bool, GpuError> {
        gpu.check()?;
        self.follow_volumes(gpu, fields, std::iter::once(id))?;
        if self.volumes.get_mut(&id).is_some_and(|volume| volume.demand.slice(cut)) {
            self.reconsider();
        }
        let changed = self.catch_up(gpu, fields)?;
        self.bind(gpu, &[id])?;
        Ok(changed)
    }

    fn catch_up(&mut self, gpu: &Gpu, fields: &Fields<'_>) -> Result<bool, GpuError> {
        gpu.check()?;
        if !self.stale {
            return Ok(false);
        }
        for (key, bricks) in std::mem::take(&mut self.painted) {
            let (at, field) = (self.pool_of(key), fields.field(key));
            if let (Some(pool), Some(field)) = (at.and_then(|at| self.pools[at].as_mut()), field) {
                // No refresh came: the field is not what the slots hold.
                pool.renew(gpu, (key.volume, field), &Refresh::whole(bricks).slots)?;
            }
        }
        let ids: Vec<VolumeId> = self.volumes.keys().copied().collect();
        for &id in &ids {
            let Some(volume_fields) = fields.get(id) else { continue };
            if let Some(volume) = self.volumes.get_mut(&id) {
                let judged = volume.demand.judge(volume_fields);
                self.residency.iter_mut().for_each(|residency| residency.dirty(id, judged.iter().copied()));
            }
            for kind in FieldKind::ALL {
                let key = FieldKey::new(id, kind);
                let blank = kind != FieldKind::Density && volume_fields.get(kind).is_blank();
                if !self.pages.has(key) && !blank {
                    self.begin(gpu, key)?;
                }
            }
        }
        let mut changed = false;
        for at in 0..POOLS {
            changed |= self.catch_up_pool(gpu, fields, at)?;
        }
        self.pages.write(gpu)?;
        self.stale = self.is_pending();
        Ok(changed)
    }

    /// The volumes on the device.
    pub fn volumes(&self) -> impl Iterator<Item = VolumeId> {
        self.volumes.keys().copied()
    }

    /// Bricks of level 0 that are pinned: a stroke is changing them.
    pub fn pinned(&self, key: impl Into<FieldKey>) -> Vec<BrickIndex> {
        let key = key.into();
        let pinned = self.pool(key).into_iter().flat_map(|pool| pool.pinned().iter());
        pinned.filter(|slot| slot.volume == key.volume).map(|slot| slot.brick.index).collect()
    }

    /// The 3D texture of the slots that a field lies in; `None` while nothing of the field is on the GPU. Other volumes' bricks
    /// lie in it too.
    pub fn texture(&self, key: impl Into<FieldKey>) -> Option<&wgpu::Texture> {
        self.pool(key.into()).map(|pool| &pool.texture)
    }

    /// Format of a field's texels on the GPU.
    pub fn format(&self, key: impl Into<FieldKey>) -> Option<TexelFormat> {
        self.pool(key.into()).map(Pool::format)
    }

    /// (bricks held, slots that the budget allows) of the pool that a field lies in.
    pub fn room(&self, key: impl Into<FieldKey>) -> (usize, usize) {
        self.pool(key.into()).map_or((0, 0), |pool| (pool.held_count(), pool.most()))
    }

    /// Volumes that are no boxes of another.
    pub(crate) fn whole_volumes(&self) -> usize {
        self.volumes.values().filter(|volume| !volume.fine).count()
    }

    fn key_at(&self, id: VolumeId, brick: usize) -> SlotKey {
        let bricks = self.volumes.get(&id).map_or([1; 3], |volume| volume.demand.bricks());
        SlotKey::new(id, BrickKey { level: 0, index: brick_of(bricks, brick) })
    }
}
