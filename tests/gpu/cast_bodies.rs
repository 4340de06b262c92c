//! Lists of bodies against the reference: overlapping, exploded, masked, painted, united.

use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Mask, Overlay};
use burin::math::{Aabb, DQuat, DVec3, Plane, Pose};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn any(rng: &mut ChaCha8Rng, s: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)))
}

/// Boxes of index space as regions in world mm at rest, cut in `n` along each axis.
fn blocks(grid: &Grid, n: [u32; 3]) -> Vec<Vec<Plane>> {
    let whole = grid.index_bounds();
    let to_world = |plane: &Plane| {
        let point = grid.world_from_index.transform_point3(plane.normal * plane.offset);
        Plane::through(point, grid.index_from_world().matrix3.transpose() * plane.normal).unwrap()
    };
    let mut out = Vec::new();
    for i in 0..n[0] * n[1] * n[2] {
        let at = DVec3::new(f64::from(i % n[0]), f64::from(i / n[0] % n[1]), f64::from(i / (n[0] * n[1])));
        let count = DVec3::new(f64::from(n[0]), f64::from(n[1]), f64::from(n[2]));
        let size = whole.max - whole.min;
        let bounds = Aabb { min: whole.min + at / count * size, max: whole.min + (at + 1.0) / count * size };
        out.push(bounds.planes().iter().map(to_world).collect());
    }
    out
}

fn centre(grid: &Grid) -> DVec3 {
    grid.world_bounds().centre()
}

fn region_centre(grid: &Grid, region: &[Plane]) -> DVec3 {
    let inside = |p: &DVec3| region.iter().all(|f| f.distance(*p) <= 0.0);
    let dims = grid.dims;
    let at = each([12; 3], |v| DVec3::from_array(std::array::from_fn(|a| f64::from(v[a] * dims[a]) / 12.0)));
    let points: Vec<DVec3> = at.into_iter().map(|p| grid.world_from_index.transform_point3(p)).filter(inside).collect();
    points.iter().sum::<DVec3>() / points.len() as f64
}

pub(super) fn exploded(grid: &Grid, n: [u32; 3], spread: f64, mask: Mask) -> Vec<Body> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let part = |(i, region): (usize, Vec<Plane>)| {
        let middle = region_centre(grid, &region);
        let turn = DQuat::from_scaled_axis(any(&mut rng, 0.2) * spread);
        let pose = Pose::about(middle, turn, (middle - centre(grid)) * spread);
        Body { pose, region, mask, ..Body::whole(10 + i as u32) }
    };
    blocks(grid, n).into_iter().enumerate().map(part).collect()
}

/// A soft ball off the middle.
pub(super) fn soft_ball(grid: &Grid) -> Field {
    let grid = *grid;
    painted(FieldKind::Selection, &grid, move |v| {
        let p = DVec3::from_array(std::array::from_fn(|a| f64::from(v[a]) / f64::from(grid.dims[a]) - 0.45));
        [((0.32 - p.length()) * 1400.0).clamp(0.0, 255.0) as u8, 0, 0, 0]
    })
}

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([66, 44, 36]);
    Some(Stage::new(gpu, grid, lumps(grid)))
}

pub(super) fn wide(grid: &Grid, bodies: Vec<Body>) -> Frame {
    let mut view = frame(grid, tissue(), DVec3::new(1.0, -1.6, 0.8), [56, 48]);
    view.camera = view.camera.zoomed(1.3);
    view.bodies = bodies;
    view
}

#[test]
fn five_overlapping_boxes_in_random_poses_add_their_extinctions() {
    let Some(mut stage) = stage() else { return };
    for seed in 0..2 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let grid = stage.grid;
        let bodies: Vec<Body> = (0..5)
            .map(|id| {
                let middle = centre(&grid) + any(&mut rng, 6.0);
                let turn = DQuat::from_scaled_axis(any(&mut rng, 2.0));
                let half = any(&mut rng, 6.0).abs() + 9.0;
                let around = |p: &Plane| Plane { offset: p.offset + p.normal.dot(middle), ..*p };
                let region = Aabb { min: -half, max: half }.planes().iter().map(around).collect();
                let tint = Some(std::array::from_fn(|_| rng.random_range(0.2..1.0)));
                let pose = Pose::about(middle, turn, any(&mut rng, 8.0));
                Body { pose, region, tint, ..Body::whole(id) }
            })
            .collect();
        for view in projections(&wide(&grid, bodies)) {
            for lighting in [None, Some(Lighting::default())] {
                let d = stage.compare(&Frame { lighting, ..view.clone() });
                assert!(d.covered > 0.03 && d.largest <= 3.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
            }
            let d = stage.compare(&Frame { mode: Mode::Mip, ..view.clone() });
            assert!(d.largest <= 1.0, "{d:?}");
            let d = stage.compare(&Frame { mode: Mode::Iso(26_000.0), ..view.clone() });
            assert!(d.beyond_one < 0.01 && d.misplaced < 0.01, "{d:?}");
        }
    }
}

#[test]
fn many_intervals_merge_in_one_ray() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let grid = stage.grid;
    // More than the smallest capacities, all over one another; thin matter, so that all of them count.
    let bodies = (0..21)
        .map(|id| {
            let pose = Pose::about(centre(&grid), DQuat::from_scaled_axis(any(&mut rng, 3.0)), any(&mut rng, 5.0));
            Body { id, pose, ..Body::whole(id) }
        })
        .collect();
    let mut view = wide(&grid, bodies);
    view.size = [32, 24];
    view.transfer.opacity.iter_mut().for_each(|p| p.1 *= 0.05);
    let d = stage.compare(&view);
    assert!(d.covered > 0.03 && d.largest <= 3.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
}

#[test]
fn intervals_merge_over_many_passes_beside_tiles_that_hold_nothing() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let grid = stage.grid;
    // All but one in a heap, and that one far off; a sample of the heap costs so much that a ray takes several passes.
    let bodies = (0..24)
        .map(|id| {
            let off = if id == 23 { DVec3::X * 300.0 } else { any(&mut rng, 4.0) };
            let pose = Pose::about(centre(&grid), DQuat::from_scaled_axis(any(&mut rng, 3.0)), off);
            Body { id, pose, ..Body::whole(id) }
        })
        .collect();
    let mut view = wide(&grid, bodies);
    view.size = [12, 8];
    view.step_mm = 0.3;
    view.transfer.opacity.iter_mut().for_each(|p| p.1 *= 0.02);
    let d = stage.compare(&view);
    assert!(d.covered > 0.03 && d.largest <= 3.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
}

#[test]
fn exploded_parts_are_drawn_where_their_poses_put_them() {
    let Some(mut stage) = stage() else { return };
    for n in [[2, 2, 2], [4, 4, 4]] {
        let view = wide(&stage.grid, exploded(&stage.grid, n, 0.4, Mask::None));
        for view in projections(&view) {
            for lighting in [None, Some(Lighting::default())] {
                let d = stage.compare(&Frame { lighting, ..view.clone() });
                assert!(d.covered > 0.03 && d.largest <= 3.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
            }
            let lighting = Some(Lighting::default());
            let d = stage.compare(&Frame { mode: Mode::Iso(26_000.0), lighting, ..view });
            assert!(d.covered > 0.1 && d.beyond_one < 0.01 && d.misplaced < 0.01, "{d:?}");
        }
    }
}

#[test]
fn the_selection_stays_and_the_parts_carry_the_background_away() {
    let Some(mut stage) = stage() else { return };
    stage.fields[2] = soft_ball(&stage.grid);
    let mut bodies = exploded(&stage.grid, [2, 2, 2], 0.5, Mask::Background);
    bodies.push(Body { mask: Mask::Selection, ..Body::whole(1) });
    let mut view = wide(&stage.grid, bodies);
    view.overlay = Overlay { selection: 0.6, selection_colour: [0.9, 0.2, 0.3], ..Overlay::default() };
    for lighting in [None, Some(Lighting::default())] {
        let d = stage.compare(&Frame { lighting, ..view.clone() });
        assert!(d.covered > 0.03 && d.largest <= 3.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
        let d = stage.compare(&Frame { mode: Mode::Iso(26_000.0), lighting, ..view.clone() });
        assert!(d.beyond_one < 0.01 && d.misplaced < 0.01, "{d:?}");
    }
    // Where s is ½ to the GPU's last digit, a sample may fall to either side.
    let d = stage.compare(&Frame { mode: Mode::Mip, ..view });
    assert!(d.beyond_one < 0.002 && d.mean < 0.2, "{d:?}");
}

#[test]
fn parts_at_rest_with_their_selection_are_the_volume() {
    let Some(mut stage) = stage() else { return };
    stage.fields[2] = soft_ball(&stage.grid);
    let mut bodies = exploded(&stage.grid, [4, 4, 4], 0.0, Mask::Background);
    bodies.push(Body { mask: Mask::Selection, ..Body::whole(1) });
    for lighting in [None, Some(Lighting::default())] {
        for mode in [Mode::Dvr, Mode::Mip, Mode::Iso(26_000.0)] {
            let parts = Frame { lighting, mode, ..wide(&stage.grid, bodies.clone()) };
            let whole = Frame { bodies: vec![Body::whole(0)], ..parts.clone() };
            let (united, volume) = (stage.image(&parts), stage.image(&whole));
            assert_eq!(united.colour, volume.colour, "{mode:?}: the same picture to the bit");
            assert_eq!(united.depth_mm, volume.depth_mm);
            if mode != Mode::Dvr {
                continue;
            }
            // Each on its own, in order of sight or merged, they still give it.
            stage.caster.shortcuts = false;
            let apart = stage.image(&parts);
            stage.caster.shortcuts = true;
            let worst = |a: &[f32; 4], b: &[f32; 4]| (0..4).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max);
            let off = apart.colour.iter().zip(&volume.colour).map(|(a, b)| worst(a, b)).fold(0.0, f32::max);
            assert!(off <= 1.0 / 255.0, "{off}");
            // Objects are those of the parts.
            let d = stage.compare(&parts);
            assert!(d.misplaced < 0.01 && d.largest <= 3.0, "{d:?}");
        }
    }
}

#[test]
fn painted_fields_colour_what_the_table_shows() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    stage.fields[1] = painted(FieldKind::Colour, &grid, |v| {
        [(v[0] * 3) as u8, 40, (v[2] * 6) as u8, if v[1] > 20 { 200 } else { 30 }]
    });
    stage.fields[2] = soft_ball(&grid);
    stage.fields[3] = painted(FieldKind::Labels, &grid, |v| {
        let [a, b] = (if v[0] > 30 {
            2_u16
        } else if v[2] > 20 {
            300
        } else {
            0
        })
        .to_le_bytes();
        [a, b, 0, 0]
    });
    let mut segments = Segments::default();
    segments.ensure(2);
    segments.ensure(300);
    let overlay = Overlay { colour: 0.8, labels: 0.5, selection: 0.7, selection_colour: [1.0, 0.1, 0.2], segments };
    let mut hidden = overlay.clone();
    hidden.segments.get_mut(300).unwrap().visible = false;
    let only = |f: fn(&mut Overlay)| {
        let mut one = Overlay { segments: overlay.segments.clone(), ..Overlay::default() };
        f(&mut one);
        one
    };
    let each = [only(|o| o.colour = 1.0), only(|o| o.labels = 1.0), only(|o| o.selection = 1.0), overlay, hidden];
    for overlay in each {
        for mode in [Mode::Dvr, Mode::Mip, Mode::Iso(26_000.0)] {
            let view = Frame { overlay: overlay.clone(), mode, ..wide(&grid, vec![Body::whole(0)]) };
            let d = stage.compare(&view);
            // Eight bits a channel of a sampler's weights and of a segment's colour.
            assert!(d.beyond_one < 0.02 && d.mean < 0.2, "{mode:?} {overlay:?}: {d:?}");
        }
    }
}

#[test]
fn skipping_changes_no_picture() {
    let Some(mut stage) = stage() else { return };
    stage.fields[2] = soft_ball(&stage.grid);
    let mut bodies = exploded(&stage.grid, [2, 2, 2], 0.5, Mask::Background);
    bodies.push(Body { mask: Mask::Selection, ..Body::whole(1) });
    for bodies in [vec![Body::whole(0)], bodies] {
        for mode in [Mode::Dvr, Mode::Mip, Mode::Iso(26_000.0)] {
            for view in
                projections(&Frame { mode, lighting: Some(Lighting::default()), ..wide(&stage.grid, bodies.clone()) })
            {
                let fast = stage.image(&view);
                stage.caster.shortcuts = false;
                let plain = stage.image(&view);
                stage.caster.shortcuts = true;
                let off = fast.colour.iter().flatten().zip(plain.colour.iter().flatten());
                let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 1e-5, "{mode:?}: {off}");
                let differing = fast.depth_mm.iter().zip(&plain.depth_mm).filter(|(a, b)| a != b).count();
                assert_eq!(differing, 0, "{mode:?}");
            }
        }
    }
}
