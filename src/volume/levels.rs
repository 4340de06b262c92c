//! How a field changes: built from its source, swapped brick by brick, its coarser levels and summaries renewed.
//!
//! The cost of a swap is that of the bricks it is given, their neighbours (through the apron) and their ancestors.

use super::blocks::{copy_box, interior};
use super::field::{Base, Changes, Field, FieldKind, Refresh};
use super::pyramid::{coarsen, summarise};
use super::{BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickKey, BrickSource, DensityMap, SourceError};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

impl Field {
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
                    coarsen(field.format, &brick, field.valid(0, child), octant(child), &mut texels);
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
                    field.refine_parent(level, parent, &field.children(level, parent))?;
                }
            }
            field.summarise_all(
                field.brick_indices(level).into_iter().map(|index| BrickKey { level, index }).collect(),
            )?;
        }
        progress(1.0);
        Ok(Some(field))
    }

    /// Exchanges bricks of level 0: `Some` is an edit, `None` takes the edit away. Answers what was there before (the same
    /// call with it undoes this one) and which slots are new at every level.
    ///
    /// # Errors
    /// If the source fails; the field is then as it was.
    pub fn swap(&mut self, changes: Changes) -> Result<(Changes, Refresh), SourceError> {
        let bytes = self.format.bytes();
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
        match self.refresh(before.iter().map(|(i, _)| *i).collect()) {
            Ok(refresh) => Ok((before, refresh)),
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

    fn refresh(&mut self, changed: BTreeSet<BrickIndex>) -> Result<Refresh, SourceError> {
        let mut slots = Vec::new();
        let mut changed = changed;
        for level in 0..self.level_count {
            if level > 0 {
                let mut families: BTreeMap<BrickIndex, Vec<BrickIndex>> = BTreeMap::new();
                for child in &changed {
                    families.entry(child.parent()).or_default().push(*child);
                }
                for (parent, children) in &families {
                    self.refine_parent(level, *parent, children)?;
                }
                changed = families.into_keys().collect();
            }
            let around: BTreeSet<BrickIndex> = changed.iter().flat_map(|&b| self.neighbourhood(level, b)).collect();
            let keys: Vec<_> = around.into_iter().map(|index| BrickKey { level, index }).collect();
            self.summarise_all(keys.clone())?;
            slots.extend(keys);
        }
        Ok(Refresh { slots })
    }

    /// Renews the given children's octants of a coarser brick.
    fn refine_parent(&mut self, level: u8, parent: BrickIndex, children: &[BrickIndex]) -> Result<(), SourceError> {
        let bytes = self.format.bytes();
        let key = BrickKey { level, index: parent };
        let mut texels = self.coarse.get(&key).map_or_else(|| vec![0; BRICK_VOXELS * bytes], |b| b.to_texels(bytes));
        for &child in children {
            let brick = self.brick(BrickKey { level: level - 1, index: child })?;
            coarsen(self.format, &brick, self.valid(level - 1, child), octant(child), &mut texels);
        }
        self.coarse.insert(key, Brick::from_texels(texels, bytes));
        Ok(())
    }

    fn summarise_all(&mut self, keys: Vec<BrickKey>) -> Result<(), SourceError> {
        let about = keys
            .into_par_iter()
            .map(|key| Ok((key, summarise(self.format, &self.map, &self.slot(key)?))))
            .collect::<Result<Vec<_>, SourceError>>()?;
        self.about.extend(about);
        Ok(())
    }

    /// The children of a brick of `level` that exist.
    fn children(&self, level: u8, parent: BrickIndex) -> Vec<BrickIndex> {
        let dims = self.brick_dims(level - 1);
        let at = |i: u32| {
            BrickIndex([parent.0[0] * 2 + (i & 1), parent.0[1] * 2 + (i >> 1 & 1), parent.0[2] * 2 + (i >> 2)])
        };
        (0..8).map(at).filter(|b| (0..3).all(|a| b.0[a] < dims[a])).collect()
    }

    /// The brick and its neighbours.
    fn neighbourhood(&self, level: u8, b: BrickIndex) -> Vec<BrickIndex> {
        let dims = self.brick_dims(level);
        let range = |a: usize| b.0[a].saturating_sub(1)..=(b.0[a] + 1).min(dims[a] - 1);
        range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| BrickIndex([x, y, z])))).collect()
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

fn octant(child: BrickIndex) -> [u32; 3] {
    child.0.map(|b| b % 2)
}
