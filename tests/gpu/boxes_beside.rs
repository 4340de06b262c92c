//! Boxes among what else a picture can have: other volumes, oblique grids, poses, planes that cut and clip, stretches; beside rays by
//! the book.

use super::cast_modes::oblique_grid;
use super::reference_family::{Family, parent_on, waves};
use super::reference_family_rays::{Apart, compare, compare_boxed};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Layers, Look, Mask};
use burin::math::{Camera, DQuat, DVec3, Plane, Pose};
use burin::volume::*;

const DIMS: [u32; 3] = [36, 32, 28];

fn nested() -> Vec<(u32, SubBox)> {
    let outer = SubBox { lo: [10, 12, 8], hi: [22, 22, 18], scale: [2; 3] };
    vec![(0, outer), (1, SubBox { lo: [0, 4, 6], hi: [12, 20, 20], scale: [4, 2, 3] })]
}

/// Another volume about the same place.
fn beside() -> Volume {
    let mut grid = oblique_grid([30, 26, 22]);
    grid.world_from_index.translation = DVec3::new(4.0, 6.0, 12.0);
    parent_on(grid, |[x, y, z]| waves([y + 7, z + 3, x]))
}

fn view() -> Frame {
    let camera = Camera::framing(&unit_grid(DIMS).world_bounds(), DVec3::new(0.5, 1.0, 0.4), DVec3::Z);
    Frame { camera, ..frame(&unit_grid(DIMS), ramp(1500.0, 3500.0), DVec3::X, [50, 40]) }
}

#[test]
fn matter_of_another_volume_beside_a_box_weighs_what_it_weighs_there() {
    let Some(gpu) = gpu() else { return };
    let mut family = Family::new(parent_on(unit_grid(DIMS), waves), &nested());
    family.volumes.push(beside());
    let other = Body { volume: VolumeId(3), ..Body::whole(0) };
    // Thin matter, and matter that hides what lies behind it within a step.
    for (most, step_mm) in [(0.5, 1.0), (0.97, 3.0)] {
        let mut plain = Frame { bodies: vec![Body::whole(0), other.clone()], step_mm, ..view() };
        plain.transfer.opacity = vec![(1500.0, 0.0), (3500.0, most)];
        let apart = compare(&family, &gpu, &plain);
        assert!(apart.through > 40 && apart.furthest <= 1.0, "{most}: {apart:?}");
    }
    for mode in [Mode::Mip, Mode::Iso(2300.0)] {
        let look = Look { transfer: ramp(1500.0, 3500.0), mode, lighting: None, opacity: 0.6 };
        let own = Body { look: Some(0), ..Body::whole(0) };
        let apart = compare(&family, &gpu, &Frame { bodies: vec![own, other.clone()], looks: vec![look], ..view() });
        let Apart { through, beyond_one, .. } = apart;
        assert!(through > 40 && beyond_one <= through / 100, "{mode:?}: {apart:?}");
    }
}

/// Parts of an oblique volume with voxels of three lengths, turned and shifted, cut through the boxes and clipped.
fn oblique() -> (Family, Frame) {
    let grid = oblique_grid(DIMS);
    let family = Family::new(parent_on(grid, waves), &nested());
    let middle = grid.world_from_index.transform_point3(DVec3::new(14.0, 17.0, 12.0));
    let cut = Plane::through(middle, DVec3::new(1.0, 0.4, -0.3)).unwrap();
    let pose = |angle: f64, translation: DVec3| Pose {
        rotation: DQuat::from_rotation_y(angle),
        translation: translation + middle - DQuat::from_rotation_y(angle) * middle,
    };
    let plain = Frame {
        camera: Camera::framing(&grid.world_bounds(), DVec3::new(-0.4, 1.0, 0.5), DVec3::Z),
        bodies: vec![
            Body { region: vec![cut], pose: pose(0.2, DVec3::new(-5.0, 0.0, 1.0)), ..Body::whole(1) },
            Body { region: vec![cut.flipped()], pose: pose(-0.1, DVec3::new(6.0, 2.0, 0.0)), ..Body::whole(2) },
        ],
        layers: Layers { clips: vec![Plane::through(middle, DVec3::new(0.1, 0.2, 1.0)).unwrap()], ..Layers::default() },
        ..frame(&grid, ramp(1500.0, 3500.0), DVec3::X, [50, 40])
    };
    (family, plain)
}

#[test]
fn parts_of_an_oblique_volume_are_cut_through_boxes_as_through_the_volume() {
    let Some(gpu) = gpu() else { return };
    let (family, plain) = oblique();
    let light = Some(Lighting::default());
    for (mode, lighting) in [(Mode::Dvr, None), (Mode::Dvr, light), (Mode::Mip, None), (Mode::Iso(2300.0), light)] {
        let apart = compare(&family, &gpu, &Frame { mode, lighting, ..plain.clone() });
        let Apart { through, beyond_one, .. } = apart;
        assert!(through > 40 && beyond_one <= through / 100, "{mode:?} {lighting:?}: {apart:?}");
    }
}

/// Stretches are beside far finer samples what they are where there is no box.
#[test]
fn stretches_through_boxes_are_as_near_to_far_finer_samples_as_without_boxes() {
    let Some(gpu) = gpu() else { return };
    let light = Some(Lighting::default());
    let touching = |lo: u32, hi: u32, scale| (0, SubBox { lo: [lo, 10, 8], hi: [hi, 22, 18], scale: [scale; 3] });
    for boxes in [nested(), vec![touching(10, 17, 3), touching(17, 24, 8)]] {
        let family = Family::new(parent_on(unit_grid(DIMS), waves), &boxes);
        let none = Family::new(parent_on(unit_grid(DIMS), waves), &[]);
        for lighting in [None, light] {
            let plain = Frame { lighting, size: [36, 30], ..view() };
            let rough = Frame { refine: true, ..plain.clone() };
            let fine = Frame { step_mm: 1.0 / 16.0, ..plain };
            let off = |family: &Family| {
                let (a, b) = (family.with_boxes(&rough), family.with_boxes(&fine));
                let (a, b) = (family.draw(&gpu, &a), family.draw(&gpu, &b));
                let pairs = a.colour.iter().flatten().zip(b.colour.iter().flatten());
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) * 255.0
            };
            let (with, without) = (off(&family), off(&none));
            assert!(
                without < 16.0 && with <= without.max(1.0) * 1.25,
                "{lighting:?}: {with} with boxes, {without} without"
            );
        }
    }
}

/// A box that has a look of its own: other colours, another mode, little of its matter, none of its host's.
#[test]
fn a_box_may_be_shown_otherwise_than_its_host() {
    let Some(gpu) = gpu() else { return };
    let touching = |lo: u32, hi: u32, scale| (0, SubBox { lo: [lo, 10, 8], hi: [hi, 22, 18], scale: [scale; 3] });
    let other =
        TransferFunction { colour: vec![(1500.0, [0.1, 0.6, 0.2]), (3500.0, [0.9, 0.2, 0.9])], ..ramp(1300.0, 3000.0) };
    let look =
        |mode, opacity, transfer: &TransferFunction| Look { transfer: transfer.clone(), mode, lighting: None, opacity };
    let faint = TransferFunction { opacity: vec![(0.0, 0.0), (4000.0, 0.0)], ..other.clone() };
    for (name, boxes) in [("nested", nested()), ("touching", vec![touching(10, 17, 3), touching(17, 24, 8)])] {
        let family = Family::new(parent_on(unit_grid(DIMS), waves), &boxes);
        for (own, host) in [
            (look(Mode::Dvr, 1.0, &other), look(Mode::Dvr, 0.4, &ramp(1500.0, 3500.0))),
            (look(Mode::Dvr, 1.0, &other), look(Mode::Dvr, 1.0, &faint)),
            (look(Mode::Mip, 0.8, &other), look(Mode::Dvr, 0.4, &ramp(1500.0, 3500.0))),
            (look(Mode::Iso(2300.0), 0.6, &other), look(Mode::Dvr, 0.4, &ramp(1500.0, 3500.0))),
            (look(Mode::Dvr, 0.5, &other), look(Mode::Mip, 0.7, &ramp(1500.0, 3500.0))),
            (look(Mode::Iso(2400.0), 1.0, &other), look(Mode::Iso(2300.0), 1.0, &ramp(1500.0, 3500.0))),
        ] {
            let modes = (own.mode, host.mode);
            let plain =
                Frame { bodies: vec![Body { look: Some(0), ..Body::whole(0) }], looks: vec![host, own], ..view() };
            let mut boxed = family.with_boxes(&plain);
            // The last box has it, and what it is cut out of not.
            boxed.bodies.iter_mut().filter(|b| b.volume == VolumeId(2)).for_each(|b| b.look = Some(1));
            let apart = compare_boxed(&family, &gpu, &plain, &boxed);
            let Apart { through, beyond_one, .. } = apart;
            assert!(through > 40 && beyond_one <= through / 50, "{name}, {modes:?}: {apart:?}");
        }
    }
}

/// What is selected stays where it was while the part about it has gone: in a box its own selection says what that is.
#[test]
fn what_is_selected_in_a_box_alone_stays_and_what_is_selected_beneath_it_alone_does_not_show() {
    let Some(gpu) = gpu() else { return };
    let of = SubBox { lo: [10, 12, 8], hi: [22, 22, 18], scale: [2; 3] };
    let all = |grid: &Grid| painted(FieldKind::Selection, grid, |_| [255, 0, 0, 0]);
    let away = Pose { translation: DVec3::new(0.0, 0.0, 500.0), ..Pose::IDENTITY };
    let bodies = vec![
        Body { mask: Mask::Background, pose: away, ..Body::whole(1) },
        Body { mask: Mask::Selection, ..Body::whole(9) },
    ];
    let dense = TransferFunction { opacity: vec![(0.0, 0.9), (4000.0, 0.9)], ..ramp(0.0, 4000.0) };
    let plain = Frame { bodies, ..Frame { transfer: dense, ..view() } };
    let middle = unit_grid(DIMS).world_from_index.transform_point3(DVec3::new(16.0, 17.0, 13.0));
    let px = plain.camera.project(middle, plain.size).unwrap().0;
    for in_box in [true, false] {
        let mut family = Family::new(parent_on(unit_grid(DIMS), waves), &[(0, of)]);
        let volume = &mut family.volumes[usize::from(in_box)];
        volume.selection = all(volume.grid());
        let seen = family.draw(&gpu, &family.with_boxes(&plain));
        let at = px.y as usize * 50 + px.x as usize;
        if in_box {
            assert_eq!(seen.object[at].body(), Some(9), "{px}");
            assert_eq!(seen.object[at].volume(), Some(VolumeId(1)));
            assert!(seen.object.iter().all(|o| o.volume() != Some(VolumeId::FIRST)), "the box alone is selected");
        } else {
            // From outside the selection about the box is seen; the box itself is a hole in it.
            let eye = DVec3::new(16.0, 17.0, 13.0);
            let inside = Camera { eye, target: eye + DVec3::X, ..plain.camera };
            let seen = family.draw(&gpu, &family.with_boxes(&Frame { camera: inside, ..plain.clone() }));
            let nearest = seen.depth_mm.iter().copied().fold(f32::INFINITY, f32::min);
            assert!((4.9..7.0).contains(&nearest), "{nearest} mm to the box's face");
        }
    }
}
