//! Strokes by command, on the GPU.

use super::maker::{bytes, run};
use super::maker_gpu::block;
use crate::common::one::One;
use burin::document::{Document, ViewName};
use burin::volume::FieldKind;
use rand::{Rng, SeedableRng};
use serde_json::{Value, json};

fn paint(document: &mut Document, target: Value, mm: [f64; 3]) -> Value {
    run(document, &json!({"brush":{"set":{"target":target,"radius_mm":5}}}).to_string()).unwrap();
    run(document, &json!({"stroke":{"paint":{"points":[{"at":{"mm":mm}}]}}}).to_string()).unwrap()
}

#[test]
fn strokes_on_every_field_come_back_byte_for_byte() {
    for budget in [1 << 30, 0] {
        let Some(mut document) = block() else { return };
        run(&mut document, &json!({"history":{"budget":{"bytes":budget}}}).to_string()).unwrap();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut states = vec![bytes(&document)];
        for i in 0..16 {
            let target = match i % 4 {
                0 => json!({"density": rng.random_range(-50.0..400.0)}),
                1 => json!({"colour": [0.1, 0.9, 0.2, 1.0]}),
                2 => json!({"selection": 1.0}),
                _ => json!({"label": i + 1}),
            };
            let at = |rng: &mut rand_chacha::ChaCha8Rng| json!({"at":{"index":[rng.random_range(-2.0..66.0), rng.random_range(-2.0..50.0), rng.random_range(0.0..40.0)]}});
            let points = [at(&mut rng), at(&mut rng)];
            let set = json!({"brush":{"set":{"target":target,"radius_mm":rng.random_range(0.0..9.0),"erase":i > 11}}});
            run(&mut document, &set.to_string()).unwrap();
            let answer = run(&mut document, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap();
            if answer["step"] != Value::Null {
                assert!(answer["voxels_changed"].as_u64().unwrap() > 0);
                states.push(bytes(&document));
            } else {
                assert_eq!(bytes(&document), *states.last().unwrap());
            }
        }
        assert!(states.len() > 12);
        for way in ["undo", "redo"] {
            let walk: Vec<_> =
                if way == "undo" { states.iter().rev().skip(1).collect() } else { states.iter().skip(1).collect() };
            for state in walk {
                run(&mut document, &format!(r#"{{"history":{{"{way}":{{}}}}}}"#)).unwrap();
                assert_eq!(bytes(&document), *state, "{way}");
            }
        }
    }
}

#[test]
fn a_stroke_that_changes_nothing_is_no_step() {
    let Some(mut document) = block() else { return };
    let before = (bytes(&document), document.history().undo_names().len());
    // A label far outside would have made a segment, a density beyond the codes a wider map.
    for target in [json!({"label": 9}), json!({"density": 5000.0})] {
        let answer = paint(&mut document, target, [500.0, 0.0, 0.0]);
        assert_eq!((&answer["step"], &answer["voxels_changed"]), (&Value::Null, &json!(0)));
        assert_eq!((bytes(&document), document.history().undo_names().len()), before);
    }
    run(&mut document, r#"{"brush":{"set":{"erase":true}}}"#).unwrap();
    assert_eq!(paint(&mut document, json!({"selection": 1.0}), [30.0, 20.0, 20.0])["step"], Value::Null);
}

#[test]
fn density_beyond_its_codes_gets_wider_ones_and_keeps_what_was_painted() {
    let Some(mut document) = block() else { return };
    let value = |d: &mut Document, at: [u32; 3]| {
        run(d, &json!({"ask":{"voxel":{"at":{"index":at}}}}).to_string()).unwrap()["density"].as_f64().unwrap()
    };
    run(&mut document, r#"{"brush":{"set":{"falloff":"hard"}}}"#).unwrap();
    paint(&mut document, json!({"density": 150.0}), [20.0, 20.0, 20.0]);
    let narrow = bytes(&document);
    paint(&mut document, json!({"density": 70_000.0}), [45.0, 30.0, 20.0]);
    // Exact: integers of a span over 65,535 are kept as 32-bit floats.
    for (at, expected) in [([45, 30, 20], 70_000.0), ([20, 20, 20], 150.0), ([10, 30, 25], 200.0), ([1, 1, 1], 0.0)] {
        assert_eq!(value(&mut document, at), expected, "{at:?}");
    }
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(bytes(&document), narrow);
    run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap();
    assert_eq!(value(&mut document, [45, 30, 20]), 70_000.0);
    // And the picture is drawn from the new codes.
    assert!(document.picture(ViewName::ThreeD, [32, 32], None).unwrap().colour.iter().any(|c| c[3] > 0.5));
}

#[test]
fn what_builds_up_adds_every_dab_until_the_type_can_hold_no_more() {
    let Some(mut document) = block() else { return };
    let value = |d: &mut Document, at: [u32; 3]| {
        run(d, &json!({"ask":{"voxel":{"at":{"index":at}}}}).to_string()).unwrap()["density"].as_f64().unwrap()
    };
    let untouched = bytes(&document);
    let brush = json!({"brush":{"set":{"falloff":"hard","radius_mm":4,"tip":"build_up","operation":"add","target":{"density":3.0}}}});
    run(&mut document, &brush.to_string()).unwrap();
    let to = |verb: &str, x: f64| json!({"stroke":{verb:{"points":[{"at":{"index":[x, 4, 20]}}]}}}).to_string();
    // Dabs a millimetre apart: nine reach a voxel on the way, nine more on the way back but for the one where it turns.
    run(&mut document, &to("begin", 12.0)).unwrap();
    run(&mut document, &to("extend", 40.0)).unwrap();
    run(&mut document, &to("extend", 12.0)).unwrap();
    run(&mut document, r#"{"stroke":{"end":{}}}"#).unwrap();
    for (at, dabs) in [([26, 4, 20], 18), ([40, 4, 20], 9), ([45, 4, 20], 0), ([26, 8, 20], 2)] {
        let before = if at[1] >= 8 { 200.0 } else { 0.0 };
        let (found, expected) = (value(&mut document, at), before + 3.0 * f64::from(dabs));
        assert!((found - expected).abs() < 0.01, "{at:?}: {found}, {expected} expected");
    }
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(bytes(&document), untouched);
    // Four ways add up to more than there was room for at the stroke's beginning: it is painted anew with wider codes.
    let ways = |document: &mut Document, n: usize| {
        for i in 0..=n {
            let verb = if i == 0 { "begin" } else { "extend" };
            let at = json!({"index":[if i.is_multiple_of(2) { 12 } else { 40 }, 20, 20]});
            run(document, &json!({"stroke":{verb:{"points":[{"at":at}]}}}).to_string()).unwrap();
        }
        run(document, r#"{"stroke":{"end":{}}}"#).unwrap();
    };
    run(&mut document, r#"{"brush":{"set":{"target":{"density":1.0}}}}"#).unwrap();
    ways(&mut document, 4);
    assert!((value(&mut document, [26, 20, 20]) - 236.0).abs() < 0.01);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(bytes(&document), untouched);
    // 200 + 18·30 is no byte any more.
    run(&mut document, r#"{"brush":{"set":{"target":{"density":30.0}}}}"#).unwrap();
    ways(&mut document, 2);
    assert!((value(&mut document, [26, 20, 20]) - 255.0).abs() < 0.01);
}

#[test]
fn a_cancelled_stroke_leaves_nothing_but_was_seen() {
    let Some(mut document) = block() else { return };
    let picture = |d: &mut Document| d.picture(ViewName::ThreeD, [48, 48], None).unwrap().colour;
    let (before, seen) = (bytes(&document), picture(&mut document));
    run(&mut document, r#"{"brush":{"set":{"target":{"density":0},"radius_mm":12}}}"#).unwrap();
    run(&mut document, r#"{"stroke":{"begin":{"points":[{"at":{"pixel":{"view":"3d","px":[48,48]}}}]}}}"#).unwrap();
    run(&mut document, r#"{"stroke":{"extend":{"points":[{"at":{"mm":[20,39,20]}}]}}}"#).unwrap();
    assert_ne!(picture(&mut document), seen);
    run(&mut document, r#"{"stroke":{"cancel":{}}}"#).unwrap();
    assert_eq!(picture(&mut document), seen);
    assert_eq!(bytes(&document), before);
    assert!(run(&mut document, r#"{"stroke":{"end":{}}}"#).unwrap_err().to_string().contains("no stroke is running"));
}

#[test]
fn undo_shows_in_the_next_picture() {
    let Some(mut document) = block() else { return };
    let pictures = |d: &mut Document| {
        [ViewName::ThreeD, ViewName::Axial, ViewName::Coronal, ViewName::Sagittal]
            .map(|view| d.picture(view, [48, 48], None).unwrap().colour)
    };
    let before = pictures(&mut document);
    paint(&mut document, json!({"density": 0.0}), [31.0, 39.0, 19.0]);
    paint(&mut document, json!({"colour": [0.0, 0.0, 1.0, 1.0]}), [20.0, 39.0, 19.0]);
    let after = pictures(&mut document);
    assert_ne!(after, before);
    run(&mut document, r#"{"history":{"undo":{"steps":2}}}"#).unwrap();
    assert_eq!(pictures(&mut document), before);
    run(&mut document, r#"{"history":{"redo":{"steps":2}}}"#).unwrap();
    assert_eq!(pictures(&mut document), after);
}

#[test]
fn other_commands_end_a_running_stroke_and_questions_do_not() {
    let Some(mut document) = block() else { return };
    run(&mut document, r#"{"stroke":{"begin":{"points":[{"at":{"mm":[30,20,20]}}]}}}"#).unwrap();
    for line in [
        r#"{"ask":{"voxel":{"at":{"mm":[1,1,1]}}}}"#,
        r#"{"view":{"orbit":{"azimuth_deg":5,"elevation_deg":0}}}"#,
        r#"{"explosion":{"step":{"steps":1}}}"#,
    ] {
        run(&mut document, line).unwrap();
        assert!(document.is_painting(), "{line}");
    }
    assert!(run(&mut document, r#"{"stroke":{"begin":{"points":[]}}}"#).is_err());
    run(&mut document, r#"{"view":{"window":{"level":7,"width":7}}}"#).unwrap();
    assert!(!document.is_painting());
    let names: Vec<_> = document.history().undo_names().collect();
    assert_eq!(names, ["Paint selection"]);
}

#[test]
fn a_locked_segment_and_a_range_keep_their_voxels() {
    let Some(mut document) = block() else { return };
    run(&mut document, r#"{"brush":{"set":{"falloff":"hard","range":[100,300]}}}"#).unwrap();
    paint(&mut document, json!({"label": 1}), [8.0, 20.0, 20.0]);
    let label = |d: &Document, v: [u32; 3]| d.state().unwrap().one().labels.value(v).unwrap();
    assert_eq!((label(&document, [9, 20, 20]), label(&document, [6, 20, 20])), (1.0, 0.0));
    run(&mut document, r#"{"segment":{"set":{"id":1,"locked":true}}}"#).unwrap();
    paint(&mut document, json!({"label": 2}), [11.0, 20.0, 20.0]);
    assert_eq!((label(&document, [9, 20, 20]), label(&document, [15, 20, 20])), (1.0, 2.0));
}

#[test]
fn a_stroke_outlives_the_loss_of_its_device() {
    let Some(mut whole) = block() else { return };
    let Some(mut broken) = block() else { return };
    let gpu = burin::gpu::Gpu::headless().unwrap();
    broken.use_gpu(gpu.clone());
    for (document, breaks) in [(&mut whole, false), (&mut broken, true)] {
        run(document, r#"{"brush":{"set":{"target":{"density":10},"radius_mm":6}}}"#).unwrap();
        run(document, r#"{"stroke":{"begin":{"points":[{"at":{"mm":[20,20,20]}}]}}}"#).unwrap();
        if breaks {
            gpu.raw().0.destroy();
            let _gone = gpu.raw().0.poll(wgpu::PollType::wait_indefinitely());
            assert!(gpu.lost());
        }
        run(document, r#"{"stroke":{"extend":{"points":[{"at":{"mm":[40,25,20]}}]}}}"#).unwrap();
        run(document, r#"{"stroke":{"end":{}}}"#).unwrap();
    }
    assert_eq!(bytes(&whole), bytes(&broken));
    assert!(broken.state().unwrap().one().field(FieldKind::Density).edits().len() > 1);
}

#[test]
fn a_stroke_that_was_running_at_a_crash_is_finished() {
    let Some(probe) = block() else { return };
    drop(probe);
    let folder = tempfile::tempdir().unwrap();
    let (volume, project) = (folder.path().join("v.nrrd"), folder.path().join("p"));
    let grid = burin::volume::Grid::aligned([40, 36, 34], burin::math::DVec3::ONE, burin::math::DVec3::ZERO);
    super::maker::write_nrrd(&volume, &grid, |v| v[0] as f32);
    let begin = |name: &str| {
        let mut document = Document::new();
        run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
        let path = project.with_extension(name);
        run(&mut document, &json!({"project":{"save":{"path":path}}}).to_string()).unwrap();
        run(&mut document, r#"{"brush":{"set":{"radius_mm":6}}}"#).unwrap();
        run(&mut document, r#"{"stroke":{"begin":{"points":[{"at":{"mm":[10,10,10]},"pressure":0.5}]}}}"#).unwrap();
        run(&mut document, r#"{"stroke":{"extend":{"points":[{"at":{"mm":[30,20,30]}}]}}}"#).unwrap();
        (document, path)
    };
    let (mut whole, _) = begin("whole");
    run(&mut whole, r#"{"stroke":{"end":{}}}"#).unwrap();
    let (crashed, path) = begin("crashed");
    drop(crashed);
    let mut again = Document::new();
    let answer = run(&mut again, &json!({"project":{"open":{"path":path}}}).to_string()).unwrap();
    assert_eq!(answer["recovered"]["stroke"], "painted");
    assert_eq!(bytes(&again), bytes(&whole));
    assert_eq!(again.history().undo_names().collect::<Vec<_>>(), ["Paint selection"]);
}

#[test]
fn a_stroke_that_turns_into_an_erasing_one_is_two_steps() {
    let Some(mut document) = block() else { return };
    let selected = |d: &mut Document, x: u32| {
        run(d, &json!({"ask":{"voxel":{"at":{"index":[x, 20, 20]}}}}).to_string()).unwrap()["selection"]
            .as_f64()
            .unwrap()
    };
    let steps = document.history().undo_names().len();
    let at = |x: f64| json!([{"at":{"index":[x, 20.0, 20.0]}}]);
    // What the window sends while E is pressed in mid-stroke: painted to 40, from there back to 25 taken away.
    for line in [
        json!({"brush":{"set":{"target":{"selection":1.0},"radius_mm":3,"falloff":"hard"}}}),
        json!({"stroke":{"begin":{"points":at(10.0)}}}),
        json!({"stroke":{"extend":{"points":at(40.0)}}}),
        json!({"stroke":{"end":{}}}),
        json!({"brush":{"set":{"erase":true}}}),
        json!({"stroke":{"begin":{"points":at(40.0)}}}),
        json!({"stroke":{"extend":{"points":at(25.0)}}}),
        json!({"stroke":{"end":{}}}),
    ] {
        run(&mut document, &line.to_string()).unwrap();
    }
    assert_eq!([15, 21, 24, 40].map(|x| selected(&mut document, x)), [1.0, 1.0, 0.0, 0.0]);
    assert_eq!(document.history().undo_names().skip(steps).collect::<Vec<_>>(), ["Paint selection", "Erase selection"]);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!([15, 24, 40].map(|x| selected(&mut document, x)), [1.0; 3], "one step back the painted stroke is whole");
}

#[test]
fn pictures_follow_a_wider_map_and_its_undo() {
    let picture = |d: &mut Document| d.picture(ViewName::ThreeD, [48, 48], None).unwrap().colour;
    let widen = |d: &mut Document| {
        run(d, r#"{"brush":{"set":{"falloff":"hard"}}}"#).unwrap();
        paint(d, json!({"density": 50.0}), [20.0, 20.0, 30.0]);
        paint(d, json!({"density": 70_000.0}), [45.0, 30.0, 33.0]);
    };
    let Some(mut document) = block() else { return };
    let first = picture(&mut document);
    widen(&mut document);
    let wide = picture(&mut document);
    assert_ne!(first, wide);
    // One that drew nothing before.
    let Some(mut other) = block() else { return };
    widen(&mut other);
    let back = |d: &mut Document| run(d, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(picture(&mut other), wide);
    back(&mut document);
    back(&mut other);
    assert_eq!(picture(&mut document), picture(&mut other));
    back(&mut document);
    assert_eq!(picture(&mut document), first);
}

#[test]
fn a_stroke_whose_device_and_source_were_lost_can_be_cancelled() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    // One of its own, to lose.
    let gpu = burin::gpu::Gpu::headless().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let volume = folder.path().join("v.nrrd");
    let grid = burin::volume::Grid::aligned([40, 36, 34], burin::math::DVec3::ONE, burin::math::DVec3::ZERO);
    super::maker::write_nrrd(&volume, &grid, |v| v[0] as f32);
    let mut document = Document::new();
    document.use_gpu(gpu.clone());
    run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
    run(&mut document, r#"{"brush":{"set":{"target":{"density":10},"radius_mm":6}}}"#).unwrap();
    run(&mut document, r#"{"stroke":{"begin":{"points":[{"at":{"mm":[20,20,20]}}]}}}"#).unwrap();
    gpu.raw().0.destroy();
    let _gone = gpu.raw().0.poll(wgpu::PollType::wait_indefinitely());
    // Its source fails for a while, too.
    let written = std::fs::metadata(&volume).unwrap().modified().unwrap();
    let dated = |at| std::fs::File::options().write(true).open(&volume).unwrap().set_modified(at).unwrap();
    dated(std::time::UNIX_EPOCH);
    run(&mut document, r#"{"stroke":{"extend":{"points":[{"at":{"mm":[30,25,20]}}]}}}"#).unwrap_err();
    run(&mut document, r#"{"stroke":{"cancel":{}}}"#).unwrap();
    dated(written);
    let before = bytes(&document);
    run(&mut document, r#"{"stroke":{"paint":{"points":[{"at":{"mm":[10,10,10]}}]}}}"#).unwrap();
    let after = bytes(&document);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert!(after != before && bytes(&document) == before);
}
