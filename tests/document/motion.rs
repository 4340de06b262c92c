//! Pictures while something moves.

use super::maker::run;
use super::maker_gpu::{block, cut, select};
use crate::common::one::One;
use burin::document::{Document, Origin, State, ViewName};
use burin::math::{DQuat, DVec3, Pose};
use burin::volume::*;
use std::sync::Arc;

#[test]
fn a_picture_in_motion_waits_for_few_bricks_and_at_rest_none_is_missing() {
    let mut document = Document::new();
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    // Matter in 80 bricks, every one painted in many colours: density of that size lies in place, paint does not.
    let dims = [640, 128, 32];
    let grid = Grid::aligned(dims, DVec3::ONE, DVec3::ZERO);
    let voxels = vec![200_u8; grid.voxel_count() as usize];
    let statistics = Statistics { min: 200.0, max: 200.0, sum: 0.0, nan_count: 0, ..Statistics::default() };
    let source = Arc::new(MemorySource::new("slab", grid, Voxels::U8(voxels), (1.0, 0.0)).unwrap());
    let origin = Origin { path: "slab.nrrd".into(), component: 0, frame: 0 };
    let histogram = Histogram { min: 0.0, max: 250.0, bins: vec![1; 256], ..Histogram::default() };
    let mut state = State::new(source, origin, statistics, histogram, None, &|_| true).unwrap();
    let texels: Vec<u8> = (0..BRICK_VOXELS).flat_map(|i| [(i * 7 % 251) as u8, (i / 99) as u8, 0, 255]).collect();
    let changes =
        state.one().colour.brick_indices(0).into_iter().map(|b| (b, Some(Brick::from_texels(texels.clone(), 4))));
    state.one_mut().colour.swap(changes.collect()).unwrap();
    document.adopt(state);
    let opaque =
        r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[90,0],[110,0.9]],"unit_mm":1}}}}"#;
    run(&mut document, opaque).unwrap();
    run(&mut document, r#"{"view":{"size":{"view":"3d","size":[64,64]}}}"#).unwrap();
    let mut picture = |moving: bool| {
        document.set_motion(moving);
        let image = document.picture(ViewName::ThreeD, [64, 64], None).unwrap();
        (image.colour, document.is_pending())
    };
    let (rough, pending) = picture(true);
    assert!(pending && rough.iter().any(|c| c[3] > 0.0), "coarser bricks stand in");
    let (next, pending) = picture(true);
    assert!(!pending, "the rest comes with the next picture");
    let (rest, pending) = picture(false);
    assert!(!pending && rest == next && rest != rough);
}

fn poses(document: &Document) -> Vec<Pose> {
    document.poses().in_order(&document.state().unwrap().scene.explosion.parts)
}

fn farthest(a: &[Pose], b: &[Pose]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.translation.distance(b.translation)).fold(0.0, f64::max)
}

/// Steps one by one; the poses after the first, and at rest.
fn stepped(document: &mut Document) -> (Vec<Pose>, Vec<Pose>) {
    let mut first = Vec::new();
    for i in 0..2000 {
        let answer = run(document, r#"{"explosion":{"step":{"steps":1}}}"#).unwrap();
        if i == 0 {
            first = poses(document);
        }
        if answer["moving"] == false {
            return (first, poses(document));
        }
    }
    panic!("parts never come to rest");
}

#[test]
fn parts_follow_the_slider_from_the_first_steps_and_rest_where_they_belong() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    let mut before = poses(&document);
    for degree in [1.0, 0.4, 0.8, 0.0] {
        run(&mut document, &format!(r#"{{"explosion":{{"degree":{{"value":{degree}}}}}}}"#)).unwrap();
        let (first, rest) = stepped(&mut document);
        let way = farthest(&before, &rest);
        assert!(way > 3.0, "{way} mm");
        // Long before all is measured they are on their way, and in the right direction.
        let begun = farthest(&before, &first);
        assert!(begun > 1e-4 * way, "degree {degree}: {begun} of {way} mm");
        assert!(farthest(&first, &rest) < way, "degree {degree}");
        run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap();
        assert_eq!(rest, poses(&document), "degree {degree}");
        before = rest;
    }
}

#[test]
fn parts_that_moved_during_a_stroke_stay_where_they_are_when_it_comes_to_nothing() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    run(&mut document, r#"{"explosion":{"degree":{"value":1}}}"#).unwrap();
    for end in [r#"{"stroke":{"end":{}}}"#, r#"{"stroke":{"cancel":{}}}"#] {
        let before = poses(&document);
        run(&mut document, r#"{"stroke":{"begin":{"points":[{"at":{"mm":[500,500,500]}}]}}}"#).unwrap();
        run(&mut document, r#"{"explosion":{"step":{"steps":5}}}"#).unwrap();
        let moved = poses(&document);
        assert!(farthest(&before, &moved) > 1e-3);
        assert_eq!(run(&mut document, end).unwrap()["step"], serde_json::Value::Null);
        assert_eq!(moved, poses(&document), "{end}");
    }
}

#[test]
fn a_share_of_a_pose_is_that_share_of_its_shift_and_turn() {
    let centre = DVec3::new(3.0, -2.0, 7.0);
    let pose = Pose::about(centre, DQuat::from_axis_angle(DVec3::new(0.0, 0.6, 0.8), 0.8), DVec3::new(4.0, 0.0, -2.0));
    for share in [0.0, 0.25, 1.0, 1.7] {
        let part = pose.share(share, centre);
        assert!((part.apply(centre) - centre - DVec3::new(4.0, 0.0, -2.0) * share).length() < 1e-12, "{share}");
        let turn = DQuat::from_axis_angle(DVec3::new(0.0, 0.6, 0.8), 0.8 * share);
        assert!(part.rotation.angle_between(turn) < 1e-6, "{share}");
    }
}

#[test]
fn the_explosion_says_what_it_lacks() {
    let Some(mut document) = block() else { return };
    let degree = |d: &mut Document, value: f64| {
        run(d, &format!(r#"{{"explosion":{{"degree":{{"value":{value}}}}}}}"#)).unwrap()["hint"].clone()
    };
    assert!(degree(&mut document, 1.0).as_str().unwrap().contains("part.split"), "one part");
    cut(&mut document);
    assert!(degree(&mut document, 1.0).as_str().unwrap().contains("select something first"));
    let settled = run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap();
    assert!(settled["hint"].as_str().unwrap().contains("select something first"), "{settled}");
    assert_eq!(degree(&mut document, 0.0), serde_json::Value::Null);
    select(&mut document);
    assert_eq!(degree(&mut document, 1.0), serde_json::Value::Null);
}
