//! What editing asks of the pools: new texels after a swap, slots for a running stroke.

use super::{FieldPools, place};
use crate::gpu::pool::Pool;
use crate::gpu::{Gpu, GpuError};
use crate::volume::{BrickIndex, BrickKey, Field, FieldKind, Refresh};

impl FieldPools {
    /// After [`Field::swap`]: uploads what is held and marks pages and cells for the next frame.
    ///
    /// # Errors
    /// As [`make_resident`](Self::make_resident).
    pub fn refresh(&mut self, gpu: &Gpu, kind: FieldKind, field: &Field, refresh: &Refresh) -> Result<(), GpuError> {
        if let Some(pool) = &mut self.pools[place(kind)] {
            pool.renew(gpu, field, &refresh.slots)?;
        }
        self.stale = true;
        if kind == FieldKind::Density {
            self.extinction.take();
        }
        // Most of the time all is drawn from level 0, and a coarse brick lies over very many of its bricks.
        let coarsest = self.pools[place(kind)].as_ref().map_or(0, Pool::coarsest);
        for key in refresh.slots.iter().filter(|k| k.level <= coarsest) {
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
        if let Some(stale) = &mut self.stale_cells
            && (level == 0 || level == drawn)
        {
            stale.insert(i);
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

    /// Ends the keep of pinned bricks and of cells marked as occupied. What was written to them is committed (by
    /// [`refresh`](Self::refresh)) or put back by the caller.
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
}
