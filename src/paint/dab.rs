//! One footprint of a brush, and which voxels get how much of it.
//!
//! Distances are millimetres of the world on any grid, measured through `world_from_index` from voxel centre to dab centre.
//! Direct Volume Editing (2008), equation 2: G = strength·F(d/m), zero beyond the support m. A dab whose support is under half
//! the voxel's diagonal may reach no centre at all: there the voxel that holds the dab's centre has G = strength·pressure.

use crate::math::{DMat3, DVec3, Plane};
use crate::paint::brush::{Brush, Shape};
use crate::paint::falloff::{EDGE, Falloff};
use crate::volume::{BRICK, BrickIndex, Grid};

/// One footprint along a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    /// World mm at rest.
    pub centre: DVec3,
    /// Support m of equation 2, mm. 0: the one voxel that holds the centre.
    pub radius_mm: f64,
    /// 0..1, scales the brush's strength.
    pub pressure: f32,
    /// Normal of the slice for a disc, of the surface for what lies along it; a ball ignores it.
    pub normal: DVec3,
}

/// The image of a place across a plane.
pub fn image(plane: &Plane, at: DVec3) -> DVec3 {
    at - plane.normal * (2.0 * plane.distance(at))
}

/// Dabs with their images across a plane behind each of them; one that is its own image lies there once.
pub fn with_images(plane: &Plane, dabs: &[Dab]) -> Vec<Dab> {
    let both = |dab: &Dab| {
        let normal = dab.normal - plane.normal * (2.0 * plane.normal.dot(dab.normal));
        let other = Dab { centre: image(plane, dab.centre), normal, ..*dab };
        let own = other.centre.distance(dab.centre) <= 1e-9 * (dab.radius_mm + dab.centre.length());
        std::iter::once(*dab).chain((!own).then_some(other))
    };
    dabs.iter().flat_map(both).collect()
}

/// A box of voxels, never empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexBox {
    /// First voxel.
    pub lo: [u32; 3],
    /// One past the last voxel.
    pub end: [u32; 3],
}

impl IndexBox {
    /// Bricks that hold a voxel of the box, x fastest.
    pub fn bricks(&self) -> impl Iterator<Item = BrickIndex> + use<> {
        bricks_between(self.lo.map(|v| v / BRICK), self.end.map(|v| (v - 1) / BRICK))
    }

    /// Bricks whose slot (a brick with one voxel of apron) shows a voxel of the box, in a volume of `dims` voxels.
    pub fn slots(&self, dims: [u32; 3]) -> impl Iterator<Item = BrickIndex> + use<> {
        let lo = self.lo.map(|v| v.saturating_sub(1) / BRICK);
        bricks_between(lo, std::array::from_fn(|a| self.end[a].min(dims[a] - 1) / BRICK))
    }

    /// Its part in a brick, which it meets.
    #[must_use]
    pub fn within(&self, brick: BrickIndex) -> Self {
        let origin = brick.origin();
        Self {
            lo: std::array::from_fn(|a| self.lo[a].max(origin[a])),
            end: std::array::from_fn(|a| self.end[a].min(origin[a] + BRICK)),
        }
    }

    /// Its voxels, x fastest.
    pub fn voxels(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let Self { lo, end } = *self;
        (lo[2]..end[2]).flat_map(move |z| (lo[1]..end[1]).flat_map(move |y| (lo[0]..end[0]).map(move |x| [x, y, z])))
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            lo: std::array::from_fn(|a| self.lo[a].min(other.lo[a])),
            end: std::array::from_fn(|a| self.end[a].max(other.end[a])),
        }
    }
}

fn bricks_between(lo: [u32; 3], hi: [u32; 3]) -> impl Iterator<Item = BrickIndex> {
    (lo[2]..=hi[2])
        .flat_map(move |z| (lo[1]..=hi[1]).flat_map(move |y| (lo[0]..=hi[0]).map(move |x| BrickIndex([x, y, z]))))
}

/// The layer of voxels that a disc lies in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscLayer {
    /// Voxel axis across the layer: the one whose layers are most nearly normal to the dab's normal.
    pub axis: usize,
    /// Index along it.
    pub index: u32,
    /// Unit normal of the layer in the world; on a sheared grid not the direction of the axis.
    pub normal: DVec3,
}

/// How a dab lies along a surface: the distance to its centre counts across the normal as it is, along it beyond `half_mm` and
/// stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Along {
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// Up to this height over and under the centre nothing counts, mm: so far matter is moved, and all of that way is covered alike.
    pub half_mm: f64,
    /// 1 over the ratio of an ellipsoid's axes.
    pub stretch: f64,
}

/// A dab laid on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Where the dab's centre is; with radius 0 the centre of the voxel that holds it. Continuous index.
    pub centre: DVec3,
    /// mm.
    pub radius_mm: f64,
    /// Strength times pressure.
    pub gain: f32,
    /// For a disc.
    pub layer: Option<DiscLayer>,
    /// For what lies along a surface.
    pub along: Option<Along>,
    /// All voxels with G > 0 are in here.
    pub bounds: IndexBox,
    /// Whether the voxel that holds the centre has all of the gain, whatever its distance.
    pub thin: bool,
    falloff: Falloff,
    world_from_index: DMat3,
}

/// Half the longest diagonal of a voxel, mm: a dab of this radius reaches the centre of the voxel that it lies in.
pub fn half_diagonal_mm(grid: &Grid) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|a| grid.world_from_index.matrix3.col(a));
    [x + y + z, x + y - z, x - y + z, x - y - z].into_iter().map(|d| d.length() * 0.5).fold(0.0, f64::max)
}

impl Dab {
    /// The dab on a grid; `None` if it meets no voxel's neighbourhood or has no strength.
    pub fn footprint(&self, brush: &Brush, grid: &Grid) -> Option<Footprint> {
        let inverse = grid.index_from_world();
        let mut centre = inverse.transform_point3(self.centre);
        let gain = brush.strength * self.pressure;
        if !(gain > 0.0 && centre.is_finite()) {
            return None;
        }
        // Row a of the inverse is the gradient of index a: normal to the layers of axis a, as long as 1 / their distance.
        let rows = inverse.matrix3.transpose();
        let mut reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()) * self.radius_mm;
        let mut shown = centre;
        let mut layer = None;
        if brush.shape == Shape::Disc {
            let found = disc_layer(self.normal, centre, &rows, grid)?;
            // Distances count in the layer, so the disc is about the foot of the perpendicular.
            let lift = (f64::from(found.index) - centre[found.axis]) / rows.col(found.axis).length();
            shown = centre + inverse.matrix3 * (found.normal * lift);
            for a in 0..3 {
                let row = rows.col(a);
                reach[a] = self.radius_mm * (row - found.normal * row.dot(found.normal)).length();
            }
            reach[found.axis] = 0.0;
            shown[found.axis] = f64::from(found.index);
            layer = Some(found);
        }
        let along = self.along(brush);
        if let Some(along) = &along {
            for a in 0..3 {
                let (row, lift) = (rows.col(a), rows.col(a).dot(along.normal));
                let flat = (row.length_squared() - lift * lift).max(0.0) + (lift / along.stretch).powi(2);
                reach[a] = self.radius_mm * flat.sqrt() + along.half_mm * lift.abs();
            }
        }
        let thin = self.radius_mm > 0.0 && self.radius_mm < half_diagonal_mm(grid);
        let bounds = if self.radius_mm == 0.0 {
            let voxel = grid.voxel_at(centre)?;
            centre = DVec3::new(f64::from(voxel[0]), f64::from(voxel[1]), f64::from(voxel[2]));
            IndexBox { lo: voxel, end: voxel.map(|v| v + 1) }
        } else {
            // The slack of EDGE, and of the inverse's rounding.
            let slack = reach * EDGE + (shown.abs() + 1.0) * 1e-12;
            let lo = (shown - reach - slack).ceil().max(DVec3::ZERO);
            let end = ((shown + reach + slack).floor() + 1.0).min(grid.dims_f64());
            let reached = lo
                .cmplt(end)
                .all()
                .then(|| IndexBox { lo: lo.to_array().map(|v| v as u32), end: end.to_array().map(|v| v as u32) });
            let held = if thin { grid.voxel_at(centre) } else { None };
            let held = held.map(|voxel| IndexBox { lo: voxel, end: voxel.map(|v| v + 1) });
            match (reached, held) {
                (Some(a), Some(b)) => a.union(&b),
                (a, b) => a.or(b)?,
            }
        };
        Some(Footprint {
            centre,
            radius_mm: self.radius_mm,
            gain,
            layer,
            along,
            bounds,
            thin,
            falloff: brush.effective_falloff(),
            world_from_index: grid.world_from_index.matrix3,
        })
    }
}

impl Dab {
    /// How it lies along the surface, if it does.
    fn along(&self, brush: &Brush) -> Option<Along> {
        let normal = self.normal.try_normalize().filter(|_| brush.lies_along() && self.radius_mm > 0.0)?;
        let half_mm = if brush.effective().displaces() { brush.height_mm.unwrap_or(0.0) } else { 0.0 };
        let stretch = if brush.shape == Shape::Ellipsoid { 1.0 / brush.ratio } else { 1.0 };
        Some(Along { normal, half_mm, stretch })
    }
}

/// The layer nearest to the centre; `None` outside the volume.
fn disc_layer(normal: DVec3, centre: DVec3, rows: &DMat3, grid: &Grid) -> Option<DiscLayer> {
    let lean = |a: usize| (rows.col(a).normalize().dot(normal)).abs();
    let axis = (0..3).fold(0, |best, a| if lean(a) > lean(best) { a } else { best });
    let index = (centre[axis] + 0.5).floor();
    (index >= 0.0 && index < f64::from(grid.dims[axis])).then(|| DiscLayer {
        axis,
        index: index as u32,
        normal: rows.col(axis).normalize(),
    })
}

impl Footprint {
    /// G of equation 2 for a voxel: strength · pressure · F(d / radius), 0 beyond the support.
    pub fn coverage(&self, voxel: [u32; 3]) -> f64 {
        let at = DVec3::new(f64::from(voxel[0]), f64::from(voxel[1]), f64::from(voxel[2]));
        if self.thin && (self.centre + 0.5).floor() == at {
            return f64::from(self.gain);
        }
        let mut d = self.world_from_index * (at - self.centre);
        if let Some(layer) = self.layer {
            if voxel[layer.axis] != layer.index {
                return 0.0;
            }
            d -= layer.normal * layer.normal.dot(d);
        }
        if let Some(along) = self.along {
            let lift = along.normal.dot(d);
            let counts = (lift.abs() - along.half_mm).max(0.0) * along.stretch;
            d += along.normal * (counts - lift);
        }
        f64::from(self.gain) * self.falloff.at(d.length(), self.radius_mm)
    }
}
