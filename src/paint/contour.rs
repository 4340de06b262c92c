//! A closed contour in a plane, and the voxels that it fills: a lasso.
//!
//! A voxel is in it if its centre, carried to the plane along the normal, lies inside: the contour winds about it, however it crosses
//! itself. Without a depth the layer of voxels that the plane goes through is filled, with one all that lie so near to either side. Lengths are mm, on any
//! grid. Knows neither strokes nor documents.

use crate::math::{DVec2, DVec3, Plane};
use crate::paint::brush::{Brush, Shape, Tip};
use crate::paint::dab::image;
use crate::paint::falloff::Falloff;
use crate::paint::voxel_set::VoxelSet;
use crate::volume::Grid;

/// A contour in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Its corners, mm; the last is joined to the first. The plane goes through the first.
    pub points: Vec<DVec3>,
    /// Unit normal of its plane.
    pub normal: DVec3,
    /// How far it fills to either side, mm.
    pub depth_mm: f64,
}

impl Contour {
    /// The middle of its extent, in its plane, and how far from there its corners lie at most.
    pub fn reach(&self) -> (DVec3, f64) {
        let flat: Vec<DVec3> = self.points.iter().map(|p| self.flat(*p)).collect();
        let first = self.points.first().copied().unwrap_or(DVec3::ZERO);
        let (lo, hi) = flat.iter().fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        let middle = self.flat((lo + hi) * 0.5);
        (middle, flat.iter().map(|p| p.distance(middle)).fold(0.0, f64::max))
    }

    /// A brush of one dab at its middle that covers all that it may fill on these grids: the rest is the contour's.
    #[must_use]
    pub fn brush<'a>(&self, brush: &Brush, grids: impl IntoIterator<Item = &'a Grid>) -> Brush {
        let layer = grids.into_iter().map(|grid| self.layer(grid)).fold(0.0, f64::max);
        let (_, across) = self.reach();
        let half = self.depth_mm.max(layer);
        // An ellipsoid about a cylinder of the same proportions.
        let (across, half) = (across.max(layer) * COVERS, half * COVERS);
        let radius_mm = across.max(half * 0.25);
        Brush {
            shape: Shape::Ellipsoid,
            radius_mm,
            ratio: half / radius_mm,
            falloff: Falloff::Hard,
            tip: Tip::Wash,
            ..*brush
        }
    }

    /// Half of a voxel's extent along the normal, mm.
    fn layer(&self, grid: &Grid) -> f64 {
        let m = grid.world_from_index.matrix3;
        [m.x_axis, m.y_axis, m.z_axis].map(|edge| edge.dot(self.normal).abs()).iter().sum::<f64>() * 0.5
    }

    /// A place carried to the plane.
    fn flat(&self, at: DVec3) -> DVec3 {
        let first = self.points.first().copied().unwrap_or(DVec3::ZERO);
        at - self.normal * self.normal.dot(at - first)
    }

    /// Its image across a plane.
    #[must_use]
    pub fn image(&self, plane: &Plane) -> Self {
        let normal = self.normal - plane.normal * (2.0 * plane.normal.dot(self.normal));
        Self { points: self.points.iter().map(|p| image(plane, *p)).collect(), normal, ..*self }
    }

    /// The voxels that it fills.
    pub fn voxels(&self, grid: &Grid) -> VoxelSet {
        let mut set = VoxelSet::default();
        let layer = self.layer(grid);
        let half = self.depth_mm.max(layer);
        let (middle, across) = self.reach();
        let inverse = grid.index_from_world();
        let rows = inverse.matrix3.transpose();
        let centre = inverse.transform_point3(middle);
        // All of it lies in a cylinder about the middle.
        let far = DVec3::from_array([0, 1, 2].map(|a| {
            let (row, along) = (rows.col(a), rows.col(a).dot(self.normal).abs());
            (row.length_squared() - along * along).max(0.0).sqrt() * across + along * half
        }));
        let lo = (centre - far - 1e-6).ceil().max(DVec3::ZERO);
        let end = ((centre + far + 1e-6).floor() + 1.0).min(grid.dims_f64());
        if !lo.cmplt(end).all() {
            return set;
        }
        let [lo, end] = [lo, end].map(|v| v.to_array().map(|v| v as u32));
        // Along a row of voxels only the first of these coordinates grows.
        let step = grid.world_from_index.matrix3.x_axis;
        let flat = step - self.normal * step.dot(self.normal);
        let along = flat.try_normalize().unwrap_or_else(|| self.normal.any_orthonormal_vector());
        let beside = self.normal.cross(along);
        let first = self.points.first().copied().unwrap_or(DVec3::ZERO);
        let coordinates = |at: DVec3| DVec2::new((at - first).dot(along), (at - first).dot(beside));
        let corners: Vec<DVec2> = self.points.iter().map(|p| coordinates(*p)).collect();
        for z in lo[2]..end[2] {
            for y in lo[1]..end[1] {
                let place = |x: u32| {
                    grid.world_from_index.transform_point3(DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
                };
                let crossings = crossings(&corners, coordinates(place(lo[0])).y);
                if crossings.is_empty() {
                    continue;
                }
                for x in lo[0]..end[0] {
                    let at = place(x);
                    let lift = self.normal.dot(at - first);
                    // Of two layers between which the plane lies, the lower one.
                    let in_layer = lift > -layer * (1.0 + HAIR) && lift <= layer * (1.0 - HAIR);
                    let is_near = in_layer || lift.abs() <= self.depth_mm * (1.0 + HAIR);
                    let s = coordinates(at).x;
                    let winding: i32 = crossings.iter().filter(|(at, _)| *at > s).map(|(_, turn)| turn).sum();
                    if is_near && winding != 0 {
                        set.insert([x, y, z]);
                    }
                }
            }
        }
        set
    }
}

/// What rounding may add to a distance.
const HAIR: f64 = 1e-9;
/// √2 and a hair.
const COVERS: f64 = 1.415;

/// Where the contour crosses a line of the plane, and which way.
fn crossings(corners: &[DVec2], line: f64) -> Vec<(f64, i32)> {
    let next = corners.iter().cycle().skip(1);
    let cross = |(a, b): (&DVec2, &DVec2)| {
        let (below, above) = (a.y <= line, b.y <= line);
        (below != above).then(|| (a.x + (line - a.y) / (b.y - a.y) * (b.x - a.x), if below { 1 } else { -1 }))
    };
    corners.iter().zip(next).filter_map(cross).collect()
}
