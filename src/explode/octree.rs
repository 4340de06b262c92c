//! The two min-max octrees, of density and selection, and the explosion points that a walk through both finds.
//!
//! Of a volume with sub-volumes there are two for each of them, over the voxels that it tells. Exploded Views (2006), 3.2: a node wholly visible under the transfer function and wholly selected gives one point, else the
//! leaves of 8³ voxels that hold both do. A point weighs the selected volume of its node. Kept by the brick, only where
//! something is selected, so that a stroke refreshes what it touched; the levels above are folded anew for every walk, which
//! costs microseconds. Owns its minima and maxima; knows fields, not how they are painted.

use crate::math::DVec3;
use crate::volume::{
    Asked, BRICK, Brick, BrickIndex, BrickKey, CELL, Cells, Field, Grid, SelectedCell, SourceError, Standing,
    TransferFunction, selected_cells,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Voxels along an edge of a leaf.
pub const LEAF: u32 = 8;
/// Leaves along an edge of a brick.
const LEAVES: u32 = BRICK / LEAF;
/// Points at most.
pub const MAX_POINTS: usize = 512;
/// Jitter either way, as a share of the node's edge: enough to break the lattice, too little to leave the node.
const JITTER: f64 = 0.125;

/// A point of the selection from which parts are pushed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplosionPoint {
    /// World mm.
    pub position: DVec3,
    /// Selected volume that it stands for, mm³.
    pub weight: f64,
}

/// A node of both octrees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    density: [f32; 2],
    /// Smallest and largest code of the selection.
    selection: [u8; 2],
    /// Sum of the selection's codes, each times the share of a voxel that it stands for.
    sum: f64,
}

impl Node {
    const NOTHING: Self = Self { density: [f32::INFINITY, f32::NEG_INFINITY], selection: [u8::MAX, 0], sum: 0.0 };

    fn and(self, other: Self) -> Self {
        Self {
            density: [self.density[0].min(other.density[0]), self.density[1].max(other.density[1])],
            selection: [self.selection[0].min(other.selection[0]), self.selection[1].max(other.selection[1])],
            sum: self.sum + other.sum,
        }
    }
}

/// Place of a node within its level, in nodes; level 0 has leaves.
type At = [u32; 3];

/// The two octrees over the cells of density and selection, down to leaves of a cell.
#[derive(Clone, Debug)]
pub struct Octrees {
    grid: Grid,
    standing: Standing,
    /// Leaves of bricks with a selection, x fastest.
    bricks: BTreeMap<BrickIndex, Vec<Node>>,
}

impl Octrees {
    /// Reads all bricks with a selection.
    ///
    /// # Errors
    /// If a source fails.
    pub fn new(grid: &Grid, density: &Field, selection: &Field) -> Result<Self, SourceError> {
        Self::within(grid, Standing::of_whole(grid.dims, Vec::new()), density, selection)
    }

    /// The same of the voxels that a volume tells among others that lie in it, or that it lies in.
    ///
    /// # Errors
    /// If a source fails.
    pub fn within(grid: &Grid, standing: Standing, density: &Field, selection: &Field) -> Result<Self, SourceError> {
        let mut octrees = Self { grid: *grid, standing, bricks: BTreeMap::new() };
        octrees.update(density, selection, selection.brick_indices(0))?;
        Ok(octrees)
    }

    /// Reads these bricks again: those whose density or selection changed, apron neighbours included (all of level 0 in a
    /// `Refresh`).
    ///
    /// # Errors
    /// If a source fails; nothing has then changed.
    pub fn update(
        &mut self,
        density: &Field,
        selection: &Field,
        bricks: impl IntoIterator<Item = BrickIndex>,
    ) -> Result<(), SourceError> {
        let bricks: Vec<BrickIndex> = bricks.into_iter().collect();
        let read = |&index: &BrickIndex| {
            let nothing = selection.summary(BrickKey { level: 0, index }).max <= 0.0;
            let brick = if nothing { None } else { Some(selection.brick(BrickKey { level: 0, index })?) };
            let cells = brick.map(|b| self.selected(&b, index, selection.valid(0, index)));
            Ok((index, cells.and_then(|c| leaves(density, index, &c))))
        };
        let read: Vec<_> = bricks.par_iter().map(read).collect::<Result<_, SourceError>>()?;
        for (index, leaves) in read {
            self.set(index, leaves);
        }
        Ok(())
    }

    /// Takes a brick of a selection that a running stroke has not yet handed over to its field, by its 8³ cells.
    pub fn paint(&mut self, density: &Field, index: BrickIndex, selected: &[SelectedCell]) {
        let mut cells: Vec<Selected> = selected.iter().map(Selected::of_cell).collect();
        if self.standing.brick(index) != Asked::All {
            // Until the stroke ends, what a cell has that others tell counts where the cell tells anything.
            let (origin, valid) = (index.origin(), density.valid(0, index));
            let mut tells = vec![false; cells.len()];
            voxels(valid).for_each(|(at, cell)| {
                tells[cell] |= self.standing.is_asked(std::array::from_fn(|a| origin[a] + at[a]));
            });
            cells.iter_mut().zip(tells).filter(|(_, tells)| !tells).for_each(|(cell, _)| *cell = Selected::UNTOLD);
        }
        self.set(index, leaves(density, index, &cells));
    }

    /// The cells of a brick of the selection, as far as they are told here.
    fn selected(&self, brick: &Brick, index: BrickIndex, valid: [u32; 3]) -> Vec<Selected> {
        let plain = selected_cells(brick, valid);
        let mut cells: Vec<Selected> = plain.iter().map(Selected::of_cell).collect();
        let origin = index.origin();
        if !self.standing.is_odd_in(index) {
            return cells;
        }
        cells.iter_mut().for_each(|cell| cell.sum = 0.0);
        for (at, cell) in voxels(valid) {
            let share = self.standing.share(std::array::from_fn(|a| origin[a] + at[a]));
            cells[cell].sum += share * f64::from(brick.texel(at, 1)[0]);
            if share == 0.0 {
                // What holds a voxel that others tell is not wholly selected.
                cells[cell].ends[0] = 0;
            }
        }
        cells.iter_mut().filter(|cell| cell.sum == 0.0).for_each(|cell| cell.ends[1] = 0);
        cells
    }

    /// The same for a brick of the density: minima and maxima of its cells.
    pub fn paint_density(&mut self, density: &Field, index: BrickIndex, cells: &[[f32; 2]]) {
        if let Some(leaves) = self.bricks.get_mut(&index) {
            set_density(leaves, density.valid(0, index), &|cell| cells[cell]);
        }
    }

    fn set(&mut self, index: BrickIndex, leaves: Option<Vec<Node>>) {
        match leaves {
            Some(leaves) => self.bricks.insert(index, leaves),
            None => self.bricks.remove(&index),
        };
    }

    /// The explosion points, at most [`MAX_POINTS`], in a fixed order. `seed` chooses their jitter, which depends on nothing
    /// else but a node's place, so that painting here does not shake points there.
    pub fn points(&self, transfer: &TransferFunction, seed: u64) -> Vec<ExplosionPoint> {
        points_of(&[(self, transfer)], seed)
    }

    /// All levels, leaves first, until one node is left.
    fn fold(&self) -> Vec<BTreeMap<At, Node>> {
        let mut levels = vec![BTreeMap::new()];
        for (index, leaves) in &self.bricks {
            for (i, leaf) in (0..).zip(leaves) {
                let within = [i % LEAVES, i / LEAVES % LEAVES, i / (LEAVES * LEAVES)];
                if leaf.sum > 0.0 {
                    levels[0].insert(std::array::from_fn(|a| index.0[a] * LEAVES + within[a]), *leaf);
                }
            }
        }
        while levels[levels.len() - 1].len() > 1 {
            let below = &levels[levels.len() - 1];
            let mut above: BTreeMap<At, (Node, u32)> = BTreeMap::new();
            for (at, node) in below {
                let (sum, count) = above.entry(at.map(|a| a / 2)).or_insert((Node::NOTHING, 0));
                *sum = sum.and(*node);
                *count += 1;
            }
            let level = levels.len();
            // Children without any selection are not kept; a node that misses one is not wholly selected.
            let complete = |at: At, (node, count): (Node, u32)| {
                let whole = count == self.children(level, at);
                (at, if whole { node } else { Node { selection: [0, node.selection[1]], ..node } })
            };
            levels.push(above.into_iter().map(|(at, node)| complete(at, node)).collect());
        }
        levels
    }

    /// How many of a node's eight children lie in the volume.
    fn children(&self, level: usize, at: At) -> u32 {
        let edge = u64::from(LEAF) << (level - 1);
        let along =
            |a: usize| (0..2).filter(|c| (u64::from(at[a]) * 2 + c) * edge < u64::from(self.grid.dims[a])).count();
        (along(0) * along(1) * along(2)) as u32
    }

    /// A node's centre, clipped to the volume, with jitter; index space.
    fn jittered(&self, level: usize, at: At, seed: u64) -> DVec3 {
        let edge = f64::from(LEAF) * f64::from(1_u32 << level);
        let lo = DVec3::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2])) * edge;
        let hi = (lo + edge).min(self.grid.dims_f64());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let place = at.iter().fold(level as u64, |key, &a| key << 20 | u64::from(a & 0xf_ffff));
        rng.set_stream(place);
        let mut draw = || rng.random_range(-JITTER..JITTER);
        (lo + hi) * 0.5 - 0.5 + DVec3::new(draw(), draw(), draw()) * (hi - lo)
    }
}

/// The walk: down until a node is homogeneous, empty of one of the two, or a leaf.
fn walk(
    levels: &[BTreeMap<At, Node>],
    level: usize,
    at: At,
    transfer: &TransferFunction,
    found: &mut Vec<(usize, At, f64)>,
) {
    let Some(node) = levels[level].get(&at) else { return };
    let [lo, hi] = node.density.map(f64::from);
    if node.selection[1] == 0 || transfer.max_opacity_in(lo, hi) <= 0.0 {
        return;
    }
    let homogeneous = node.selection[0] > 0 && least_opacity(transfer, lo, hi) > 0.0;
    if homogeneous || level == 0 {
        found.push((level, at, node.sum));
        return;
    }
    for child in 0..8 {
        walk(
            levels,
            level - 1,
            [at[0] * 2 + (child & 1), at[1] * 2 + (child >> 1 & 1), at[2] * 2 + (child >> 2)],
            transfer,
            found,
        );
    }
}

/// The smallest opacity anywhere in `[lo, hi]`.
fn least_opacity(transfer: &TransferFunction, lo: f64, hi: f64) -> f32 {
    let inner = transfer.opacity.iter().filter(|(v, _)| (lo..=hi).contains(v)).map(|&(_, a)| a);
    inner.fold(transfer.opacity_at(lo).min(transfer.opacity_at(hi)), f32::min)
}

/// The explosion points of several octrees together, each shown by its own transfer function; see [`Octrees::points`].
pub fn points_of(octrees: &[(&Octrees, &TransferFunction)], seed: u64) -> Vec<ExplosionPoint> {
    let mut heaps = Vec::new();
    for (tree, (octrees, transfer)) in octrees.iter().enumerate() {
        let levels = octrees.fold();
        let mut found = Vec::new();
        if let Some(top) = levels.len().checked_sub(1) {
            for &at in levels[top].keys() {
                walk(&levels, top, at, transfer, &mut found);
            }
        }
        heaps.extend(found.into_iter().map(|(level, at, sum)| {
            let position = octrees.jittered(level, at, seed);
            Heap { tree, level, at, weight: sum / 255.0, moment: position * (sum / 255.0) }
        }));
    }
    let matrix = |tree: usize| octrees[tree].0.grid.world_from_index;
    let voxels_mm3: Vec<f64> = (0..octrees.len()).map(|tree| matrix(tree).matrix3.determinant().abs()).collect();
    let point = |h: Heap| ExplosionPoint {
        position: matrix(h.tree).transform_point3(h.moment / h.weight),
        weight: h.weight * voxels_mm3[h.tree],
    };
    merge(heaps, &voxels_mm3).into_iter().map(point).collect()
}

/// A point under way: selected voxels of an octree, and their sum of positions in index space.
#[derive(Clone, Copy, Debug)]
struct Heap {
    tree: usize,
    level: usize,
    at: At,
    weight: f64,
    moment: DVec3,
}

/// Merges points into their parents, lightest families of the finest level first, until few enough are left.
fn merge(mut points: Vec<Heap>, voxels_mm3: &[f64]) -> Vec<Heap> {
    let mut level = 0;
    while points.len() > MAX_POINTS && level < 32 {
        let (fine, mut kept): (Vec<Heap>, Vec<Heap>) = points.into_iter().partition(|p| p.level == level);
        let mut families: BTreeMap<(usize, At), Vec<Heap>> = BTreeMap::new();
        for point in fine {
            families.entry((point.tree, point.at.map(|a| a / 2))).or_default().push(point);
        }
        let mut by_weight: Vec<(f64, (usize, At), Vec<Heap>)> =
            families.into_iter().map(|(at, f)| (f.iter().map(|p| p.weight).sum(), at, f)).collect();
        let size = |family: &(f64, (usize, At), Vec<Heap>)| family.0 * voxels_mm3[family.1.0];
        by_weight.sort_by(|a, b| size(a).total_cmp(&size(b)).then(a.1.cmp(&b.1)));
        let mut count = kept.len() + by_weight.iter().map(|f| f.2.len()).sum::<usize>();
        for (weight, (tree, at), family) in by_weight {
            if count > MAX_POINTS {
                count -= family.len() - 1;
                let moment = family.iter().map(|p| p.moment).sum();
                kept.push(Heap { tree, level: level + 1, at, weight, moment });
            } else {
                kept.extend(family);
            }
        }
        points = kept;
        level += 1;
    }
    points.sort_by_key(|p| (p.tree, p.level, p.at));
    points
}

/// The selection over a cell's own voxels, as far as they are told by its octrees.
#[derive(Clone, Copy, Debug)]
struct Selected {
    /// Least and greatest code.
    ends: [u8; 2],
    /// Sum of codes, each times the share of a voxel that it stands for.
    sum: f64,
}

impl Selected {
    const UNTOLD: Self = Self { ends: [0; 2], sum: 0.0 };

    fn of_cell(cell: &SelectedCell) -> Self {
        Self { ends: [cell.min, cell.max], sum: f64::from(cell.sum) }
    }
}

/// The voxels of a brick in the volume, each with its cell.
fn voxels(valid: [u32; 3]) -> impl Iterator<Item = ([u32; 3], usize)> {
    let [nx, ny, nz] = valid;
    let all = (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    let n = BRICK / CELL;
    all.map(move |at| {
        let [x, y, z] = at.map(|v| v / CELL);
        (at, (x + n * (y + n * z)) as usize)
    })
}

/// The leaves of a brick, `None` if nothing of it is selected. Selection over a leaf's own voxels; density over all taps that
/// a sample inside it can meet.
fn leaves(density: &Field, index: BrickIndex, selected: &[Selected]) -> Option<Vec<Node>> {
    let mut leaves = vec![Node::NOTHING; (LEAVES * LEAVES * LEAVES) as usize];
    let valid = density.valid(0, index);
    for (cell, leaf) in cells_in(valid) {
        let (leaf, cell) = (&mut leaves[leaf], selected[cell]);
        leaf.selection = [leaf.selection[0].min(cell.ends[0]), leaf.selection[1].max(cell.ends[1])];
        leaf.sum += cell.sum;
    }
    if leaves.iter().all(|l| l.sum == 0.0) {
        return None;
    }
    match density.cells(BrickKey { level: 0, index }) {
        Cells::Uniform(range) => set_density(&mut leaves, valid, &|_| range),
        Cells::Dense(cells) => set_density(&mut leaves, valid, &|cell| cells[cell]),
    }
    Some(leaves)
}

fn set_density(leaves: &mut [Node], valid: [u32; 3], range: &dyn Fn(usize) -> [f32; 2]) {
    leaves.iter_mut().for_each(|leaf| leaf.density = Node::NOTHING.density);
    for (cell, leaf) in cells_in(valid) {
        let ([lo, hi], leaf) = (range(cell), &mut leaves[leaf]);
        leaf.density = [leaf.density[0].min(lo), leaf.density[1].max(hi)];
    }
}

/// The cells of a brick that hold voxels of the volume, each with its leaf.
fn cells_in(valid: [u32; 3]) -> impl Iterator<Item = (usize, usize)> {
    let [nx, ny, nz] = valid.map(|v| v.div_ceil(CELL));
    let (n, per) = (BRICK / CELL, LEAF / CELL);
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).map(move |[x, y, z]| {
        let leaf = x / per + LEAVES * (y / per + LEAVES * (z / per));
        ((x + n * (y + n * z)) as usize, leaf as usize)
    })
}

/// [`Octrees::points`] of freshly read octrees.
///
/// # Errors
/// If a source fails.
pub fn explosion_points(
    density: &Field,
    selection: &Field,
    grid: &Grid,
    transfer: &TransferFunction,
    seed: u64,
) -> Result<Vec<ExplosionPoint>, SourceError> {
    Ok(Octrees::new(grid, density, selection)?.points(transfer, seed))
}
