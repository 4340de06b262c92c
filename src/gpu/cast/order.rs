//! Order of sight on the host: which of two solids a ray meets first.
//!
//! Of two solids, a face of one that has the other wholly outside decides (after Bruckner and Gröller 2006, section 4.3, whose
//! parts are sorted as objects). Solids that overlap, or interlock in a ring, have no order; the tiles in which such a pair
//! shows merge intervals instead.

use crate::gpu::cast::solid::Polyhedron;
use crate::math::{Camera, DVec3, Plane, Projection};

/// Where rays come from.
#[derive(Clone, Copy, Debug)]
pub enum RayOrigin {
    /// All from one point.
    Eye(DVec3),
    /// All along one direction.
    Along(DVec3),
}

impl RayOrigin {
    /// The rays of a camera.
    pub fn of(camera: &Camera) -> Self {
        match camera.projection {
            Projection::Perspective { .. } => Self::Eye(camera.eye),
            Projection::Orthographic { .. } => Self::Along(camera.forward()),
        }
    }

    /// Whether a ray meets the inner side of the plane first.
    fn starts_inside(self, plane: &Plane) -> bool {
        match self {
            Self::Eye(eye) => plane.distance(eye) < 0.0,
            Self::Along(direction) => plane.normal.dot(direction) > 0.0,
        }
    }
}

/// What the order of sight found.
pub struct Order {
    /// Indices of the solids, nearest first.
    pub sequence: Vec<usize>,
    count: usize,
    clashes: Vec<bool>,
}

impl Order {
    /// Whether `sequence` says nothing reliable about two solids.
    pub fn clash(&self, a: usize, b: usize) -> bool {
        self.clashes[a * self.count + b]
    }

    /// Sorts solids by sight.
    pub fn of(solids: &[Polyhedron], sight: RayOrigin) -> Self {
        let count = solids.len();
        let mut clashes = vec![false; count * count];
        let mut after: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut waiting_for = vec![0_usize; count];
        for a in 0..count {
            for b in a + 1..count {
                let a_first = match solids[a].face_before(&solids[b]) {
                    Some(face) => Some(sight.starts_inside(&face)),
                    None => solids[b].face_before(&solids[a]).map(|face| !sight.starts_inside(&face)),
                };
                match a_first {
                    Some(a_first) => {
                        let (first, second) = if a_first { (a, b) } else { (b, a) };
                        after[first].push(second);
                        waiting_for[second] += 1;
                    }
                    None => {
                        clashes[a * count + b] = true;
                        clashes[b * count + a] = true;
                    }
                }
            }
        }
        let nearness = |i: usize| {
            let centre = solids[i].corners().iter().sum::<DVec3>() / solids[i].corners().len() as f64;
            match sight {
                RayOrigin::Eye(eye) => centre.distance_squared(eye),
                RayOrigin::Along(direction) => centre.dot(direction),
            }
        };
        let nearness: Vec<f64> = (0..count).map(nearness).collect();
        let mut sequence = Vec::with_capacity(count);
        let mut left: Vec<usize> = (0..count).collect();
        while !left.is_empty() {
            let free = (0..left.len()).filter(|&i| waiting_for[left[i]] == 0);
            let nearest = |a: &usize, b: &usize| nearness[left[*a]].total_cmp(&nearness[left[*b]]);
            // A ring has no first: the nearest goes ahead, and what should have gone before it clashes with it.
            let at = free.min_by(nearest).or_else(|| (0..left.len()).min_by(nearest)).unwrap_or(0);
            let next = left.swap_remove(at);
            if waiting_for[next] > 0 {
                for &other in left.iter().filter(|&&other| after[other].contains(&next)) {
                    clashes[other * count + next] = true;
                    clashes[next * count + other] = true;
                }
            }
            for &second in &after[next] {
                waiting_for[second] = waiting_for[second].saturating_sub(1);
            }
            sequence.push(next);
        }
        Self { sequence, count, clashes }
    }
}
