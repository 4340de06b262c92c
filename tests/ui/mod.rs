//! The window and its tools: pure state machines, panels driven by accessible names, and one real window.

mod answers;
mod browse;
mod browser;
mod brush_panel;
mod busy;
mod curve;
mod devices;
mod driver;
mod duties;
mod files;
mod footprint;
mod glance;
mod interact;
mod layout;
mod look_menu;
mod looks;
mod meaning;
mod names;
mod painted;
mod points;
mod preview;
mod projection;
mod reach;
mod real;
mod recent;
mod replies;
mod rescue;
mod saving;
mod shown;
mod slices;
mod sub_volumes;
mod surface;
mod swatches;
mod tooltips;
mod typed;
mod untouched;
mod volumes;
mod window;
mod worker;
mod written;

use burin::document::{Origin, Scene, VolumeSettings};
use burin::math::DVec3;
use burin::volume::{Grid, Histogram};

/// 64 × 64 × 32 voxels of 1 × 1 × 2 mm, values 0 to 100, nothing painted.
fn scene() -> (Grid, Scene) {
    let grid = Grid::aligned([64, 64, 32], DVec3::new(1.0, 1.0, 2.0), DVec3::ZERO);
    let histogram =
        Histogram { min: 0.0, max: 100.0, bins: (0..50).map(|i| 1000 / (i + 1)).collect(), ..Histogram::default() };
    let scene = Scene::new(
        &grid,
        &histogram,
        VolumeSettings::new("small", Origin { path: "small.nii".into(), component: 0, frame: 0 }),
    );
    (grid, scene)
}
