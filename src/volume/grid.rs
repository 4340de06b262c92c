//! The lattice of voxel centres and its place in the world.

use crate::math::{Aabb, DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// `dims` voxels along i (fastest), j, k; centres at integer indices; the box of the volume has its faces at −½ and n−½.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Voxels along i, j, k; none is 0.
    pub dims: [u32; 3],
    /// Index (voxel centres at integers) to world (RAS+ mm). Invertible.
    pub world_from_index: DAffine3,
}

impl Grid {
    /// A box where there is no volume: voxels of 1 mm, at least one.
    pub fn of_nothing(bounds: &Aabb) -> Self {
        let dims = (bounds.max - bounds.min).ceil().max(DVec3::ONE).min(DVec3::splat(1024.0));
        Self::aligned(dims.to_array().map(|n| n as u32), DVec3::ONE, bounds.min + 0.5)
    }

    /// An axis-aligned grid with the given spacing in mm and voxel (0,0,0) at `origin`.
    pub fn aligned(dims: [u32; 3], spacing_mm: DVec3, origin: DVec3) -> Self {
        Self { dims, world_from_index: DAffine3 { matrix3: DMat3::from_diagonal(spacing_mm), translation: origin } }
    }

    /// World (RAS+ mm) to continuous index.
    pub fn index_from_world(&self) -> DAffine3 {
        self.world_from_index.inverse()
    }

    /// Distance in mm between neighbours along i, j, k.
    pub fn spacing(&self) -> DVec3 {
        let m = self.world_from_index.matrix3;
        DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
    }

    /// The smallest spacing in mm: "one voxel" as a step of the ray caster.
    pub fn voxel_mm(&self) -> f64 {
        self.spacing().min_element()
    }

    /// Number of voxels.
    pub fn voxel_count(&self) -> u64 {
        self.dims.iter().map(|&d| u64::from(d)).product()
    }

    /// The box of the volume in index space: −½ to n−½.
    pub fn index_bounds(&self) -> Aabb {
        Aabb { min: DVec3::splat(-0.5), max: self.dims_f64() - 0.5 }
    }

    /// The box from the first voxel's centre to the last one's, in index space: all that is known of a box of another volume.
    pub fn centre_bounds(&self) -> Aabb {
        Aabb { min: DVec3::ZERO, max: self.dims_f64() - 1.0 }
    }

    /// The smallest world box around the volume.
    pub fn world_bounds(&self) -> Aabb {
        let corners = self.index_bounds().corners().map(|c| self.world_from_index.transform_point3(c));
        Aabb {
            min: corners.into_iter().fold(corners[0], DVec3::min),
            max: corners.into_iter().fold(corners[0], DVec3::max),
        }
    }

    /// The volume's eight corners in world mm, in the order of [`Aabb::corners`]; oblique grids keep their shape.
    pub fn world_corners(&self) -> [DVec3; 8] {
        self.index_bounds().corners().map(|c| self.world_from_index.transform_point3(c))
    }

    /// The voxel that holds a continuous index, if it is inside the volume's box.
    pub fn voxel_at(&self, index: DVec3) -> Option<[u32; 3]> {
        let v = (index + 0.5).floor();
        let inside = v.cmpge(DVec3::ZERO).all() && v.cmplt(self.dims_f64()).all();
        inside.then_some([v.x as u32, v.y as u32, v.z as u32])
    }

    /// The grid of a coarser level: voxel j of level l covers voxels 2^l·j … 2^l·j + 2^l − 1 of level 0.
    #[must_use]
    pub fn level(&self, level: u8) -> Self {
        let f = f64::from(1_u32 << level);
        let shift =
            DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(f)), translation: DVec3::splat((f - 1.0) * 0.5) };
        Self { dims: level_dims(self.dims, level), world_from_index: self.world_from_index * shift }
    }

    /// The number of levels until everything fits into one brick, level 0 included.
    pub fn level_count(&self) -> u8 {
        let longest = self.dims.iter().copied().max().unwrap_or(1);
        let mut levels = 1;
        while longest.div_ceil(1 << (levels - 1)) > crate::volume::brick::BRICK {
            levels += 1;
        }
        levels
    }

    /// The dimensions as a vector.
    pub fn dims_f64(&self) -> DVec3 {
        DVec3::new(f64::from(self.dims[0]), f64::from(self.dims[1]), f64::from(self.dims[2]))
    }
}

/// `⌈dims / 2^level⌉`.
pub(super) fn level_dims(dims: [u32; 3], level: u8) -> [u32; 3] {
    dims.map(|d| d.div_ceil(1 << level))
}
