//! Connected components over several lattices, each but the first a box of another at a finer spacing: a volume with its sub-volumes.
//!
//! Each lattice is taken apart for itself by [`Components`]; what touches across a box's faces is joined then. Two voxels touch where
//! their cells, each ended at its own box, share a part of a face (by 18 neighbours an edge there, by 26 a corner). Neighbours of one
//! lattice that a box parts are taken as they are, one by one. Who tells the place on either side of a face is the innermost lattice that
//! has it. Places are whole numbers, so that nothing rounds.

use crate::segment::components::{ComponentId, Components};
use crate::segment::mask::BrickMask;
use crate::segment::runs::{Connectivity, Union};
use crate::volume::{BRICK, BrickIndex, Standing, SubBox};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// A lattice of voxels.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// Which of them it tells.
    pub standing: &'a Standing,
    /// The number of the lattice that it is a box of, and the box, if it is one.
    pub within: Option<(usize, SubBox)>,
}

/// The connected components of sets of voxels of several lattices.
#[derive(Debug)]
pub struct Joined {
    of: Vec<Apart>,
    /// The component of each of those of all lattices.
    number: Vec<u32>,
    sizes: Vec<u64>,
}

/// One lattice for itself.
#[derive(Debug)]
struct Apart {
    components: Components,
    /// Voxels that are no part of them, each a component of its own, numbered after them.
    single: BTreeMap<[u32; 3], u32>,
    /// The number of its first component among all lattices'.
    first: u32,
}

impl Apart {
    fn new<E: Send>(
        standing: &Standing,
        connectivity: Connectivity,
        mask: impl Fn(BrickIndex) -> Result<BrickMask, E> + Sync,
    ) -> Result<Self, E> {
        let parted = standing.parted(connectivity.most());
        let mut by_brick: BTreeMap<BrickIndex, BTreeSet<[u32; 3]>> = BTreeMap::new();
        for voxel in parted {
            by_brick.entry(BrickIndex::of_voxel(voxel)).or_default().insert(voxel);
        }
        let found = Mutex::new(BTreeSet::new());
        let dims = standing.dims();
        let components = Components::new(dims, connectivity, |index| {
            let mask = mask(index)?;
            let Some(parted) = by_brick.get(&index) else { return Ok(mask) };
            let valid = std::array::from_fn(|a| BRICK.min(dims[a] - index.origin()[a]));
            let own = parted.iter().filter(|voxel| mask.contains(voxel.map(|v| v % BRICK)));
            found.lock().unwrap_or_else(PoisonError::into_inner).extend(own.copied());
            Ok(mask.without(&of_voxels(parted, index, valid), valid))
        })?;
        let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        let first = components.len() as u32;
        Ok(Self { components, single: found.into_iter().zip(first..).collect(), first: 0 })
    }

    fn len(&self) -> u32 {
        (self.components.len() + self.single.len()) as u32
    }

    /// The number of a voxel's component among all lattices'.
    fn at(&self, voxel: [u32; 3]) -> Option<u32> {
        let own = self.components.at(voxel).map(|id| id.0);
        Some(self.first + own.or_else(|| self.single.get(&voxel).copied())?)
    }

    fn sizes(&self) -> impl Iterator<Item = u64> {
        self.components.sizes().iter().copied().chain(self.single.iter().map(|_| 1))
    }
}

fn of_voxels(voxels: &BTreeSet<[u32; 3]>, index: BrickIndex, valid: [u32; 3]) -> BrickMask {
    let origin = index.origin();
    BrickMask::new(valid, |at| voxels.contains(&std::array::from_fn(|a| origin[a] + at[a])))
}

impl Joined {
    /// Of lattices, the first a whole volume's, each later than what it is a box of. `mask` tells a brick of one at a time; of voxels
    /// that a box inside stands for it has none.
    ///
    /// # Errors
    /// Whatever `mask` fails with.
    pub fn new<E: Send>(
        lattices: &[Lattice<'_>],
        connectivity: Connectivity,
        mask: impl Fn(usize, BrickIndex) -> Result<BrickMask, E> + Sync,
    ) -> Result<Self, E> {
        let mut of = Vec::new();
        let mut total = 0;
        for (l, lattice) in lattices.iter().enumerate() {
            let apart = Apart::new(lattice.standing, connectivity, |index| mask(l, index))?;
            let first = total;
            total += apart.len();
            of.push(Apart { first, ..apart });
        }
        let mut union = Union::new(total);
        if of.len() > 1 {
            let places = Places::new(lattices);
            let faces: Vec<Face> = (1..lattices.len()).flat_map(Face::of_box).collect();
            let joins = |face: &Face| places.joins(*face, connectivity.most(), &|l, voxel| of[l].at(voxel));
            let pairs: Vec<Vec<[u32; 2]>> = faces.par_iter().map(joins).collect();
            pairs.into_iter().flatten().for_each(|[a, b]| union.join(a, b));
        }
        for (apart, lattice) in of.iter().zip(lattices) {
            let most = connectivity.most();
            for (&voxel, own) in &apart.single {
                for &by in connectivity.steps() {
                    for by in [by, by.map(|d| -d)] {
                        let other = lattice.standing.beside(voxel, by).and_then(|other| apart.at(other));
                        if let Some(other) = other
                            && lattice.standing.touch(voxel, by, most)
                        {
                            union.join(apart.first + own, other);
                        }
                    }
                }
            }
        }
        let (number, count) = union.numbers();
        let mut sizes = vec![0; count as usize];
        for (number, size) in number.iter().zip(of.iter().flat_map(Apart::sizes)) {
            sizes[*number as usize] += size;
        }
        Ok(Self { of, number, sizes })
    }

    /// How many components there are.
    pub fn len(&self) -> usize {
        self.sizes.len()
    }

    /// Whether no voxel is in any.
    pub fn is_empty(&self) -> bool {
        self.sizes.is_empty()
    }

    /// The component of a voxel of a lattice; `None` if it is in none.
    pub fn at(&self, lattice: usize, voxel: [u32; 3]) -> Option<ComponentId> {
        self.of[lattice].at(voxel).map(|number| ComponentId(self.number[number as usize]))
    }

    /// Voxels of a component, of whatever size.
    pub fn size(&self, id: ComponentId) -> u64 {
        self.sizes.get(id.0 as usize).copied().unwrap_or(0)
    }

    /// What of a lattice is of the components that `is_wanted`, by the brick, in order.
    pub fn voxels(
        &self,
        lattice: usize,
        is_wanted: impl Fn(ComponentId) -> bool + Sync,
    ) -> Vec<(BrickIndex, BrickMask)> {
        let apart = &self.of[lattice];
        let named = |own: u32| ComponentId(self.number[(apart.first + own) as usize]);
        let voxels = apart.components.voxels(|own| is_wanted(named(own.0)));
        let single = apart.single.iter().filter(|(_, own)| is_wanted(named(**own)));
        let mut by_brick: BTreeMap<BrickIndex, BTreeSet<[u32; 3]>> = BTreeMap::new();
        for (voxel, _) in single {
            by_brick.entry(BrickIndex::of_voxel(*voxel)).or_default().insert(*voxel);
        }
        if by_brick.is_empty() {
            return voxels;
        }
        let mut all: BTreeMap<[u32; 3], (BrickIndex, BrickMask)> =
            voxels.into_iter().map(|(index, mask)| (reversed(index), (index, mask))).collect();
        for (index, voxels) in by_brick {
            let valid = apart.components.valid(index);
            let (_, mask) = all.entry(reversed(index)).or_insert((index, BrickMask::None));
            *mask = std::mem::replace(mask, BrickMask::None).or(of_voxels(&voxels, index, valid), valid);
        }
        all.into_values().collect()
    }

    /// Of each component what its voxels of each lattice amount to, at so much for one of each lattice.
    pub fn amounts(&self, each: &[f64]) -> Vec<f64> {
        let mut amounts = vec![0.0; self.sizes.len()];
        for (apart, each) in self.of.iter().zip(each) {
            for (own, size) in (apart.first..).zip(apart.sizes()) {
                amounts[self.number[own as usize] as usize] += size as f64 * each;
            }
        }
        amounts
    }
}

/// By which bricks come in order, x fastest.
fn reversed(index: BrickIndex) -> [u32; 3] {
    let [x, y, z] = index.0;
    [z, y, x]
}

/// A face of a lattice's box.
#[derive(Clone, Copy, Debug)]
struct Face {
    lattice: usize,
    axis: usize,
    /// Whether the box lies before it.
    is_last: bool,
}

impl Face {
    fn of_box(lattice: usize) -> impl Iterator<Item = Self> {
        (0..6).map(move |n| Self { lattice, axis: n / 2, is_last: n % 2 == 1 })
    }
}

/// Where lattices lie along an axis, in whole numbers of a length that divides half of every spacing.
#[derive(Clone, Copy, Debug)]
struct Along {
    origin: i128,
    step: i128,
    count: i128,
}

impl Along {
    fn end(self) -> i128 {
        self.origin + self.step * (self.count - 1)
    }

    /// The number of the voxel nearest to a place, given in halves, that is no border of cells.
    fn nearest(self, twice: i128) -> i128 {
        let from_cell = twice - 2 * self.origin + self.step;
        from_cell.div_euclid(2 * self.step).clamp(0, self.count - 1)
    }
}

struct Places(Vec<[Along; 3]>);

/// The components of the layer of voxels that lies in a face, as far as the face reaches.
struct Layer {
    /// Of every piece of the face along its two axes the voxel of it, counted in the layer; `None` beyond the lattice.
    own: [Vec<Option<u32>>; 2],
    row: usize,
    /// One more than the number of a component, 0 for none.
    components: Vec<u32>,
}

impl Layer {
    fn at(&self, i: usize, j: usize) -> Option<u32> {
        Some(self.components[self.own[0][i]? as usize + self.row * self.own[1][j]? as usize])
    }
}

impl Places {
    fn new(lattices: &[Lattice<'_>]) -> Self {
        let scales = |l: usize, a: usize| {
            let mut within = lattices[l].within;
            let mut scale = 1_i128;
            while let Some((outer, of)) = within {
                scale *= i128::from(of.scale[a]);
                within = lattices[outer].within;
            }
            scale
        };
        let unit = |a: usize| 2 * (0..lattices.len()).map(|l| scales(l, a)).fold(1, least_common_multiple);
        let units = [0, 1, 2].map(unit);
        let mut all: Vec<[Along; 3]> = Vec::new();
        for (l, lattice) in lattices.iter().enumerate() {
            let along = |a: usize| {
                let count = i128::from(lattice.standing.dims()[a]);
                let origin = lattice.within.map_or(0, |(outer, of)| {
                    let outer = all[outer][a];
                    outer.origin + outer.step * i128::from(of.lo[a])
                });
                Along { origin, step: units[a] / scales(l, a), count }
            };
            let axes = [0, 1, 2].map(along);
            all.push(axes);
        }
        Self(all)
    }

    /// Which components touch across a face.
    fn joins(
        &self,
        face: Face,
        most: u32,
        component: &(dyn Fn(usize, [u32; 3]) -> Option<u32> + Sync),
    ) -> Vec<[u32; 2]> {
        let Face { lattice, axis, is_last } = face;
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let own = self.0[lattice];
        let plane = if is_last { own[axis].end() } else { own[axis].origin };
        let rectangle = across.map(|a| [own[a].origin, own[a].end()]);
        let sides = [true, false].map(|after| self.beside(axis, across, plane, after, rectangle));
        if sides.iter().any(Vec::is_empty) {
            return Vec::new();
        }
        // Where cells and boxes end that meet the face.
        let pieces: [Vec<i128>; 2] = std::array::from_fn(|n| {
            let [lo, hi] = rectangle[n];
            let mut ends = vec![lo, hi];
            for along in sides.iter().flatten().map(|l| self.0[*l][across[n]]) {
                ends.extend([along.origin, along.end()].into_iter().filter(|end| (lo..=hi).contains(end)));
                let (first, last) = (along.nearest(2 * lo), along.nearest(2 * hi));
                let borders = (first..last).map(|v| along.origin + along.step * v + along.step / 2);
                ends.extend(borders.filter(|end| (lo..=hi).contains(end)));
            }
            ends.sort_unstable();
            ends.dedup();
            ends.windows(2).map(|pair| pair[0] + pair[1]).collect()
        });
        let layers = sides.map(|side| {
            let layer = |l: &usize| self.layer(*l, axis, across, plane, rectangle, &pieces, component);
            side.iter().map(layer).collect::<Vec<_>>()
        });
        // The innermost is the last.
        let tells =
            |side: &[Layer], i: usize, j: usize| side.iter().rev().find_map(|layer| layer.at(i, j)).unwrap_or(0);
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        let [columns, rows] = [pieces[0].len(), pieces[1].len()];
        for j in 0..rows {
            for i in 0..columns {
                let a = tells(&layers[0], i, j);
                if a == 0 {
                    continue;
                }
                let near = |at: usize, count: usize| match most {
                    1 => at..=at,
                    _ => at.saturating_sub(1)..=(at + 1).min(count - 1),
                };
                for to_j in near(j, rows) {
                    for to_i in near(i, columns) {
                        let b = match 1 + u32::from(to_i != i) + u32::from(to_j != j) <= most {
                            true => tells(&layers[1], to_i, to_j),
                            false => 0,
                        };
                        if b != 0 && pairs.last() != Some(&[a - 1, b - 1]) {
                            pairs.push([a - 1, b - 1]);
                        }
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// The lattices that may tell what lies on one side of a face, outermost first.
    fn beside(
        &self,
        axis: usize,
        across: [usize; 2],
        plane: i128,
        after: bool,
        rectangle: [[i128; 2]; 2],
    ) -> Vec<usize> {
        let reaches = |l: &usize| {
            let (of, along) = (self.0[*l], self.0[*l][axis]);
            let there = match after {
                true => along.origin <= plane && plane < along.end(),
                false => along.origin < plane && plane <= along.end(),
            };
            // One that has the place but no layer there has another inside that tells it.
            let layered = (plane - along.origin) % along.step == 0;
            let meets = |n: usize| of[across[n]].origin < rectangle[n][1] && rectangle[n][0] < of[across[n]].end();
            there && layered && meets(0) && meets(1)
        };
        let mut all: Vec<usize> = (0..self.0.len()).filter(reaches).collect();
        let covers = |l: &usize| {
            let has = |n: usize| {
                let along = self.0[*l][across[n]];
                along.origin <= rectangle[n][0] && rectangle[n][1] <= along.end()
            };
            has(0) && has(1)
        };
        let outermost = all.iter().rposition(covers).unwrap_or(0);
        all.drain(..outermost);
        all
    }

    #[expect(clippy::too_many_arguments, reason = "a face has that many sides to it")]
    fn layer(
        &self,
        lattice: usize,
        axis: usize,
        across: [usize; 2],
        plane: i128,
        rectangle: [[i128; 2]; 2],
        pieces: &[Vec<i128>; 2],
        component: &(dyn Fn(usize, [u32; 3]) -> Option<u32> + Sync),
    ) -> Layer {
        let of = self.0[lattice];
        let at = (plane - of[axis].origin) / of[axis].step;
        let first: [i128; 2] = std::array::from_fn(|n| of[across[n]].nearest(2 * rectangle[n][0] - 1));
        let last: [i128; 2] = std::array::from_fn(|n| of[across[n]].nearest(2 * rectangle[n][1] + 1));
        let own = std::array::from_fn(|n| {
            let along = of[across[n]];
            let piece = |twice: &i128| {
                let inside = 2 * along.origin < *twice && *twice < 2 * along.end();
                inside.then(|| (along.nearest(*twice) - first[n]) as u32)
            };
            pieces[n].iter().map(piece).collect()
        });
        let mut components = Vec::new();
        for j in first[1]..=last[1] {
            for i in first[0]..=last[0] {
                let mut voxel = [0_u32; 3];
                (voxel[axis], voxel[across[0]], voxel[across[1]]) = (at as u32, i as u32, j as u32);
                components.push(component(lattice, voxel).map_or(0, |id| id + 1));
            }
        }
        Layer { own, row: (last[0] - first[0] + 1) as usize, components }
    }
}

fn least_common_multiple(a: i128, b: i128) -> i128 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
