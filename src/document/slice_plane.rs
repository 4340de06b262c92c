//! Where a slice view's pixels lie in the world.
//!
//! A slice runs along the voxel axis nearest to its anatomical one, so that its pixels are voxels and not mixtures. Everyone who
//! needs a slice's pixels (pointer, picture, crosshair, side letters) asks here. Axial is seen from the feet, coronal from the
//! front (patient's right on the picture's left in both), sagittal from the left (anterior on the picture's left).

use super::{ViewName, Views};
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::document::SliceView;
    use crate::math::{Camera, DAffine3, DMat3, Projection};

    fn views(centre: DVec3, crosshair: DVec3) -> Views {
        let slice = SliceView { centre, height_mm: 100.0, size: [200, 100] };
        let projection = Projection::Perspective { fov_y_deg: 30.0 };
        let camera = Camera { eye: DVec3::Y, target: DVec3::ZERO, up: DVec3::Z, projection };
        Views { camera, size: [1, 1], slices: [slice; 3], crosshair }
    }

    const SLICES: [ViewName; 3] = [ViewName::Axial, ViewName::Coronal, ViewName::Sagittal];

    #[test]
    fn sides_are_where_radiologists_expect_them_whatever_the_axis_order() {
        // i runs posterior, j superior, k left.
        let m = DMat3::from_cols(DVec3::NEG_Y, DVec3::Z * 2.0, DVec3::NEG_X * 3.0);
        for matrix3 in [DMat3::IDENTITY, m] {
            let grid = Grid { dims: [10, 20, 30], world_from_index: DAffine3 { matrix3, translation: DVec3::ZERO } };
            let letters = SLICES.map(|v| {
                SlicePlane::new(&grid, &views(DVec3::ZERO, DVec3::ZERO), v)
                    .unwrap()
                    .side_letters()
                    .iter()
                    .collect::<String>()
            });
            assert_eq!(letters, ["RLAP", "RLSI", "APSI"]);
        }
    }

    #[test]
    fn the_axes_of_an_oblique_grid_are_each_used_once() {
        let turned = DMat3::from_rotation_z(0.6) * DMat3::from_rotation_x(0.7);
        let grid = Grid { dims: [10, 20, 30], world_from_index: DAffine3 { matrix3: turned, translation: DVec3::ONE } };
        let mut axes = SLICES.map(|v| SlicePlane::new(&grid, &views(DVec3::ZERO, DVec3::ZERO), v).unwrap().axis);
        axes.sort_unstable();
        assert_eq!(axes, [0, 1, 2]);
    }

    #[test]
    fn pixel_and_world_are_inverse_and_stay_on_the_slice() {
        let m = DMat3::from_rotation_y(0.3) * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.5));
        let grid =
            Grid { dims: [40, 40, 40], world_from_index: DAffine3 { matrix3: m, translation: DVec3::splat(-9.0) } };
        let crosshair = grid.world_from_index.transform_point3(DVec3::new(7.2, 30.6, 11.4));
        for view in SLICES {
            let plane = SlicePlane::new(&grid, &views(DVec3::new(3.0, 2.0, 1.0), crosshair), view).unwrap();
            assert_eq!(plane.index, [7, 31, 11][plane.axis]);
            for px in [DVec2::ZERO, DVec2::new(150.0, 20.0)] {
                let world = plane.world(px);
                assert!((plane.pixel(world) - px).length() < 1e-9);
                let index = grid.index_from_world().transform_point3(world);
                assert!((index[plane.axis] - f64::from(plane.index)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_crosshair_outside_the_volume_shows_its_last_slice() {
        let grid = Grid::aligned([4, 5, 6], DVec3::ONE, DVec3::ZERO);
        let planes = SLICES.map(|v| SlicePlane::new(&grid, &views(DVec3::ZERO, DVec3::splat(99.0)), v).unwrap().index);
        assert_eq!(planes, [5, 4, 3]);
    }
}
