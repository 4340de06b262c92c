//! What a pool shows, and how it follows what is needed of all volumes.
//!
//! If all that is needed fits, a change costs the bricks that it changed. If not, a cut through the levels of all volumes is
//! chosen, at the cost of the needed bricks, when the camera moved or a change asks for other slots. While pictures are in
//! motion uploads can be bounded: a coarser brick then stands in, and what is held comes nearer to the cut from picture to
//! picture.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::dirty_bricks::DirtyBricks;
use crate::gpu::fields::page_tables::{Page, held_page, uniform_page};
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::residency::{self, Need};
use crate::gpu::fields::slot_key::{SlotKey, count_of, number_of};
use crate::gpu::fields::volumes::Fields;
use crate::volume::{BrickKey, Field, FieldKey, FieldKind, VolumeId};
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// What one pool shows of all volumes that lie in it, and which bricks' pages may have to change.
#[derive(Debug)]
pub(crate) struct FieldResidency {
    /// Bricks of level 0 that take a slot each: the needed ones of more than one value, and those being painted.
    finest: BTreeSet<(VolumeId, usize)>,
    cut: Option<HeldCut>,
    /// Bricks whose page may be another, of every volume that lies in the pool.
    dirty: BTreeMap<VolumeId, DirtyBricks>,
    /// Another cut may be due.
    recut: bool,
    /// Coarser bricks stand in until more is uploaded.
    pending: bool,
}

#[derive(Debug)]
struct HeldCut {
    held: HashSet<SlotKey>,
    uniform: HashSet<SlotKey>,
}

/// What of a cut a changed coarser brick is.
pub(crate) enum InCut {
    /// Nothing draws from it.
    No,
    /// Drawn from its texels.
    Drawn,
    /// It has become, or was, of one value.
    Uniform,
}

impl Default for FieldResidency {
    fn default() -> Self {
        Self { finest: BTreeSet::new(), cut: None, dirty: BTreeMap::new(), recut: true, pending: false }
    }
}

impl FieldResidency {
    /// A volume's field lies in the pool from now on.
    pub(crate) fn enter(&mut self, volume: VolumeId) {
        self.dirty.insert(volume, DirtyBricks::all());
        self.recut = true;
    }

    /// It no longer does.
    pub(crate) fn forget(&mut self, volume: VolumeId) {
        if self.dirty.remove(&volume).is_some() {
            self.finest.retain(|(of, _)| *of != volume);
            self.recut = true;
        }
    }

    /// Pages of some bricks may be others.
    pub(crate) fn dirty(&mut self, volume: VolumeId, bricks: impl IntoIterator<Item = usize>) {
        if let Some(dirty) = self.dirty.get_mut(&volume) {
            dirty.extend(bricks);
        }
    }

    /// The camera or the looks decide otherwise.
    pub(crate) fn reconsider(&mut self) {
        self.recut |= self.cut.is_some();
    }

    /// These bricks are about to be painted.
    pub(crate) fn pin(&mut self, keys: &[SlotKey]) {
        self.recut |= self.cut.as_ref().is_some_and(|cut| keys.iter().any(|k| !cut.held.contains(k)));
    }

    pub(crate) fn in_cut(&self, key: SlotKey, field: &Field) -> InCut {
        match &self.cut {
            Some(cut) if cut.uniform.contains(&key) => InCut::Uniform,
            Some(cut) if cut.held.contains(&key) && field.summary(key.brick).uniform.is_some() => InCut::Uniform,
            Some(cut) if cut.held.contains(&key) => InCut::Drawn,
            // Any brick that is held may stand in.
            _ if self.pending => InCut::Drawn,
            _ => InCut::No,
        }
    }

    /// Whether coarser bricks stand in until more is uploaded.
    pub(crate) fn is_pending(&self) -> bool {
        self.pending
    }

    fn is_current(&self) -> bool {
        self.dirty.values().all(DirtyBricks::is_empty) && !self.recut && !self.pending
    }
}

/// Bricks whose pages changed, in order, by volume.
type Changed = Vec<(VolumeId, Vec<usize>)>;

impl FieldPools {
    /// Holds what the needed bricks of a pool are drawn from and sets their pages. Answers whether anything changed.
    pub(crate) fn catch_up_pool(&mut self, gpu: &Gpu, fields: &Fields<'_>, at: usize) -> Result<bool, GpuError> {
        let kind = Self::kind_of(at);
        let Some(mut pool) = self.pools[at].take() else { return Ok(false) };
        let mut residency = std::mem::take(&mut self.residency[at]);
        let volumes: Vec<_> = residency.dirty.keys().copied().collect();
        let done = self.caught_up(gpu, fields, kind, &mut pool, &mut residency);
        self.pools[at] = Some(pool);
        let Ok((uploaded, changed)) = done else {
            // After a failure all is looked at again.
            volumes.into_iter().for_each(|volume| self.residency[at].enter(volume));
            return done.map(|_| false);
        };
        self.residency[at] = residency;
        let mut any = uploaded;
        for (volume, bricks) in changed {
            any |= !bricks.is_empty();
            self.skips.dirty(FieldKey::new(volume, kind), bricks.iter().copied());
        }
        Ok(any)
    }

    /// (whether anything was uploaded, bricks whose page changed)
    fn caught_up(
        &mut self,
        gpu: &Gpu,
        fields: &Fields<'_>,
        kind: FieldKind,
        pool: &mut Pool,
        residency: &mut FieldResidency,
    ) -> Result<(bool, Changed), GpuError> {
        if !pool.is_disturbed() && residency.is_current() {
            return Ok((false, Vec::new()));
        }
        let field_of = |volume: VolumeId| fields.field(FieldKey::new(volume, kind));
        let mut dirty = self.take_dirty(residency);
        if pool.is_in_place() {
            let uploaded = pool.hold(gpu, &field_of, &[], false)?;
            // Unless memory was short.
            if pool.is_in_place() {
                (residency.recut, residency.pending) = (false, false);
                pool.take_disturbed();
                let held = |(volume, i)| page_of(pool, self.key_at(volume, i));
                let pages: Vec<_> = dirty.iter().map(|&at| (at, held(at))).collect();
                return Ok((uploaded, self.set_pages(gpu, kind, &pages)?));
            }
        }
        let mut moved = false;
        for &(volume, i) in &dirty {
            let key = self.key_at(volume, i);
            let several = || field_of(volume).is_some_and(|field| field.summary(key.brick).uniform.is_none());
            let own = pool.is_pinned(key) || self.needs(volume, i) && several();
            moved |= if own { residency.finest.insert((volume, i)) } else { residency.finest.remove(&(volume, i)) };
        }
        let fits = residency.finest.len() <= pool.most();
        let disturbed = pool.take_disturbed();
        let anew =
            std::mem::take(&mut residency.recut) || disturbed || residency.pending || fits == residency.cut.is_some();
        let mut uploaded = false;
        let free = |&(volume, i): &(VolumeId, usize), pool: &Pool| {
            Some(self.key_at(volume, i)).filter(|key| !pool.is_pinned(*key))
        };
        let few = |keys: &[SlotKey], pool: &Pool| {
            self.limit.is_none_or(|limit| keys.iter().filter(|k| !pool.holds(**k)).count() <= limit)
        };
        let own: Vec<_> =
            dirty.iter().filter(|at| residency.finest.contains(at)).filter_map(|at| free(at, pool)).collect();
        if fits && !anew && few(&own, pool) {
            let gone = dirty.iter().filter(|at| !residency.finest.contains(at));
            pool.release(gone.map(|&(volume, i)| self.key_at(volume, i)));
            uploaded = pool.hold(gpu, &field_of, &own, false)?;
        } else if anew || moved || fits {
            let finest: Vec<_> = residency.finest.iter().filter_map(|at| free(at, pool)).collect();
            let (mut target, cut) = if fits {
                (finest, None)
            } else {
                let urgency = self.urgency(fields, &finest);
                let room = pool.most().saturating_sub(pool.pinned().len());
                let cut = residency::choose(&Need { field_of: &field_of, finest: &finest, urgency: &urgency, room });
                let held = cut.held.iter().copied().collect();
                (cut.held, Some(HeldCut { held, uniform: cut.uniform }))
            };
            pool.release_all();
            residency.pending = !few(&target, pool);
            if residency.pending {
                target = first(target, &field_of, pool, self.limit.unwrap_or(usize::MAX));
            }
            uploaded = pool.hold(gpu, &field_of, &target, false)?;
            residency.cut = cut;
            dirty.extend(&residency.finest);
            dirty.sort_unstable();
            dirty.dedup();
        }
        let page = |at: (VolumeId, usize)| Some(self.page(pool, field_of(at.0)?, residency, at));
        let pages: Vec<_> = dirty.iter().map(|&at| (at, page(at))).collect();
        Ok((uploaded, self.set_pages(gpu, kind, &pages)?))
    }

    /// Bricks that are to be looked at, in order.
    fn take_dirty(&mut self, residency: &mut FieldResidency) -> Vec<(VolumeId, usize)> {
        let mut all = Vec::new();
        for (&volume, dirty) in &mut residency.dirty {
            let count = self.volumes.get(&volume).map_or(0, |on| count_of(on.demand.bricks()));
            all.extend(dirty.take(count).into_iter().map(|i| (volume, i)));
        }
        all
    }

    fn needs(&self, volume: VolumeId, brick: usize) -> bool {
        self.volumes.get(&volume).is_some_and(|on| on.demand.needs(brick))
    }

    /// How much each of some bricks of level 0 matters, those of a volume on end.
    fn urgency(&self, fields: &Fields<'_>, finest: &[SlotKey]) -> Vec<f32> {
        let of = |bricks: &[SlotKey]| {
            let id = bricks[0].volume;
            let keys: Vec<BrickKey> = bricks.iter().map(|key| key.brick).collect();
            match (self.volumes.get(&id), fields.get(id)) {
                (Some(on), Some(fields)) => on.demand.urgency(fields.density, &keys),
                _ => vec![0.0; keys.len()],
            }
        };
        finest.chunk_by(|a, b| a.volume == b.volume).flat_map(of).collect()
    }

    /// Sets the pages of some bricks, those of a volume on end. Answers those that changed.
    fn set_pages(
        &mut self,
        gpu: &Gpu,
        kind: FieldKind,
        pages: &[((VolumeId, usize), Option<Page>)],
    ) -> Result<Changed, GpuError> {
        let mut changed = Vec::new();
        self.judged += pages.len() as u64;
        for pages in pages.chunk_by(|a, b| a.0.0 == b.0.0) {
            let volume = pages[0].0.0;
            let pages: Vec<_> = pages.iter().filter_map(|((_, i), page)| Some((*i, (*page)?))).collect();
            changed.push((volume, self.pages.set(gpu, FieldKey::new(volume, kind), &pages)?));
        }
        Ok(changed)
    }

    /// Where a brick of level 0 is drawn from.
    fn page(&self, pool: &Pool, field: &Field, residency: &FieldResidency, (volume, brick): (VolumeId, usize)) -> Page {
        let mut key = self.key_at(volume, brick);
        if let Some((slot, true)) = pool.slot(key) {
            return held_page(key.brick.level, slot);
        }
        let about = field.summary(key.brick);
        if let Some(texel) = about.uniform {
            return uniform_page(0, texel);
        }
        if !self.needs(volume, brick) {
            // Nothing of it shows, its least value neither.
            let density = field.kind() == FieldKind::Density;
            return uniform_page(0, if density { field.map().encode(f64::from(about.min)) } else { [0; 4] });
        }
        while key.brick.level < field.level_count() {
            let (held, uniform) = match &residency.cut {
                _ if residency.pending => (true, true),
                Some(cut) => (cut.held.contains(&key), cut.uniform.contains(&key)),
                None => (true, false),
            };
            if let Some(page) = page_of(pool, key).filter(|_| held) {
                return page;
            }
            if let Some(texel) = field.summary(key.brick).uniform.filter(|_| uniform) {
                return uniform_page(key.brick.level, texel);
            }
            key = key.parent();
        }
        // What is held covers every needed brick, so this is not reached.
        uniform_page(0, [0; 4])
    }

    /// The number of a brick of level 0 of a volume.
    pub(crate) fn number(&self, key: SlotKey) -> usize {
        let bricks = self.volumes.get(&key.volume).map_or([1; 3], |on| on.demand.bricks());
        number_of(bricks, key.brick.index)
    }
}

/// The page that draws from a held brick.
fn page_of(pool: &Pool, key: SlotKey) -> Option<Page> {
    pool.slot(key).map(|(slot, _)| held_page(key.brick.level, slot))
}

/// Of the bricks to be held those that are held, and so many of the others; and each volume's coarsest, so that nothing is
/// missing. That takes no more slots than all of `target` would.
fn first<'f>(
    target: Vec<SlotKey>,
    field_of: &dyn Fn(VolumeId) -> Option<&'f Field>,
    pool: &Pool,
    limit: usize,
) -> Vec<SlotKey> {
    let above = |key: &SlotKey| {
        let mut key = *key;
        while field_of(key.volume).is_some_and(|field| key.brick.level + 1 < field.level_count()) {
            key = key.parent();
        }
        key
    };
    let several = |key: &SlotKey| field_of(key.volume).is_some_and(|f| f.summary(key.brick).uniform.is_none());
    let coarsest: BTreeSet<_> = target.iter().map(above).filter(several).collect();
    let mut left = limit;
    let rest = target.into_iter().filter(|key| {
        let now = pool.holds(*key) || left > 0;
        left -= usize::from(now && !pool.holds(*key));
        now && !coarsest.contains(key)
    });
    let rest: Vec<_> = rest.collect();
    coarsest.iter().copied().chain(rest).collect()
}
