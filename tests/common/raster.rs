//! A volume and boxes of finer samples in it, cut into little cubes that lie in no two cells: who tells what is where, and who touches
//! whom, by looking at every cube.

use burin::volume::SubBox;
use std::collections::{BTreeMap, BTreeSet};

/// A lattice: its voxels, and the box of an earlier one that it is.
#[derive(Clone, Debug)]
pub struct Nest {
    pub dims: [u32; 3],
    pub within: Option<(usize, SubBox)>,
}

impl Nest {
    pub fn whole(dims: [u32; 3]) -> Self {
        Self { dims, within: None }
    }

    pub fn of(outer: usize, lo: [u32; 3], hi: [u32; 3], scale: [u32; 3]) -> Self {
        let dims = std::array::from_fn(|a| (hi[a] - lo[a]) * scale[a] + 1);
        Self { dims, within: Some((outer, SubBox { lo, hi, scale })) }
    }
}

/// A voxel of a lattice.
pub type Node = (usize, [u32; 3]);

/// The cubes, `fine` of them along half a voxel of the whole; those beyond its outermost centres belong to whoever is at the border.
pub struct Raster {
    fine: u32,
    size: [usize; 3],
    nodes: Vec<Node>,
}

impl Raster {
    pub fn new(nests: &[Nest], fine: u32) -> Self {
        let dims = nests[0].dims;
        let size = dims.map(|d| (d * 2 * fine) as usize);
        let mut nodes = Vec::new();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let i = [x, y, z];
                    let place: [f64; 3] = std::array::from_fn(|a| {
                        let middle = (i[a] as f64 + 0.5) / f64::from(2 * fine) - 0.5;
                        // A place within the outermost centres, so near to them that it is in no other cell.
                        let near = 1e-6;
                        middle.clamp(near, f64::from(dims[a] - 1) - near)
                    });
                    nodes.push(teller(nests, place));
                }
            }
        }
        Self { fine, size, nodes }
    }

    /// How much of a voxel of its lattice each voxel stands for, by the cubes.
    pub fn shares(&self, nests: &[Nest]) -> BTreeMap<Node, f64> {
        let mut shares: BTreeMap<Node, f64> = BTreeMap::new();
        for node in &self.nodes {
            *shares.entry(*node).or_default() += 1.0;
        }
        for ((lattice, _), share) in &mut shares {
            let mut cubes = f64::from(2 * self.fine).powi(3);
            let mut nest = &nests[*lattice];
            while let Some((outer, SubBox { scale, .. })) = nest.within {
                cubes /= scale.iter().map(|s| f64::from(*s)).product::<f64>();
                nest = &nests[outer];
            }
            *share /= cubes;
        }
        shares
    }

    /// What of a set of voxels hangs together: cells that share part of a face, for `most` 1, or else an edge or a corner.
    pub fn components(&self, most: usize, is_in: impl Fn(Node) -> bool) -> Vec<BTreeSet<Node>> {
        let mut touching: BTreeMap<Node, BTreeSet<Node>> = BTreeMap::new();
        let at = |i: [usize; 3]| self.nodes[i[0] + self.size[0] * (i[1] + self.size[1] * i[2])];
        let steps: Vec<[i64; 3]> = (0..27_i64).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]).collect();
        let steps: Vec<_> =
            steps.into_iter().filter(|by| (1..=most).contains(&by.iter().filter(|d| **d != 0).count())).collect();
        let [nx, ny, nz] = self.size;
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let own = at([x, y, z]);
                    if !is_in(own) {
                        continue;
                    }
                    let others = touching.entry(own).or_default();
                    for by in &steps {
                        let next: [i64; 3] = std::array::from_fn(|a| [x, y, z][a] as i64 + by[a]);
                        if (0..3).all(|a| (0..self.size[a] as i64).contains(&next[a])) {
                            let other = at(next.map(|v| v as usize));
                            if other != own && is_in(other) {
                                others.insert(other);
                            }
                        }
                    }
                }
            }
        }
        let mut left: BTreeSet<Node> = touching.keys().copied().collect();
        let mut all = Vec::new();
        while let Some(start) = left.pop_first() {
            let mut component = BTreeSet::from([start]);
            let mut open = vec![start];
            while let Some(node) = open.pop() {
                for other in &touching[&node] {
                    if left.remove(other) {
                        component.insert(*other);
                        open.push(*other);
                    }
                }
            }
            all.push(component);
        }
        all
    }
}

/// The voxel of the innermost lattice that has a place, in voxels of the first.
fn teller(nests: &[Nest], place: [f64; 3]) -> Node {
    let mut places = Vec::new();
    let mut told = None;
    for (l, nest) in nests.iter().enumerate() {
        let own: [f64; 3] = match nest.within {
            None => place,
            Some((outer, SubBox { lo, scale, .. })) => {
                let outer: [f64; 3] = places[outer];
                std::array::from_fn(|a| (outer[a] - f64::from(lo[a])) * f64::from(scale[a]))
            }
        };
        places.push(own);
        if (0..3).all(|a| 0.0 < own[a] && own[a] < f64::from(nest.dims[a] - 1)) {
            told = Some((l, own.map(|v| (v + 0.5).floor() as u32)));
        }
    }
    told.unwrap()
}
