//! A box of a volume at a finer resolution of its own: what a sub-volume holds where nobody edited it.
//!
//! Owns the arithmetic of "Direct Volume Editing" (2008), 4.1: density and selection by the tensor product of quadratic splines that
//! quasi-interpolate (weights 1, 6, 1 of 8 at voxel centres), linear at the box's faces and blended with that over half a voxel of
//! the parent; colour linear, labels of the nearest voxel. An axis at 1× is a copy. Keeps the parent as it was when the box was
//! made; computes what is asked for and stores nothing but what was asked lately.

use crate::volume::Voxels;
use crate::volume::brick::{BRICK, BrickKey, CELL, CELLS_PER_BRICK, SLOT, shared_texel};
use crate::volume::cells::{BrickSummary, Cells};
use crate::volume::computed::{Computed, SubBox};
use crate::volume::field::{Field, FieldKind};
use crate::volume::grid::{Grid, level_dims};
use crate::volume::pyramid::texel_value;
use crate::volume::resample::{Axis, Block, interpolate, quasi_interpolate};
use crate::volume::source::{BrickSource, SourceError, check_box};
use crate::volume::texel::DensityMap;
use crate::volume::volume::Volume;
use crate::volume::voxel_type::VoxelType;
use lru::LruCache;
use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

/// How a field goes between the parent's voxels.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Between {
    /// By quadratic splines, an axis at 1× as it is.
    Splines,
    /// Straight.
    Linear,
}

/// The samples of a [`SubBox`] as its parent has them.
#[derive(Debug)]
struct RefinedBox {
    parent: Arc<Volume>,
    of: SubBox,
    grid: Grid,
    name: String,
    voxel_type: VoxelType,
}

impl RefinedBox {
    /// Of a parent as it is now; `of` lies in it.
    fn new(parent: Arc<Volume>, of: SubBox) -> Self {
        let grid = of.grid(parent.grid());
        let name = format!("a box of {}", parent.source.name());
        // Numbers of up to 24 bits are 32-bit floats to the last digit.
        let voxel_type = match parent.source.voxel_type() {
            VoxelType::U8 | VoxelType::I8 | VoxelType::U16 | VoxelType::I16 | VoxelType::F32 => VoxelType::F32,
            _ => VoxelType::F64,
        };
        Self { parent, of, grid, name, voxel_type }
    }

    /// Whether the parent's field had nothing.
    fn is_blank(&self, kind: FieldKind) -> bool {
        self.parent.field(kind).is_blank()
    }

    /// The samples `lo` and on of a level, seen from the parent.
    fn axes(&self, level: u8, lo: [u32; 3], size: [u32; 3], between: Between) -> [Axis; 3] {
        let dims = self.parent.grid().dims;
        let fine = f64::from(1_u32 << level);
        std::array::from_fn(|a| {
            let scale = f64::from(self.of.scale[a]);
            let (first, last) = (f64::from(self.of.lo[a]), f64::from(self.of.hi[a]));
            let of = |i: u32| ((fine * (f64::from(lo[a] + i) + 0.5) - 0.5) / scale + first).min(last);
            let splines = between == Between::Splines && self.of.scale[a] > 1;
            Axis::new((0..size[a]).map(of), [first, last], dims[a], splines)
        })
    }

    /// The parent's values that samples are made of, in the unit of `values`.
    fn block(&self, kind: FieldKind, axes: &[Axis; 3]) -> Result<Block, SourceError> {
        let lo = [0, 1, 2].map(|a| axes[a].first());
        let size = [0, 1, 2].map(|a| axes[a].count());
        let field = self.parent.field(kind);
        let values = match kind {
            FieldKind::Density => {
                let mut out = vec![0.0; size.iter().map(|&s| s as usize).product()];
                field.values(lo, size)?.each(|i, number| out[i] = number.to_f64());
                out
            }
            _ => field.read(0, lo.map(i64::from), size)?.into_iter().map(f64::from).collect(),
        };
        Ok(Block { size, values })
    }

    /// Density at a box of samples of a level.
    fn density(&self, level: u8, lo: [u32; 3], size: [u32; 3]) -> Result<Vec<f64>, SourceError> {
        let axes = self.axes(level, lo, size, Between::Splines);
        Ok(quasi_interpolate(&self.block(FieldKind::Density, &axes)?, &axes))
    }

    /// Texels of a box of samples of a level, appended to `out`, x fastest; density by this map.
    fn texels(
        &self,
        kind: FieldKind,
        map: &DensityMap,
        (level, lo, size): (u8, [u32; 3], [u32; 3]),
        out: &mut Vec<u8>,
    ) -> Result<(), SourceError> {
        check_box(lo, size, level_dims(self.of.dims(), level))?;
        match kind {
            FieldKind::Density => {
                let values = self.wrap(self.density(level, lo, size)?);
                map.encode_voxels(&values, (1.0, 0.0), out);
            }
            FieldKind::Selection => {
                let axes = self.axes(level, lo, size, Between::Splines);
                let values = quasi_interpolate(&self.block(kind, &axes)?, &axes);
                out.extend(values.into_iter().map(|v| (v + 0.5) as u8));
            }
            FieldKind::Colour => {
                let axes = self.axes(level, lo, size, Between::Linear);
                let texels = self.parent_texels(kind, &axes)?;
                let of_block = axes.each_ref().map(Axis::count);
                let channel = |c: usize| {
                    let values = texels.iter().skip(c).step_by(4).map(|&v| f64::from(v)).collect();
                    interpolate(&Block { size: of_block, values }, &axes)
                };
                let [r, g, b, a] = [0, 1, 2, 3].map(channel);
                let pixels = r.iter().zip(&g).zip(b.iter().zip(&a));
                out.extend(pixels.flat_map(|((r, g), (b, a))| [r, g, b, a].map(|c| (c + 0.5) as u8)));
            }
            FieldKind::Labels => {
                let axes = self.axes(level, lo, size, Between::Splines);
                let block = self.parent_texels(kind, &axes)?;
                for_each(size, |at| {
                    let [x, y, z] = std::array::from_fn(|a| axes[a].nearest(at[a]));
                    let place = x + axes[0].count() as usize * (y + axes[1].count() as usize * z);
                    out.extend_from_slice(&block[place * 2..place * 2 + 2]);
                });
            }
        }
        Ok(())
    }

    fn parent_texels(&self, kind: FieldKind, axes: &[Axis; 3]) -> Result<Vec<u8>, SourceError> {
        let [lo, size] = [axes.each_ref().map(Axis::first), axes.each_ref().map(Axis::count)];
        self.parent.field(kind).read(0, lo.map(i64::from), size)
    }

    /// What is known of a brick without its samples: bounds by the parent's voxels that each is a mean of.
    fn about(&self, kind: FieldKind, map: &DensityMap, key: BrickKey) -> Result<(BrickSummary, Cells), SourceError> {
        let dims = level_dims(self.of.dims(), key.level);
        let origin = key.index.origin();
        let last = |a: usize, i: u32| (origin[a] + i).min(dims[a] - 1);
        // A brick and what lies around it.
        let lo: [u32; 3] = origin.map(|o| o.saturating_sub(1));
        let size: [u32; 3] = std::array::from_fn(|a| last(a, BRICK) - lo[a] + 1);
        let axes = self.axes(key.level, lo, size, Between::Splines);
        let format = kind.format(self.parent.density.format());
        let block: Vec<f32> = match kind {
            FieldKind::Density => self.block(kind, &axes)?.values.into_iter().map(|v| v as f32).collect(),
            _ => {
                let texels = self.parent_texels(kind, &axes)?;
                if let Some(shared) = shared_texel(&texels, format.bytes()) {
                    let value = texel_value(format, map, shared);
                    let about = BrickSummary { uniform: Some(shared), min: value, max: value };
                    return Ok((about, Cells::Uniform([value; 2])));
                }
                let padded = |t: &[u8]| std::array::from_fn(|i| t.get(i).copied().unwrap_or(0));
                texels.chunks_exact(format.bytes()).map(|t| texel_value(format, map, padded(t))).collect()
            }
        };
        if kind == FieldKind::Density && block.iter().all(|v| *v == block[0]) {
            let shared = map.encode(f64::from(block[0]));
            let about = BrickSummary { uniform: Some(shared), min: block[0], max: block[0] };
            return Ok((about, Cells::Uniform([block[0]; 2])));
        }
        let ranges: [Vec<[usize; 2]>; 3] = std::array::from_fn(|a| {
            let cells = (0..BRICK / CELL).map(|cell| {
                let from = (origin[a] + cell * CELL).saturating_sub(1).min(dims[a] - 1) - lo[a];
                let to = last(a, (cell + 1) * CELL) - lo[a];
                axes[a].reach(from, to)
            });
            cells.collect()
        });
        let cells = bounds(&block, axes.each_ref().map(|a| a.count() as usize), &ranges);
        debug_assert_eq!(cells.len(), CELLS_PER_BRICK);
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let [min, max] = cells.iter().fold(none, |[lo, hi], c| [lo.min(c[0]), hi.max(c[1])]);
        Ok((BrickSummary { uniform: None, min, max }, Cells::Dense(cells.into())))
    }

    fn wrap(&self, values: Vec<f64>) -> Voxels {
        match self.voxel_type {
            VoxelType::F64 => Voxels::F64(values),
            _ => Voxels::F32(values.into_iter().map(|v| v as f32).collect()),
        }
    }
}

type KnownBricks = HashMap<BrickKey, (BrickSummary, Cells)>;

/// A level, the first sample, how many along each axis.
type TexelBox = (u8, [u32; 3], [u32; 3]);

type RecentTexels = (DensityMap, LruCache<TexelBox, Arc<[u8]>>);

/// Boxes of texels that are held, none larger than a slot: a click of 64 samples needs a hundred.
const MOST_RECENT: NonZeroUsize = NonZeroUsize::MIN.saturating_add(127);

/// One kind of field of a box.
#[derive(Debug)]
struct FieldOfBox {
    of: Arc<RefinedBox>,
    kind: FieldKind,
    /// Of bricks that were asked for, and by which map: pictures ask again and again.
    known: RwLock<(DensityMap, KnownBricks)>,
    /// Texels of bricks that were computed lately, by this map: a stroke's end asks again for what its beginning had to have.
    recent: Mutex<RecentTexels>,
}

impl FieldOfBox {
    fn new(of: Arc<RefinedBox>, kind: FieldKind) -> Self {
        let (known, recent) = (KnownBricks::new(), LruCache::new(MOST_RECENT));
        let none_yet = DensityMap::FLOAT;
        Self { of, kind, known: RwLock::new((none_yet, known)), recent: Mutex::new((none_yet, recent)) }
    }

    /// What is held of recent texels.
    fn recent(&self, map: &DensityMap) -> MutexGuard<'_, RecentTexels> {
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if recent.0 != *map {
            recent.0 = *map;
            recent.1.clear();
        }
        recent
    }
}

impl Computed for FieldOfBox {
    fn texels(&self, map: &DensityMap, of: TexelBox, out: &mut Vec<u8>) -> Result<(), SourceError> {
        if of.2.iter().any(|&size| size > SLOT) {
            return self.of.texels(self.kind, map, of, out);
        }
        let held = self.recent(map).1.get(&of).cloned();
        if let Some(texels) = held {
            out.extend_from_slice(&texels);
            return Ok(());
        }
        // Others go on meanwhile; who computes the same twice finds the same.
        let from = out.len();
        self.of.texels(self.kind, map, of, out)?;
        self.recent(map).1.put(of, out[from..].into());
        Ok(())
    }

    fn about(&self, map: &DensityMap, key: BrickKey) -> Result<(BrickSummary, Cells), SourceError> {
        let held = self.known.read().ok().filter(|known| known.0 == *map);
        if let Some(known) = held.and_then(|known| known.1.get(&key).cloned()) {
            return Ok(known);
        }
        let about = self.of.about(self.kind, map, key)?;
        if let Ok(mut known) = self.known.write() {
            if known.0 != *map {
                *known = (*map, HashMap::new());
            }
            known.1.insert(key, about.clone());
        }
        Ok(about)
    }

    fn sub_box(&self) -> SubBox {
        self.of.of
    }
}

impl Volume {
    /// A box of a parent as it is now, at its own resolution: nothing is computed or stored before it is looked at or edited.
    /// Statistics and histogram are the parent's, within which its samples lie (see [`Field::measured`] for its own); its density has the
    /// parent's codes.
    pub fn refined(parent: &Arc<Self>, of: SubBox) -> Self {
        let refined = Arc::new(RefinedBox::new(parent.clone(), of));
        let field = |kind| {
            let computed = FieldOfBox::new(refined.clone(), kind);
            let source: Option<Arc<dyn BrickSource>> = match kind {
                FieldKind::Density => Some(refined.clone()),
                _ => None,
            };
            match refined.is_blank(kind) {
                true => Field::blank(kind, refined.grid()),
                false => Field::computed(kind, Arc::new(computed), source, (refined.grid(), *parent.density.map())),
            }
        };
        Self {
            density: field(FieldKind::Density),
            colour: field(FieldKind::Colour),
            selection: field(FieldKind::Selection),
            labels: field(FieldKind::Labels),
            source: refined.clone(),
            statistics: parent.statistics,
            histogram: parent.histogram.clone(),
            painted: parent.painted,
        }
    }
}

impl BrickSource for RefinedBox {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    fn scaling(&self) -> (f64, f64) {
        (1.0, 0.0)
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        check_box(lo, size, self.grid.dims)?;
        Ok(self.wrap(self.density(0, lo, size)?))
    }
}

fn for_each(size: [u32; 3], mut visit: impl FnMut([usize; 3])) {
    let [nx, ny, nz] = size.map(|s| s as usize);
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                visit([x, y, z]);
            }
        }
    }
}

/// Least and greatest number of the block over each cell's reach, by separate axes; min > max where there is no number.
fn bounds(block: &[f32], size: [usize; 3], ranges: &[Vec<[usize; 2]>; 3]) -> Vec<[f32; 2]> {
    let none = [f32::INFINITY, f32::NEG_INFINITY];
    // A comparison with what is no number says no.
    let join = |[lo, hi]: [f32; 2], [a, b]: [f32; 2]| [if a < lo { a } else { lo }, if b > hi { b } else { hi }];
    let mut now: Vec<[f32; 2]> = block.iter().map(|&v| if v.is_nan() { none } else { [v; 2] }).collect();
    let mut stride = 1;
    let mut rest = size;
    for (axis, cells) in ranges.iter().enumerate() {
        let outer = rest[axis + 1..].iter().product::<usize>();
        let mut next = Vec::with_capacity(stride * cells.len() * outer);
        for o in 0..outer {
            for &[from, to] in cells {
                for i in 0..stride {
                    let reached = (from..=to).map(|at| now[i + stride * (at + rest[axis] * o)]);
                    next.push(reached.fold(none, join));
                }
            }
        }
        rest[axis] = cells.len();
        stride *= cells.len();
        now = next;
    }
    now
}
