//! What lies under many points of the picture at once, against one ray each.

use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Hit};
use burin::math::{DQuat, DVec2, DVec3, Pose};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn along(stage: &mut Stage, view: &Frame, ends: [DVec2; 2], count: u32) -> Vec<Option<Hit>> {
    let [density, colour, selection, labels] = &stage.fields;
    let fields = one_volume(&stage.grid, density, colour, selection, labels);
    stage.caster.pick_along(&stage.gpu, &mut stage.pools, &fields, view, ends, count).unwrap()
}

fn pick(stage: &mut Stage, view: &Frame, px: DVec2) -> Option<Hit> {
    let [density, colour, selection, labels] = &stage.fields;
    let fields = one_volume(&stage.grid, density, colour, selection, labels);
    stage.caster.pick(&stage.gpu, &mut stage.pools, &fields, view, px).unwrap()
}

#[test]
fn points_along_a_line_of_the_picture_are_hit_as_one_by_one() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([40, 36, 30]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let middle = grid.world_bounds().centre();
    let mut view = frame(&grid, tissue(), DVec3::new(0.6, -1.0, 0.4), [120, 70]);
    view.mode = Mode::Iso(26_000.0);
    let pose = Pose::about(middle, DQuat::from_rotation_z(0.4), DVec3::new(14.0, 3.0, -8.0));
    view.bodies = vec![Body::whole(3), Body { pose, ..Body::whole(5) }];
    let (mut hits, mut seen) = (0, [0; 2]);
    for view in projections(&view) {
        for _ in 0..8 {
            let mut any = || DVec2::new(rng.random_range(-5.0..125.0), rng.random_range(-5.0..75.0));
            let [from, to] = [any(), any()];
            let count = 12;
            let found = along(&mut stage, &view, [from, to], count);
            assert_eq!(found.len(), count as usize);
            for (i, found) in found.into_iter().enumerate() {
                let px = from + (to - from) * ((i + 1) as f64 / f64::from(count));
                let single = pick(&mut stage, &view, px);
                let (Some(a), Some(b)) = (found, single) else {
                    // A silhouette may go either way.
                    seen[0] += usize::from(found.is_some() != single.is_some());
                    continue;
                };
                hits += 1;
                seen[1] += usize::from(a.world.distance(b.world) > 0.05 || a.body != b.body);
                let body = view.bodies.iter().find(|body| body.id == a.body).unwrap();
                assert!(body.pose.apply(a.rest).distance(a.world) < 1e-9);
                let ray = view.camera.ray(px, view.size);
                assert!((a.world - ray.origin).cross(ray.dir).length() < 1e-3, "{px}: on the pixel's own ray");
                assert!((ray.at(a.depth_mm).distance(a.world)) < 1e-3);
            }
        }
    }
    assert!(hits > 60 && seen[0] <= 2 && seen[1] <= 2, "{hits} {seen:?}");
    // No way at all is its one place, over and over.
    let px = view.camera.project(middle, view.size).unwrap().0;
    let one = pick(&mut stage, &view, px);
    assert_eq!(along(&mut stage, &view, [px; 2], 3), [one; 3]);
}

#[test]
fn more_points_than_a_row_holds_go_on_in_the_next() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([30, 12, 8]);
    let mut stage = Stage::new(gpu, grid, density_u16(grid, |_| 40_000));
    let mut view = frame(&grid, tissue(), DVec3::NEG_Y, [64, 32]);
    view.mode = Mode::Iso(30_000.0);
    let ends = [DVec2::new(2.0, 15.0), DVec2::new(61.0, 17.0)];
    let count = 9001;
    let found = along(&mut stage, &view, ends, count);
    assert_eq!(found.len(), count as usize);
    for (i, hit) in found.iter().enumerate() {
        let px = ends[0] + (ends[1] - ends[0]) * ((i + 1) as f64 / f64::from(count));
        let ray = view.camera.ray(px, view.size);
        let Some(hit) = hit else { continue };
        assert!((hit.world - ray.origin).cross(ray.dir).length() < 2e-3, "{i}");
    }
    let met = found.iter().filter(|h| h.is_some()).count();
    assert!(met > 3000 && found[4090..4102].iter().all(Option::is_some), "{met}");
}
