//! Brushes, strokes and dabs against equation 2 and closed forms.

mod along;
mod brush;
mod build_up;
mod dab;
mod falloff;
mod path;
mod room;
mod surface;

use crate::common::falloffs::*;
use burin::math::{DAffine3, DMat3, DVec3};
use burin::paint::*;
use burin::volume::Grid;

/// Grids that a brush must not care about: cubes, slabs, turned, sheared and mirrored.
fn grids() -> Vec<(&'static str, Grid)> {
    let dims = [40, 36, 33];
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let oblique =
        |m: DMat3| Grid { dims, world_from_index: DAffine3 { matrix3: m, translation: DVec3::new(-31.5, 12.25, 7.0) } };
    vec![
        ("cubes", Grid::aligned(dims, DVec3::ONE, DVec3::ZERO)),
        ("slabs", Grid::aligned(dims, DVec3::new(0.7, 0.9, 2.5), DVec3::new(-14.0, 3.0, 100.0))),
        ("turned", oblique(turned * DMat3::from_diagonal(DVec3::new(0.8, 1.1, 1.7)))),
        ("mirrored", oblique(turned * DMat3::from_diagonal(DVec3::new(-0.8, 1.1, 1.7)))),
        (
            "sheared",
            oblique(DMat3::from_cols(DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.3, 0.9, 0.0), DVec3::new(-0.4, 0.5, 1.6))),
        ),
    ]
}

fn sample(position: DVec3) -> Sample {
    Sample { position, normal: DVec3::Z, pressure: 1.0, breaks: false }
}

fn dab(centre: DVec3, radius_mm: f64) -> Dab {
    Dab { centre, radius_mm, pressure: 1.0, normal: DVec3::Z }
}

fn hard(shape: Shape, radius_mm: f64) -> Brush {
    Brush { shape, radius_mm, falloff: Falloff::Hard, ..Brush::default() }
}

fn voxels(dims: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..dims[2]).flat_map(move |z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| [x, y, z])))
}

fn centre_of(grid: &Grid, v: [u32; 3]) -> DVec3 {
    grid.world_from_index.transform_point3(DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])))
}
