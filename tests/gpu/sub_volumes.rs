//! Pictures of volumes of which boxes have a resolution of their own, against rays by the book.
//!
//! A ray takes a sample at every step of the lattice, and from a step that begins in the box as many as the box is finer; each stands for
//! the way to the next one, and what it meets is told by where it lies.

use super::reference_family::{Family, parent_on, waves};
use super::reference_family_rays::compare;
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Image};
use burin::math::{Camera, DVec3, Plane, Pose, Projection};
use burin::volume::*;

pub fn family(dims: [u32; 3], of: &[SubBox]) -> Family {
    let boxes: Vec<_> = of.iter().map(|&of| (0, of)).collect();
    Family::new(parent_on(unit_grid(dims), waves), &boxes)
}

fn views(dims: [u32; 3]) -> Vec<Camera> {
    let bounds = unit_grid(dims).world_bounds();
    let slanted = Camera::framing(&bounds, DVec3::new(0.5, 1.0, 0.4), DVec3::Z);
    let along = Camera::framing(&bounds, DVec3::X, DVec3::Z);
    vec![slanted, Camera { projection: Projection::Orthographic { height_mm: 48.0 }, ..along }]
}

fn worst(a: &Image, b: &Image) -> f32 {
    let pairs = a.colour.iter().flatten().zip(b.colour.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) * 255.0
}

pub const DIMS: [u32; 3] = [44, 40, 36];
pub const INNER: SubBox = SubBox { lo: [12, 20, 10], hi: [26, 34, 24], scale: [4; 3] };

#[test]
fn rays_through_a_box_agree_with_the_equations_and_others_do_not_change_by_a_bit() {
    let Some(gpu) = gpu() else { return };
    for scale in [[4, 4, 4], [3, 2, 1]] {
        let family = family(DIMS, &[SubBox { scale, ..INNER }]);
        for camera in views(DIMS) {
            let transfer = ramp(1500.0, 3500.0);
            let plain = Frame { camera, ..frame(family.volumes[0].grid(), transfer, DVec3::X, [120, 96]) };
            let apart = compare(&family, &gpu, &plain);
            assert!(apart.through > 400 && apart.furthest <= 1.0, "{scale:?}: {apart:?}");
        }
    }
}

#[test]
fn a_box_that_divides_nothing_changes_nothing_to_speak_of_in_any_mode() {
    let Some(gpu) = gpu() else { return };
    let family = family(DIMS, &[SubBox { scale: [1; 3], ..INNER }]);
    let light = Some(Lighting::default());
    for camera in views(DIMS) {
        // Steps so short are marched in several passes.
        const SHORT: Option<f64> = Some(0.004);
        for (mode, lighting, refine, step) in [
            (Mode::Dvr, None, false, None),
            (Mode::Dvr, light, false, None),
            (Mode::Dvr, None, true, None),
            (Mode::Iso(2300.0), light, false, None),
            (Mode::Mip, None, false, None),
            (Mode::Dvr, light, false, SHORT),
            (Mode::Iso(2300.0), light, false, SHORT),
            (Mode::Mip, None, false, SHORT),
        ] {
            let plain = frame(family.volumes[0].grid(), ramp(1500.0, 3500.0), DVec3::X, [120, 96]);
            let step_mm = step.unwrap_or(plain.step_mm);
            let plain = Frame { camera, mode, lighting, refine, step_mm, ..plain };
            let (without, with) = (family.draw(&gpu, &plain), family.draw(&gpu, &family.with_boxes(&plain)));
            let off = worst(&without, &with);
            assert!(off <= 1.0, "{mode:?} {lighting:?} refine {refine} step {step_mm}: {off} of 255");
            let depth = without.depth_mm.iter().zip(&with.depth_mm);
            let lost = depth.filter(|(a, b)| a.is_finite() != b.is_finite()).count();
            assert_eq!(lost, 0, "{mode:?} {lighting:?} refine {refine} step {step_mm}");
        }
    }
}

#[test]
fn a_surface_goes_on_through_the_faces_of_boxes_without_a_hole_or_a_step_of_light() {
    let Some(gpu) = gpu() else { return };
    // Boxes that touch, and a part's plane through one of them.
    let second = SubBox { lo: [26, 20, 10], hi: [38, 34, 24], scale: [8, 2, 5] };
    // A ramp along a slant: its surface is a plane, and so it has one light.
    let slant = |[x, y, z]: [u32; 3]| (x * 20 + y * 60 + z * 20) as u16;
    let family = Family::new(parent_on(unit_grid(DIMS), slant), &[(0, INNER), (0, second)]);
    let cut = Plane { normal: DVec3::new(1.0, 0.2, 0.0).normalize(), offset: 24.0 };
    let parts = vec![
        Body { region: vec![cut], ..Body::whole(1) },
        Body {
            region: vec![cut.flipped()],
            pose: Pose { translation: DVec3::new(9.0, 0.0, 0.0), ..Pose::IDENTITY },
            ..Body::whole(2)
        },
    ];
    for bodies in [vec![Body::whole(0)], parts] {
        for camera in views(DIMS) {
            let looks = frame(family.volumes[0].grid(), ramp(0.0, 4000.0), DVec3::X, [160, 128]);
            let mode = Mode::Iso(2450.0);
            let plain = Frame { camera, mode, lighting: Some(Lighting::default()), bodies: bodies.clone(), ..looks };
            let (without, with) = (family.draw(&gpu, &plain), family.draw(&gpu, &family.with_boxes(&plain)));
            let depth = without.depth_mm.iter().zip(&with.depth_mm);
            let holes = depth.clone().filter(|(a, b)| a.is_finite() != b.is_finite()).count();
            let off = depth.filter(|(a, _)| a.is_finite()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(holes == 0 && off < 0.01, "{} bodies: {holes} holes, {off} mm off", bodies.len());
            let light = worst(&without, &with);
            assert!(light <= 1.0, "{} bodies: {light} of 255", bodies.len());
        }
    }
}
