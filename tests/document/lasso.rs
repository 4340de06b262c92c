//! A contour drawn on a slice fills, against plain loops with the winding number.

use super::maker::run;
use super::maker_gpu::{labelled, made};
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Voxels;
use serde_json::{Value, json};
use std::collections::BTreeSet;

const DIMS: [u32; 3] = [70, 40, 37];
const SPACING: DVec3 = DVec3::new(0.8, 1.1, 1.9);

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn blank() -> Option<Document> {
    let mut document = made(Voxels::U8(vec![50; 70 * 40 * 37]), DIMS, SPACING)?;
    say(&mut document, json!({"brush":{"set":{"target":{"label":1},"radius_mm":1,"visible_only":true}}}));
    Some(document)
}

/// How often a closed polygon winds about a point: angles added up.
fn winding(corners: &[[f64; 2]], at: [f64; 2]) -> i32 {
    let angle = |p: [f64; 2]| (p[1] - at[1]).atan2(p[0] - at[0]);
    let mut sum = 0.0;
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let mut turn = angle(b) - angle(*a);
        if turn > std::f64::consts::PI {
            turn -= std::f64::consts::TAU;
        }
        if turn < -std::f64::consts::PI {
            turn += std::f64::consts::TAU;
        }
        sum += turn;
    }
    (sum / std::f64::consts::TAU).round() as i32
}

/// A star that crosses itself, about a place of two axes of the index, mm.
fn star(middle: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    (0..5)
        .map(|i| f64::from(i) * 2.0 * std::f64::consts::TAU / 5.0 + 0.3)
        .map(|a| [middle[0] + radius * a.cos(), middle[1] + radius * a.sin()])
        .collect()
}

type Set = BTreeSet<[u32; 3]>;

/// The voxels whose centres lie so near to `at` along an axis, mm, and inside along the two others.
fn filled(corners: &[[f64; 2]], axis: usize, at: f64, depth: f64) -> Set {
    let others: Vec<usize> = (0..3).filter(|a| *a != axis).collect();
    let mut set = Set::new();
    for z in 0..DIMS[2] {
        for y in 0..DIMS[1] {
            for x in 0..DIMS[0] {
                let v = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * SPACING;
                let near = (v[axis] - at).abs() <= depth.max(SPACING[axis] * 0.5 - 1e-9);
                if near && winding(corners, [v[others[0]], v[others[1]]]) != 0 {
                    set.insert([x, y, z]);
                }
            }
        }
    }
    set
}

fn place(corner: [f64; 2], axis: usize, at: f64) -> [f64; 3] {
    let others: Vec<usize> = (0..3).filter(|a| *a != axis).collect();
    let mut place = [0.0; 3];
    (place[axis], place[others[0]], place[others[1]]) = (at, corner[0], corner[1]);
    place
}

#[test]
fn a_contour_fills_its_slice_or_as_deep_as_it_is_told() {
    for (axis, middle, at) in [(2, [27.0, 20.0], 31.1), (1, [25.5, 33.0], 17.0), (0, [22.0, 36.0], 25.7)] {
        let mut normal = [0.0; 3];
        normal[axis] = 3.0;
        for depth in [0.0, 4.3] {
            let Some(mut document) = blank() else { return };
            let corners = star(middle, 15.3);
            let points: Vec<_> = corners.iter().map(|c| json!({"mm": place(*c, axis, at)})).collect();
            let lasso = json!({"points":points,"normal":normal,"depth_mm":depth});
            let answer = say(&mut document, json!({"stroke":{"lasso":lasso}}));
            let found: Set = labelled(&document, 1).into_iter().collect();
            let expected = filled(&corners, axis, at, depth);
            assert!(expected.len() > 100);
            assert_eq!(found, expected, "{axis} {depth}");
            assert_eq!(answer["voxels_changed"], expected.len());
            say(&mut document, json!({"history":{"undo":{}}}));
            assert!(labelled(&document, 1).is_empty());
        }
    }
}

#[test]
fn pixels_of_a_slice_fill_what_they_go_around_and_the_step_says_it_in_mm() {
    let Some(mut document) = blank() else { return };
    say(&mut document, json!({"view":{"crosshair":{"at":{"index":[20,20,11]}}}}));
    let pixels = [[180.0, 200.0], [330.0, 210.0], [320.0, 320.0], [190.0, 300.0]];
    let points: Vec<_> = pixels.iter().map(|px| json!({"pixel":{"view":"axial","px":px,"size":[512,512]}})).collect();
    say(&mut document, json!({"stroke":{"lasso":{"points":points}}}));
    let found: Set = labelled(&document, 1).into_iter().collect();
    assert!(found.len() > 50 && found.iter().all(|v| v[2] == 11), "{}", found.len());
    let told = say(&mut document, json!({"ask":{"history":{"commands":true}}}));
    let command = told["undo_commands"].as_array().unwrap().last().unwrap()[0]["command"].clone();
    assert!(command["stroke"]["lasso"]["points"][0]["mm"].is_array(), "{command}");
    // The same, said by the step, in a fresh document.
    let Some(mut again) = blank() else { return };
    say(&mut again, command);
    assert_eq!(labelled(&again, 1).into_iter().collect::<Set>(), found);
}

#[test]
fn a_contour_keeps_to_limits_has_its_image_and_erases() {
    let Some(mut document) = blank() else { return };
    let square = |lo: f64, hi: f64| -> Vec<Value> {
        [[lo, lo], [hi, lo], [hi, hi], [lo, hi]].iter().map(|[x, y]| json!({"index":[x, y, 9]})).collect()
    };
    let inside = |v: [u32; 3], lo: u32, hi: u32| v[2] == 9 && (lo..=hi).contains(&v[0]) && (lo..=hi).contains(&v[1]);
    let label = |document: &Document, id| labelled(document, id).into_iter().collect::<Set>();
    say(&mut document, json!({"stroke":{"lasso":{"points":square(4.5, 20.5)}}}));
    assert!(label(&document, 1).iter().all(|v| inside(*v, 5, 20)) && label(&document, 1).len() == 256);
    let only = json!({"target":{"label":2},"only":{"segment":{"id":1,"side":"inside"}}});
    say(&mut document, json!({"brush":{"set":only}}));
    say(&mut document, json!({"stroke":{"lasso":{"points":square(14.5, 30.5)}}}));
    assert!(label(&document, 2).iter().all(|v| inside(*v, 15, 20)) && label(&document, 2).len() == 36);
    say(&mut document, json!({"brush":{"set":{"target":{"label":3},"only":{},"mirror":{"axis":"x"},"strength":0.9}}}));
    say(&mut document, json!({"stroke":{"lasso":{"points":square(24.5, 27.5),"depth_mm":2.0}}}));
    let both = label(&document, 3);
    assert_eq!(both.len(), 2 * 9 * 3);
    assert!(both.iter().all(|[x, y, z]| both.contains(&[69 - x, *y, *z])));
    say(&mut document, json!({"brush":{"set":{"erase":true,"mirror":"off"}}}));
    say(&mut document, json!({"stroke":{"lasso":{"points":square(4.5, 30.5)}}}));
    assert!(label(&document, 1).is_empty() && label(&document, 2).is_empty());
    // The brush is as it was.
    let brush = say(&mut document, json!({"brush":{"set":{}}}))["brush"].clone();
    assert_eq!((brush["radius_mm"].as_f64(), brush["shape"].as_str()), (Some(1.0), Some("sphere")));
}

#[test]
fn what_is_no_contour_is_refused_by_name() {
    let Some(mut document) = blank() else { return };
    let at = |x: f64| json!({"mm":[x,3,4]});
    for (lasso, said) in [
        (json!({"points":[at(1.0), at(2.0)]}), "points"),
        (json!({"points":[at(1.0), at(2.0), {"pixel":{"view":"axial","px":[1,2]}}]}), "points"),
        (
            json!({"points":[{"pixel":{"view":"3d","px":[1,2]}}, {"pixel":{"view":"3d","px":[9,2]}}, {"pixel":{"view":"3d","px":[1,7]}}]}),
            "points",
        ),
        (json!({"points":[at(1.0), at(2.0), at(3.0)],"depth_mm":-1}), "depth_mm"),
        (json!({"points":[at(1.0), at(2.0), at(3.0)],"normal":[0,0,0]}), "normal"),
        (json!({"points":[at(1.0), at(2.0), at(3.0)],"pressure":1.5}), "pressure"),
    ] {
        let error = run(&mut document, &json!({"stroke":{"lasso":lasso}}).to_string()).unwrap_err().to_string();
        assert!(error.contains(said), "{lasso}: {error}");
    }
    // A line goes around nothing.
    let answer = say(&mut document, json!({"stroke":{"lasso":{"points":[at(1.0), at(9.0), at(22.0)]}}}));
    assert!(answer["nothing"].as_str().unwrap().contains("contour"), "{answer}");
    assert_eq!(document.state().unwrap().one().labels.edits().len(), 0);
}
