//! A stroke in the 3D view is the same however often the pointer was sampled along the same way: straight, oblique, of any length,
//! at once or while it runs.

use super::maker::run;
use super::maker_gpu::{labelled, made as of};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde_json::{Value, json};
use std::collections::BTreeSet;

const N: u32 = 40;

/// Balls and plates before one another, so that depth jumps by steps of every size.
fn clutter(random: &mut StdRng) -> Voxels {
    let mut voxels = vec![0_u8; (N * N * N) as usize];
    for body in 0..6 {
        let centre = DVec3::from_array(std::array::from_fn(|_| random.random_range(6.0..34.0)));
        let radius = random.random_range(3.0..10.0);
        for (i, voxel) in voxels.iter_mut().enumerate() {
            let i = i as u32;
            let d = DVec3::new(f64::from(i % N), f64::from(i / N % N), f64::from(i / N / N)) - centre;
            let inside = if body % 3 == 2 {
                d.x.abs() < radius && d.y.abs() < radius && d.z.abs() < 2.0
            } else {
                d.length() < radius
            };
            if inside {
                *voxel = 200;
            }
        }
    }
    Voxels::U8(voxels)
}

fn pixel(px: [f64; 2]) -> Value {
    json!({"at":{"pixel":{"view":"3d","px":px}}})
}

/// What a way of so many pieces paints: at once, or point by point. Undone again.
fn painted(document: &mut Document, points: &[[f64; 2]], at_once: bool) -> BTreeSet<[u32; 3]> {
    let points: Vec<_> = points.iter().map(|&px| pixel(px)).collect();
    if at_once {
        run(document, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap();
    } else {
        run(document, &json!({"stroke":{"begin":{"points":[points[0]]}}}).to_string()).unwrap();
        for point in &points[1..] {
            run(document, &json!({"stroke":{"extend":{"points":[point]}}}).to_string()).unwrap();
        }
        run(document, r#"{"stroke":{"end":{}}}"#).unwrap();
    }
    let found: BTreeSet<_> = labelled(document, 1).into_iter().collect();
    if !found.is_empty() {
        run(document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
    found
}

#[test]
fn a_stroke_does_not_depend_on_how_often_the_pointer_was_sampled() {
    let mut random = StdRng::seed_from_u64(3);
    let (mut voxels, mut ways) = (0, 0);
    for spacing in [DVec3::ONE, DVec3::new(0.8, 0.8, 2.0), DVec3::ONE, DVec3::new(0.5, 1.0, 1.5)] {
        let Some(mut document) = of(clutter(&mut random), [N; 3], spacing) else { return };
        let opaque =
            r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[90,0],[110,1]],"unit_mm":1}}}}"#;
        run(&mut document, opaque).unwrap();
        run(&mut document, r#"{"view":{"size":{"view":"3d","size":[160,160]}}}"#).unwrap();
        let from: [f64; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
        run(&mut document, &json!({"view":{"frame":{"from":from}}}).to_string()).unwrap();
        for (radius, a, b) in [
            (2.0, [30.0, 80.0], [130.0, 80.0]),
            (4.0, [40.0, 40.0], [120.0, 120.0]),
            (1.0, [31.3, 121.9], [128.1, 47.7]),
            (0.3, [80.5, 30.2], [78.1, 131.4]),
        ] {
            let radius = radius * spacing.min_element();
            let settings = json!({"radius_mm":radius,"falloff":"hard","target":{"label":1}});
            run(&mut document, &json!({"brush":{"set":settings}}).to_string()).unwrap();
            let at = |t: f64| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let whole = painted(&mut document, &[a, b], true);
            let mut uneven: Vec<f64> = (0..15).map(|_| random.random_range(0.0..1.0)).collect();
            uneven.extend([0.0, 1.0]);
            uneven.sort_by(f64::total_cmp);
            let every = |px: f64| (0..=(length / px) as u32).map(|i| f64::from(i) * px / length).chain([1.0]).collect();
            let samplings: [(Vec<f64>, bool); 5] =
                [(every(20.0), true), (every(7.3), false), (every(1.0), true), (every(0.4), false), (uneven, true)];
            for (shares, at_once) in samplings {
                let points: Vec<_> = shares.iter().map(|&t| at(t)).collect();
                let found = painted(&mut document, &points, at_once);
                let apart = found.symmetric_difference(&whole).count();
                // A sample that lies on the line between others to a fiftieth of a voxel is left out of what is kept.
                let few = whole.len() / 200 + 2;
                assert!(apart <= few, "{spacing} {radius} {} points: {apart} of {} differ", points.len(), whole.len());
            }
            (voxels, ways) = (voxels + whole.len(), ways + 1);
        }
    }
    assert!(voxels > 200 * ways, "{voxels} voxels of {ways} strokes");
}

#[test]
fn the_end_of_a_stroke_is_under_the_pointer_between_pixels_too() {
    let Some(mut document) = of(Voxels::U8(vec![200; (N * N * N) as usize]), [N; 3], DVec3::ONE) else { return };
    let opaque = r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[90,0],[110,1]],"unit_mm":1}}}}"#;
    run(&mut document, opaque).unwrap();
    run(&mut document, r#"{"view":{"size":{"view":"3d","size":[24,24]}}}"#).unwrap();
    run(&mut document, r#"{"view":{"frame":{"from":[0,0,1],"zoom":1}}}"#).unwrap();
    run(&mut document, r#"{"brush":{"set":{"radius_mm":0.1,"target":{"label":1}}}}"#).unwrap();
    // A pixel is several voxels wide.
    for end in [13.45, 13.9, 14.05, 14.72] {
        let points = [[11.0, 12.0], [12.2, 12.0], [end, 12.0]];
        let asked = run(&mut document, &json!({"ask":{"pick":{"px":points[2]}}}).to_string()).unwrap();
        let index: Vec<f64> = serde_json::from_value(asked["hit"]["index"].clone()).unwrap();
        let voxel: [u32; 3] = std::array::from_fn(|i| (index[i] + 0.5).floor().clamp(0.0, f64::from(N - 1)) as u32);
        for at_once in [true, false] {
            let found = painted(&mut document, &points, at_once);
            assert!(found.contains(&voxel), "{end}: {voxel:?} not among {found:?}");
        }
    }
}
