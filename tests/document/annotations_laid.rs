//! How annotations lie: on the surface that the voxels make, wherever these are edited, moved or finer.

use super::annotations::{ISO, RADIUS, ball, middle, on, say, text};
use burin::document::{Document, Subject};
use burin::math::{DQuat, DVec3, Pose};
use burin::volume::VolumeId;
use serde_json::{Value, json};

/// How far a place is from the surface, voxels of a volume, by its numbers as they are now: the trilinear value over its slope along the
/// steepest of many directions.
fn off(subject: &Subject<'_>, at: DVec3) -> f64 {
    let grid = subject.grid();
    let value = |p: DVec3| {
        let index = grid.index_from_world().transform_point3(p);
        let base = index.floor().clamp(DVec3::ZERO, grid.dims_f64() - 2.0);
        let part = index - base;
        let values = subject.volume.density.values(base.to_array().map(|x| x as u32), [2; 3]).unwrap();
        let mut all = [0.0; 8];
        values.each(|i, number| all[i] = number.to_f64());
        (0..8)
            .map(|i| {
                let share = |a: usize| if i >> a & 1 == 1 { part[a] } else { 1.0 - part[a] };
                share(0) * share(1) * share(2) * all[i]
            })
            .sum::<f64>()
            - ISO
    };
    let h = 0.05 * grid.voxel_mm();
    let slope =
        DVec3::from_array([DVec3::X, DVec3::Y, DVec3::Z].map(|a| (value(at + a * h) - value(at - a * h)) / (2.0 * h)));
    value(at).abs() / slope.length() / grid.voxel_mm()
}

fn vertices(document: &mut Document, id: u32) -> Vec<Option<DVec3>> {
    let said = say(document, json!({"ask":{"annotations":{"id":id,"vertices":true}}}));
    let all: Vec<Option<[f64; 3]>> =
        serde_json::from_value(said["annotations"][0]["grid"]["vertices"].clone()).unwrap();
    all.into_iter().map(|v| v.map(DVec3::from_array)).collect()
}

/// The greatest distance of a grid's vertices from the surface, voxels, and how many there are.
fn worst(document: &mut Document, volume: u32) -> (f64, usize) {
    let all = vertices(document, 0);
    let state = document.state().unwrap();
    let subject = state.subject(VolumeId(volume)).unwrap();
    let inside = |p: &DVec3| {
        let q = subject.grid().index_from_world().transform_point3(*p);
        q.cmpge(DVec3::splat(0.01)).all() && q.cmple(subject.grid().dims_f64() - 1.01).all()
    };
    let there: Vec<DVec3> = all.iter().flatten().copied().filter(inside).collect();
    (there.iter().map(|p| off(&subject, *p)).fold(0.0, f64::max), there.len())
}

fn sculpt(document: &mut Document, brush: Value, direction: DVec3, volume: u32) {
    say(document, json!({"brush":{"set":brush}}));
    let points = json!([{"at":on(direction)}]);
    say(document, json!({"stroke":{"paint":{"points":points,"volume":volume}}}));
}

#[test]
fn every_vertex_lies_on_the_surface_of_the_voxels() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    for (more, name) in [
        (json!({}), "text"),
        (json!({"relaxed":false}), "plain"),
        (json!({"text":"A long line of words","size_mm":3}), "long"),
        (json!({"directions":"most_curved"}), "curved"),
    ] {
        let said = text(&mut document, more);
        let (far, count) = worst(&mut document, 0);
        println!("{name}: {count} vertices, at most {far:.4} voxels off");
        assert!(far <= 0.05 && count > 40, "{name}: {far} {count}");
        assert_eq!(said["grid"]["turned_over"], 0, "{said}");
        say(&mut document, json!({"history":{"undo":{}}}));
    }
}

#[test]
fn a_grid_follows_what_is_done_to_the_density_and_back() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    text(&mut document, json!({}));
    let plain = vertices(&mut document, 0);
    let height = |p: &Option<DVec3>| p.map_or(0.0, |p| p.distance(middle()));
    for (operation, way) in [("raise", 1.0), ("lower", -1.0)] {
        let brush =
            json!({"target":{"density":0},"operation":operation,"height_mm":1.5,"radius_mm":5,"falloff":"smooth"});
        sculpt(&mut document, brush, DVec3::NEG_Y, 0);
        let (far, count) = worst(&mut document, 0);
        let all = vertices(&mut document, 0);
        let moved = (height(&all[all.len() / 2]) - height(&plain[plain.len() / 2])) * way;
        println!("{operation}: the centre goes {moved:.2} mm; {count} vertices, at most {far:.4} voxels off");
        assert!(far <= 0.05 && moved > 0.7, "{operation}: {far} {moved}");
        say(&mut document, json!({"history":{"undo":{}}}));
        assert_eq!(vertices(&mut document, 0), plain, "{operation} is undone");
    }
    // Elsewhere nothing happens to it.
    let brush = json!({"target":{"density":0},"operation":"raise","height_mm":1.5,"radius_mm":4,"falloff":"smooth"});
    sculpt(&mut document, brush, DVec3::Y, 0);
    assert_eq!(vertices(&mut document, 0), plain);
}

#[test]
fn a_grid_is_trimmed_where_the_surface_was_taken_away_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let said = text(&mut document, json!({"text":"words here"}));
    assert_eq!((&said["grid"]["trimmed"], &said["grid"]["remarks"]), (&json!(0), &Value::Null), "{said}");
    // A shell with a hole a little beside the centre: the surface turns back within two voxels there.
    let brush = json!({"target":{"density":0},"operation":"replace","radius_mm":12.5,"falloff":"hard"});
    say(&mut document, json!({"brush":{"set":brush}}));
    for at in [middle(), middle() + DVec3::new(14.0, -8.0, 0.0)] {
        say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":at.to_array()}}]}}}));
    }
    let said = say(&mut document, json!({"ask":{"annotations":{}}}))["annotations"][0]["grid"].take();
    let trimmed = said["trimmed"].as_u64().unwrap();
    println!(
        "{trimmed} of {} vertices are trimmed",
        said["columns"].as_u64().unwrap() * said["rows"].as_u64().unwrap()
    );
    assert!(trimmed > 0, "{said}");
    assert!(said["remarks"][0].as_str().unwrap().contains("left out"), "{said}");
    let (far, _) = worst(&mut document, 0);
    assert!(far <= 0.05, "what is left lies on the surface: {far}");
    // All of it.
    say(&mut document, json!({"brush":{"set":{"radius_mm":40}}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":middle().to_array()}}]}}}));
    let said = say(&mut document, json!({"ask":{"annotations":{}}}))["annotations"][0]["grid"].take();
    assert!(said["remarks"][0].as_str().unwrap().contains("no surface"), "{said}");
}

#[test]
fn a_volume_that_is_moved_carries_what_lies_on_it() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    text(&mut document, json!({}));
    let before = vertices(&mut document, 0);
    let pose = Pose { rotation: DQuat::from_rotation_z(0.7), translation: DVec3::new(5.0, -3.0, 11.0) };
    say(&mut document, json!({"volume":{"set":{"volume":0,"pose":pose}}}));
    let after = vertices(&mut document, 0);
    let to = pose.world_from_rest();
    let moved = before.iter().zip(&after).map(|(a, b)| to.transform_point3(a.unwrap()).distance(b.unwrap()));
    let far = moved.fold(0.0, f64::max);
    println!("carried to {far:.1e} mm");
    assert!(far < 0.02, "{far}");
}

#[test]
fn edits_of_a_sub_volume_are_followed_at_its_own_resolution() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    text(&mut document, json!({}));
    let plain = vertices(&mut document, 0);
    let grid = super::annotations::grid();
    let index = grid.index_from_world().transform_point3(middle() + DVec3::NEG_Y * RADIUS);
    let corner = |by: f64| (index + by).round().clamp(DVec3::ZERO, grid.dims_f64() - 1.0).to_array().map(|x| x as u32);
    say(&mut document, json!({"sub_volume":{"add":{"lo":corner(-10.0),"hi":corner(10.0),"scale":2}}}));
    let brush = json!({"target":{"density":0},"operation":"raise","height_mm":1,"radius_mm":3,"falloff":"smooth"});
    sculpt(&mut document, brush, DVec3::NEG_Y, 1);
    let (far, count) = worst(&mut document, 1);
    let all = vertices(&mut document, 0);
    let moved = all[all.len() / 2].unwrap().distance(plain[plain.len() / 2].unwrap());
    println!("in a box: the centre goes {moved:.2} mm; {count} vertices, at most {far:.4} of its voxels off");
    // The tolerance is one of the volume's voxels, half as large as the box's are many.
    assert!(far <= 0.05 && count > 40 && moved > 0.4, "{far} {count} {moved}");
}

#[test]
fn a_ruler_is_as_long_as_the_arc() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    for (a, b) in [(DVec3::NEG_Y, DVec3::X), (DVec3::new(0.3, -1.0, 0.6), DVec3::new(-0.5, 0.1, 1.0))] {
        let (a, across) = (a.normalize(), b.reject_from(a).normalize());
        let to = a * 1.0_f64.cos() + across * 1.0_f64.sin();
        let content = json!({"ruler":{"to":[0,0,0]}});
        let said =
            say(&mut document, json!({"annotation":{"add":{"content":content,"at":on(a),"to":on(to),"size_mm":1}}}));
        let length = said["grid"]["length_mm"].as_f64().unwrap();
        println!("1 rad of {RADIUS} mm: {length:.4} mm, {:.3} % off", (length / RADIUS - 1.0) * 100.0);
        assert!((length / RADIUS - 1.0).abs() < 0.003, "{length}");
    }
}

#[test]
fn a_ruler_whose_end_is_cut_away_says_so_and_comes_back() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = ball(dir.path()) else { return };
    let content = json!({"ruler":{"to":[0,0,0]}});
    let line = json!({"annotation":{"add":{"content":content,"at":on(DVec3::NEG_Y),"to":on(DVec3::X),"size_mm":1}}});
    let before = say(&mut document, line)["grid"]["length_mm"].take();
    let brush = json!({"target":{"density":0},"operation":"replace","radius_mm":40,"falloff":"hard"});
    say(&mut document, json!({"brush":{"set":brush}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":middle().to_array()}}]}}}));
    let picture = json!({"render":{"image":{"path":dir.path().join("gone.png")}}});
    text(&mut document, json!({}));
    // What failed once is remembered: the second asking answers as the first does.
    for _ in 0..2 {
        let said = say(&mut document, json!({"ask":{"annotations":{}}}))["annotations"].take();
        assert!(said[0]["grid"].is_null(), "{said}");
        assert!(said[0]["not_shown"].as_str().unwrap().contains("no surface"), "{said}");
        assert!(said[1]["grid"]["remarks"][0].as_str().unwrap().contains("no surface"), "the other is told of: {said}");
        say(&mut document, picture.clone());
    }
    say(&mut document, json!({"history":{"undo":{}}}));
    say(&mut document, json!({"history":{"undo":{}}}));
    let said = say(&mut document, json!({"ask":{"annotations":{}}}))["annotations"][0].take();
    assert_eq!((&said["grid"]["length_mm"], &said["not_shown"]), (&before, &Value::Null), "{said}");
}
