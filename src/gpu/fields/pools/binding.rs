//! What shaders see of the pools: the volumes of a picture, in order, and the one bind group.
//!
//! A picture of one volume has variants of its own, which know no list of volumes.

use crate::gpu::device::constants::MOST_VOLUMES;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::shader::Def;
use crate::gpu::fields::bindings::{self, FieldInfo};
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pools::{CODES, FINE_CODES, FINE_FLOATS, FINE_LABELS, FLOATS, FieldPools, LABELS};
use crate::gpu::fields::skip_maps::cell_of;
use crate::volume::{FieldKey, FieldKind, TexelFormat, VolumeId};

impl FieldPools {
    /// What shaders that import `burin::field` are composed with, for the volumes of the last call that made bricks resident.
    pub fn defs(&self, gpu: &Gpu) -> Vec<(&'static str, Def)> {
        let floats = |id: &VolumeId| self.volumes.get(id).is_some_and(|v| v.map.format == TexelFormat::R32Float);
        let pool = |id: &VolumeId| self.pool_of(FieldKey::new(*id, FieldKind::Density));
        let shown = self.shown();
        let lie_in = |at| shown.iter().any(|id| pool(id) == Some(at));
        let in_floats = lie_in(FLOATS) || lie_in(FINE_FLOATS);
        let many = shown.len() > 1;
        let in_place = shown.iter().filter_map(pool).any(|at| self.is_in_place(at));
        let labels = |id: &VolumeId| self.pool_of(FieldKey::new(*id, FieldKind::Labels));
        [
            ("MANY_VOLUMES", many),
            ("CODE_POOL", many && lie_in(CODES)),
            ("FLOAT_POOL", many && lie_in(FLOATS)),
            ("FINE_CODES", many && lie_in(FINE_CODES)),
            ("FINE_FLOATS", many && lie_in(FINE_FLOATS)),
            ("PLACED", many && in_place),
            ("FINE_LABELS", many && shown.iter().any(|id| labels(id) == Some(FINE_LABELS))),
            ("PLACED_LABELS", many && self.is_in_place(LABELS)),
            ("FLOAT_DENSITY", shown.iter().any(floats)),
            ("MANUAL_FILTER", in_floats && !gpu.filters_float()),
            ("IN_PLACE", !many && in_place),
            ("LABELS_IN_PLACE", self.has_labels_in_place()),
        ]
        .into_iter()
        .filter(|def| def.1)
        .map(|(name, on)| (name, Def::Bool(on)))
        .collect()
    }

    fn is_in_place(&self, at: usize) -> bool {
        self.pools[at].as_ref().is_some_and(Pool::is_in_place)
    }

    /// Whether shaders find labels where their voxels are, without pages.
    pub(crate) fn has_labels_in_place(&self) -> bool {
        self.shown().len() == 1 && self.is_in_place(LABELS)
    }

    /// The volumes that are bound; before any is, those on the device.
    pub(crate) fn shown(&self) -> Vec<VolumeId> {
        if self.bound.is_empty() { self.volumes.keys().copied().take(1).collect() } else { self.bound.clone() }
    }

    /// (lo, span): value = lo + texel · span for the density that shaders read.
    pub fn value_of_texel(&self, id: VolumeId) -> (f64, f64) {
        self.volumes.get(&id).map_or((0.0, 1.0), |volume| match volume.map.format {
            TexelFormat::R32Float => (volume.map.lo, 1.0 / volume.map.codes_per_unit),
            _ => (volume.map.lo, volume.map.hi() - volume.map.lo),
        })
    }

    /// The place of a volume among those that are bound.
    pub fn place_of(&self, id: VolumeId) -> usize {
        self.bound.iter().position(|of| *of == id).unwrap_or(0)
    }

    /// Layout of group 1.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Group 1, as of the last call that bound volumes, made bricks resident or pinned them.
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// Lets shaders see these volumes, in order. They must be on the device.
    ///
    /// # Errors
    /// [`GpuError::TooManyVolumes`]; out of memory, or a lost device.
    pub fn bind(&mut self, gpu: &Gpu, volumes: &[VolumeId]) -> Result<(), GpuError> {
        let most = MOST_VOLUMES as usize;
        if volumes.len() > most {
            return Err(GpuError::TooManyVolumes { volumes: volumes.len(), most });
        }
        let replaced = self.pools.iter().flatten().any(|p| p.replaced) || self.pages.replaced || self.skips.replaced;
        let infos: Vec<_> = volumes.iter().filter_map(|&id| self.info_of(gpu, id)).collect();
        let others = self.bound != volumes;
        self.bound = volumes.to_vec();
        if self.infos != infos {
            gpu.queue.write_buffer(&self.info, 0, bytemuck::cast_slice(&infos));
            self.infos = infos;
        }
        if !(replaced || others) {
            return Ok(());
        }
        let first = |id: &VolumeId| self.pool_of(FieldKey::new(*id, FieldKind::Density));
        // Of one volume alone density is the first binding, whatever it is.
        let ([one, two], labels) = match volumes {
            [id] => ([first(id), None], self.pool_of(FieldKey::new(*id, FieldKind::Labels))),
            _ => ([Some(CODES), Some(FLOATS)], Some(LABELS)),
        };
        let filters = one.and_then(|at| self.pools[at].as_ref());
        let filters = filters.is_none_or(|p| p.format() != TexelFormat::R32Float || gpu.filters_float());
        let [float, uint, layer] = &self.nothing;
        let of = |at: Option<usize>| at.and_then(|at| self.pools[at].as_ref()).map(|pool| &pool.texture);
        let textures = [
            of(one).unwrap_or(float),
            of(two).unwrap_or(float),
            of(Some(2)).unwrap_or(float),
            of(Some(3)).unwrap_or(float),
            of(labels).unwrap_or(uint),
            &self.pages.texture,
            &self.skips.texture,
            self.pairs_of(volumes).unwrap_or(layer),
            of(Some(FINE_CODES)).unwrap_or(float),
            of(Some(FINE_FLOATS)).unwrap_or(float),
            of(Some(FINE_LABELS)).unwrap_or(uint),
        ];
        (self.layout, self.group) = gpu.scoped("the fields' bindings", || {
            let layout = bindings::layout(gpu, filters);
            let group = bindings::group(gpu, &layout, &self.info, &self.sampler, textures);
            Ok((layout, group))
        })?;
        self.pools.iter_mut().flatten().for_each(|p| p.replaced = false);
        (self.pages.replaced, self.skips.replaced) = (false, false);
        Ok(())
    }

    pub(crate) fn info_of(&self, gpu: &Gpu, id: VolumeId) -> Option<FieldInfo> {
        let demand = &self.volumes.get(&id)?.demand;
        let key = |kind| FieldKey::new(id, kind);
        let texel = |kind| self.pool(key(kind)).map_or([1.0; 3], Pool::texel);
        let pages = |kind| self.pages.first(key(kind));
        let placed = |kind| self.pool(key(kind)).is_some_and(Pool::is_in_place);
        let (lo, span) = self.value_of_texel(id);
        Some(FieldInfo {
            dims: demand.grid().dims,
            cell: cell_of(demand.grid().dims, gpu.device.limits().max_texture_dimension_3d),
            bricks: demand.bricks(),
            value_lo: lo as f32,
            density_texel: texel(FieldKind::Density),
            value_span: span as f32,
            colour_texel: texel(FieldKind::Colour),
            floats: u32::from(self.volumes[&id].map.format == TexelFormat::R32Float),
            selection_texel: texel(FieldKind::Selection),
            pool: match self.pool_of(key(FieldKind::Density)) {
                Some(FLOATS) => 1,
                Some(FINE_CODES) => 2,
                Some(FINE_FLOATS) => 3,
                _ => 0,
            },
            density_pages: pages(FieldKind::Density),
            colour_pages: pages(FieldKind::Colour),
            selection_pages: pages(FieldKind::Selection),
            label_pages: pages(FieldKind::Labels),
            density_placed: u32::from(placed(FieldKind::Density)),
            labels_placed: u32::from(placed(FieldKind::Labels)),
            fine_labels: u32::from(self.pool_of(key(FieldKind::Labels)) == Some(FINE_LABELS)),
            unused: 0,
        })
    }

    pub(crate) fn rebind(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let bound = self.bound.clone();
        self.bind(gpu, &bound)
    }
}
