//! Slice pixels in the world.

use burin::document::{SlicePlane, SliceView, ViewName, Views};
use burin::math::{Camera, DAffine3, DMat3, DVec2, DVec3, Projection};
use burin::volume::Grid;

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
    let grid = Grid { dims: [40, 40, 40], world_from_index: DAffine3 { matrix3: m, translation: DVec3::splat(-9.0) } };
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
