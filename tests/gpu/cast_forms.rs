//! The caster's two forms give the same picture to the bit.

use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::cast::tiles::Window;
use burin::gpu::{Body, CutMesh, Form, Frame, Image, Layers, Mask, ObjectId, OpaqueMesh, Overlay};
use burin::math::{Aabb, DQuat, DVec2, DVec3, Plane, Pose};
use burin::mesh::TriangleMesh;
use burin::volume::*;
use std::sync::Arc;

const MODES: [Mode; 3] = [Mode::Dvr, Mode::Iso(26_000.0), Mode::Mip];

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([50, 40, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    stage.fields[2] = painted(FieldKind::Selection, &grid, |v| [if v[0] > 25 { (v[1] * 6) as u8 } else { 0 }, 0, 0, 0]);
    stage.fields[1] = painted(FieldKind::Colour, &grid, |v| [200, (v[2] * 7) as u8, 30, (v[1] * 6) as u8]);
    Some(stage)
}

/// One body; parts that moved apart and the selection at rest; bodies one in another.
fn arrangements(grid: &Grid) -> [Vec<Body>; 3] {
    let centre = grid.world_bounds().centre();
    let mut parts: Vec<Body> = (0..4)
        .map(|i| {
            let plane = |normal: DVec3, bit: u32| {
                let normal = if i >> bit & 1 == 1 { -normal } else { normal };
                Plane::through(centre, normal).unwrap()
            };
            let region = vec![plane(DVec3::new(0.9, 0.2, 0.1), 0), plane(DVec3::new(-0.1, 0.3, 0.8), 1)];
            let pose = Pose::about(centre, DQuat::from_rotation_z(0.1 * f64::from(i)), region[0].normal * -6.0);
            let tint = (i == 2).then_some([0.5, 1.0, 0.7]);
            Body { pose, region, mask: Mask::Background, tint, ..Body::whole(20 + i) }
        })
        .collect();
    parts.push(Body { mask: Mask::Selection, ..Body::whole(1) });
    let turned = Pose::about(centre, DQuat::from_rotation_x(0.9), DVec3::new(3.0, -2.0, 1.0));
    [vec![Body::whole(0)], parts, vec![Body::whole(0), Body { pose: turned, ..Body::whole(1) }]]
}

fn both(stage: &mut Stage, draw: impl Fn(&mut Stage) -> Image) -> [Image; 2] {
    let before = stage.caster.form();
    let images = [Form::Fragments, Form::Workgroups].map(|form| {
        stage.caster.set_form(form);
        draw(stage)
    });
    stage.caster.set_form(before);
    images
}

fn part(stage: &mut Stage, frame: &Frame, window: &Window) -> Image {
    let Stage { gpu, pools, caster, grid, fields: [density, colour, selection, labels], .. } = stage;
    let fields = one_volume(grid, density, colour, selection, labels);
    caster.part(gpu, pools, &fields, frame, window).unwrap()
}

#[test]
fn fragments_and_workgroups_draw_one_picture_to_the_bit() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let overlay = Overlay { colour: 0.7, selection: 0.5, selection_colour: [1.0, 0.2, 0.1], ..Overlay::default() };
    for bodies in arrangements(&grid) {
        // Sizes that no tile divides.
        let mut view = frame(&grid, tissue(), DVec3::new(0.8, -1.4, 0.9), [45, 37]);
        (view.bodies, view.overlay) = (bodies, overlay.clone());
        for view in projections(&view) {
            for mode in MODES {
                for lighting in [None, Some(Lighting::default())] {
                    let view = Frame { mode, lighting, ..view.clone() };
                    let [fragments, workgroups] = both(&mut stage, |s| s.image(&view));
                    assert!(
                        fragments.object.iter().filter(|o| **o != ObjectId::NOTHING).count() > 100,
                        "something shows"
                    );
                    assert_eq!(fragments, workgroups, "{mode:?} {lighting:?}");
                }
            }
        }
    }
}

#[test]
fn parts_of_pictures_points_and_long_rays_are_the_same_in_both_forms() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    for bodies in arrangements(&grid) {
        let mut view = frame(&grid, tissue(), DVec3::new(0.8, -1.4, 0.9), [45, 37]);
        view.bodies = bodies;
        for mode in MODES {
            let view = Frame { mode, ..view.clone() };
            for (origin, size) in [([3.0, 5.0], [1, 1]), ([7.25, 11.5], [23, 3]), ([0.0, 20.0], [45, 9])] {
                let window = Window { picture: view.size, origin: DVec2::from_array(origin), size, only: None };
                let [fragments, workgroups] = both(&mut stage, |s| part(s, &view, &window));
                assert_eq!(fragments, workgroups, "{mode:?} {window:?}");
            }
            let points = [Form::Fragments, Form::Workgroups].map(|form| {
                stage.caster.set_form(form);
                let Stage { gpu, pools, caster, grid, fields: [density, colour, selection, labels], .. } = &mut stage;
                let fields = one_volume(grid, density, colour, selection, labels);
                let ends = [DVec2::new(5.0, 6.0), DVec2::new(40.0, 30.0)];
                let along = caster.pick_along(gpu, pools, &fields, &view, ends, 37).unwrap();
                let one = caster.pick(gpu, pools, &fields, &view, DVec2::new(22.0, 18.0)).unwrap();
                (along, one)
            });
            assert!(points[0].0.iter().flatten().count() > 3);
            assert_eq!(points[0], points[1], "{mode:?}");
            // Several passes, each after what the one before it left.
            let long = Frame { step_mm: 0.004, size: [7, 5], ..view };
            let [fragments, workgroups] = both(&mut stage, |s| s.image(&long));
            assert_eq!(fragments, workgroups, "{mode:?} over many passes");
        }
    }
}

#[test]
fn layers_are_the_same_in_both_forms() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let centre = grid.world_bounds().centre();
    let cuboid = |half: [f64; 3]| {
        let half = DVec3::from_array(half);
        Arc::new(TriangleMesh::cuboid(&Aabb { min: -half, max: half }))
    };
    let pose = |turn: f64, off: DVec3| Pose::about(DVec3::ZERO, DQuat::from_rotation_y(turn), centre + off);
    let layers = Layers {
        opaque: vec![OpaqueMesh {
            id: 99,
            mesh: cuboid([5.0, 3.0, 8.0]),
            pose: pose(0.4, DVec3::X * 4.0),
            colour: [0.2, 0.7, 0.9],
            lighting: Some(Lighting::default()),
        }],
        cuts: vec![CutMesh { id: 0, mesh: cuboid([8.0, 6.0, 5.0]), pose: pose(1.1, DVec3::NEG_Y * 6.0) }],
        clips: vec![Plane::through(centre + DVec3::Z * 9.0, DVec3::new(0.1, 0.2, 1.0)).unwrap()],
        ..Layers::default()
    };
    for bodies in arrangements(&grid) {
        let mut view = frame(&grid, tissue(), DVec3::new(0.8, -1.4, 0.9), [45, 37]);
        (view.bodies, view.layers) = (bodies, layers.clone());
        view.transfer.opacity.iter_mut().for_each(|p| p.1 *= 0.12);
        for mode in [Mode::Dvr, Mode::Iso(44_000.0), Mode::Mip] {
            for (step_mm, size) in [(0.8, [29, 21]), (0.006, [7, 5])] {
                let view = Frame { mode, step_mm, size, ..view.clone() };
                let [fragments, workgroups] = both(&mut stage, |s| s.image(&view));
                assert!(fragments.object.iter().any(|o| o.body() == Some(99)), "the mesh shows");
                assert_eq!(fragments, workgroups, "{mode:?} {step_mm}");
            }
        }
    }
}
