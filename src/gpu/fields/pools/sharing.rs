//! Which volumes are on the device, and what of the budget their pools may take.
//!
//! A volume comes when a picture or a stroke first names it and goes when it exists no more. The two pools of density divide
//! their share by what they are to hold; a volume that is alone may lie in place.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::demand::Demand;
use crate::gpu::fields::pool::{self, Pool};
use crate::gpu::fields::pools::field_residency::FieldResidency;
use crate::gpu::fields::pools::{CODES, FINE_CODES, FINE_FLOATS, FLOATS, FieldPools, LABELS, OnDevice, POOLS, share};
use crate::gpu::fields::slot_key::count_of;
use crate::gpu::fields::volumes::Fields;
use crate::volume::{Field, FieldKey, FieldKind, Grid, TexelFormat, VolumeId};

/// Pools of density.
const OF_DENSITY: [usize; 4] = [CODES, FLOATS, FINE_CODES, FINE_FLOATS];

const PAINTED: GpuError = GpuError::Stroke("one is running; end it before another volume is shown");

impl FieldPools {
    /// Takes a volume onto the device, or what is new of one that is there.
    pub(crate) fn enter(&mut self, gpu: &Gpu, id: VolumeId, grid: &Grid, density: &Field) -> Result<(), GpuError> {
        if let Some(volume) = self.volumes.get_mut(&id) {
            if volume.demand.grid().dims == grid.dims {
                if volume.demand.place(grid) {
                    self.reconsider();
                }
                if self.volumes[&id].map != *density.map() {
                    self.remap(id, density);
                }
                return Ok(());
            }
            self.leave(id);
        }
        let demand = Demand::new(grid, density.brick_dims(0));
        let fine = density.is_of_box();
        self.volumes.insert(id, OnDevice { demand, map: *density.map(), fine });
        self.begin(gpu, FieldKey::new(id, FieldKind::Density))
    }

    /// A volume is no longer among those that pictures may name.
    pub(crate) fn leave(&mut self, id: VolumeId) {
        let Some(gone) = self.volumes.remove(&id) else { return };
        self.judged += gone.demand.judged();
        for kind in FieldKind::ALL {
            self.pages.end(FieldKey::new(id, kind));
            self.painted.remove(&FieldKey::new(id, kind));
        }
        for (pool, residency) in self.pools.iter_mut().zip(&mut self.residency) {
            residency.forget(id);
            if let Some(pool) = pool {
                pool.forget(id);
            }
        }
        self.skips.forget(id);
        self.bound.retain(|of| *of != id);
        self.drop_idle_pools();
        self.places_labels &= gone.fine;
        if self.whole_volumes() == 1 && self.places && !gone.fine {
            // What is left may lie in place again.
            for at in [CODES, FLOATS] {
                if !self.is_painted(at) {
                    self.drop_pool(at);
                }
            }
        }
        self.reconsider();
    }

    /// Whether a stroke holds slots of a pool.
    pub(crate) fn is_painted(&self, at: usize) -> bool {
        self.pools[at].as_ref().is_some_and(|pool| !pool.pinned().is_empty())
    }

    /// Drops a pool; what lies in it begins anew when it is next needed.
    pub(crate) fn drop_pool(&mut self, at: usize) {
        let Some(gone) = self.pools[at].take() else { return };
        self.uploaded += gone.uploaded();
        self.residency[at] = FieldResidency::default();
        let inside: Vec<_> = self.pages.keys().filter(|key| self.pool_of(*key) == Some(at)).collect();
        for key in inside {
            self.pages.end(key);
            self.painted.remove(&key);
        }
        self.stale = true;
    }

    /// Drops pools in which nothing lies.
    pub(crate) fn drop_idle_pools(&mut self) {
        for at in 0..POOLS {
            if !self.pages.keys().any(|key| self.pool_of(key) == Some(at)) {
                self.drop_pool(at);
            }
        }
    }

    /// What a pool may take: all that is its fields' share, but for the two of density, which divide theirs by what they are to
    /// hold.
    pub(crate) fn budget_of(&self, at: usize, kind: FieldKind) -> u64 {
        let most = share(self.budget, kind);
        if kind != FieldKind::Density {
            return most;
        }
        let whole = |at: usize| -> u64 {
            let inside =
                self.volumes.iter().filter(|(id, _)| self.pool_of(FieldKey::new(**id, FieldKind::Density)) == Some(at));
            let format = if [CODES, FINE_CODES].contains(&at) { TexelFormat::R16Unorm } else { TexelFormat::R32Float };
            inside.map(|(_, volume)| count_of(volume.demand.bricks()) as u64 * pool::slot_bytes(format)).sum()
        };
        let own = whole(at);
        let other: u64 = OF_DENSITY.into_iter().filter(|of| *of != at).map(whole).sum();
        match most.checked_sub(other) {
            Some(left) if own <= left => left,
            _ => (u128::from(most) * u128::from(own) / u128::from((own + other).max(1))) as u64,
        }
    }

    /// The volumes are those of `fields` that the picture names, and those of before that still exist.
    pub(crate) fn follow_volumes(
        &mut self,
        gpu: &Gpu,
        fields: &Fields<'_>,
        named: impl Iterator<Item = VolumeId>,
    ) -> Result<(), GpuError> {
        let gone: Vec<_> = self.volumes.keys().copied().filter(|id| fields.get(*id).is_none()).collect();
        gone.into_iter().for_each(|id| self.leave(id));
        let known: Vec<_> = self.volumes.keys().copied().collect();
        for id in known.into_iter().chain(named) {
            let fields = fields.get(id).ok_or(GpuError::NoVolume { id: id.0 })?;
            self.enter(gpu, id, &fields.grid, fields.density)?;
        }
        Ok(())
    }

    /// Takes a volume onto the device, as whoever paints on it before it was drawn needs.
    ///
    /// # Errors
    /// Out of memory, a lost device, or a volume that `fields` has not.
    pub(crate) fn have(&mut self, gpu: &Gpu, fields: &Fields<'_>, id: VolumeId) -> Result<(), GpuError> {
        let fields = fields.get(id).ok_or(GpuError::NoVolume { id: id.0 })?;
        self.enter(gpu, id, &fields.grid, fields.density)
    }

    /// What the fields in a pool hold.
    pub(crate) fn kind_of(at: usize) -> FieldKind {
        match at {
            CODES | FLOATS | FINE_CODES | FINE_FLOATS => FieldKind::Density,
            2 => FieldKind::Colour,
            3 => FieldKind::Selection,
            _ => FieldKind::Labels,
        }
    }

    /// Labels are to lie in place, if they are of the only volume, fit, and no stroke holds their slots. They begin anew for that: a
    /// stroke on labels alone, which costs its bricks, does not ask for it.
    pub(crate) fn place_labels(&mut self) {
        if !self.places_labels && self.places && self.whole_volumes() == 1 && !self.is_painted(LABELS) {
            self.places_labels = true;
            self.drop_pool(LABELS);
        }
    }

    /// Begins a field's pages, and its pool if there is none.
    pub(crate) fn begin(&mut self, gpu: &Gpu, key: FieldKey) -> Result<(), GpuError> {
        let (Some(volume), Some(at)) = (self.volumes.get(&key.volume), self.pool_of(key)) else { return Ok(()) };
        let (bricks, fine) = (volume.demand.bricks(), volume.fine);
        let format = match key.kind {
            FieldKind::Density => self.on_device(volume.map.format),
            kind => kind.format(volume.map.format),
        };
        if key.kind == FieldKind::Density {
            self.rebalance(gpu)?;
        }
        if self.pools[at].is_none() {
            let budget = self.budget_of(at, key.kind);
            let most = match key.kind {
                // Half of its share: a larger volume had better not be uploaded whole before it is seen.
                FieldKind::Density => budget / 2,
                FieldKind::Labels if self.places_labels => budget,
                _ => 0,
            };
            let alone = self.places && self.whole_volumes() == 1 && !fine;
            let in_place = alone && pool::fits_in_place(gpu, format, bricks, most);
            let in_place = in_place.then_some((key.volume, bricks));
            // A slot for the coarsest brick of each volume.
            let least = self.volumes.len();
            self.pools[at] = Some(Pool::new(gpu, key.kind.name(), format, (budget, least), in_place)?);
        }
        self.pages.begin(key, bricks);
        self.residency[at].enter(key.volume);
        if key.kind != FieldKind::Colour {
            self.skips.dirty_all(key.volume);
        }
        self.stale = true;
        Ok(())
    }

    /// Gives the pools of density their parts of the budget, for one more volume. One that has more already begins anew, and so
    /// does what lies in place and is no longer alone.
    pub(crate) fn rebalance(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let (several, least) = (self.whole_volumes() > 1, self.volumes.len());
        if several && self.pools[LABELS].as_ref().is_some_and(Pool::is_in_place) {
            if self.is_painted(LABELS) {
                return Err(PAINTED);
            }
            self.drop_pool(LABELS);
        }
        self.places_labels &= !several;
        for at in OF_DENSITY {
            let budget = self.budget_of(at, FieldKind::Density);
            let Some(pool) = &mut self.pools[at] else { continue };
            let in_place = pool.is_in_place();
            if in_place && !several {
                continue;
            }
            if !in_place && pool.bytes() <= budget {
                pool.set_budget(gpu, (budget, least));
            } else if self.is_painted(at) {
                return Err(PAINTED);
            } else {
                self.drop_pool(at);
            }
        }
        Ok(())
    }
}
