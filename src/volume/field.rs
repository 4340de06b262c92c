//! One quantity over the grid: density, colour, selection or labels.
//!
//! Level 0 is a sparse map of edited bricks over a source (or over nothing: colour, selection and labels cost memory only
//! where someone painted). Coarser levels, cell minima and maxima and brick summaries are kept beside it and refreshed by
//! [`Field::swap`], whose cost is that of the bricks it is given.

use super::grid::level_dims;
use super::pyramid::{coarsen, summarise, texel_value};
use super::{
    BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickKey, BrickSource, DensityMap, Grid, SLOT, SourceError, TexelFormat,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldKind {
    /// The volume's values.
    Density,
    /// Painted colour over the transfer function's.
    Colour,
    /// Degree of interest, 0..1.
    Selection,
    /// Exclusive labels, ids of segments.
    Labels,
}

impl FieldKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Density, Self::Colour, Self::Selection, Self::Labels];

    /// The name in files and messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Density => "density",
            Self::Colour => "colour",
            Self::Selection => "selection",
            Self::Labels => "labels",
        }
    }
}

/// What is known of a slot (a brick and its apron) without reading it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickSummary {
    /// The bytes that all 34³ texels share, if they do: such a brick needs no slot.
    pub uniform: Option<[u8; 4]>,
    /// Smallest value (density: the volume's unit; selection, alpha: 0..1; label: id); above `max` if all are NaN.
    pub min: f32,
    /// Largest value.
    pub max: f32,
}

/// Minima and maxima of a brick's 8³ cells of 4³ voxels, each over every tap that a sample in the cell can meet.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// All cells have this (min, max).
    Uniform([f32; 2]),
    /// x fastest; min > max where all is NaN.
    Dense(Arc<[[f32; 2]]>),
}

/// What a swap changed: the slots (changed bricks, and neighbours through their apron) whose texels are new.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refresh {
    /// At every level, in order.
    pub slots: Vec<BrickKey>,
}

/// Bricks of level 0 for [`Field::swap`]: `Some` is an edit, `None` none.
pub type Changes = Vec<(BrickIndex, Option<Brick>)>;

#[derive(Clone, Debug)]
enum Base {
    Blank,
    Source(Arc<dyn BrickSource>),
}

/// See the module's head.
#[derive(Clone, Debug)]
pub struct Field {
    kind: FieldKind,
    format: TexelFormat,
    map: DensityMap,
    dims: [u32; 3],
    level_count: u8,
    base: Base,
    edits: HashMap<BrickIndex, Brick>,
    coarse: HashMap<BrickKey, Brick>,
    about: HashMap<BrickKey, (BrickSummary, Cells)>,
}

const EMPTY: (BrickSummary, Cells) =
    (BrickSummary { uniform: Some([0; 4]), min: 0.0, max: 0.0 }, Cells::Uniform([0.0, 0.0]));

impl Field {
    /// A field with nothing painted: all texels 0.
    pub fn blank(kind: FieldKind, grid: &Grid) -> Self {
        let format = match kind {
            FieldKind::Density => TexelFormat::R32Float,
            FieldKind::Colour => TexelFormat::Rgba8Unorm,
            FieldKind::Selection => TexelFormat::R8Unorm,
            FieldKind::Labels => TexelFormat::R16Uint,
        };
        Self {
            kind,
            format,
            map: DensityMap::FLOAT,
            dims: grid.dims,
            level_count: grid.level_count(),
            base: Base::Blank,
            edits: HashMap::new(),
            coarse: HashMap::new(),
            about: HashMap::new(),
        }
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

    /// What the field holds.
    pub fn kind(&self) -> FieldKind {
        self.kind
    }

    /// Format of its texels.
    pub fn format(&self) -> TexelFormat {
        self.format
    }

    /// How density becomes texels; of no meaning for other kinds.
    pub fn map(&self) -> &DensityMap {
        &self.map
    }

    /// The source of unedited voxels; `None` where these are 0.
    pub fn source(&self) -> Option<&Arc<dyn BrickSource>> {
        match &self.base {
            Base::Blank => None,
            Base::Source(source) => Some(source),
        }
    }

    /// Voxels along i, j, k of a level.
    pub fn dims(&self, level: u8) -> [u32; 3] {
        level_dims(self.dims, level)
    }

    /// Number of levels, the finest included.
    pub fn level_count(&self) -> u8 {
        self.level_count
    }

    /// Bricks along i, j, k of a level.
    pub fn brick_dims(&self, level: u8) -> [u32; 3] {
        self.dims(level).map(|d| d.div_ceil(BRICK))
    }

    /// All bricks of a level, x fastest.
    pub fn brick_indices(&self, level: u8) -> Vec<BrickIndex> {
        let [nx, ny, nz] = self.brick_dims(level);
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| BrickIndex([x, y, z])))).collect()
    }

    /// Whether nothing was ever painted into a field without a source.
    pub fn is_blank(&self) -> bool {
        matches!(self.base, Base::Blank) && self.edits.is_empty()
    }

    /// The edited bricks of level 0, in order.
    pub fn edits(&self) -> BTreeMap<BrickIndex, &Brick> {
        self.edits.iter().map(|(&i, b)| (i, b)).collect()
    }

    /// What was painted over a brick of level 0, if anything.
    pub fn edit(&self, index: BrickIndex) -> Option<&Brick> {
        self.edits.get(&index)
    }

    /// Memory of edits and coarser levels in bytes.
    pub fn heap_bytes(&self) -> usize {
        self.edits.values().chain(self.coarse.values()).map(Brick::heap_bytes).sum()
    }

    /// The brick's summary, apron included.
    pub fn summary(&self, key: BrickKey) -> BrickSummary {
        self.about.get(&key).unwrap_or(&EMPTY).0
    }

    /// Smallest and largest value of the whole field, in one pass over the summaries of level 0; min > max if all is NaN.
    pub fn extremes(&self) -> [f32; 2] {
        self.brick_indices(0)
            .into_iter()
            .map(|index| self.summary(BrickKey { level: 0, index }))
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], s| [lo.min(s.min), hi.max(s.max)])
    }

    /// Minima and maxima of the cells of a brick of any level.
    pub fn cells(&self, key: BrickKey) -> Cells {
        self.about.get(&key).unwrap_or(&EMPTY).1.clone()
    }

    /// A brick's own 32³ texels; those beyond the volume are 0.
    ///
    /// # Errors
    /// If the source fails.
    pub fn brick(&self, key: BrickKey) -> Result<Brick, SourceError> {
        if key.level > 0 {
            return Ok(self.coarse.get(&key).cloned().unwrap_or(Brick::Uniform([0; 4])));
        }
        if let Some(brick) = self.edits.get(&key.index) {
            return Ok(brick.clone());
        }
        self.base_brick(key.index)
    }

    /// A brick of level 0 as it is without edits.
    ///
    /// # Errors
    /// If the source fails.
    pub fn base_brick(&self, index: BrickIndex) -> Result<Brick, SourceError> {
        let Base::Source(source) = &self.base else { return Ok(Brick::Uniform([0; 4])) };
        let bytes = self.format.bytes();
        let valid = self.valid(0, index);
        let mut block = Vec::with_capacity(BRICK_VOXELS * bytes);
        self.map.encode_voxels(&source.read(index.origin(), valid)?, source.scaling(), &mut block);
        let mut texels = vec![0; BRICK_VOXELS * bytes];
        copy_box(&block, valid, [0; 3], &mut texels, [BRICK; 3], [0; 3], valid, bytes);
        Ok(Brick::from_texels(texels, bytes))
    }

    /// The texel of a voxel of level 0, its bytes padded with zeros.
    ///
    /// # Errors
    /// If the source fails or the voxel is outside.
    pub fn texel(&self, voxel: [u32; 3]) -> Result<[u8; 4], SourceError> {
        super::source::check_box(voxel, [1; 3], self.dims)?;
        let index = BrickIndex::of_voxel(voxel);
        if let Some(brick) = self.edits.get(&index) {
            return Ok(brick.texel(voxel.map(|v| v % BRICK), self.format.bytes()));
        }
        let Base::Source(source) = &self.base else { return Ok([0; 4]) };
        let mut out = Vec::with_capacity(4);
        self.map.encode_voxels(&source.read(voxel, [1; 3])?, source.scaling(), &mut out);
        out.resize(4, 0);
        Ok([out[0], out[1], out[2], out[3]])
    }

    /// The value of a voxel of level 0: density in the volume's unit, selection or alpha 0..1, label id.
    ///
    /// # Errors
    /// If the source fails or the voxel is outside.
    pub fn value(&self, voxel: [u32; 3]) -> Result<f32, SourceError> {
        Ok(texel_value(self.format, &self.map, self.texel(voxel)?))
    }

    /// A brick with one voxel of its neighbours around it: 34³ texels, x fastest, repeated at the volume's border.
    ///
    /// # Errors
    /// If the source fails.
    pub fn slot(&self, key: BrickKey) -> Result<Vec<u8>, SourceError> {
        let lo = key.index.origin().map(|o| i64::from(o) - 1);
        self.read(key.level, lo, [SLOT; 3])
    }

    /// The slot of a brick of level 0 as it is without edits.
    ///
    /// # Errors
    /// If the source fails.
    pub fn base_slot(&self, index: BrickIndex) -> Result<Vec<u8>, SourceError> {
        self.read_box(0, index.origin().map(|o| i64::from(o) - 1), [SLOT; 3], false)
    }

    /// Any box of texels of a level, x fastest; voxels outside repeat the volume's border.
    ///
    /// # Errors
    /// If the source fails.
    pub fn read(&self, level: u8, lo: [i64; 3], size: [u32; 3]) -> Result<Vec<u8>, SourceError> {
        self.read_box(level, lo, size, true)
    }

    fn read_box(&self, level: u8, lo: [i64; 3], size: [u32; 3], edits: bool) -> Result<Vec<u8>, SourceError> {
        let dims = self.dims(level);
        let bytes = self.format.bytes();
        // The part inside the volume, at least one voxel thick so that there is something to repeat.
        let first: [u32; 3] = std::array::from_fn(|a| lo[a].clamp(0, i64::from(dims[a]) - 1) as u32);
        let last: [u32; 3] =
            std::array::from_fn(|a| (lo[a] + i64::from(size[a]) - 1).clamp(0, i64::from(dims[a]) - 1) as u32);
        let inner: [u32; 3] = std::array::from_fn(|a| last[a] - first[a] + 1);
        let mut block = Vec::with_capacity(inner.iter().map(|&s| s as usize).product::<usize>() * bytes);
        let low = first.map(|v| v / BRICK);
        let high = last.map(|v| v / BRICK);
        let edited = |key: &BrickKey| if level == 0 { self.edits.get(&key.index) } else { self.coarse.get(key) };
        match &self.base {
            Base::Source(source) if level == 0 => {
                self.map.encode_voxels(&source.read(first, inner)?, source.scaling(), &mut block);
            }
            _ => block.resize(inner.iter().map(|&s| s as usize).product::<usize>() * bytes, 0),
        }
        if edits && !(level == 0 && self.edits.is_empty()) {
            for z in low[2]..=high[2] {
                for y in low[1]..=high[1] {
                    for x in low[0]..=high[0] {
                        let index = BrickIndex([x, y, z]);
                        let Some(brick) = edited(&BrickKey { level, index }) else { continue };
                        let origin = index.origin();
                        let from: [u32; 3] = std::array::from_fn(|a| first[a].max(origin[a]));
                        let to: [u32; 3] = std::array::from_fn(|a| (last[a] + 1).min(origin[a] + BRICK));
                        let count: [u32; 3] = std::array::from_fn(|a| to[a] - from[a]);
                        let in_brick: [u32; 3] = std::array::from_fn(|a| from[a] - origin[a]);
                        let in_block: [u32; 3] = std::array::from_fn(|a| from[a] - first[a]);
                        match brick {
                            Brick::Dense(texels) => {
                                copy_box(texels, [BRICK; 3], in_brick, &mut block, inner, in_block, count, bytes);
                            }
                            Brick::Uniform(value) => fill_box(&value[..bytes], &mut block, inner, in_block, count),
                        }
                    }
                }
            }
        }
        if inner == size {
            return Ok(block);
        }
        let mut out = Vec::with_capacity(size.iter().map(|&s| s as usize).product::<usize>() * bytes);
        let clamp = |a: usize, i: u32| {
            ((lo[a] + i64::from(i)).clamp(i64::from(first[a]), i64::from(last[a])) - i64::from(first[a])) as u32
        };
        let columns: Vec<usize> = (0..size[0]).map(|x| clamp(0, x) as usize * bytes).collect();
        for z in 0..size[2] {
            for y in 0..size[1] {
                let row = inner[0] as usize * bytes * (clamp(1, y) as usize + inner[1] as usize * clamp(2, z) as usize);
                for &x in &columns {
                    out.extend_from_slice(&block[row + x..row + x + bytes]);
                }
            }
        }
        Ok(out)
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

    /// How many texels of a brick lie in the volume along each axis.
    pub fn valid(&self, level: u8, index: BrickIndex) -> [u32; 3] {
        let (dims, origin) = (self.dims(level), index.origin());
        std::array::from_fn(|a| BRICK.min(dims[a].saturating_sub(origin[a])))
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

/// The 32³ texels inside a slot's apron.
pub(super) fn interior(slot: &[u8], bytes: usize) -> Brick {
    let mut texels = vec![0; BRICK_VOXELS * bytes];
    copy_box(slot, [SLOT; 3], [1; 3], &mut texels, [BRICK; 3], [0; 3], [BRICK; 3], bytes);
    Brick::from_texels(texels, bytes)
}

fn offset(at: [u32; 3], dims: [u32; 3]) -> usize {
    at[0] as usize + dims[0] as usize * (at[1] as usize + dims[1] as usize * at[2] as usize)
}

/// Copies a box of `count` texels between two blocks, each x fastest.
#[allow(clippy::too_many_arguments)]
fn copy_box(
    from: &[u8],
    from_dims: [u32; 3],
    from_at: [u32; 3],
    to: &mut [u8],
    to_dims: [u32; 3],
    to_at: [u32; 3],
    count: [u32; 3],
    bytes: usize,
) {
    let row = count[0] as usize * bytes;
    for z in 0..count[2] {
        for y in 0..count[1] {
            let a = offset([from_at[0], from_at[1] + y, from_at[2] + z], from_dims) * bytes;
            let b = offset([to_at[0], to_at[1] + y, to_at[2] + z], to_dims) * bytes;
            to[b..b + row].copy_from_slice(&from[a..a + row]);
        }
    }
}

fn fill_box(value: &[u8], to: &mut [u8], to_dims: [u32; 3], to_at: [u32; 3], count: [u32; 3]) {
    for z in 0..count[2] {
        for y in 0..count[1] {
            let start = offset([to_at[0], to_at[1] + y, to_at[2] + z], to_dims) * value.len();
            for texel in to[start..start + count[0] as usize * value.len()].chunks_exact_mut(value.len()) {
                texel.copy_from_slice(value);
            }
        }
    }
}
