//! The focus of the 3D view: what a script says of it, and where it is.

use super::maker::{labelled, run};
use super::maker_gpu::block;
use burin::document::{Aim, Document, ViewName};
use burin::gpu::Image;
use burin::math::DVec3;
use serde_json::{Value, json};

const SIZE: [u32; 2] = [48, 48];

fn seen(document: &mut Document) -> Image {
    document.picture(ViewName::ThreeD, SIZE, None).unwrap()
}

fn focus(document: &mut Document, change: Value) -> Value {
    run(document, &json!({"view": {"focus": change}}).to_string()).unwrap()["focus"].clone()
}

/// The places of pixels that two pictures show otherwise, in pixels from the middle, largest.
fn changed(a: &Image, b: &Image) -> usize {
    a.colour.iter().zip(&b.colour).filter(|(a, b)| a != b).count()
}

#[test]
fn what_is_left_out_of_a_focus_stays_and_it_goes_back_as_looks_do() {
    let mut document = labelled();
    let before = focus(&mut document, json!({"on": false}));
    assert_eq!(before["on"], false);
    let said = focus(&mut document, json!({"distance_mm": 7.5, "opacity": 0.25, "as": "contour"}));
    assert_eq!(said, json!({"on": true, "distance_mm": 7.5, "opacity": 0.25, "as": "contour"}));
    let said = focus(&mut document, json!({"opacity": 0.5}));
    assert_eq!(said, json!({"on": true, "distance_mm": 7.5, "opacity": 0.5, "as": "contour"}));
    let said = focus(&mut document, json!({"at": {"mm": [1, 2, 3]}}));
    assert_eq!(said["at"], json!([1.0, 2.0, 3.0]));
    assert_eq!(focus(&mut document, json!({"as": "faded"}))["at"], json!([1.0, 2.0, 3.0]));
    assert!(focus(&mut document, json!({"follow": true})).get("at").is_none());
    // It is no step of work, and what was seen before comes back.
    assert_eq!(document.history().undo_names().count(), 0);
    for _ in 0..3 {
        assert_eq!(run(&mut document, r#"{"view":{"back":{}}}"#).unwrap()["of"], "looks");
    }
    let now = *document.state().unwrap().scene.focus;
    assert_eq!((now.opacity, now.at), (0.5, None));
    assert_eq!(run(&mut document, r#"{"ask":{"scene":{}}}"#).unwrap()["scene"]["focus"]["opacity"], 0.5);
}

#[test]
fn a_focus_that_cannot_be_is_refused_by_its_field() {
    let mut document = labelled();
    let before = document.state().unwrap().scene.clone();
    for (change, field) in [
        (json!({"distance_mm": -1.0}), "distance_mm"),
        (json!({"opacity": 1.5}), "opacity"),
        (json!({"follow": true, "at": {"mm": [0, 0, 0]}}), "follow"),
    ] {
        let refused = run(&mut document, &json!({"view": {"focus": change}}).to_string()).unwrap_err().to_string();
        assert!(refused.starts_with(field), "{refused}");
    }
    assert_eq!(document.state().unwrap().scene, before);
}

#[test]
fn a_scene_that_does_not_say_has_none() {
    let document = labelled();
    let mut scene = serde_json::to_value(&document.state().unwrap().scene).unwrap();
    scene.as_object_mut().unwrap().remove("focus").unwrap();
    let scene: burin::document::Scene = serde_json::from_value(scene).unwrap();
    assert!(!scene.focus.on);
}

#[test]
fn a_focus_follows_the_brush_from_dab_to_dab_and_shows_the_footprint_as_it_is() {
    let Some(mut document) = block() else { return };
    run(&mut document, r#"{"brush":{"set":{"radius_mm":5,"target":{"selection":1},"visible_only":false}}}"#).unwrap();
    let plain = seen(&mut document);
    focus(&mut document, json!({"distance_mm": 3.0, "opacity": 0.1}));
    // Nothing was painted and no hand is anywhere.
    assert_eq!(seen(&mut document), plain);
    let mut last = None;
    for x in [20, 44] {
        let points = json!([{"at": {"index": [x, 39, 20]}}]);
        run(&mut document, &json!({"stroke": {"paint": {"points": points}}}).to_string()).unwrap();
        let with = seen(&mut document);
        run(&mut document, r#"{"view":{"focus":{"on":false}}}"#).unwrap();
        let without = seen(&mut document);
        run(&mut document, r#"{"view":{"focus":{"on":true}}}"#).unwrap();
        // The front of the block is seen face on: what is within 8 mm of the dab is a disc there.
        let camera = document.state().unwrap().scene.views.camera;
        let (mut inside, mut faded) = (0, 0);
        for (i, (a, b)) in with.colour.iter().zip(&without.colour).enumerate() {
            let depth = without.depth_mm[i];
            if !depth.is_finite() {
                continue;
            }
            let px = burin::math::DVec2::new((i % 48) as f64 + 0.5, (i / 48) as f64 + 0.5);
            let off = camera.ray(px, SIZE).at(f64::from(depth)).distance(DVec3::new(f64::from(x), 39.0, 20.0));
            if off < 6.5 {
                assert_eq!(a, b, "{px}: {off} mm from the dab");
                assert_eq!((with.depth_mm[i], with.object[i]), (depth, without.object[i]), "{px}");
                inside += 1;
            } else if off > 10.0 {
                assert!(a[3] < b[3], "{px}: {a:?} {b:?}");
                faded += 1;
            }
        }
        assert!(inside > 20 && faded > 200, "{inside} {faded}");
        assert!(last.is_none_or(|last| changed(&last, &with) > 100));
        last = Some(with);
    }
    // A hand that hovers elsewhere takes it along; so does a place that is named.
    assert!(document.aim(Some(Aim { rest: DVec3::new(20.0, 39.0, 20.0), part: None })));
    let hovered = seen(&mut document);
    assert!(changed(&hovered, last.as_ref().unwrap()) > 100);
    focus(&mut document, json!({"at": {"index": [20, 39, 20]}}));
    assert!(!document.aim(None), "what stays where it is follows no hand");
    assert_eq!(seen(&mut document).colour, hovered.colour);
    // Strokes, picks and depths do not heed it.
    assert_eq!(hovered.depth_mm, seen(&mut document).depth_mm);
    let px = json!({"ask": {"pick": {"px": [70, 48]}}}).to_string();
    let picked = run(&mut document, &px).unwrap();
    run(&mut document, r#"{"view":{"focus":{"on":false}}}"#).unwrap();
    assert_eq!(run(&mut document, &px).unwrap(), picked);
    assert!(picked["hit"] != json!(false) && picked.to_string().len() > 20);
}

#[test]
fn a_focus_goes_with_the_part_that_its_place_is_of() {
    let Some(mut document) = block() else { return };
    run(&mut document, r#"{"part":{"split":{"by":{"plane":{"normal":[1,0,0],"point":[32,24,20]}}}}}"#).unwrap();
    focus(&mut document, json!({"distance_mm": 6.0, "opacity": 0.0, "at": {"index": [20, 39, 20]}}));
    let middle = |image: &Image| {
        let shown: Vec<_> = image.colour.iter().enumerate().filter(|(_, c)| c[3] > 0.0).map(|(i, _)| i / 48).collect();
        assert!(shown.len() > 10, "{}", shown.len());
        shown.iter().sum::<usize>() as f64 / shown.len() as f64
    };
    let before = middle(&seen(&mut document));
    let parts = document.state().unwrap().scene.explosion.parts.clone();
    let left = document.state().unwrap().scene.explosion.of_body(0, DVec3::new(20.0, 39.0, 20.0)).unwrap();
    assert_eq!(parts.len(), 2);
    let pose = json!({"rotation": [0, 0, 0, 1], "translation": [0.0, 0.0, 26.0]});
    run(&mut document, &json!({"part": {"move": {"id": left, "pose": pose}}}).to_string()).unwrap();
    // Where it was at rest nothing is left.
    let after = middle(&seen(&mut document));
    assert!(before - after > 6.0, "{before} {after}");
}
