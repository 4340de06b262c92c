//! What editing asks of the pools: new texels after a swap, slots for a running stroke.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::importance;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pools::marks::Marks;
use crate::gpu::fields::pools::shown::InCut;
use crate::gpu::fields::pools::{FieldPools, place};
use crate::volume::{BrickIndex, BrickKey, Cells, Field, FieldKind, Refresh};
use std::collections::HashSet;

impl FieldPools {
    /// After [`Field::swap`]: uploads what is held and marks pages and cells for the next frame.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn refresh(&mut self, gpu: &Gpu, kind: FieldKind, field: &Field, refresh: &Refresh) -> Result<(), GpuError> {
        let mut slots = refresh.slots.clone();
        if let Some((_, painted)) = self.painted.take_if(|(of, _)| *of == kind) {
            // The stroke did not reach the field: its slots differ from it in more than what is new.
            slots.retain(|(key, _)| !painted.contains(key));
            slots.extend(Refresh::whole(painted).slots);
        }
        if let Some(pool) = &mut self.pools[place(kind)] {
            pool.renew(gpu, field, &slots)?;
        }
        self.follow(kind, field, refresh);
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
        kind: FieldKind,
        field: &Field,
        refresh: &Refresh,
    ) -> Result<(), GpuError> {
        let right = self.painted.take_if(|(of, _)| *of == kind).map(|(_, keys)| keys).unwrap_or_default();
        if let Some(pool) = &mut self.pools[place(kind)] {
            let other: Vec<_> = refresh.slots.iter().copied().filter(|(key, _)| !right.contains(key)).collect();
            pool.renew(gpu, field, &other)?;
        }
        self.follow(kind, field, refresh);
        Ok(())
    }

    /// Density has another map, so that all its texels are others. The other fields keep their slots.
    pub fn remap(&mut self, density: &Field) {
        self.map = *density.map();
        self.pools[0] = None;
        self.visible.clear();
        self.extinction.take();
        self.stale_cells = Marks::all();
        self.stale = true;
    }

    /// Marks what a changed field may change.
    fn follow(&mut self, kind: FieldKind, field: &Field, refresh: &Refresh) {
        self.stale = true;
        let coarsest = self.pools[place(kind)].as_ref().map_or(0, Pool::coarsest);
        for key in refresh.keys().filter(|k| k.level <= coarsest) {
            if key.level == 0 {
                self.renew_brick(field, key.index);
                continue;
            }
            match self.shown[place(kind)].in_cut(key, field) {
                InCut::No => {}
                InCut::Uniform => self.shown[place(kind)].reconsider(),
                InCut::Drawn => self.renew_cells_below(kind, key),
            }
        }
    }

    fn renew_brick(&mut self, field: &Field, index: BrickIndex) {
        let kind = field.kind();
        let i = self.brick_at(index);
        self.shown[place(kind)].stale.insert(i);
        let Some(map) = map_of(kind) else { return };
        if kind == FieldKind::Density {
            if !self.visible.is_empty() {
                self.visible[i] = self.shows(field, index);
            }
            if let (Some(extinction), Some(look)) = (self.extinction.get_mut(), &self.look) {
                extinction[i] = importance::extinction(field, &self.grid, &look.transfer, index);
            }
        }
        self.live[map].remove(&i);
        self.unsure.insert(i);
        self.stale_cells.insert(i);
    }

    /// A coarser brick is new that bricks of level 0 are drawn from.
    fn renew_cells_below(&mut self, kind: FieldKind, key: BrickKey) {
        let (Some(pool), Some(_)) = (&self.pools[place(kind)], map_of(kind)) else { return };
        let below = key.index.0.map(|b| b << key.level);
        let end: [u32; 3] = std::array::from_fn(|a| ((key.index.0[a] + 1) << key.level).min(self.bricks[a]));
        for z in below[2]..end[2] {
            for y in below[1]..end[1] {
                for x in below[0]..end[0] {
                    let i = self.brick_at(BrickIndex([x, y, z]));
                    if pool.level_of(i) == key.level {
                        self.stale_cells.insert(i);
                    }
                }
            }
        }
    }

    /// While a stroke runs: what the cells of a brick hold whose slot it writes, until [`refresh`](Self::refresh) or
    /// [`unpin`](Self::unpin).
    pub fn set_live(&mut self, kind: FieldKind, brick: BrickIndex, cells: Cells) {
        let Some(map) = map_of(kind) else { return };
        let i = self.brick_at(brick);
        self.live[map].insert(i, cells);
        self.stale = true;
        self.stale_cells.insert(i);
        self.unsure.insert(i);
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
            self.begin_pool(gpu, field)?;
        }
        let Some(pool) = &mut self.pools[place(kind)] else { return Ok(Vec::new()) };
        let keys: Vec<_> = bricks.iter().map(|&index| BrickKey { level: 0, index }).collect();
        let new: HashSet<_> = keys.iter().filter(|k| !pool.is_pinned(**k)).collect();
        let asked = pool.pinned().len() + new.len();
        let room = if pool.is_in_place() { pool.most() } else { (pool.most() * 3 / 4).max(1) };
        if asked > room {
            return Err(GpuError::PoolFull { field: kind.name(), asked, room });
        }
        self.shown[place(kind)].pin(&keys);
        pool.hold(gpu, field, &keys, true)?;
        let origins = keys.iter().filter_map(|k| pool.texel_origin(*k)).collect();
        for &index in bricks {
            let i = self.brick_at(index);
            self.shown[place(kind)].stale.insert(i);
        }
        self.stale = true;
        self.rebind(gpu)?;
        Ok(origins)
    }

    /// Ends the keep of pinned bricks and of what was said of their cells. What was written to them is put back by the caller.
    pub fn unpin(&mut self, kind: FieldKind) {
        self.let_go(kind);
    }

    /// The same where the slots hold what the field is about to hold, as [`refresh_painted`](Self::refresh_painted) then says.
    /// If it does not, they are made as the field is.
    pub fn hand_over(&mut self, kind: FieldKind) {
        let keys = self.let_go(kind);
        self.painted = Some((kind, keys));
    }

    fn let_go(&mut self, kind: FieldKind) -> HashSet<BrickKey> {
        let keys = self.pools[place(kind)].as_mut().map(Pool::unpin).unwrap_or_default();
        let bricks: Vec<_> = keys.iter().map(|key| self.brick_at(key.index)).collect();
        self.shown[place(kind)].stale.extend(bricks);
        self.shown[place(kind)].reconsider();
        self.stale = true;
        if let Some(map) = map_of(kind) {
            let live = std::mem::take(&mut self.live[map]);
            self.stale_cells.extend(live.keys().copied());
            self.unsure.extend(live.into_keys());
        }
        keys
    }
}

/// The number of a field that cells and needs depend on.
fn map_of(kind: FieldKind) -> Option<usize> {
    match kind {
        FieldKind::Density => Some(0),
        FieldKind::Selection => Some(1),
        FieldKind::Colour | FieldKind::Labels => None,
    }
}
