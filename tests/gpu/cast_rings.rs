//! Parts that no order serves: rings in which each lies before the next, and opaque ones in one place.

use super::cast_modes::Stage;
use super::reference::{Dense, picture};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame};
use burin::math::{Aabb, DQuat, DVec3, Pose};
use burin::volume::*;

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = unit_grid([40; 3]);
    Some(Stage::new(gpu, grid, density_u16(grid, |_| 40_000)))
}

fn opaque() -> TransferFunction {
    TransferFunction { colour: vec![(0.0, [1.0; 3])], opacity: vec![(0.0, 1.0)], unit_mm: 1.0 }
}

/// Six bars along the sides of a hexagon about the volume's middle, the end of each laid over the beginning of the next.
fn ring(middle: DVec3) -> Vec<Body> {
    let half = DVec3::new(9.0, 1.5, 0.6);
    let bounds = Aabb { min: middle - half, max: middle + half };
    (0..6)
        .map(|i| {
            let turn = DQuat::from_rotation_z(f64::from(i) * std::f64::consts::TAU / 6.0);
            // Rising along the side.
            let pose = Pose::about(middle, turn * DQuat::from_rotation_y(-0.45), turn * DVec3::Y * -10.4);
            let tint = Some([[1.0, 0.2, 0.2], [0.2, 1.0, 0.2], [0.2, 0.2, 1.0]][i as usize % 3]);
            Body { pose, region: bounds.planes().to_vec(), tint, ..Body::whole(i as u32) }
        })
        .collect()
}

#[test]
fn a_ring_of_parts_each_before_the_next_is_drawn_as_it_lies() {
    let Some(mut stage) = stage() else { return };
    let bodies = ring(stage.grid.world_bounds().centre());
    // No two of them clash: only the ring has no order.
    for (from, size) in [(DVec3::Z, [96, 96]), (DVec3::new(0.2, -0.1, -1.0), [64, 64])] {
        for mode in [Mode::Dvr, Mode::Iso(20_000.0), Mode::Mip] {
            let view = Frame { mode, bodies: bodies.clone(), step_mm: 0.5, ..frame(&stage.grid, opaque(), from, size) };
            let d = stage.compare(&view);
            assert!(d.covered > 0.04 && d.beyond_one < 0.003 && d.misplaced < 0.004, "{mode:?} {d:?}");
            let objects = stage.image(&view).object;
            let seen: std::collections::BTreeSet<u32> =
                objects.into_iter().map(|o| o.body().map_or(0, |id| id + 1)).collect();
            assert_eq!(seen.len(), 7, "nothing and all six: {seen:?}");
        }
    }
}

#[test]
fn opaque_parts_in_one_place_share_its_colour() {
    let Some(mut stage) = stage() else { return };
    let tints = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.6]];
    let bodies: Vec<Body> = (0..3)
        .map(|i| {
            let pose = Pose { translation: DVec3::X * 6.0 * f64::from(i), ..Pose::IDENTITY };
            Body { pose, tint: Some(tints[i as usize]), ..Body::whole(i as u32) }
        })
        .collect();
    let mut view = frame(&stage.grid, opaque(), DVec3::new(0.1, -1.0, 0.1), [48, 40]);
    view.bodies = bodies;
    let image = stage.image(&view);
    assert!(image.colour.iter().flatten().all(|c| c.is_finite()), "no sample is a number by a number without end");
    let all = image.colour.iter().filter(|c| (c[0] - 1.0 / 3.0).abs() < 0.01 && (c[2] - 0.2).abs() < 0.01).count();
    assert!(all > 100, "where all three lie a third of each: {all}");
    let reference = picture(&Dense::of(&stage.fields(), &stage.grid), &view);
    let far = image
        .colour
        .iter()
        .zip(&reference)
        .filter(|(a, b)| (0..4).any(|i| (f64::from(a[i]) - b.colour[i]).abs() > 0.01));
    assert!(far.count() < 20, "but for rays along an edge");
}
