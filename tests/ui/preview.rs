//! What a splitter is about to cut and where parts end, against the planes that the splitters are defined by.

use super::scene;
use burin::document::{SlicePlane, ViewName};
use burin::explode::{Axis, Poses};
use burin::interact::preview;
use burin::interact::{Aim, CutSlice, Hit, Tool};
use burin::math::{DVec2, DVec3, Plane, Pose};

const SIZE: [u32; 2] = [400, 300];

#[test]
fn a_preview_is_the_cut_that_a_click_makes() {
    let (grid, scene) = scene();
    let shift = DVec3::new(3.0, -2.0, 1.0);
    let id = scene.explosion.parts[0].id;
    for pose in [Pose::IDENTITY, Pose { translation: shift, ..Pose::IDENTITY }] {
        let poses = Poses::found(&scene.explosion.parts, &[pose]);
        let camera = scene.views.camera;
        let world = grid.world_bounds().centre() + DVec3::new(5.0, 7.0, -3.0);
        let (px, depth_mm) = camera.project(world, SIZE).unwrap();
        let hit = Some(Hit { world, part: Some(id), depth_mm });
        let aim = |hit| Aim::Solid { px, size: SIZE, hit };
        let (right, up) = camera.right_up();
        let forward = camera.forward();
        let sight = world - camera.eye;
        for (tool, axis, normal) in [
            (Tool::AxisSplit, Axis::Horizontal, sight.cross(right)),
            (Tool::AxisSplit, Axis::Vertical, sight.cross(up)),
            (Tool::DepthSplit, Axis::Horizontal, forward),
        ] {
            let cuts = preview::cuts((tool, None), (&scene, &poses), aim(hit), axis);
            assert_eq!(cuts.len(), 1, "{tool:?} {axis:?}");
            assert_eq!(cuts[0].part, id);
            let plane = cuts[0].plane;
            assert!(plane.normal.cross(normal.normalize()).length() < 1e-9, "{tool:?} {axis:?}: {plane:?}");
            assert!(plane.distance(world - pose.translation).abs() < 1e-6, "{tool:?} {axis:?}: at rest");
            assert_eq!(preview::cuts((tool, None), (&scene, &poses), aim(None), axis), []);
        }
        let (from, to) = (px - DVec2::new(300.0, 10.0), px + DVec2::new(300.0, 10.0));
        let line = Some([from, to]);
        let cuts = preview::cuts((Tool::LineSplit, line), (&scene, &poses), aim(hit), Axis::Horizontal);
        let (a, b) = (camera.ray(from, SIZE).dir, camera.ray(to, SIZE).dir);
        assert_eq!(cuts.len(), 1);
        assert!(cuts[0].plane.normal.cross(a.cross(b).normalize()).length() < 1e-9, "{cuts:?}");
        assert!(cuts[0].plane.distance(camera.eye - pose.translation).abs() < 1e-6, "{cuts:?}");
        let beside = Some([DVec2::ZERO, DVec2::X]);
        let past = preview::cuts((Tool::LineSplit, beside), (&scene, &poses), aim(None), Axis::Horizontal);
        assert_eq!(past, []);
        assert_eq!(preview::cuts((Tool::Navigate, None), (&scene, &poses), aim(hit), Axis::Horizontal), []);
    }
    assert_eq!(scene.explosion.parts.len(), 1, "only a copy is cut");
}

#[test]
fn a_cut_that_would_only_graze_is_none() {
    let (grid, scene) = scene();
    let slice = CutSlice::new(&grid, &scene, ViewName::Axial, SIZE).unwrap();
    let inside = slice.plane.pixel(grid.world_bounds().centre());
    let outside = slice.plane.pixel(grid.world_bounds().max + DVec3::splat(20.0));
    let placed = (&scene, &Poses::default());
    let cuts = |px| preview::cuts((Tool::AxisSplit, None), placed, Aim::Slice { px, slice }, Axis::Horizontal);
    assert_eq!(cuts(inside).len(), 1);
    assert_eq!(cuts(outside), []);
}

#[test]
fn borders_of_parts_lie_where_the_cut_was_and_end_at_the_volume() {
    let (grid, mut scene) = scene();
    let bounds = grid.world_bounds();
    let whole = scene.explosion.parts[0].clone();
    assert_eq!(preview::seams(&whole).count(), 0, "the volume's own faces are none");
    let cut = Plane::through(bounds.centre() + DVec3::new(2.0, 1.0, 0.0), DVec3::new(1.0, 0.4, 0.2)).unwrap();
    let halves = scene.explosion.split_at_rest(whole.id, &cut).unwrap().unwrap();
    // Slices show parts at rest: a pose makes no difference.
    scene.explosion.place(halves[0], Pose { translation: DVec3::splat(30.0), ..Pose::IDENTITY }).unwrap();
    for view in [ViewName::Axial, ViewName::Coronal, ViewName::Sagittal] {
        let slice = SlicePlane::new(&grid, &scene.views, view).unwrap();
        let normal = slice.right.cross(slice.up).normalize();
        for id in halves {
            let part = scene.explosion.part(id).unwrap();
            let seams: Vec<Plane> = preview::seams(part).collect();
            assert_eq!(seams.len(), 1);
            let ends = preview::crossing(part, &seams[0], &slice).unwrap();
            for end in ends {
                assert!(cut.distance(end).abs() < 1e-6 && (end - slice.centre).dot(normal).abs() < 1e-6, "{view:?}");
                let out = (end - end.clamp(bounds.min, bounds.max)).length();
                let on_border =
                    (0..3).any(|a| (end[a] - bounds.min[a]).abs() < 1e-6 || (end[a] - bounds.max[a]).abs() < 1e-6);
                assert!(out < 1e-6 && on_border, "{view:?}: {end} of {bounds:?}");
            }
            assert!(ends[0].distance(ends[1]) > 5.0, "{view:?}: {ends:?}");
        }
        let beside = Plane::through(bounds.max + DVec3::splat(50.0), DVec3::new(1.0, 0.4, 0.2)).unwrap();
        assert_eq!(preview::crossing(&whole, &beside, &slice), None);
        let within = Plane::through(slice.centre, normal).unwrap();
        assert_eq!(preview::crossing(&whole, &within, &slice), None, "a plane that is the slice has no line on it");
    }
}
