//! Refined volume rendering: against its own reference, and against the limit of ever finer plain samples.

use super::cast_bodies::{exploded, soft_ball, wide};
use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use super::reference::{Dense, Difference, difference, picture};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Frame, Mask};
use burin::math::DVec3;
use burin::volume::*;

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([66, 44, 36]);
    Some(Stage::new(gpu, grid, lumps(grid)))
}

/// From the reference, in place and with every brick apart: the larger difference of each kind. Where runs of samples end, which
/// bricks have a say in, stretches of two steps end too, so that the two are not the same to the bit.
fn from_reference(stage: &mut Stage, frame: &Frame) -> Difference {
    let reference = picture(&Dense::of(&stage.fields(), &stage.grid), frame);
    let [a, b] = [stage.image(frame), stage.image_apart(frame)].map(|i| difference(&i, &reference, frame.step_mm));
    println!("lit {}: {a:?}, apart {b:?}", frame.lighting.is_some());
    Difference {
        largest: a.largest.max(b.largest),
        mean: a.mean.max(b.mean),
        beyond_one: a.beyond_one.max(b.beyond_one),
        misplaced: a.misplaced.max(b.misplaced),
        covered: a.covered,
    }
}

/// From plain samples `finer` times as dense, in f64.
fn from_limit(stage: &mut Stage, frame: &Frame, finer: f64) -> Difference {
    let image = stage.image(frame);
    let limit = Frame { step_mm: frame.step_mm / finer, refine: false, ..frame.clone() };
    difference(&image, &picture(&Dense::of(&stage.fields(), &stage.grid), &limit), frame.step_mm)
}

#[test]
fn a_refined_picture_is_the_references() {
    let Some(mut stage) = stage() else { return };
    let view = frame(&stage.grid, tissue(), DVec3::new(1.0, -2.0, 0.7), [72, 60]);
    for frame in projections(&view) {
        for step_mm in [0.8, 1.7] {
            let plain = Frame { step_mm, refine: true, ..frame.clone() };
            let d = from_reference(&mut stage, &plain);
            assert!(d.covered > 0.15 && d.beyond_one <= 0.01 && d.mean <= 0.1 && d.misplaced < 0.01, "{d:?}");
            let d = from_reference(&mut stage, &Frame { lighting: Some(Lighting::default()), ..plain });
            assert!(d.largest <= 8.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
        }
    }
}

#[test]
fn exploded_parts_begin_and_end_where_they_are_cut() {
    let Some(mut stage) = stage() else { return };
    let parts = exploded(&stage.grid, [2, 2, 1], 0.5, Mask::None);
    for lighting in [None, Some(Lighting::default())] {
        let view = Frame { refine: true, lighting, ..wide(&stage.grid, parts.clone()) };
        let d = from_reference(&mut stage, &view);
        assert!(d.covered > 0.05 && d.largest <= 8.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
    }
}

#[test]
fn overlapping_and_selected_bodies_go_to_the_limit_of_ever_finer_samples() {
    let Some(mut stage) = stage() else { return };
    stage.fields[2] = soft_ball(&stage.grid);
    let mut bodies = exploded(&stage.grid, [2, 1, 1], 0.3, Mask::Background);
    bodies.push(Body { mask: Mask::Selection, ..Body::whole(0) });
    let view = Frame { refine: true, step_mm: 1.0, ..wide(&stage.grid, bodies) };
    let plain = from_limit(&mut stage, &Frame { refine: false, ..view.clone() }, 12.0);
    let refined = from_limit(&mut stage, &view, 12.0);
    assert!(refined.covered > 0.05 && refined.mean < plain.mean, "{refined:?} beside {plain:?}");
    assert!(refined.largest < 0.7 * plain.largest, "{refined:?} beside {plain:?}");
}

#[test]
fn what_is_no_number_is_transparent_when_refined_too() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([40; 3]);
    let hole = |v: [u32; 3]| (v[0] / 9 + v[1] / 7 + v[2] / 11).is_multiple_of(3);
    let value = |v: [u32; 3]| if hole(v) { f32::NAN } else { 20_000.0 + 500.0 * v[0] as f32 };
    let mut stage = Stage::new(gpu, grid, density_f32(grid, value));
    let view = frame(&grid, tissue(), DVec3::new(0.3, -1.0, 0.4), [48, 40]);
    let d = from_reference(&mut stage, &Frame { refine: true, ..view });
    assert!(d.covered > 0.1 && d.beyond_one < 0.06 && d.largest < 6.0 && d.mean < 0.12, "{d:?}");
}

#[test]
fn a_smooth_ball_shows_no_rings() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([56; 3]);
    let ball = density_u16(grid, |v| {
        let r = v.iter().map(|&x| (f64::from(x) - 27.5).powi(2)).sum::<f64>().sqrt();
        (2_000.0 + 38_000.0 / (1.0 + ((r - 21.0) / 0.8).exp())) as u16
    });
    let mut stage = Stage::new(gpu, grid, ball);
    let skin = TransferFunction { opacity: vec![(8_000.0, 0.0), (20_000.0, 0.3), (60_000.0, 0.5)], ..tissue() };
    let lighting = Some(Lighting::default());
    let view = Frame { lighting, ..frame(&grid, skin, DVec3::new(0.4, -1.0, 0.3), [96, 80]) };
    let plain = from_limit(&mut stage, &view, 12.0);
    let refined = from_limit(&mut stage, &Frame { refine: true, ..view }, 12.0);
    assert!(plain.mean > 0.05 && plain.largest > 3.0, "plain samples leave rings: {plain:?}");
    assert!(refined.mean < 0.7 * plain.mean, "{refined:?} beside {plain:?}");
    assert!(refined.beyond_one < 0.2 * plain.beyond_one, "{refined:?} beside {plain:?}");
}

#[test]
fn skipping_what_is_empty_changes_no_refined_picture() {
    let Some(mut stage) = stage() else { return };
    let view = frame(&stage.grid, tissue(), DVec3::new(0.6, -1.0, 0.3), [64, 56]);
    let view = Frame { refine: true, lighting: Some(Lighting::default()), ..view };
    let with = stage.image(&view);
    stage.caster.shortcuts = false;
    let without = stage.image(&view);
    let far = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max) * 255.0;
    let largest = with.colour.iter().zip(&without.colour).map(far).fold(0.0, f32::max);
    assert!(largest <= 1.0, "{largest}/255");
}

#[test]
fn surfaces_and_maxima_are_the_same_refined_or_not() {
    let Some(mut stage) = stage() else { return };
    let view = frame(&stage.grid, tissue(), DVec3::new(0.6, -1.0, 0.3), [40, 32]);
    for mode in [Mode::Iso(26_000.0), Mode::Mip] {
        let plain = Frame { mode, ..view.clone() };
        let refined = stage.image(&Frame { refine: true, ..plain.clone() });
        assert!(refined == stage.image(&plain), "{mode:?}");
    }
}
