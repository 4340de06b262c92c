//! Lines of parts and of the cut to come, against the planes that the splitters are defined by.

use super::scene;
use burin::explode::{Axis, PartId, depth_plane};
use burin::interact::{Gesture, Hit, Tool, preview};
use burin::math::{DQuat, DVec2, DVec3, Pose};

const SIZE: [u32; 2] = [400, 300];

/// Distances of a ring's corners from a plane through a point.
fn off(ring: &[DVec3], through: DVec3, normal: DVec3) -> f64 {
    ring.iter().map(|c| (*c - through).dot(normal.normalize()).abs()).fold(0.0, f64::max)
}

#[test]
fn a_preview_is_the_cut_that_a_click_makes() {
    let (grid, scene) = scene();
    let camera = scene.views.camera;
    let bounds = grid.world_bounds();
    let world = bounds.centre() + DVec3::new(5.0, 7.0, -3.0);
    let (px, depth_mm) = camera.project(world, SIZE).unwrap();
    let hit = Some(Hit { world, part: Some(scene.explosion.parts[0].id), depth_mm });
    let (right, up) = camera.right_up();
    let forward = camera.forward();
    let sight = world - camera.eye;
    for (tool, axis, normal) in [
        (Tool::AxisSplit, Axis::Horizontal, sight.cross(right)),
        (Tool::AxisSplit, Axis::Vertical, sight.cross(up)),
        (Tool::DepthSplit, Axis::Horizontal, forward),
    ] {
        let rings = preview::cuts((tool, None), &scene, (px, SIZE), hit, axis);
        assert_eq!(rings.len(), 1, "{tool:?} {axis:?}");
        assert!(rings[0].len() >= 4, "a box is cut across: {rings:?}");
        assert!(off(&rings[0], world, normal) < 1e-6, "{tool:?} {axis:?}: {rings:?}");
        let out = |c: &DVec3| (*c - c.clamp(bounds.min, bounds.max)).length();
        assert!(rings[0].iter().all(|c| out(c) < 1e-6), "{rings:?}");
        assert_eq!(preview::cuts((tool, None), &scene, (px, SIZE), None, axis), Vec::<Vec<DVec3>>::new());
    }
    let (from, to) = (px - DVec2::new(300.0, 10.0), px + DVec2::new(300.0, 10.0));
    let line = Gesture::Line { from, to };
    let rings = preview::cuts((Tool::LineSplit, Some(&line)), &scene, (px, SIZE), hit, Axis::Horizontal);
    let (a, b) = (camera.ray(from, SIZE).dir, camera.ray(to, SIZE).dir);
    assert_eq!(rings.len(), 1);
    assert!(off(&rings[0], camera.eye, a.cross(b)) < 1e-6, "{rings:?}");
    assert_eq!(scene.explosion.parts.len(), 1, "only a copy is cut");
}

#[test]
fn seams_are_the_cut_faces_where_the_part_stands() {
    let (grid, mut scene) = scene();
    assert_eq!(preview::seams(&scene.explosion.parts[0]), Vec::<Vec<DVec3>>::new(), "the volume's own faces are none");
    let centre = grid.world_bounds().centre();
    let plane = depth_plane(&scene.views.camera, centre).unwrap();
    let [near, _]: [PartId; 2] = scene.explosion.split(scene.explosion.parts[0].id, &plane).unwrap().unwrap();
    let part = scene.explosion.part_mut(near).unwrap();
    part.pose = Pose { rotation: DQuat::from_rotation_z(0.5), translation: DVec3::new(0.0, 40.0, 3.0) };
    let (part, forward) = (part.clone(), scene.views.camera.forward());
    let rings = preview::seams(&part);
    assert_eq!(rings.len(), 1);
    let turned = DQuat::from_rotation_z(0.5);
    let through = turned * centre + DVec3::new(0.0, 40.0, 3.0);
    assert!(off(&rings[0], through, turned * forward) < 1e-6, "{rings:?}");
}
