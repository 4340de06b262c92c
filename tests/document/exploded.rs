//! Parts on the picture: picks, splitters, forces, pictures.

use super::maker::{bytes, run};
use super::maker_gpu::{block, cut, select};
use crate::common::one::One;
use burin::document::{Document, ViewName};
use burin::math::{DVec3, Pose};
use serde_json::{Value, json};

fn settle(document: &mut Document, degree: f64) -> Value {
    run(document, &json!({"explosion":{"degree":{"value":degree}}}).to_string()).unwrap();
    run(document, r#"{"explosion":{"settle":{}}}"#).unwrap()
}

#[test]
fn a_pixel_on_a_moved_part_is_its_voxel_at_rest() {
    let Some(mut document) = block() else { return };
    let plane = r#"{"part":{"split":{"by":{"plane":{"point":[31.5,0,0],"normal":[1,0,0]}}}}}"#;
    let halves = run(&mut document, plane).unwrap()["halves"].clone();
    // The half at larger x is moved up by 30 mm; its front face is then seen 30 mm higher.
    let upper = halves[0][1].clone();
    let moved = json!({"part":{"move":{"id":upper,"pose":{"rotation":[0,0,0,1],"translation":[0,0,30]}}}});
    run(&mut document, &moved.to_string()).unwrap();
    let camera = document.state().unwrap().scene.views.camera;
    let (px, _) = camera.project(DVec3::new(45.0, 39.5, 52.0), [96, 96]).unwrap();
    let hit = run(&mut document, &json!({"ask":{"pick":{"px":px.to_array()}}}).to_string()).unwrap()["hit"].clone();
    assert_eq!(hit["part"], upper);
    let rest: Vec<f64> = serde_json::from_value(hit["rest_mm"].clone()).unwrap();
    // Within a step of the ray.
    assert!(DVec3::from_slice(&rest).distance(DVec3::new(45.0, 39.5, 22.0)) < 1.5, "{rest:?}");
    // Whatever is asked or put at a pixel is asked and put where the part rests.
    let at = json!({"pixel":{"view":"3d","px":px.to_array()}});
    let voxel = run(&mut document, &json!({"ask":{"voxel":{"at":at}}}).to_string()).unwrap();
    assert_eq!(voxel["voxel"], json!([45, 39, 22]), "{voxel}");
    let crosshair = run(&mut document, &json!({"view":{"crosshair":{"at":at}}}).to_string()).unwrap();
    assert!((crosshair["index"][2].as_f64().unwrap() - 22.0).abs() < 1.5, "{crosshair}");
    run(&mut document, r#"{"brush":{"set":{"target":{"label":4},"radius_mm":2,"falloff":"hard"}}}"#).unwrap();
    let stroke = json!({"stroke":{"paint":{"points":[{"at":{"pixel":{"view":"3d","px":px.to_array()}}}]}}});
    assert_eq!(run(&mut document, &stroke.to_string()).unwrap()["missed"], 0);
    assert_eq!(document.state().unwrap().one().labels.value([45, 39, 22]).unwrap(), 4.0);
    // Beside it there is nothing.
    let nothing = run(&mut document, r#"{"ask":{"pick":{"px":[1,1]}}}"#).unwrap();
    assert_eq!(nothing["hit"], Value::Null);
    let error = run(&mut document, r#"{"view":{"crosshair":{"at":{"pixel":{"view":"3d","px":[1,1]}}}}}"#).unwrap_err();
    assert!(error.to_string().contains("where nothing is visible"), "{error}");
}

#[test]
fn splitters_cut_what_is_under_the_pixel() {
    let Some(mut document) = block() else { return };
    let split = |d: &mut Document, by: Value| run(d, &json!({"part":{"split":{"by":by}}}).to_string());
    let axis = json!({"axis":{"px":[48,48],"axis":"vertical"}});
    assert_eq!(split(&mut document, axis).unwrap()["parts"], 2);
    let cuts = |d: &Document| -> Vec<DVec3> {
        let parts = &d.state().unwrap().scene.explosion.parts;
        parts.iter().flat_map(|p| p.faces.iter().filter(|f| f.cut).map(|f| f.plane.normal)).collect()
    };
    // Seen from the front the vertical plane through the middle has a normal along x.
    assert!(cuts(&document).iter().all(|n| n.x.abs() > 0.999));
    let depth = json!({"depth":{"px":[40,48]}});
    assert_eq!(split(&mut document, depth).unwrap()["parts"], 3);
    assert!(cuts(&document).iter().any(|n| n.y.abs() > 0.999));
    let before = document.state().unwrap().scene.clone();
    assert!(split(&mut document, json!({"depth":{"px":[1,1]}})).is_err());
    assert_eq!(document.state().unwrap().scene, before);
}

#[test]
fn the_same_camera_gives_the_same_poses_whatever_came_before() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    let steps = document.history().undo_names().len();
    let first = settle(&mut document, 1.0);
    assert!(first["visible"].as_f64().unwrap() >= 0.99, "{first}");
    assert!(first["rounds"].as_u64().unwrap() <= 12 && first["steps"].as_u64().unwrap() <= 1500);
    run(&mut document, r#"{"view":{"frame":{"from":[1,1,1]}}}"#).unwrap();
    let other = run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap();
    assert_ne!(other["poses"], first["poses"]);
    run(&mut document, r#"{"explosion":{"step":{"steps":7}}}"#).unwrap();
    run(&mut document, r#"{"view":{"back":{}}}"#).unwrap();
    assert_eq!(run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap()["poses"], first["poses"]);
    // Where the forces take the parts is no step: one undo closes the explosion again.
    assert_eq!(document.history().undo_names().len(), steps + 1);
    let open = bytes(&document);
    let apart = run(&mut document, r#"{"ask":{"parts":{}}}"#).unwrap();
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    let parts = &document.state().unwrap().scene.explosion.parts;
    assert!(document.poses().in_order(parts).iter().all(|p| *p == Pose::IDENTITY));
    run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap();
    assert_eq!(bytes(&document), open);
    assert_eq!(run(&mut document, r#"{"ask":{"parts":{}}}"#).unwrap(), apart);
}

#[test]
fn degree_zero_is_the_identity_and_its_picture_the_whole_one() {
    let Some(mut document) = block() else { return };
    select(&mut document);
    let picture = |d: &mut Document| d.picture(ViewName::ThreeD, [64, 64], None).unwrap().colour;
    let whole = picture(&mut document);
    cut(&mut document);
    settle(&mut document, 1.0);
    assert_ne!(picture(&mut document), whole);
    settle(&mut document, 0.0);
    let parts = &document.state().unwrap().scene.explosion.parts;
    assert!(document.poses().in_order(parts).iter().all(|p| *p == Pose::IDENTITY));
    // Each part and the selection as bodies of their own: the same but for rounding where they meet.
    let id = document.state().unwrap().scene.explosion.parts[0].id;
    run(&mut document, &json!({"part":{"set":{"id":id,"colour":[1,1,1]}}}).to_string()).unwrap();
    let worst = picture(&mut document)
        .iter()
        .flatten()
        .zip(whole.iter().flatten())
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max);
    assert!(worst <= 1.0 / 255.0, "{worst}");
}

#[test]
fn the_window_s_steps_arrive_where_settle_does() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    run(&mut document, r#"{"explosion":{"degree":{"value":0.7}}}"#).unwrap();
    let mut frames = 0;
    let last = loop {
        let answer = run(&mut document, r#"{"explosion":{"step":{"steps":4}}}"#).unwrap();
        frames += 1;
        if answer["moving"] == false || frames > 400 {
            break answer;
        }
    };
    assert!(frames > 3 && frames < 400, "{frames}");
    assert_eq!(run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap()["poses"], last["poses"]);
}

#[test]
fn forces_follow_a_stroke_that_is_still_running() {
    // A selection that grows, and matter that is painted away from under one half of it.
    for target in [json!({"selection": 1}), json!({"density": 0})] {
        let Some(mut document) = block() else { return };
        cut(&mut document);
        if target["density"] == 0 {
            select(&mut document);
        }
        run(&mut document, r#"{"explosion":{"degree":{"value":1}}}"#).unwrap();
        let steps = |document: &mut Document| loop {
            let answer = run(document, r#"{"explosion":{"step":{"steps":10}}}"#).unwrap();
            if answer["moving"] == false {
                break answer["poses"].clone();
            }
        };
        let rest = steps(&mut document);
        let set = json!({"brush":{"set":{"target":target,"radius_mm":12,"falloff":"hard"}}});
        run(&mut document, &set.to_string()).unwrap();
        run(&mut document, r#"{"stroke":{"begin":{"points":[{"at":{"mm":[38,23,19]}}]}}}"#).unwrap();
        let during = steps(&mut document);
        assert!(document.is_painting());
        assert_ne!(rest, during, "{target}");
        // The stroke's end brings nothing new: what was known of its cells was right.
        run(&mut document, r#"{"stroke":{"end":{}}}"#).unwrap();
        assert_eq!(steps(&mut document), during, "{target}");
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        assert_eq!(steps(&mut document), rest, "{target}");
    }
}

#[test]
fn pictures_go_to_files_by_extension() {
    let Some(mut document) = block() else { return };
    let folder = tempfile::tempdir().unwrap();
    let render = |d: &mut Document, name: &str, extra: Value| {
        let mut image = json!({ "path": folder.path().join(name), "size": [40, 30] });
        image.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        run(d, &json!({"render":{"image":image}}).to_string())
    };
    assert!(render(&mut document, "a.png", json!({})).unwrap()["covered"].as_f64().unwrap() > 0.02);
    render(&mut document, "b.exr", json!({})).unwrap();
    render(&mut document, "c.png", json!({ "view": "coronal", "transparent": true })).unwrap();
    assert_eq!(image::image_dimensions(folder.path().join("a.png")).unwrap(), (40, 30));
    let drawn = document.picture(ViewName::ThreeD, [40, 30], None).unwrap();
    let exr = folder.path().join("b.exr");
    let [z, id, alpha] = ["Z", "id", "A"].map(|name| super::pictures::channel(&exr, name));
    assert_eq!((&z, alpha), (&drawn.depth_mm, drawn.colour.iter().map(|c| c[3]).collect()));
    assert_eq!(id, drawn.object.iter().map(|o| o.body().map_or(0.0, |id| id as f32 + 1.0)).collect::<Vec<_>>());
    assert!(z.iter().any(|z| z.is_finite()) && z.iter().any(|z| z.is_infinite()) && id.contains(&1.0));
    // Linear light of the display's colour, IEC 61966-2-1, still multiplied by what covers the ground.
    for (n, name) in ["R", "G", "B"].into_iter().enumerate() {
        let light = super::pictures::channel(&exr, name);
        for (i, colour) in drawn.colour.iter().enumerate() {
            let (shown, a) = (colour[n], colour[3]);
            let straight = if a > 0.0 { shown / a } else { 0.0 };
            let linear = if straight <= 0.04045 { straight / 12.92 } else { ((straight + 0.055) / 1.055).powf(2.4) };
            assert!((light[i] - linear * a).abs() < 1e-3, "{name} {i}: {} for {shown} of {a}", light[i]);
        }
    }
    let lit = drawn.colour.iter().filter(|c| c[3] > 0.5 && c[0] > c[1] + 0.05 && c[1] > c[2] + 0.05).count();
    assert!(lit > 20, "three channels that are told apart: {lit}");
    let error = render(&mut document, "d.jpg", json!({})).unwrap_err().to_string();
    assert!(error.contains(".png or .exr expected"), "{error}");
    let error = render(&mut document, "e.png", json!({ "size": [0, 3] })).unwrap_err().to_string();
    assert_eq!(error, "size: [0, 3] found, 1 to 16384 pixels either way, 67108864 in all expected");
}
