//! A surface along the faces of voxels, made smooth without leaving them: a constrained elastic net (Gibson 1998, "Constrained Elastic
//! Surface Nets") that keeps its volume.
//!
//! Every corner begins in the middle of a face of a voxel and may go half a voxel from that face or one beside it. It is drawn towards the mean of its
//! neighbours, which shrinks what is round; so each closed piece is then moved along its normals until it encloses as much as its
//! voxels do, of which a ball is the fixed point. Works in index space, where voxels are cubes. Deterministic.

use crate::math::DVec3;
use crate::mesh::march::Surface;
use rayon::prelude::*;

/// How far from its face a corner may go, in voxels: half of one, and room for rounding to 32 bits.
const REACH: f64 = 0.499;
/// A ball of radius 12 is smoothest after about so many rounds; more draw what is flat and what is round apart.
const ROUNDS: usize = 22;
/// How far a corner goes towards its neighbours in a round.
const PULL: f64 = 0.5;
/// Steps in which the volume is found at last, and how near it must come.
const VOLUME_STEPS: usize = 40;
const VOLUME_NEAR: f64 = 1e-3;
/// Corners that are handled together: sums are made in this order on every machine.
const CHUNK: usize = 4096;

/// A surface on its way.
struct Net {
    anchors: Vec<DVec3>,
    axes: Vec<usize>,
    /// Of each corner the two others of its triangles, one after another.
    around: Vec<[u32; 2]>,
    first: Vec<u32>,
    /// The closed piece that each corner is of.
    piece: Vec<u32>,
    /// What the voxels of each piece fill; a hollow's is negative.
    targets: Vec<f64>,
}

/// Volume and area of a piece.
#[derive(Clone, Copy, Default)]
struct Extent {
    volume: f64,
    area: f64,
}

impl Surface {
    /// Smooths a surface whose corners lie in the middle of faces of voxels. `proceed` gets the share done and answers whether to go
    /// on; answers false if not.
    pub(super) fn smooth(&mut self, proceed: &dyn Fn(f32) -> bool) -> bool {
        let net = Net::new(self);
        let mut corners = std::mem::take(&mut self.corners);
        for round in 0..ROUNDS {
            if !proceed(round as f32 / ROUNDS as f32) {
                return false;
            }
            let drawn = net.map(&corners, |at, around| {
                let sum = around.iter().fold(DVec3::ZERO, |sum, [a, _]| sum + corners[*a as usize]);
                corners[at] + (sum / around.len().max(1) as f64 - corners[at]) * PULL
            });
            corners = net.filled(&drawn, 0.0).unwrap_or(drawn);
        }
        for _ in 0..VOLUME_STEPS {
            match net.filled(&corners, VOLUME_NEAR) {
                Some(filled) => corners = filled,
                None => break,
            }
        }
        self.corners = corners;
        true
    }
}

impl Net {
    fn new(surface: &Surface) -> Self {
        let count = surface.corners.len();
        let mut first = vec![0_u32; count + 1];
        for corner in surface.triangles.iter().flatten() {
            first[*corner as usize + 1] += 1;
        }
        for i in 0..count {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut around = vec![[0; 2]; first[count] as usize];
        for &[a, b, c] in &surface.triangles {
            for [own, one, other] in [[a, b, c], [b, c, a], [c, a, b]] {
                around[next[own as usize] as usize] = [one, other];
                next[own as usize] += 1;
            }
        }
        let mut net = Self {
            anchors: surface.corners.clone(),
            axes: surface.sides.iter().map(|side| side.map_or(0, |(axis, _)| axis)).collect(),
            around,
            first,
            piece: vec![u32::MAX; count],
            targets: Vec::new(),
        };
        net.find_pieces();
        // What faces enclose, from those across one axis: place times direction, each of area 1.
        net.targets = vec![0.0; net.piece.iter().max().map_or(0, |last| *last as usize + 1)];
        for ((anchor, side), &piece) in surface.corners.iter().zip(&surface.sides).zip(&net.piece) {
            if let Some((0, far)) = side {
                net.targets[piece as usize] += if *far { anchor.x } else { -anchor.x };
            }
        }
        net
    }

    fn find_pieces(&mut self) {
        let mut pieces = 0;
        for start in 0..self.anchors.len() {
            if self.piece[start] != u32::MAX {
                continue;
            }
            let mut open = vec![start as u32];
            self.piece[start] = pieces;
            while let Some(corner) = open.pop() {
                for at in self.first[corner as usize]..self.first[corner as usize + 1] {
                    let next = self.around[at as usize][0];
                    if self.piece[next as usize] == u32::MAX {
                        self.piece[next as usize] = pieces;
                        open.push(next);
                    }
                }
            }
            pieces += 1;
        }
    }

    fn around(&self, corner: usize) -> &[[u32; 2]] {
        &self.around[self.first[corner] as usize..self.first[corner + 1] as usize]
    }

    /// Something of every corner and what is around it, in order.
    fn map<T: Send>(&self, corners: &[DVec3], of: impl Fn(usize, &[[u32; 2]]) -> T + Sync) -> Vec<T> {
        (0..corners.len()).into_par_iter().with_min_len(CHUNK).map(|at| of(at, self.around(at))).collect()
    }

    /// Twice the area about each corner, as a vector outward, and what each piece encloses.
    fn measured(&self, corners: &[DVec3]) -> (Vec<DVec3>, Vec<Extent>) {
        let about = self.anchors[0];
        // Every triangle is met at each of its three corners.
        let all = self.map(corners, |at, around| {
            let own = corners[at];
            around.iter().fold((DVec3::ZERO, Extent::default()), |(sum, extent), [a, b]| {
                let [a, b] = [a, b].map(|i| corners[*i as usize] - own);
                let normal = a.cross(b);
                let volume = extent.volume + (own - about).dot(normal) / 18.0;
                (sum + normal, Extent { volume, area: extent.area + normal.length() / 6.0 })
            })
        });
        let mut extents = vec![Extent::default(); self.targets.len()];
        for ((_, extent), &piece) in all.iter().zip(&self.piece) {
            extents[piece as usize].volume += extent.volume;
            extents[piece as usize].area += extent.area;
        }
        (all.into_iter().map(|(normal, _)| normal).collect(), extents)
    }

    /// The corners moved along their normals by what their piece lacks of its volume, and no farther from their faces than they may.
    /// `None` if no piece lacks more than a share of `near`.
    fn filled(&self, corners: &[DVec3], near: f64) -> Option<Vec<DVec3>> {
        let (normals, extents) = self.measured(corners);
        let lacks = |(extent, target): (&Extent, &f64)| (extent.volume / target - 1.0).abs() >= near;
        if !extents.iter().zip(&self.targets).any(lacks) {
            return None;
        }
        let by: Vec<f64> =
            extents.iter().zip(&self.targets).map(|(e, target)| (target - e.volume) / e.area.max(1e-9)).collect();
        Some(self.map(corners, |at, _| {
            let moved =
                corners[at] + normals[at].normalize_or_zero() * by[self.piece[at] as usize].clamp(-REACH, REACH);
            self.held(at, moved)
        }))
    }

    /// The nearest place to one that a corner may take.
    fn held(&self, at: usize, place: DVec3) -> DVec3 {
        let mut nearest = self.on_face(at, place);
        if place.distance_squared(nearest) <= REACH * REACH {
            return place;
        }
        for [other, _] in self.around(at) {
            let on = self.on_face(*other as usize, place);
            if place.distance_squared(on) < place.distance_squared(nearest) {
                nearest = on;
            }
        }
        nearest + (place - nearest).clamp_length_max(REACH)
    }

    /// The nearest place on the face that a corner began on.
    fn on_face(&self, at: usize, place: DVec3) -> DVec3 {
        let mut off = (place - self.anchors[at]).clamp(DVec3::splat(-0.5), DVec3::splat(0.5));
        off[self.axes[at]] = 0.0;
        self.anchors[at] + off
    }
}
