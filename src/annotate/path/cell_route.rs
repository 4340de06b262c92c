//! The way between two points of a surface through the cells of a lattice that it passes.
//!
//! Owns the search (A*), which tells whether two points are on one piece of surface and gives a first path that rulers shorten. Knows the
//! field only through its values at lattice points. Places within cells as in dual contouring without normals: the mean of the edges'
//! crossings ("surface nets", Gibson 1998).

use crate::annotate::surface::Surface;
use glam::{DVec3, I64Vec3};
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

/// How much more the way ahead counts than the way behind: the first path is shortened anyway, and is found sooner.
const EAGER: f64 = 1.1;

/// The most cells looked at for a whole path.
pub(crate) const MAX_CELLS: usize = 1 << 19;

/// A cell that waits, by the least length of a way through it.
struct Waiting {
    least_mm: f64,
    so_far_mm: f64,
    cell: I64Vec3,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_cell = || self.cell.to_array().cmp(&other.cell.to_array());
        other.least_mm.total_cmp(&self.least_mm).then_with(by_cell)
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

/// Values at lattice points, each asked for once.
struct Lattice<'a> {
    surface: &'a dyn Surface,
    origin: DVec3,
    step_mm: f64,
    values: HashMap<I64Vec3, Option<f64>>,
}

impl Lattice<'_> {
    fn place(&self, point: I64Vec3) -> DVec3 {
        self.origin + point.as_dvec3() * self.step_mm
    }

    fn value(&mut self, point: I64Vec3) -> Option<f64> {
        let place = self.place(point);
        *self.values.entry(point).or_insert_with(|| self.surface.value(place))
    }

    /// Mean of where the surface crosses the cell's edges, world mm; `None` if it crosses none.
    fn crossing(&mut self, cell: I64Vec3) -> Option<DVec3> {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for axis in 0..3 {
            for side in 0..4 {
                let mut low = [0; 3];
                low[(axis + 1) % 3] = side & 1;
                low[(axis + 2) % 3] = side >> 1;
                let a = cell + I64Vec3::from_array(low);
                let b = a + I64Vec3::AXES[axis];
                let (Some(va), Some(vb)) = (self.value(a), self.value(b)) else { continue };
                if (va > 0.0) != (vb > 0.0) {
                    sum += self.place(a).lerp(self.place(b), va / (va - vb));
                    count += 1.0;
                }
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    /// Whether the surface passes from a cell to the next one along `axis`, `ahead` or behind, through the face between them.
    fn passes(&mut self, cell: I64Vec3, axis: usize, ahead: bool) -> bool {
        let low = cell + if ahead { I64Vec3::AXES[axis] } else { I64Vec3::ZERO };
        let (u, v) = (I64Vec3::AXES[(axis + 1) % 3], I64Vec3::AXES[(axis + 2) % 3]);
        let corners = [low, low + u, low + v, low + u + v].map(|p| self.value(p));
        let dense = |v: &Option<f64>| v.is_some_and(|v| v > 0.0);
        corners.iter().all(Option::is_some) && corners.iter().any(dense) && !corners.iter().all(dense)
    }
}

/// Points near the surface from `from` to `to` (both on it, world mm), one to a cell of `step_mm` that the surface passes, the ends
/// included. `None` if the surface does not connect them, or only by a way that looks at more than `most` cells to be found.
pub(crate) fn cell_route(
    surface: &dyn Surface,
    from: DVec3,
    to: DVec3,
    step_mm: f64,
    most: usize,
) -> Option<Vec<DVec3>> {
    // Off the lattice by a share that has no meaning, so that flat faces of a volume do not lie in the lattice's own planes.
    let origin = from - DVec3::new(0.4142, 0.5772, 0.3217) * step_mm;
    let mut lattice = Lattice { surface, origin, step_mm, values: HashMap::new() };
    let cell_of = |p: DVec3| ((p - origin) / step_mm).floor().as_i64vec3();
    let start = crossed_near(&mut lattice, cell_of(from), from)?;
    let goal = crossed_near(&mut lattice, cell_of(to), to)?;
    let mut best: HashMap<I64Vec3, (f64, I64Vec3)> = HashMap::from([(start, (0.0, start))]);
    let mut waiting = BinaryHeap::from([Waiting { least_mm: from.distance(to), so_far_mm: 0.0, cell: start }]);
    while let Some(Waiting { so_far_mm, cell, .. }) = waiting.pop() {
        if cell == goal {
            return Some(way_back(&mut lattice, &best, [from, to], goal));
        }
        if best.len() > most {
            return None;
        }
        if best.get(&cell).is_some_and(|b| b.0 < so_far_mm) {
            continue;
        }
        let Some(here) = lattice.crossing(cell) else { continue };
        for axis in 0..3 {
            for ahead in [false, true] {
                if !lattice.passes(cell, axis, ahead) {
                    continue;
                }
                let next = if ahead { cell + I64Vec3::AXES[axis] } else { cell - I64Vec3::AXES[axis] };
                let Some(there) = lattice.crossing(next) else { continue };
                let so_far = so_far_mm + here.distance(there);
                if best.get(&next).is_none_or(|b| so_far < b.0) {
                    best.insert(next, (so_far, cell));
                    waiting.push(Waiting {
                        least_mm: so_far + EAGER * there.distance(to),
                        so_far_mm: so_far,
                        cell: next,
                    });
                }
            }
        }
    }
    None
}

/// The cell of a point on the surface, or where a corner of it was just missed, the nearest crossed one beside it.
fn crossed_near(lattice: &mut Lattice, cell: I64Vec3, p: DVec3) -> Option<I64Vec3> {
    let around = (0..27).map(|i| cell + I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    let crossed = around.filter_map(|c| lattice.crossing(c).map(|at| (c, at.distance(p))));
    crossed.min_by(|a, b| (a.0 != cell).cmp(&(b.0 != cell)).then(a.1.total_cmp(&b.1))).map(|(c, _)| c)
}

fn way_back(
    lattice: &mut Lattice,
    best: &HashMap<I64Vec3, (f64, I64Vec3)>,
    ends: [DVec3; 2],
    goal: I64Vec3,
) -> Vec<DVec3> {
    let mut line = vec![ends[1]];
    let mut cell = goal;
    while let Some(&(_, before)) = best.get(&cell) {
        if before == cell {
            break;
        }
        cell = before;
        line.extend(lattice.crossing(cell));
    }
    // The first cell's own place would only turn the path back.
    if line.len() > 1 {
        line.pop();
    }
    line.push(ends[0]);
    line.reverse();
    line
}
