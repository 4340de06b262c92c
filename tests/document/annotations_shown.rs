//! What pictures show of annotations, labels and cutaways, and what is told of where that is.

use super::annotations::{RADIUS, ball, middle, on, say, text};
use super::maker::run;
use burin::document::Document;
use burin::math::{Camera, DVec2, DVec3, Projection};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;

const SIZE: [u32; 2] = [96, 96];

fn picture(document: &mut Document, dir: &Path) -> image::RgbaImage {
    let path = dir.join("picture.png");
    say(document, json!({"render":{"image":{"path":path,"size":SIZE,"background":[0,0,0]}}}));
    image::open(path).unwrap().to_rgba8()
}

/// Middle and number of pixels that are much redder than green.
fn red(picture: &image::RgbaImage) -> (DVec2, usize) {
    let red: Vec<DVec2> = picture
        .enumerate_pixels()
        .filter(|(_, _, p)| i32::from(p[0]) > i32::from(p[1]) + 60)
        .map(|(x, y, _)| DVec2::new(f64::from(x), f64::from(y)))
        .collect();
    (red.iter().sum::<DVec2>() / red.len().max(1) as f64, red.len())
}

const RED: [f32; 3] = [1.0, 0.0, 0.0];

fn plate(document: &mut Document, direction: DVec3, size: f64) -> Value {
    let content = json!({"pattern":{"kind":"lines","aspect":1,"spacing_mm":2,"line_mm":1.5}});
    say(
        document,
        json!({"annotation":{"add":{"content":content,"at":on(direction),"size_mm":size,"colour":RED,"no_halo":true,"lit":false}}}),
    )
}

#[test]
fn a_text_is_seen_where_it_lies_and_hidden_behind_the_ball() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let none = red(&picture(&mut document, dir.path())).1;
    assert_eq!(none, 0);
    text(&mut document, json!({"text":"MM","size_mm":8,"colour":RED,"no_halo":true,"lit":false,"opacity":1}));
    let (at, count) = red(&picture(&mut document, dir.path()));
    assert!(count > 20 && at.distance(DVec2::splat(47.5)) < 6.0, "{at} {count}");
    for hidden in [json!({"id":0,"visible":false}), json!({"id":0,"opacity":0})] {
        say(&mut document, json!({"annotation":{"set":hidden}}));
        assert_eq!(red(&picture(&mut document, dir.path())).1, 0);
        say(&mut document, json!({"history":{"undo":{}}}));
    }
    say(&mut document, json!({"view":{"frame":{"from":[0,1,0]}}}));
    assert_eq!(red(&picture(&mut document, dir.path())).1, 0, "it is on the other side");
}

#[test]
fn what_lies_on_a_part_rides_on_it_and_is_cut_with_it() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    plate(&mut document, DVec3::NEG_Y, 8.0);
    let (whole, pixels) = red(&picture(&mut document, dir.path()));
    say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":middle().to_array(),"normal":[1,0,0]}}}}}));
    let parts = say(&mut document, json!({"ask":{"parts":{}}}))["parts"].clone();
    let right = parts.as_array().unwrap().iter().max_by(|a, b| {
        let x = |p: &Value| p["vertices"].as_array().unwrap().iter().map(|v| v[0].as_f64().unwrap()).sum::<f64>();
        x(a).total_cmp(&x(b))
    });
    let id = right.unwrap()["id"].clone();
    let pose = json!({"rotation":[0,0,0,1],"translation":[0,0,9]});
    say(&mut document, json!({"part":{"move":{"id":id,"pose":pose}}}));
    let moved = picture(&mut document, dir.path());
    let halves = |picture: &image::RgbaImage, right: bool| {
        let half = image::RgbaImage::from_fn(SIZE[0], SIZE[1], |x, y| match (x > whole.x as u32) == right {
            true => *picture.get_pixel(x, y),
            false => image::Rgba([0; 4]),
        });
        red(&half)
    };
    let (stays, rides) = (halves(&moved, false), halves(&moved, true));
    let apart = (stays.0.y - rides.0.y).abs();
    println!("halves of {pixels} pixels: {} stay, {} ride, {apart:.1} pixels apart", stays.1, rides.1);
    assert!(stays.1 * 3 > pixels && rides.1 * 3 > pixels, "{stays:?} {rides:?} {pixels}");
    // 9 mm, in a picture that is about as high as the ball's box.
    assert!(apart > 8.0, "{apart}");
    assert!((stays.0.y - whole.y).abs() < 2.0, "{stays:?} {whole}");
    // A grid is told as it is at rest.
    say(&mut document, json!({"part":{"set":{"id":id,"visible":false}}}));
    let hidden = red(&picture(&mut document, dir.path()));
    assert!(hidden.1 * 3 < pixels * 2, "a hidden part hides its piece: {hidden:?}");
}

#[test]
fn what_is_selected_stays_with_the_selection() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    say(&mut document, json!({"brush":{"set":{"target":{"selection":1},"radius_mm":9,"falloff":"hard"}}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":on(DVec3::NEG_Y)}]}}}));
    say(&mut document, json!({"selection":{"set":{"look":{"lighting":null}}}}));
    let said = plate(&mut document, DVec3::NEG_Y, 6.0);
    assert_eq!(said["anchor"]["selected"], true, "{said}");
    let (at, pixels) = red(&picture(&mut document, dir.path()));
    let part = say(&mut document, json!({"ask":{"parts":{}}}))["parts"][0]["id"].clone();
    let pose = json!({"rotation":[0,0,0,1],"translation":[0,20,9]});
    say(&mut document, json!({"part":{"move":{"id":part,"pose":pose}}}));
    let (stays, still) = red(&picture(&mut document, dir.path()));
    assert!(pixels > 20 && still * 10 > pixels * 8 && stays.distance(at) < 2.0, "{at} {pixels}, then {stays} {still}");
    say(&mut document, json!({"annotation":{"set":{"id":0,"selected":false}}}));
    let (rides, _) = red(&picture(&mut document, dir.path()));
    assert!(rides.distance(at) > 3.0 || rides == DVec2::ZERO, "{at}, then {rides}");
}

fn labels(document: &mut Document, camera: Option<Camera>) -> Value {
    say(document, json!({"ask":{"labels":{"camera":camera,"size":[400, 300]}}}))
}

/// Two segments in the ball and one that is hidden, and one without voxels.
fn segments(document: &mut Document) {
    let blobs = [(3, "left", DVec3::X * 6.0), (4, "right", DVec3::X * -6.0), (5, "hidden", DVec3::Z * 8.0)];
    for (id, name, at) in blobs {
        say(document, json!({"segment":{"set":{"id":id,"name":name}}}));
        say(document, json!({"brush":{"set":{"target":{"label":id},"radius_mm":4,"falloff":"hard"}}}));
        let at = json!({"mm":(middle() + at).to_array()});
        say(document, json!({"stroke":{"paint":{"points":[{"at":at}]}}}));
    }
    say(document, json!({"segment":{"set":{"id":5,"visible":false}}}));
    say(document, json!({"segment":{"set":{"id":6,"name":"empty"}}}));
}

#[test]
fn every_visible_segment_with_voxels_is_labelled_once_at_one_of_them() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    segments(&mut document);
    let answer = say(&mut document, json!({"label":{"from_segments":{}}}));
    let texts: Vec<_> = answer["labels"].as_array().unwrap().iter().map(|l| l["text"].clone()).collect();
    assert_eq!(texts, [json!("left"), json!("right")], "{answer}");
    assert_eq!(say(&mut document, json!({"label":{"from_segments":{}}}))["labels"], json!([]), "once");
    assert!(document.state().unwrap().scene.labels.all.len() == 2);
    // Where two cameras see it is the place.
    let cameras = [DVec3::NEG_Y, DVec3::X].map(|from| {
        let projection = Projection::Orthographic { height_mm: 60.0 };
        Camera { eye: middle() + from * 80.0, target: middle(), up: DVec3::Z, projection }
    });
    let seen = cameras.map(|camera| labels(&mut document, Some(camera)));
    for (i, id) in [(0, 3), (1, 4)] {
        let px = |k: usize| -> DVec2 {
            let anchor = serde_json::from_value::<[f64; 2]>(seen[k]["labels"][i]["anchor"].clone());
            DVec2::from_array(anchor.unwrap_or_else(|e| panic!("{e}: {}", seen[k])))
        };
        let [front, side] = [0, 1].map(|k| cameras[k].ray(px(k), [400, 300]));
        let at = DVec3::new(front.origin.x, side.origin.y, front.origin.z);
        assert!((front.origin.z - side.origin.z).abs() < 1e-6, "{front:?} {side:?}");
        let voxel = say(&mut document, json!({"ask":{"voxel":{"at":{"mm":at.to_array()}}}}));
        assert_eq!(voxel["label"], json!(id), "{at}: {voxel}");
        // A ball of 4 mm is deepest in its middle.
        let blob = middle() + DVec3::X * if id == 3 { 6.0 } else { -6.0 };
        assert!(at.distance(blob) < 1.3, "{id}: {at}, {blob}");
    }
}

#[test]
fn labels_of_hidden_points_are_not_shown() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    for (name, direction) in [("front", DVec3::NEG_Y), ("back", DVec3::Y)] {
        say(&mut document, json!({"label":{"add":{"text":name,"at":on(direction)}}}));
    }
    for (from, seen) in [([0, -1, 0], "front"), ([0, 1, 0], "back")] {
        say(&mut document, json!({"view":{"frame":{"from":from}}}));
        let said = labels(&mut document, None);
        for label in said["labels"].as_array().unwrap() {
            let is = label["text"] == seen;
            assert_eq!((label["seen"] == true, label["rect"].is_array()), (is, is), "{from:?}: {label}");
            assert!(label["anchor"].is_array());
        }
    }
    // Without what hides it both are seen.
    say(&mut document, json!({"label":{"set":{"id":0,"visible":false}}}));
    assert_eq!(labels(&mut document, None)["labels"].as_array().unwrap().len(), 1);
}

fn mesh(said: &Value) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mesh = &said["cutaways"][0]["mesh"];
    let corners: Vec<[f64; 3]> = serde_json::from_value(mesh["corners"].clone()).unwrap();
    (corners.into_iter().map(DVec3::from_array).collect(), serde_json::from_value(mesh["triangles"].clone()).unwrap())
}

fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_default() += 1;
        }
    }
    !edges.is_empty() && edges.iter().all(|(&(from, to), count)| *count == 1 && edges.get(&(to, from)) == Some(&1))
}

#[test]
fn a_window_is_a_closed_mesh_whatever_its_outline() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let places: Vec<Value> = [(0.4, 0.2), (0.0, 0.45), (-0.4, 0.1), (-0.1, 0.0), (-0.2, -0.4), (0.3, -0.3)]
        .into_iter()
        .map(|(x, z)| on(DVec3::new(x, -1.0, z)))
        .collect();
    for add in [
        json!({"at":on(DVec3::NEG_Y),"width_mm":8,"depth_mm":5}),
        json!({"at":on(DVec3::NEG_Y),"width_mm":8,"height_mm":4,"depth_mm":5}),
        json!({"lasso":places,"depth_mm":4}),
    ] {
        let lasso = add["lasso"].is_array();
        let said = say(&mut document, json!({"cutaway":{"add":add}}));
        let told = say(&mut document, json!({"ask":{"cutaways":{"mesh":true}}}));
        let (corners, triangles) = mesh(&told);
        assert_eq!(said["mesh"]["counts"], json!([corners.len(), triangles.len()]));
        assert!(is_closed(&triangles), "{add}: every edge twice, there and back");
        let at = |i: u32| corners[i as usize] - middle();
        let volume = triangles.iter().map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c)))).sum::<f64>() / 6.0;
        let told = said["mesh"]["volume_mm3"].as_f64().unwrap();
        println!("{add}: {} triangles, {volume:.1} mm³", triangles.len());
        assert!((volume / told - 1.0).abs() < 1e-6 && volume > 20.0, "faces look outward: {volume} {told}");
        if !lasso {
            // Displaced by its depth, a flat patch would hold this much.
            let (w, h) = (8.0, add["height_mm"].as_f64().unwrap_or(8.0));
            // Its lid stands a little above the surface.
            assert!((volume / (w * h * 5.8) - 1.0).abs() < 0.06, "{volume}");
        }
        say(&mut document, json!({"history":{"undo":{}}}));
    }
}

#[test]
fn a_picture_shows_through_a_window_what_lies_behind() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let pick = |document: &mut Document| {
        let hit = say(document, json!({"ask":{"pick":{"px":[48, 48],"size":SIZE}}}))["hit"].clone();
        hit["rest_mm"].as_array().map(|mm| mm[1].as_f64().unwrap() - middle().y)
    };
    let front = pick(&mut document).unwrap();
    assert!((front + RADIUS).abs() < 0.5, "{front}");
    let plain = picture(&mut document, dir.path());
    say(&mut document, json!({"cutaway":{"add":{"at":on(DVec3::NEG_Y),"width_mm":9,"depth_mm":6,"rim_mm":0}}}));
    let floor = pick(&mut document).unwrap();
    println!("the floor lies {:.2} mm behind the surface", floor - front);
    assert!((floor - front - 6.0).abs() < 0.5, "{floor} {front}");
    let cut = picture(&mut document, dir.path());
    let changed: Vec<DVec2> = cut
        .enumerate_pixels()
        .filter(|(x, y, p)| **p != *plain.get_pixel(*x, *y))
        .map(|(x, y, _)| DVec2::new(f64::from(x), f64::from(y)))
        .collect();
    let far = changed.iter().map(|p| p.distance(DVec2::splat(47.5))).fold(0.0, f64::max);
    assert!(changed.len() > 60 && far < 40.0, "only within the window: {} {far}", changed.len());
    // Deeper, closed, open again, and a part of the past.
    say(&mut document, json!({"cutaway":{"set":{"id":0,"depth_mm":9}}}));
    assert!((pick(&mut document).unwrap() - front - 9.0).abs() < 0.5);
    say(&mut document, json!({"cutaway":{"set":{"id":0,"open":false}}}));
    assert_eq!(picture(&mut document, dir.path()), plain);
    say(&mut document, json!({"history":{"undo":{"steps":2}}}));
    assert_eq!(picture(&mut document, dir.path()), cut);
    run(&mut document, r#"{"cutaway":{"remove":{"id":0}}}"#).unwrap();
    assert_eq!(pick(&mut document), Some(front));
}
