//! Where a slice view's pixels lie in the world.
//!
//! A slice runs along the voxel axis nearest to its anatomical one, so that its pixels are voxels and not mixtures. Everyone who
//! needs a slice's pixels (pointer, picture, crosshair, side letters) asks here. Axial is seen from the feet, coronal from the
//! front (patient's right on the picture's left in both), sagittal from the left (anterior on the picture's left).

use crate::document::scene::{ViewName, Views};
use crate::math::{DVec2, DVec3};
use crate::volume::Grid;

/// A slice picture in the world: pixel (0, 0) is its top-left corner, y runs down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlane {
    /// The voxel axis (0 i, 1 j, 2 k) that the slice is normal to.
    pub axis: usize,
    /// The slice's voxel along that axis.
    pub index: u32,
    /// The voxel axes that run along the picture's width and height.
    pub in_plane: [usize; 2],
    /// World mm in the picture's centre, on the slice's voxel centres.
    pub centre: DVec3,
    /// Unit direction of the picture's x, world.
    pub right: DVec3,
    /// Unit direction of the picture's −y, world.
    pub up: DVec3,
    /// Unit direction from the slice towards the viewer, world.
    pub towards_viewer: DVec3,
    /// Size of a pixel in mm.
    pub mm_per_px: f64,
    /// Picture in pixels.
    pub size: [u32; 2],
}

impl SlicePlane {
    /// The plane of a slice view; `None` for the 3D view.
    pub fn new(grid: &Grid, views: &Views, view: ViewName) -> Option<Self> {
        // Right, up and towards the viewer, in world axes.
        let (slot, right, up, viewer) = match view {
            ViewName::ThreeD => return None,
            ViewName::Axial => (0, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z),
            ViewName::Coronal => (1, DVec3::NEG_X, DVec3::Z, DVec3::Y),
            ViewName::Sagittal => (2, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X),
        };
        let slice = &views.slices[slot];
        let [axis_x, axis_y, axis] = [right, up, viewer].map(|d| voxel_axis_along(grid, d));
        let along = |axis: usize, wish: DVec3| {
            let direction = grid.world_from_index.matrix3.col(axis).normalize_or(wish);
            if direction.dot(wish) < 0.0 { -direction } else { direction }
        };
        let to_index = grid.index_from_world();
        let last = f64::from(grid.dims[axis].saturating_sub(1));
        let index = (to_index.transform_point3(views.crosshair)[axis] + 0.5).floor().clamp(0.0, last);
        let mut centre = to_index.transform_point3(slice.centre);
        centre[axis] = index;
        Some(Self {
            axis,
            index: index as u32,
            in_plane: [axis_x, axis_y],
            centre: grid.world_from_index.transform_point3(centre),
            right: along(axis_x, right),
            up: along(axis_y, up),
            towards_viewer: along(axis, viewer),
            mm_per_px: slice.height_mm / f64::from(slice.size[1].max(1)),
            size: slice.size,
        })
    }

    /// World mm of a point of the picture.
    pub fn world(&self, px: DVec2) -> DVec3 {
        let from_centre = (px - self.half_size()) * self.mm_per_px;
        self.centre + self.right * from_centre.x - self.up * from_centre.y
    }

    /// The picture's point nearest to a world point (which is seen along the slice's own axis).
    pub fn pixel(&self, world: DVec3) -> DVec2 {
        let d = world - self.centre;
        // Solved with the dual basis, so that sheared grids agree with `world`.
        let (rr, uu, ru) = (self.right.dot(self.right), self.up.dot(self.up), self.right.dot(self.up));
        let (dr, du) = (d.dot(self.right), d.dot(self.up));
        let det = (rr * uu - ru * ru).max(1e-12);
        let (x, y) = ((dr * uu - du * ru) / det, (du * rr - dr * ru) / det);
        self.half_size() + DVec2::new(x, -y) / self.mm_per_px
    }

    /// Letters of the body's sides at the picture's left, right, top and bottom.
    pub fn side_letters(&self) -> [char; 4] {
        [-self.right, self.right, self.up, -self.up].map(side_letter)
    }

    fn half_size(&self) -> DVec2 {
        DVec2::new(f64::from(self.size[0]), f64::from(self.size[1])) * 0.5
    }
}

/// The side of the body that a world direction points to.
pub fn side_letter(direction: DVec3) -> char {
    let a = direction.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    [['L', 'R'], ['P', 'A'], ['I', 'S']][axis][usize::from(direction[axis] >= 0.0)]
}

/// The voxel axis that serves a world axis, of the one assignment of all three that fits best.
fn voxel_axis_along(grid: &Grid, world_axis: DVec3) -> usize {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let m = grid.world_from_index.matrix3;
    let fit =
        |order: &[usize; 3]| -> f64 { (0..3).map(|world| m.col(order[world]).normalize_or_zero()[world].abs()).sum() };
    // The first of equals, so that a grid turned by exactly 45° has one answer.
    let best = ORDERS.iter().fold(ORDERS[0], |best, order| if fit(order) > fit(&best) + 1e-9 { *order } else { best });
    let world = if world_axis.x != 0.0 { 0 } else { usize::from(world_axis.z != 0.0) + 1 };
    best[world]
}
