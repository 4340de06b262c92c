//! One quantity over the grid: density, colour, selection or labels.
//!
//! Level 0 is a sparse map of edited bricks over a source (or over nothing: colour, selection and labels cost memory only
//! where someone painted). Coarser levels, cell minima and maxima and brick summaries are kept beside it and refreshed by
//! [`Field::swap`], whose cost is that of the bricks it is given.

use crate::volume::blocks::{Region, copy_box, fill_box};
use crate::volume::brick::{BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickKey, SLOT};
use crate::volume::cells::BrickSummary;
use crate::volume::cells::Cells;
use crate::volume::computed::{Computed, SubBox};
use crate::volume::grid::Grid;
use crate::volume::grid::level_dims;
use crate::volume::histogram::Measured;
use crate::volume::pyramid::texel_value;
use crate::volume::source::{BrickSource, SourceError};
use crate::volume::texel::{DensityMap, TexelFormat};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, OnceLock};

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

    /// The format of such a field's texels, in a volume whose density has texels of `density`.
    pub const fn format(self, density: TexelFormat) -> TexelFormat {
        match self {
            Self::Density => density,
            Self::Colour => TexelFormat::Rgba8Unorm,
            Self::Selection => TexelFormat::R8Unorm,
            Self::Labels => TexelFormat::R16Uint,
        }
    }
}

/// What a swap changed: the slots (changed bricks, and neighbours through their apron) whose texels are new.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refresh {
    /// At every level, in order, with a box around the voxels of the level that are new.
    pub slots: Vec<(BrickKey, Region)>,
}

impl Refresh {
    /// These slots, all of them new.
    pub fn whole(keys: impl IntoIterator<Item = BrickKey>) -> Self {
        let all = |key: BrickKey| Region {
            lo: key.index.origin().map(|o| o.saturating_sub(1)),
            end: key.index.origin().map(|o| o + BRICK + 1),
        };
        Self { slots: keys.into_iter().map(|key| (key, all(key))).collect() }
    }

    /// The slots at every level, in order.
    pub fn keys(&self) -> impl Iterator<Item = BrickKey> {
        self.slots.iter().map(|(key, _)| *key)
    }

    /// The slots of level 0, in order.
    pub fn finest(&self) -> impl Iterator<Item = BrickIndex> {
        self.keys().filter(|key| key.level == 0).map(|key| key.index)
    }
}

/// Bricks of level 0 for [`Field::swap`]: `Some` is an edit, `None` none.
pub type Changes = Vec<(BrickIndex, Option<Brick>)>;

#[derive(Clone, Debug)]
pub(super) enum Base {
    Blank,
    Source(Arc<dyn BrickSource>),
    /// Any kind and level of it, computed when asked for; for density it is a source too.
    Computed(Arc<dyn Computed>, Option<Arc<dyn BrickSource>>),
}

/// Texels over a grid, in bricks of 32³ and coarser levels: a source with sparse edits over it, or edits alone.
#[derive(Clone, Debug)]
pub struct Field {
    pub(super) kind: FieldKind,
    pub(super) format: TexelFormat,
    pub(super) map: DensityMap,
    pub(super) dims: [u32; 3],
    pub(super) level_count: u8,
    pub(super) base: Base,
    pub(super) edits: HashMap<BrickIndex, Brick>,
    pub(super) coarse: HashMap<BrickKey, Brick>,
    pub(super) about: HashMap<BrickKey, (BrickSummary, Cells)>,
    /// Of level 0, once asked for; followed by edits.
    pub(super) extremes: OnceLock<[f32; 2]>,
    /// Of its values, once asked for; forgotten by edits.
    pub(super) measured: OnceLock<Arc<Measured>>,
}

const EMPTY: (BrickSummary, Cells) =
    (BrickSummary { uniform: Some([0; 4]), min: 0.0, max: 0.0 }, Cells::Uniform([0.0, 0.0]));

/// Of a brick whose parent cannot be read now: anything may be in it, and whoever reads it is told.
const UNKNOWN: (BrickSummary, Cells) = (
    BrickSummary { uniform: None, min: f32::NEG_INFINITY, max: f32::INFINITY },
    Cells::Uniform([f32::NEG_INFINITY, f32::INFINITY]),
);

impl Field {
    /// A field with nothing painted: all texels 0.
    pub fn blank(kind: FieldKind, grid: &Grid) -> Self {
        Self {
            kind,
            format: kind.format(TexelFormat::R32Float),
            map: DensityMap::FLOAT,
            dims: grid.dims,
            level_count: grid.level_count(),
            base: Base::Blank,
            edits: HashMap::new(),
            coarse: HashMap::new(),
            about: HashMap::new(),
            extremes: OnceLock::new(),
            measured: OnceLock::new(),
        }
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
            Base::Computed(_, source) => source.as_ref(),
        }
    }

    /// Whether it is of a box of a parent.
    pub fn is_of_box(&self) -> bool {
        matches!(self.base, Base::Computed(..))
    }

    /// What it is computed from where nobody edited it, if it is.
    fn computed_by(&self) -> Option<&Arc<dyn Computed>> {
        match &self.base {
            Base::Computed(by, _) => Some(by),
            _ => None,
        }
    }

    /// The box of a parent that it is of, if it is.
    pub fn sub_box(&self) -> Option<SubBox> {
        self.computed_by().map(|by| by.sub_box())
    }

    /// What of a level lies in a box inside the volume where nobody edited it, appended to `out`, x fastest.
    fn base_texels(&self, level: u8, lo: [u32; 3], size: [u32; 3], out: &mut Vec<u8>) -> Result<(), SourceError> {
        match &self.base {
            Base::Computed(by, _) => by.texels(&self.map, (level, lo, size), out)?,
            Base::Source(source) if level == 0 => {
                self.map.encode_voxels(&source.read(lo, size)?, source.scaling(), out);
            }
            _ => out.resize(out.len() + size.iter().map(|&s| s as usize).product::<usize>() * self.format.bytes(), 0),
        }
        Ok(())
    }

    /// Whether bricks of a level that nobody edited hold anything.
    fn has_base(&self, level: u8) -> bool {
        match self.base {
            Base::Blank => false,
            Base::Source(_) => level == 0,
            Base::Computed(..) => true,
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

    /// The bricks of level 0 of a field without a source that may hold anything, in order.
    pub fn present(&self) -> Vec<BrickIndex> {
        if !self.is_of_box() {
            return self.edits().into_keys().collect();
        }
        let holds = |index: &BrickIndex| self.summary(BrickKey { level: 0, index: *index }).uniform != Some([0; 4]);
        self.brick_indices(0).into_iter().filter(holds).collect()
    }

    /// What takes everything out of a brick of a field without a source: no edit, or one of nothing over what is computed.
    pub fn nothing(&self) -> Option<Brick> {
        self.is_of_box().then_some(Brick::Uniform([0; 4]))
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
        match (self.about.get(&key), self.computed_by()) {
            (Some(about), _) => about.0,
            (None, Some(of)) => of.about(&self.map, key).map_or(UNKNOWN.0, |about| about.0),
            (None, None) => EMPTY.0,
        }
    }

    /// Smallest and largest value of the whole field; min > max if all is NaN. One pass over the summaries of level 0, and
    /// another only once an edit took an extreme away.
    pub fn extremes(&self) -> [f32; 2] {
        *self.extremes.get_or_init(|| {
            let bricks = self.brick_indices(0).into_iter();
            bricks
                .map(|index| self.summary(BrickKey { level: 0, index }))
                .fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], s| [lo.min(s.min), hi.max(s.max)])
        })
    }

    /// Minima and maxima of the cells of a brick of any level.
    pub fn cells(&self, key: BrickKey) -> Cells {
        match (self.about.get(&key), self.computed_by()) {
            (Some(about), _) => about.1.clone(),
            (None, Some(of)) => of.about(&self.map, key).map_or(UNKNOWN.1, |about| about.1),
            (None, None) => EMPTY.1.clone(),
        }
    }

    /// A brick's own 32³ texels; those beyond the volume are 0.
    ///
    /// # Errors
    /// If the source fails.
    pub fn brick(&self, key: BrickKey) -> Result<Brick, SourceError> {
        let held = if key.level > 0 { self.coarse.get(&key) } else { self.edits.get(&key.index) };
        held.map_or_else(|| self.base_of(key), |brick| Ok(brick.clone()))
    }

    /// A brick of level 0 as it is without edits.
    ///
    /// # Errors
    /// If the source fails.
    pub fn base_brick(&self, index: BrickIndex) -> Result<Brick, SourceError> {
        self.base_of(BrickKey { level: 0, index })
    }

    fn base_of(&self, key: BrickKey) -> Result<Brick, SourceError> {
        if !self.has_base(key.level) {
            return Ok(Brick::Uniform([0; 4]));
        }
        let bytes = self.format.bytes();
        let valid = self.valid(key.level, key.index);
        let mut block = Vec::with_capacity(BRICK_VOXELS * bytes);
        self.base_texels(key.level, key.index.origin(), valid, &mut block)?;
        let mut texels = vec![0; BRICK_VOXELS * bytes];
        copy_box(&block, valid, [0; 3], &mut texels, [BRICK; 3], [0; 3], valid, bytes);
        Ok(Brick::from_texels(texels, bytes))
    }

    /// The texel of a voxel of level 0, its bytes padded with zeros.
    ///
    /// # Errors
    /// If the source fails or the voxel is outside.
    pub fn texel(&self, voxel: [u32; 3]) -> Result<[u8; 4], SourceError> {
        crate::volume::source::check_box(voxel, [1; 3], self.dims)?;
        let index = BrickIndex::of_voxel(voxel);
        if let Some(brick) = self.edits.get(&index) {
            return Ok(brick.texel(voxel.map(|v| v % BRICK), self.format.bytes()));
        }
        let mut out = Vec::with_capacity(4);
        self.base_texels(0, voxel, [1; 3], &mut out)?;
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

    /// A box inside the volume as it is without edits.
    pub(super) fn read_unedited(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Vec<u8>, SourceError> {
        self.read_box(0, lo.map(i64::from), size, false)
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
        let held = |index: BrickIndex| match level {
            0 if edits => self.edits.get(&index),
            0 => None,
            _ => self.coarse.get(&BrickKey { level, index }),
        };
        let has_base = self.has_base(level);
        let mut parts = Vec::new();
        // What nobody edited.
        let mut unedited: Vec<Region> = Vec::new();
        for z in first[2] / BRICK..=last[2] / BRICK {
            for y in first[1] / BRICK..=last[1] / BRICK {
                for x in first[0] / BRICK..=last[0] / BRICK {
                    let index = BrickIndex([x, y, z]);
                    let origin = index.origin();
                    let part = Region {
                        lo: std::array::from_fn(|a| first[a].max(origin[a])),
                        end: std::array::from_fn(|a| (last[a] + 1).min(origin[a] + BRICK)),
                    };
                    match held(index) {
                        Some(brick) => parts.push((brick, origin, part)),
                        None => unedited.push(part),
                    }
                }
            }
        }
        // The box around it in one go, unless most of that was painted over.
        if let Some(around) = unedited.iter().copied().reduce(|a, b| a.union(&b))
            && around.count() <= 2 * unedited.iter().map(Region::count).sum::<usize>()
        {
            unedited = vec![around];
        }
        let mut block = Vec::new();
        match has_base && parts.is_empty() {
            true => {
                block.reserve_exact(inner.iter().map(|&s| s as usize).product::<usize>() * bytes);
                self.base_texels(level, first, inner, &mut block)?;
            }
            false => block.resize(inner.iter().map(|&s| s as usize).product::<usize>() * bytes, 0),
        }
        for part in unedited.iter().filter(|_| has_base && !parts.is_empty()) {
            let mut texels = Vec::with_capacity(part.count() * bytes);
            self.base_texels(level, part.lo, part.size(), &mut texels)?;
            let at = std::array::from_fn(|a| part.lo[a] - first[a]);
            copy_box(&texels, part.size(), [0; 3], &mut block, inner, at, part.size(), bytes);
        }
        for (brick, origin, part) in parts {
            let in_brick: [u32; 3] = std::array::from_fn(|a| part.lo[a] - origin[a]);
            let in_block: [u32; 3] = std::array::from_fn(|a| part.lo[a] - first[a]);
            match brick {
                Brick::Dense(texels) => {
                    copy_box(texels, [BRICK; 3], in_brick, &mut block, inner, in_block, part.size(), bytes);
                }
                Brick::Uniform(value) => fill_box(&value[..bytes], &mut block, inner, in_block, part.size()),
            }
        }
        if inner == size {
            return Ok(block);
        }
        let mut out = Vec::with_capacity(size.iter().map(|&s| s as usize).product::<usize>() * bytes);
        let clamp = |a: usize, i: u32| {
            ((lo[a] + i64::from(i)).clamp(i64::from(first[a]), i64::from(last[a])) - i64::from(first[a])) as u32
        };
        let before = (i64::from(first[0]) - lo[0]).clamp(0, i64::from(size[0])) as usize;
        let within = (inner[0] as usize).min(size[0] as usize - before);
        let after = size[0] as usize - before - within;
        for z in 0..size[2] {
            for y in 0..size[1] {
                let row = inner[0] as usize * bytes * (clamp(1, y) as usize + inner[1] as usize * clamp(2, z) as usize);
                let row = &block[row..row + inner[0] as usize * bytes];
                for _ in 0..before {
                    out.extend_from_slice(&row[..bytes]);
                }
                out.extend_from_slice(&row[..within * bytes]);
                for _ in 0..after {
                    out.extend_from_slice(&row[row.len() - bytes..]);
                }
            }
        }
        Ok(out)
    }

    /// How many texels of a brick lie in the volume along each axis.
    pub fn valid(&self, level: u8, index: BrickIndex) -> [u32; 3] {
        let (dims, origin) = (self.dims(level), index.origin());
        std::array::from_fn(|a| BRICK.min(dims[a].saturating_sub(origin[a])))
    }
}
