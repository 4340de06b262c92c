//! Boxes of boxes, boxes that touch, boxes at the volume's border: pictures of all modes beside rays by the book.

use super::reference_family::{Book, Family, parent_on, waves};
use super::reference_family_rays::{Apart, compare};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Look};
use burin::math::{Camera, DVec2, DVec3, Plane, Pose, Projection};
use burin::volume::*;

const DIMS: [u32; 3] = [36, 32, 28];

const fn cube(lo: [u32; 3], hi: [u32; 3], scale: [u32; 3]) -> SubBox {
    SubBox { lo, hi, scale }
}

/// Boxes by the id of what they are cut out of.
type Boxes = Vec<(u32, SubBox)>;

/// A box in a box with three faces in common, and one more in that.
fn nested() -> Boxes {
    let outer = cube([10, 12, 8], [22, 22, 18], [2; 3]);
    let inner = cube([0, 4, 6], [12, 20, 20], [4, 2, 3]);
    vec![(0, outer), (1, inner), (2, cube([10, 8, 20], [30, 24, 32], [1, 2, 1]))]
}

/// Boxes that touch, of samples that have few places in common.
fn touching() -> Boxes {
    vec![
        (0, cube([10, 10, 8], [17, 22, 18], [3; 3])),
        (0, cube([17, 10, 8], [24, 22, 18], [7, 2, 5])),
        (0, cube([10, 10, 18], [24, 22, 24], [2; 3])),
    ]
}

/// A box that ends with the volume.
fn at_the_border() -> Boxes {
    vec![(0, cube([0, 0, 0], [12, 31, 9], [4; 3])), (0, cube([24, 20, 18], [35, 31, 27], [2, 3, 2]))]
}

fn views() -> Vec<Camera> {
    let bounds = unit_grid(DIMS).world_bounds();
    let slanted = Camera::framing(&bounds, DVec3::new(0.5, 1.0, 0.4), DVec3::Z);
    let along = Camera::framing(&bounds, DVec3::X, DVec3::Z);
    let inside = Camera { eye: DVec3::new(14.3, 15.2, 12.6), target: DVec3::new(30.0, 20.0, 10.0), ..slanted };
    // No ray of the second runs along a face.
    vec![slanted, Camera { projection: Projection::Orthographic { height_mm: 39.3 }, ..along }, inside]
}

fn plain(mode: Mode, lighting: Option<Lighting>) -> Frame {
    Frame { mode, lighting, ..frame(&unit_grid(DIMS), ramp(1500.0, 3500.0), DVec3::X, [50, 40]) }
}

#[test]
fn samples_in_boxes_of_boxes_and_in_boxes_that_touch_stand_for_all_of_a_ray() {
    let Some(gpu) = gpu() else { return };
    for (name, boxes) in [("nested", nested()), ("touching", touching()), ("at the border", at_the_border())] {
        let family = Family::new(parent_on(unit_grid(DIMS), waves), &boxes);
        for (at, camera) in views().into_iter().enumerate() {
            for mode in [Mode::Dvr, Mode::Mip] {
                let plain = Frame { camera, ..plain(mode, None) };
                let apart = compare(&family, &gpu, &plain);
                let met = apart.through > 60 || (name, at) == ("at the border", 2);
                assert!(met && apart.furthest <= 1.0, "{name}, view {at}, {mode:?}: {apart:?}");
            }
        }
    }
}

#[test]
fn light_on_matter_in_boxes_is_that_of_the_equations() {
    let Some(gpu) = gpu() else { return };
    for (name, boxes) in [("nested", nested()), ("touching", touching()), ("at the border", at_the_border())] {
        let family = Family::new(parent_on(unit_grid(DIMS), waves), &boxes);
        for camera in views().into_iter().take(2) {
            let plain = Frame { camera, ..plain(Mode::Dvr, Some(Lighting::default())) };
            let apart = compare(&family, &gpu, &plain);
            assert!(apart.through > 60 && apart.furthest <= 1.0, "{name}: {apart:?}");
        }
    }
}

/// A plate thinner than the distance of samples, across the faces of all boxes.
fn plate([x, y, z]: [u32; 3]) -> u16 {
    let off = f64::from(x) * 0.9 + f64::from(y) * 0.35 + f64::from(z) * 0.25 - 22.0;
    (3000.0 * (1.0 - off.abs() * 0.8).max(0.0)) as u16
}

#[test]
fn surfaces_are_found_as_finely_about_a_box_of_a_box_as_in_it() {
    let Some(gpu) = gpu() else { return };
    let family = Family::new(parent_on(unit_grid(DIMS), plate), &nested());
    for camera in views() {
        let plain = Frame { camera, ..plain(Mode::Iso(2000.0), Some(Lighting::default())) };
        let apart = compare(&family, &gpu, &plain);
        let few = apart.through / 100;
        assert!(apart.through > 60 && apart.lost <= few && apart.beyond_one <= few, "{apart:?}");
    }
}

/// What is seen where rays meet the inner box is as whole as by steps that no plate is thin for.
#[test]
fn a_plate_has_no_holes_where_rays_meet_the_finest_box() {
    let Some(gpu) = gpu() else { return };
    let outer = cube([6, 6, 4], [30, 26, 24], [2; 3]);
    let inner = cube([16, 12, 14], [28, 26, 28], [4; 3]);
    let family = Family::new(parent_on(unit_grid(DIMS), plate), &[(0, outer), (1, inner)]);
    let framed = Camera::framing(&unit_grid(DIMS).world_bounds(), DVec3::new(1.0, 0.4, 0.2), DVec3::Z);
    let camera = Camera { projection: Projection::Orthographic { height_mm: 20.0 }, ..framed };
    // Steps of the outer box are longer than the plate is thick.
    let (size, step_mm, level) = ([50, 40], 5.0, 1700.0);
    let plain = Frame { camera, size, step_mm, ..plain(Mode::Iso(level), Some(Lighting::default())) };
    let seen = family.draw(&gpu, &family.with_boxes(&plain));
    let book = Book::of(&family);
    let (mut met, mut holes) = (0, 0);
    for (i, depth) in seen.depth_mm.iter().enumerate() {
        let ray = camera.ray(DVec2::new((i % 50) as f64 + 0.5, (i / 50) as f64 + 0.5), size);
        let dense: Vec<_> = (0..1200).map(|i| ray.at(f64::from(i) * 0.1)).collect();
        // Where the plate is as thick as a step of the inner box, in the outer one, on a ray that goes through both.
        let is_thick = |at: &usize| dense[*at..*at + 8].iter().all(|p| book.value(*p) >= level);
        let place = (0..1190).find(is_thick).filter(|&at| book.holder(dense[at]) == 1);
        let Some(place) = place.filter(|_| dense.iter().any(|p| book.holder(*p) == 2)) else { continue };
        met += 1;
        holes += usize::from(f64::from(*depth) > place as f64 * 0.1 + 0.1);
    }
    assert!(met > 50 && holes == 0, "{holes} holes of {met}");
}

/// Pixels a thousandth of a voxel apart about the faces of boxes: light goes on from each to the next.
#[test]
fn light_on_a_surface_does_not_jump_at_the_faces_of_nested_boxes() {
    let Some(gpu) = gpu() else { return };
    let family = Family::new(parent_on(unit_grid(DIMS), waves), &nested());
    let book = Book::of(&family);
    // Places of the surface on faces: of the outer box, of the inner one, of both.
    let faces = [(0, 10.0), (0, 22.0), (1, 14.0), (2, 11.0), (0, 16.0)];
    let level = 2300.0;
    let mut looked = 0;
    for (axis, at) in faces {
        for across in 0..60 {
            let other = [(axis + 1) % 3, (axis + 2) % 3];
            let place = |u: f64| {
                let mut p = DVec3::ZERO;
                p[axis] = at;
                p[other[0]] = 11.0 + f64::from(across % 10);
                p[other[1]] = u;
                p
            };
            let Some(u) = (90..180).map(|i| f64::from(i) * 0.1).find(|&u| {
                let (a, b) = (book.value(place(u)), book.value(place(u + 0.1)));
                (a < level) != (b < level) && book.holder(place(u)) > 0
            }) else {
                continue;
            };
            // Seen from outside of the matter, along the axis that the surface was found by.
            let mut sight = DVec3::AXES[other[1]] * if book.value(place(u)) < level { 1.0 } else { -1.0 };
            sight[other[0]] += 0.2;
            let middle = place(u + 0.05);
            let eye = middle - sight.normalize() * 1.0;
            let projection = Projection::Orthographic { height_mm: 0.024 };
            let camera = Camera { eye, target: middle, up: DVec3::AXES[axis], projection };
            let light = Lighting { ambient: 0.1, diffuse: 0.7, specular: 0.4, power: 30.0 };
            let size = [4, 24];
            let plain = Frame { camera, size, step_mm: 0.5, ..plain(Mode::Iso(level), Some(light)) };
            let seen = family.draw(&gpu, &family.with_boxes(&plain));
            let rows: Vec<_> = (0..24).map(|y| seen.colour[y * 4 + 1]).collect();
            if rows.iter().any(|c| c[3] < 1.0) {
                continue;
            }
            looked += 1;
            let jump = rows.windows(2).map(|w| (0..3).map(|c| (w[0][c] - w[1][c]).abs()).fold(0.0, f32::max));
            let jump = jump.fold(0.0, f32::max) * 255.0;
            assert!(jump <= 1.0, "axis {axis} at {at}, {middle:?}: light jumps by {jump}");
        }
    }
    assert!(looked > 12, "{looked} places");
}

/// Three parts, each seen in a mode of its own: rendered directly, as a maximum, as a surface that lets light through.
fn of_modes(camera: Camera) -> Frame {
    let cut = |offset| Plane { normal: DVec3::new(1.0, 0.2, 0.1).normalize(), offset };
    let [a, b] = [14.0, 19.0].map(cut);
    let shifted = |x: f64| Pose { translation: DVec3::new(x, 0.4, 0.0), ..Pose::IDENTITY };
    let body = |id, region, pose| Body { region, pose, look: Some(id as usize - 1), ..Body::whole(id) };
    let plain = plain(Mode::Dvr, None);
    let look = |mode, opacity| Look { transfer: ramp(1500.0, 3500.0), mode, lighting: None, opacity };
    Frame {
        camera,
        looks: vec![look(Mode::Dvr, 0.3), look(Mode::Mip, 0.7), look(Mode::Iso(2300.0), 0.5)],
        bodies: vec![
            body(1, vec![a], shifted(-4.0)),
            body(2, vec![a.flipped(), b], Pose::IDENTITY),
            body(3, vec![b.flipped()], shifted(5.0)),
        ],
        ..plain
    }
}

#[test]
fn a_body_and_its_boxes_are_one_maximum_and_one_surface_among_others() {
    let Some(gpu) = gpu() else { return };
    for (name, boxes) in [("nested", nested()), ("touching", touching())] {
        let family = Family::new(parent_on(unit_grid(DIMS), waves), &boxes);
        for camera in views().into_iter().take(2) {
            let apart = compare(&family, &gpu, &of_modes(camera));
            let Apart { through, furthest, beyond_one, .. } = apart;
            // Rays that graze a surface hit it or not by the last bit of their numbers.
            assert!(through > 60 && beyond_one <= through / 400, "{name}: {apart:?}, {furthest}");
        }
    }
}
