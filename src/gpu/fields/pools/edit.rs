//! What editing asks of the pools: new texels after a swap, slots for a running stroke.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::demand::live_place;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::pools::field_residency::InCut;
use crate::gpu::fields::slot_key::{SlotKey, number_of};
use crate::volume::{BrickIndex, BrickKey, Cells, Field, FieldKey, FieldKind, Refresh, Region, VolumeId};
use std::collections::HashSet;

impl FieldPools {
    /// After [`Field::swap`]: uploads what is held and marks pages and cells for the next frame.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn refresh(
        &mut self,
        gpu: &Gpu,
        key: impl Into<FieldKey>,
        field: &Field,
        refresh: &Refresh,
    ) -> Result<(), GpuError> {
        let key = key.into();
        let mut slots = refresh.slots.clone();
        if let Some(painted) = self.painted.remove(&key) {
            // The stroke did not reach the field: its slots differ from it in more than what is new.
            slots.retain(|(brick, _)| !painted.contains(brick));
            slots.extend(Refresh::whole(painted).slots);
        }
        self.renew(gpu, key, field, &slots)?;
        self.follow(key, field, refresh);
        Ok(())
    }

    /// The same after a stroke's bricks went into the field, or it was taken back: slots that were
    /// [handed over](Self::hand_over) hold that already and are not uploaded.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn refresh_painted(
        &mut self,
        gpu: &Gpu,
        key: impl Into<FieldKey>,
        field: &Field,
        refresh: &Refresh,
    ) -> Result<(), GpuError> {
        let key = key.into();
        let right = self.painted.remove(&key).unwrap_or_default();
        let other: Vec<_> = refresh.slots.iter().copied().filter(|(brick, _)| !right.contains(brick)).collect();
        self.renew(gpu, key, field, &other)?;
        self.follow(key, field, refresh);
        Ok(())
    }

    fn renew(&mut self, gpu: &Gpu, key: FieldKey, field: &Field, slots: &[(BrickKey, Region)]) -> Result<(), GpuError> {
        let at = self.pool_of(key).filter(|_| self.pages.has(key));
        match at.and_then(|at| self.pools[at].as_mut()) {
            Some(pool) => pool.renew(gpu, (key.volume, field), slots),
            None => Ok(()),
        }
    }

    /// Density of a volume has another map, so that all its texels are others. The other fields keep their slots.
    pub fn remap(&mut self, id: VolumeId, density: &Field) {
        let key = FieldKey::new(id, FieldKind::Density);
        if let Some(at) = self.pool_of(key) {
            let shared = self.pages.keys().any(|other| other != key && self.pool_of(other) == Some(at));
            match &mut self.pools[at] {
                Some(pool) if shared => {
                    pool.forget(id);
                    self.residency[at].forget(id);
                    self.pages.end(key);
                    self.painted.remove(&key);
                }
                _ => self.drop_pool(at),
            }
        }
        let Some(volume) = self.volumes.get_mut(&id) else { return };
        volume.map = *density.map();
        volume.demand.remap();
        self.skips.dirty_all(id);
        self.stale = true;
    }

    /// Marks what a changed field may change.
    fn follow(&mut self, key: FieldKey, field: &Field, refresh: &Refresh) {
        let (Some(at), true) = (self.pool_of(key), self.volumes.contains_key(&key.volume)) else { return };
        self.stale = true;
        let coarsest = self.pages.coarsest(key);
        for brick in refresh.keys().filter(|k| k.level <= coarsest) {
            let slot = SlotKey::new(key.volume, brick);
            if brick.level == 0 {
                self.renew_brick(key, field, brick.index);
                continue;
            }
            match self.residency[at].in_cut(slot, field) {
                InCut::No => {}
                InCut::Uniform => self.residency[at].reconsider(),
                InCut::Drawn => self.renew_cells_below(key, brick),
            }
        }
    }

    fn renew_brick(&mut self, key: FieldKey, field: &Field, index: BrickIndex) {
        let (Some(at), Some(volume)) = (self.pool_of(key), self.volumes.get_mut(&key.volume)) else { return };
        let i = number_of(volume.demand.bricks(), index);
        volume.demand.renew(field, index);
        self.residency[at].dirty(key.volume, [i]);
        self.skips.dirty(key, [i]);
    }

    /// A coarser brick is new that bricks of level 0 are drawn from.
    fn renew_cells_below(&mut self, key: FieldKey, brick: BrickKey) {
        let Some(volume) = self.volumes.get(&key.volume).filter(|_| key.kind != FieldKind::Colour) else { return };
        let bricks = volume.demand.bricks();
        let below = brick.index.0.map(|b| b << brick.level);
        let end: [u32; 3] = std::array::from_fn(|a| ((brick.index.0[a] + 1) << brick.level).min(bricks[a]));
        for z in below[2]..end[2] {
            for y in below[1]..end[1] {
                for x in below[0]..end[0] {
                    let i = number_of(bricks, BrickIndex([x, y, z]));
                    if self.pages.level_of(key, i) == brick.level {
                        self.skips.dirty(key, [i]);
                    }
                }
            }
        }
    }

    /// While a stroke runs: what the cells of a brick hold whose slot it writes, until [`refresh`](Self::refresh) or
    /// [`unpin`](Self::unpin).
    pub fn set_live(&mut self, key: impl Into<FieldKey>, brick: BrickIndex, cells: Cells) {
        let key = key.into();
        let (Some(map), Some(volume)) = (live_place(key.kind), self.volumes.get_mut(&key.volume)) else { return };
        let i = number_of(volume.demand.bricks(), brick);
        volume.demand.set_live(map, i, cells);
        self.stale = true;
        self.skips.dirty(key, [i]);
    }

    /// For painting: these bricks of level 0 get slots of their own, also where they are of one value, and keep them until
    /// [`unpin`](Self::unpin). Answers the first texel of each slot, apron included. The texture may be a new one
    /// afterwards, with the same texels at the same places: take [`texture`](Self::texture) again. Pages follow with the
    /// next call that makes bricks resident. The volume must be on the device.
    ///
    /// # Errors
    /// [`GpuError::PoolFull`] if they are more than three quarters of the pool; [`GpuError::NoVolume`]; else as
    /// [`make_resident`](Self::make_resident).
    pub fn pin(
        &mut self,
        gpu: &Gpu,
        key: impl Into<FieldKey>,
        field: &Field,
        bricks: &[BrickIndex],
    ) -> Result<Vec<[u32; 3]>, GpuError> {
        gpu.check()?;
        let key = key.into();
        if !self.volumes.contains_key(&key.volume) {
            return Err(GpuError::NoVolume { id: key.volume.0 });
        }
        if !self.pages.has(key) {
            self.begin(gpu, key)?;
        }
        let Some(at) = self.pool_of(key) else { return Ok(Vec::new()) };
        let Some(pool) = &mut self.pools[at] else { return Ok(Vec::new()) };
        let keys: Vec<_> = bricks.iter().map(|&index| SlotKey::new(key.volume, BrickKey { level: 0, index })).collect();
        let new: HashSet<_> = keys.iter().filter(|k| !pool.is_pinned(**k)).collect();
        let asked = pool.pinned().len() + new.len();
        let room = if pool.is_in_place() { pool.most() } else { (pool.most() * 3 / 4).max(1) };
        if asked > room {
            return Err(GpuError::PoolFull { field: key.kind.name(), asked, room });
        }
        self.residency[at].pin(&keys);
        pool.hold(gpu, &|of| (of == key.volume).then_some(field), &keys, true)?;
        let origins = keys.iter().filter_map(|k| pool.texel_origin(*k)).collect();
        let numbers: Vec<_> = keys.iter().map(|k| self.number(*k)).collect();
        self.painted_labels(key, &numbers);
        self.residency[at].dirty(key.volume, numbers);
        self.stale = true;
        self.rebind(gpu)?;
        Ok(origins)
    }

    /// Ends the keep of pinned bricks and of what was said of their cells. What was written to them is put back by the caller.
    pub fn unpin(&mut self, key: impl Into<FieldKey>) {
        self.let_go(key.into());
    }

    /// The same where the slots hold what the field is about to hold, as [`refresh_painted`](Self::refresh_painted) then says.
    /// If it does not, they are made as the field is.
    pub fn hand_over(&mut self, key: impl Into<FieldKey>) {
        let key = key.into();
        let bricks = self.let_go(key);
        self.painted.insert(key, bricks);
    }

    /// Bricks of labels are or were painted: what is skipped by labels there cannot be told meanwhile.
    fn painted_labels(&mut self, key: FieldKey, bricks: &[usize]) {
        if key.kind == FieldKind::Labels {
            self.skips.dirty(key, bricks.iter().copied());
        }
    }

    fn let_go(&mut self, key: FieldKey) -> HashSet<BrickKey> {
        let Some(at) = self.pool_of(key) else { return HashSet::new() };
        let bricks = self.pools[at].as_mut().map(|pool| pool.unpin(key.volume)).unwrap_or_default();
        let numbers: Vec<_> = bricks.iter().map(|&brick| self.number(SlotKey::new(key.volume, brick))).collect();
        self.painted_labels(key, &numbers);
        self.residency[at].dirty(key.volume, numbers);
        self.residency[at].reconsider();
        self.stale = true;
        if let (Some(map), Some(volume)) = (live_place(key.kind), self.volumes.get_mut(&key.volume)) {
            let live = volume.demand.end_live(map);
            self.skips.dirty(key, live.iter().copied());
        }
        bricks
    }
}
