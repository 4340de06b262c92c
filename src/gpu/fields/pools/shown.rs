//! What a field's pool shows, and how it follows what is needed.
//!
//! If all that is needed fits, a change costs the bricks that it changed. If not, a cut through the levels is chosen, at the
//! cost of the needed bricks, when the camera moved or a change asks for other slots. While pictures are in motion uploads can
//! be bounded: a coarser brick then stands in, and what is held comes nearer to the cut from picture to picture.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pool::pages::Page;
use crate::gpu::fields::pools::marks::Marks;
use crate::gpu::fields::pools::{FieldPools, Fields, place};
use crate::gpu::fields::residency;
use crate::gpu::fields::residency::Need;
use crate::volume::{BrickKey, Field, FieldKind};
use std::collections::{BTreeSet, HashSet};

/// See the module's head.
#[derive(Debug)]
pub(super) struct Shown {
    /// Bricks of level 0 that take a slot each: the needed ones of more than one value, and those being painted.
    finest: BTreeSet<usize>,
    cut: Option<Cut>,
    /// Bricks whose page may be another.
    pub(super) stale: Marks,
    /// Another cut may be due.
    recut: bool,
    /// Coarser bricks stand in until more is uploaded.
    pending: bool,
}

#[derive(Debug)]
struct Cut {
    held: HashSet<BrickKey>,
    uniform: HashSet<BrickKey>,
}

/// What of a cut a changed coarser brick is.
pub(super) enum InCut {
    /// Nothing draws from it.
    No,
    /// Drawn from its texels.
    Drawn,
    /// It has become, or was, of one value.
    Uniform,
}

impl Default for Shown {
    fn default() -> Self {
        Self { finest: BTreeSet::new(), cut: None, stale: Marks::all(), recut: true, pending: false }
    }
}

impl Shown {
    /// The camera or the look decides otherwise.
    pub(super) fn reconsider(&mut self) {
        self.recut |= self.cut.is_some();
    }

    /// These bricks are about to be painted.
    pub(super) fn pin(&mut self, keys: &[BrickKey]) {
        self.recut |= self.cut.as_ref().is_some_and(|cut| keys.iter().any(|k| !cut.held.contains(k)));
    }

    pub(super) fn in_cut(&self, key: BrickKey, field: &Field) -> InCut {
        match &self.cut {
            Some(cut) if cut.uniform.contains(&key) => InCut::Uniform,
            Some(cut) if cut.held.contains(&key) && field.summary(key).uniform.is_some() => InCut::Uniform,
            Some(cut) if cut.held.contains(&key) => InCut::Drawn,
            // Any brick that is held may stand in.
            _ if self.pending => InCut::Drawn,
            _ => InCut::No,
        }
    }

    /// Whether coarser bricks stand in until more is uploaded.
    pub(super) fn is_pending(&self) -> bool {
        self.pending
    }

    fn is_settled(&self) -> bool {
        self.stale.is_empty() && !self.recut && !self.pending
    }
}

impl FieldPools {
    /// Holds what the field's needed bricks are drawn from and sets their pages. Answers whether anything changed.
    pub(super) fn settle_field(&mut self, gpu: &Gpu, fields: &Fields<'_>, kind: FieldKind) -> Result<bool, GpuError> {
        let Some(mut pool) = self.pools[place(kind)].take() else { return Ok(false) };
        let mut shown = std::mem::take(&mut self.shown[place(kind)]);
        let settled = self.settled(gpu, fields, fields.get(kind), &mut pool, &mut shown);
        self.pools[place(kind)] = Some(pool);
        // After a failure all is looked at again.
        let (uploaded, changed, judged) = settled?;
        self.shown[place(kind)] = shown;
        self.judged += judged as u64;
        if matches!(kind, FieldKind::Density | FieldKind::Selection) {
            self.stale_cells.extend(changed.iter().copied());
        }
        Ok(uploaded || !changed.is_empty())
    }

    /// (whether anything was uploaded, bricks whose page changed, bricks looked at)
    fn settled(
        &self,
        gpu: &Gpu,
        fields: &Fields<'_>,
        field: &Field,
        pool: &mut Pool,
        shown: &mut Shown,
    ) -> Result<(bool, Vec<usize>, usize), GpuError> {
        if !pool.is_disturbed() && shown.is_settled() {
            return Ok((false, Vec::new(), 0));
        }
        if pool.is_in_place() {
            let uploaded = pool.hold(gpu, field, &[], false)?;
            // Unless memory was short.
            if pool.is_in_place() {
                let marks = shown.stale.take(self.needed.len());
                let pages: Vec<_> = marks.iter().filter_map(|&i| Some((i, pool.page(self.key_at(i))?))).collect();
                (shown.recut, shown.pending) = (false, false);
                pool.take_disturbed();
                return Ok((uploaded, pool.set_pages(gpu, &pages)?, marks.len()));
            }
        }
        let mut marks = shown.stale.take(self.needed.len());
        let mut moved = false;
        for &i in &marks {
            let key = self.key_at(i);
            let own = pool.is_pinned(key) || self.needed[i] && field.summary(key).uniform.is_none();
            moved |= if own { shown.finest.insert(i) } else { shown.finest.remove(&i) };
        }
        let fits = shown.finest.len() <= pool.most();
        let disturbed = pool.take_disturbed();
        let anew = std::mem::take(&mut shown.recut) || disturbed || shown.pending || fits == shown.cut.is_some();
        let mut uploaded = false;
        let free = |i: &usize, pool: &Pool| Some(self.key_at(*i)).filter(|key| !pool.is_pinned(*key));
        let few = |keys: &[BrickKey], pool: &Pool| {
            self.limit.is_none_or(|limit| keys.iter().filter(|k| !pool.holds(**k)).count() <= limit)
        };
        let own: Vec<_> = marks.iter().filter(|i| shown.finest.contains(i)).filter_map(|i| free(i, pool)).collect();
        if fits && !anew && few(&own, pool) {
            pool.release(marks.iter().filter(|i| !shown.finest.contains(i)).map(|i| self.key_at(*i)));
            uploaded = pool.hold(gpu, field, &own, false)?;
        } else if anew || moved || fits {
            let finest: Vec<_> = shown.finest.iter().filter_map(|i| free(i, pool)).collect();
            let (mut target, cut) = if fits {
                (finest, None)
            } else {
                let urgency = self.urgency(fields.density, &finest);
                let room = pool.most().saturating_sub(pool.pinned().len());
                let cut = residency::choose(&Need { field, finest: &finest, urgency: &urgency, room });
                let held = cut.held.iter().copied().collect();
                (cut.held, Some(Cut { held, uniform: cut.uniform }))
            };
            pool.release_all();
            shown.pending = !few(&target, pool);
            if shown.pending {
                target = first(target, field, pool, self.limit.unwrap_or(usize::MAX));
            }
            uploaded = pool.hold(gpu, field, &target, false)?;
            shown.cut = cut;
            marks.extend(&shown.finest);
            marks.sort_unstable();
            marks.dedup();
        }
        let pages: Vec<_> = marks.iter().map(|&i| (i, self.page(pool, field, shown, i))).collect();
        Ok((uploaded, pool.set_pages(gpu, &pages)?, marks.len()))
    }

    /// Where a brick of level 0 is drawn from.
    fn page(&self, pool: &Pool, field: &Field, shown: &Shown, brick: usize) -> Page {
        let mut key = self.key_at(brick);
        if let Some(page) = pool.pinned_page(key) {
            return page;
        }
        let about = field.summary(key);
        if let Some(texel) = about.uniform {
            return pool::pages::uniform_page(0, pool.bits(texel));
        }
        if !self.needed[brick] {
            // Nothing of it shows, its least value neither.
            let texel =
                if field.kind() == FieldKind::Density { field.map().encode(f64::from(about.min)) } else { [0; 4] };
            return pool::pages::uniform_page(0, pool.bits(texel));
        }
        while key.level < field.level_count() {
            let (held, uniform) = match &shown.cut {
                _ if shown.pending => (true, true),
                Some(cut) => (cut.held.contains(&key), cut.uniform.contains(&key)),
                None => (true, false),
            };
            if let Some(page) = pool.page(key).filter(|_| held) {
                return page;
            }
            if let Some(texel) = field.summary(key).uniform.filter(|_| uniform) {
                return pool::pages::uniform_page(key.level, pool.bits(texel));
            }
            key = BrickKey { level: key.level + 1, index: key.index.parent() };
        }
        // What is held covers every needed brick, so this is not reached.
        pool::pages::uniform_page(0, 0)
    }
}

/// Of the bricks to be held those that are held, and so many of the others; and the coarsest, so that nothing is missing. That
/// takes no more slots than all of `target` would.
fn first(target: Vec<BrickKey>, field: &Field, pool: &Pool, limit: usize) -> Vec<BrickKey> {
    let top = field.level_count() - 1;
    let above = |key: &BrickKey| BrickKey {
        level: top,
        index: crate::volume::BrickIndex(key.index.0.map(|b| b >> (top - key.level))),
    };
    let coarsest: BTreeSet<_> = target.iter().map(above).filter(|k| field.summary(*k).uniform.is_none()).collect();
    let mut left = limit;
    let rest = target.into_iter().filter(|key| {
        let now = pool.holds(*key) || left > 0;
        left -= usize::from(now && !pool.holds(*key));
        now && !coarsest.contains(key)
    });
    let rest: Vec<_> = rest.collect();
    coarsest.iter().copied().chain(rest).collect()
}
