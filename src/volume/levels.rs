//! How a field changes: built from its source, swapped brick by brick, its coarser levels and summaries renewed.
//!
//! The cost of a swap is that of the texels that it changes: neighbours cost only where an apron sees a change, coarser
//! levels only above one.

use crate::volume::blocks::{Region, copy_box, difference, interior};
use crate::volume::brick::{BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickKey, CELL};
use crate::volume::cells::Cells;
use crate::volume::computed::Computed;
use crate::volume::field::{Base, Changes, Field, FieldKind, Refresh};
use crate::volume::grid::Grid;
use crate::volume::pyramid::{About, coarsen, renew, summarise};
use crate::volume::source::{BrickSource, SourceError};
use crate::volume::texel::DensityMap;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

impl Field {
    /// Changes that make these all that a field without a source holds.
    #[must_use]
    pub fn replaced_by(&self, mut changes: Changes) -> Changes {
        let given: BTreeSet<BrickIndex> = changes.iter().map(|(index, _)| *index).collect();
        let gone = self.present().into_iter().filter(|index| !given.contains(index));
        changes.extend(gone.map(|index| (index, self.nothing())));
        changes
    }

    /// The density of a source. Reads all of it once, brick by brick, for the coarser levels and the summaries.
    /// `progress` gets the share done and answers whether to go on.
    ///
    /// # Errors
    /// If the source fails, or `Ok(None)` if `progress` said no.
    pub fn from_source(
        source: Arc<dyn BrickSource>,
        map: DensityMap,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Option<Self>, SourceError> {
        let grid = *source.grid();
        let mut field =
            Self { format: map.format, map, base: Base::Source(source), ..Self::blank(FieldKind::Density, &grid) };
        let done = std::sync::atomic::AtomicUsize::new(0);
        let parents = field.brick_indices(1);
        let total = parents.len().max(1);
        let built: Vec<_> = parents
            .into_par_iter()
            .map(|parent| {
                if !progress(done.load(std::sync::atomic::Ordering::Relaxed) as f32 / total as f32) {
                    return Ok(None);
                }
                let mut texels = vec![0; BRICK_VOXELS * field.format.bytes()];
                let mut about = Vec::with_capacity(8);
                for child in field.children(1, parent) {
                    let slot = field.slot(BrickKey { level: 0, index: child })?;
                    about.push((child, summarise(field.format, &field.map, &slot)));
                    let brick = interior(&slot, field.format.bytes());
                    let valid = field.valid(0, child);
                    let all = Region { lo: [0; 3], end: valid };
                    coarsen(field.format, &brick, valid, &all, octant(child), &mut texels);
                }
                done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                Ok(Some((parent, Brick::from_texels(texels, field.format.bytes()), about)))
            })
            .collect::<Result<_, SourceError>>()?;
        for built in built {
            let Some((parent, brick, about)) = built else { return Ok(None) };
            for (index, about) in about {
                field.about.insert(BrickKey { level: 0, index }, about);
            }
            if field.level_count > 1 {
                field.coarse.insert(BrickKey { level: 1, index: parent }, brick);
            }
        }
        for level in 1..field.level_count {
            if level > 1 {
                for parent in field.brick_indices(level) {
                    let children = field.children(level, parent).into_iter();
                    let all: Vec<_> = children
                        .map(|child| (child, Region { lo: [0; 3], end: field.valid(level - 1, child) }))
                        .collect();
                    let brick = field.refined(level, parent, &all)?;
                    field.coarse.insert(BrickKey { level, index: parent }, brick);
                }
            }
            field.summarise_all(
                field.brick_indices(level).into_iter().map(|index| BrickKey { level, index }).collect(),
            )?;
        }
        progress(1.0);
        Ok(Some(field))
    }

    /// A field that is computed where nobody edits it; density by this map. Nothing is computed yet.
    pub(super) fn computed(
        kind: FieldKind,
        by: Arc<dyn Computed>,
        source: Option<Arc<dyn BrickSource>>,
        (grid, map): (&Grid, DensityMap),
    ) -> Self {
        let blank = Self::blank(kind, grid);
        let map = if kind == FieldKind::Density { map } else { blank.map };
        Self { format: kind.format(map.format), map, base: Base::Computed(by, source), ..blank }
    }

    /// The same with the edits of some bricks alone, and without coarser levels and summaries.
    pub(super) fn edits_alone(&self, bricks: impl Fn(BrickIndex) -> bool) -> Self {
        let edits = self.edits.iter().filter(|(index, _)| bricks(**index));
        Self {
            edits: edits.map(|(index, brick)| (*index, brick.clone())).collect(),
            coarse: Default::default(),
            about: Default::default(),
            extremes: Default::default(),
            measured: Default::default(),
            base: self.base.clone(),
            ..*self
        }
    }

    /// A field without edits and levels by another map.
    pub(super) fn by_map(self, map: DensityMap) -> Self {
        Self { format: map.format, map, measured: Default::default(), ..self }
    }

    /// The density that it is where nobody edited it, by another map.
    ///
    /// # Errors
    /// As [`from_source`](Self::from_source); nothing if there is no source.
    pub fn unedited(
        &self,
        map: DensityMap,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Option<Self>, SourceError> {
        match &self.base {
            Base::Blank => Ok(None),
            Base::Source(source) => Self::from_source(source.clone(), map, progress),
            Base::Computed(..) => Ok(Some(self.edits_alone(|_| false).by_map(map))),
        }
    }

    /// Exchanges bricks of level 0: `Some` is an edit, `None` takes the edit away. Answers what was there before (the same
    /// call with it undoes this one) and which slots are new at every level.
    ///
    /// # Errors
    /// If the source fails; the field is then as it was.
    pub fn swap(&mut self, changes: Changes) -> Result<(Changes, Refresh), SourceError> {
        let bytes = self.format.bytes();
        let old = changes
            .par_iter()
            .map(|&(index, _)| self.brick(BrickKey { level: 0, index }))
            .collect::<Result<Vec<_>, _>>()?;
        let mut before = Vec::with_capacity(changes.len());
        for (index, brick) in changes {
            let brick = brick.map(|b| self.clipped(index, b));
            debug_assert!(
                brick.as_ref().is_none_or(|b| matches!(b, Brick::Uniform(_)) || b.heap_bytes() == BRICK_VOXELS * bytes)
            );
            let old = match brick {
                Some(brick) => self.edits.insert(index, brick),
                None => self.edits.remove(&index),
            };
            before.push((index, old));
        }
        match self.changed(&before, &old).and_then(|changed| self.refresh(changed)) {
            Ok(refresh) => {
                if !before.is_empty() {
                    self.measured.take();
                }
                Ok((before, refresh))
            }
            Err(error) => {
                for (index, old) in before {
                    match old {
                        Some(brick) => self.edits.insert(index, brick),
                        None => self.edits.remove(&index),
                    };
                }
                Err(error)
            }
        }
    }

    /// The texels, within the brick, in which bricks differ from what they were.
    fn changed(&self, before: &Changes, old: &[Brick]) -> Result<BTreeMap<BrickIndex, Region>, SourceError> {
        let pairs = before.par_iter().zip(old).map(|(&(index, _), old)| {
            let new = self.brick(BrickKey { level: 0, index })?;
            Ok(difference(old, &new, self.format.bytes()).map(|region| (index, region)))
        });
        Ok(pairs.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }

    fn refresh(&mut self, changed: BTreeMap<BrickIndex, Region>) -> Result<Refresh, SourceError> {
        let mut slots = Vec::new();
        let mut changed = changed;
        for level in 0..self.level_count {
            if level > 0 {
                let mut families: BTreeMap<BrickIndex, Vec<(BrickIndex, Region)>> = BTreeMap::new();
                for (child, region) in changed {
                    families.entry(child.parent()).or_default().push((child, region));
                }
                let refined = each(&families, |&index, children| {
                    Ok((BrickKey { level, index }, self.refined(level, index, children)?))
                })?;
                self.coarse.extend(refined);
                changed = families.into_iter().filter_map(|(parent, c)| Some((parent, covered(&c)?))).collect();
            }
            let bricks = self.brick_dims(level);
            let mut around: BTreeMap<BrickIndex, Region> = BTreeMap::new();
            for (brick, region) in &changed {
                let region = region.shifted(brick.origin());
                for slot in region.slots(bricks) {
                    around.entry(slot).and_modify(|r| *r = r.union(&region)).or_insert(region);
                }
            }
            let about = each(&around, |&index, region| {
                let key = BrickKey { level, index };
                Ok((key, self.renewed(key, region)?))
            })?;
            slots.extend(around.iter().map(|(&index, region)| (BrickKey { level, index }, *region)));
            if level == 0 {
                self.follow_extremes(&about);
            }
            self.about.extend(about);
        }
        Ok(Refresh { slots })
    }

    /// Widens the known extremes by new summaries; forgets them if one may have gone.
    fn follow_extremes(&mut self, about: &[(BrickKey, About)]) {
        let Some(&[lo, hi]) = self.extremes.get() else { return };
        let gone = about.iter().any(|(key, (new, _))| {
            let old = self.summary(*key);
            old.min <= lo && new.min > lo || old.max >= hi && new.max < hi
        });
        self.extremes.take();
        if !gone {
            let wider = about.iter().fold([lo, hi], |[lo, hi], (_, (s, _))| [lo.min(s.min), hi.max(s.max)]);
            self.extremes.get_or_init(|| wider);
        }
    }

    /// A coarser brick with what covers the given regions of its children renewed.
    fn refined(&self, level: u8, parent: BrickIndex, children: &[(BrickIndex, Region)]) -> Result<Brick, SourceError> {
        let bytes = self.format.bytes();
        let key = BrickKey { level, index: parent };
        let below = |&(child, region): &(BrickIndex, Region)| {
            let brick = self.brick(BrickKey { level: level - 1, index: child })?;
            Ok((brick, self.valid(level - 1, child), region, octant(child)))
        };
        let below = children.iter().map(below).collect::<Result<Vec<_>, SourceError>>()?;
        let before = self.brick(key)?;
        Ok(before.edited(bytes, |texels| {
            for (brick, valid, region, octant) in &below {
                coarsen(self.format, brick, *valid, region, *octant, texels);
            }
        }))
    }

    fn summarise_all(&mut self, keys: Vec<BrickKey>) -> Result<(), SourceError> {
        let about = keys
            .into_par_iter()
            .map(|key| Ok((key, summarise(self.format, &self.map, &self.slot(key)?))))
            .collect::<Result<Vec<_>, SourceError>>()?;
        self.about.extend(about);
        Ok(())
    }

    /// What is known of a brick after a region of its level changed: only the cells that meet it are read again.
    fn renewed(&self, key: BrickKey, region: &Region) -> Result<About, SourceError> {
        if let Some((_, Cells::Dense(cells))) = self.about.get(&key) {
            let (origin, dims) = (key.index.origin(), self.dims(key.level));
            let (cells_edge, edge) = (BRICK / CELL, i64::from(CELL));
            let met = Region {
                lo: std::array::from_fn(|a| {
                    let first = i64::from(region.lo[a]) - i64::from(origin[a]);
                    (first - 1).div_euclid(edge).max(0) as u32
                }),
                end: std::array::from_fn(|a| {
                    let last = i64::from(region.end[a]) - 1 - i64::from(origin[a]);
                    // Cells beyond the volume repeat its border.
                    let all = region.end[a] == dims[a];
                    if all { cells_edge } else { ((last + 1).div_euclid(edge) as u32 + 1).min(cells_edge) }
                }),
            };
            let lo = std::array::from_fn(|a| i64::from(origin[a] + met.lo[a] * CELL) - 1);
            let texels = self.read(key.level, lo, met.size().map(|n| n * CELL + 2))?;
            if let Some(about) = renew(self.format, &self.map, cells, &met, &texels) {
                return Ok(about);
            }
        }
        Ok(summarise(self.format, &self.map, &self.slot(key)?))
    }

    /// The children of a brick of `level` that exist.
    fn children(&self, level: u8, parent: BrickIndex) -> Vec<BrickIndex> {
        let dims = self.brick_dims(level - 1);
        let at = |i: u32| {
            BrickIndex([parent.0[0] * 2 + (i & 1), parent.0[1] * 2 + (i >> 1 & 1), parent.0[2] * 2 + (i >> 2)])
        };
        (0..8).map(at).filter(|b| (0..3).all(|a| b.0[a] < dims[a])).collect()
    }

    /// The same brick with zeros beyond the volume, so that equal content means equal bytes.
    fn clipped(&self, index: BrickIndex, brick: Brick) -> Brick {
        let valid = self.valid(0, index);
        let bytes = self.format.bytes();
        if valid == [BRICK; 3] {
            return brick;
        }
        let mut texels = vec![0; BRICK_VOXELS * bytes];
        copy_box(&brick.to_texels(bytes), [BRICK; 3], [0; 3], &mut texels, [BRICK; 3], [0; 3], valid, bytes);
        Brick::from_texels(texels, bytes)
    }
}

/// What `work` makes of each. A few are done at once: threads would cost more than they save.
fn each<V: Sync, R: Send>(
    items: &BTreeMap<BrickIndex, V>,
    work: impl Fn(&BrickIndex, &V) -> Result<R, SourceError> + Sync,
) -> Result<Vec<R>, SourceError> {
    const FEW: usize = 16;
    if items.len() <= FEW {
        return items.iter().map(|(index, value)| work(index, value)).collect();
    }
    items.par_iter().map(|(index, value)| work(index, value)).collect()
}

fn octant(child: BrickIndex) -> [u32; 3] {
    child.0.map(|b| b % 2)
}

/// What covers the given regions of children, within their parent.
fn covered(children: &[(BrickIndex, Region)]) -> Option<Region> {
    let parts = children.iter().map(|(child, r)| r.halved().shifted(octant(*child).map(|o| o * (BRICK / 2))));
    parts.reduce(|a, b| a.union(&b))
}
