//! Perspective and orthographic pictures of the same place.

use super::driver::{SMALL, Window};
use burin::document::{Command, ViewCommand};
use burin::interact::projected;
use burin::math::{Camera, DVec2, DVec3, Projection};

fn camera() -> Camera {
    let projection = Projection::Perspective { fov_y_deg: 30.0 };
    Camera { eye: DVec3::new(90.0, -40.0, 25.0), target: DVec3::new(3.0, 4.0, 5.0), up: DVec3::Z, projection }
}

#[test]
fn what_lies_at_the_target_keeps_its_size() {
    let perspective = camera();
    let orthographic = projected(&perspective, true);
    let distance = perspective.eye.distance(perspective.target);
    // tan 15° = 2 − √3.
    let height = 2.0 * distance * (2.0 - 3.0_f64.sqrt());
    let Projection::Orthographic { height_mm } = orthographic.projection else { panic!("{orthographic:?}") };
    assert!((height_mm - height).abs() < 1e-9 * height, "{height_mm} {height}");
    // A point in the target's plane, seen by both at the same pixel.
    let size = [640, 480];
    let ray = perspective.ray(DVec2::new(500.0, 100.0), size);
    let forward = perspective.forward();
    let point = ray.origin + ray.dir * (distance / ray.dir.dot(forward));
    let (px, _) = orthographic.project(point, size).unwrap();
    assert!(px.distance(DVec2::new(500.0, 100.0)) < 1e-6, "{px}");
}

#[test]
fn there_and_back_is_the_same_camera_whatever_was_zoomed_between() {
    let there = projected(&camera(), true);
    assert_eq!(projected(&there, true), there);
    let back = projected(&there, false);
    assert!(back.eye.distance(camera().eye) < 1e-9 && back.projection == camera().projection, "{back:?}");
    let zoomed = projected(&there.zoomed(0.5), false);
    assert!(zoomed.eye.distance(camera().zoomed(0.5).eye) < 1e-9, "{zoomed:?}");
}

#[test]
fn a_click_changes_the_projection_and_the_next_changes_it_back() {
    let mut window = Window::open(SMALL);
    let there = projected(&window.scene.views.camera, true);
    let sent = |camera| [Command::View(ViewCommand::Camera { camera })];
    assert_eq!(window.click("Orthographic projection"), sent(there));
    window.scene.views.camera = there;
    window.snapshot(|_| {});
    assert_eq!(window.click("Orthographic projection"), sent(projected(&there, false)));
}
