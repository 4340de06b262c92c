//! The closed surface between what is inside and what is not, over a box of samples: marching cubes, a layer of cells at a time.
//!
//! What lies beyond the box is outside, so that surfaces end at its border closed. A corner of the surface lies on an edge of the
//! lattice, where the samples between its ends, taken as linear, are 0: for samples of a field that is exactly its level set's place
//! there. Places are index space of the box's own lattice. Knows no field: samples are asked for by planes.

use crate::math::DVec3;
use crate::mesh::cell::{CORNERS, Cases, CellEdge};

/// A closed surface in index space.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) corners: Vec<DVec3>,
    /// Along which axis of the lattice each corner lies between two samples, and whether the outer one is the farther; `None` for a
    /// corner inside a cell.
    pub(super) sides: Vec<Option<(usize, bool)>>,
    /// Round about as seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Corners on the edges that leave the samples of a plane, along x, y and z.
type Plane = [Vec<u32>; 3];

const NONE: u32 = u32::MAX;

impl Surface {
    /// Of the samples of a box of `size`, its first at `lo`; `plane` gives those of the plane `z`, counted from the box's first, x
    /// fastest. Samples above 0 are inside, none is 0; beyond the box all are `outside`. Between an inner and an outer one the surface
    /// lies at the share that `share` says of the way from the former.
    ///
    /// # Errors
    /// Whatever `plane` fails with.
    pub(super) fn march<E>(
        lo: [i64; 3],
        size: [usize; 3],
        outside: i32,
        mut plane: impl FnMut(usize) -> Result<Vec<i32>, E>,
        share: impl Fn(i32, i32) -> f64,
    ) -> Result<Self, E> {
        // A layer of outside about all.
        let [nx, ny, nz] = size.map(|n| n + 2);
        let padded = |inner: Option<Vec<i32>>| {
            let mut all = vec![outside; nx * ny];
            for (y, row) in inner.iter().flat_map(|samples| samples.chunks_exact(size[0])).enumerate() {
                all[(y + 1) * nx + 1..][..size[0]].copy_from_slice(row);
            }
            all
        };
        let origin = DVec3::new(lo[0] as f64, lo[1] as f64, lo[2] as f64) - 1.0;
        let (mut surface, mut cases) = (Self::default(), Cases::new());
        let mut corners: Vec<u32> = Vec::new();
        let blank = || -> Plane { std::array::from_fn(|_| vec![NONE; nx * ny]) };
        let (mut low, mut low_edges) = (padded(None), blank());
        for z in 0..nz - 1 {
            let high = padded(if z + 1 < nz - 1 { Some(plane(z)?) } else { None });
            let mut high_edges = blank();
            for y in 0..ny - 1 {
                for x in 0..nx - 1 {
                    let at = |corner: usize| (y + (corner >> 1 & 1)) * nx + x + (corner & 1);
                    let samples: [i32; CORNERS] = std::array::from_fn(|c| if c < 4 { low[at(c)] } else { high[at(c)] });
                    let inside = samples.iter().filter(|s| **s > 0).count();
                    if inside == 0 || inside == CORNERS {
                        continue;
                    }
                    let base = origin + DVec3::new(x as f64, y as f64, z as f64);
                    for ring in cases.loops(&samples) {
                        corners.clear();
                        corners.extend(ring.edges.iter().map(|&CellEdge { corner, axis }| {
                            let planes = if corner < 4 { &mut low_edges } else { &mut high_edges };
                            let known = &mut planes[usize::from(axis)][at(usize::from(corner))];
                            if *known == NONE {
                                let ends = [corner, corner | 1 << axis].map(|c| samples[usize::from(c)]);
                                let from_low = match ends {
                                    [a, b] if a > 0 => share(a, b),
                                    [a, b] => 1.0 - share(b, a),
                                };
                                *known = surface.corners.len() as u32;
                                let mut place = base + offset(corner);
                                place[usize::from(axis)] += from_low;
                                surface.corners.push(place);
                                surface.sides.push(Some((usize::from(axis), ends[0] > 0)));
                            }
                            *known
                        }));
                        match &ring.triangles {
                            Some(triangles) => {
                                surface.triangles.extend(triangles.iter().map(|t| t.map(|i| corners[i])));
                            }
                            None => surface.fan(base, &samples, &corners),
                        }
                    }
                }
            }
            (low, low_edges) = (high, high_edges);
        }
        Ok(surface)
    }

    /// A loop as triangles about a corner of its own, which lies where the samples between those of the cell are 0.
    fn fan(&mut self, base: DVec3, samples: &[i32; CORNERS], ring: &[u32]) {
        let places = ring.iter().map(|&c| self.corners[c as usize] - base);
        let middle = places.fold(DVec3::ZERO, |sum, p| sum + p) / ring.len() as f64;
        let value = |p: DVec3| {
            let corner = |c: usize| {
                let far = offset(c as u8);
                ((DVec3::ONE - far - p).abs()).element_product() * f64::from(samples[c])
            };
            (0..CORNERS).map(corner).sum::<f64>()
        };
        // From the middle towards the corners of the other side: of the places where the sign changes the nearest.
        let inside = value(middle) > 0.0;
        let others = (0..CORNERS).filter(|&c| (samples[c] > 0) != inside).map(|c| offset(c as u8));
        let met = others.map(|to| {
            let (mut near, mut far) = (middle, to);
            for _ in 0..40 {
                let between = (near + far) * 0.5;
                if (value(between) > 0.0) == inside { near = between } else { far = between }
            }
            far
        });
        let place = met.reduce(|a, b| if b.distance_squared(middle) < a.distance_squared(middle) { b } else { a });
        let centre = self.corners.len() as u32;
        self.corners.push(base + place.unwrap_or(middle));
        self.sides.push(None);
        let next = |i: usize| ring[(i + 1) % ring.len()];
        self.triangles.extend(ring.iter().enumerate().map(|(i, &corner)| [centre, corner, next(i)]));
    }
}

/// Where a cell's corner lies in it.
fn offset(corner: u8) -> DVec3 {
    DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2 & 1))
}
