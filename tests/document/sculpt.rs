//! Strokes that change what the 3D view shows: where they go on hangs on what was there when they began, not on what they dug or
//! heaped up meanwhile, nor on how often the pointer was asked.

use super::maker::{bytes, run};
use super::maker_gpu::made;
use crate::common::one::One;
use burin::document::{Document, ViewName};
use burin::math::DVec3;
use burin::volume::Voxels;
use serde_json::{Value, json};

/// A ball of 20 voxels' radius whose values rise inwards, opaque from 105 on, in a volume of some bricks; seen from the front.
fn ball(settings: &[Value]) -> Option<Document> {
    let at = |i: u32| DVec3::new(f64::from(i % 70), f64::from(i / 70 % 64), f64::from(i / (70 * 64)));
    let value = |p: DVec3| 105.0 + 20.0 * (20.0 - p.distance(DVec3::splat(31.5)));
    let voxels = (0..70 * 64 * 40).map(|i| value(at(i)).clamp(0.0, 255.0) as u8).collect();
    let mut document = made(Voxels::U8(voxels), [70, 64, 40], DVec3::ONE)?;
    let first = [
        json!({"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0],[100,0],[110,1]],"unit_mm":1}}}}),
        json!({"view":{"size":{"view":"3d","size":[128,128]}}}),
        json!({"view":{"frame":{"from":[0.3,1,0.4]}}}),
    ];
    for line in first.iter().chain(settings) {
        run(&mut document, &line.to_string()).unwrap();
    }
    Some(document)
}

/// To and fro over the middle, in steps of some pixels.
fn to_and_fro(apart: u32) -> Vec<[f64; 2]> {
    let way = (0..=60).chain((0..60).rev()).chain(1..=60);
    way.step_by(apart as usize).map(|i| [34.0 + f64::from(i), 64.0]).collect()
}

fn points(line: &[[f64; 2]]) -> Value {
    line.iter().map(|px| json!({"at":{"pixel":{"view":"3d","px":px,"size":[128,128]}}})).collect()
}

/// The stroke as a hand paints it: point by point, and a picture of each.
fn live(document: &mut Document, line: &[[f64; 2]]) -> Value {
    for (i, px) in line.iter().enumerate() {
        let verb = if i == 0 { "begin" } else { "extend" };
        run(document, &json!({"stroke":{verb:{"points":points(&[*px])}}}).to_string()).unwrap();
        document.picture(ViewName::ThreeD, [32, 32], None).unwrap();
    }
    run(document, r#"{"stroke":{"end":{}}}"#).unwrap()
}

fn lives_as_at_once(what: &str, settings: &[Value]) {
    let Some(mut whole) = ball(settings) else { return };
    let Some(mut running) = ball(settings) else { return };
    let line = to_and_fro(3);
    let stroke = json!({"stroke":{"paint":{"points":points(&line)}}}).to_string();
    let [at_once, by_hand] = [run(&mut whole, &stroke).unwrap(), live(&mut running, &line)];
    assert!(at_once["voxels_changed"].as_u64().unwrap() > 100, "{what}: {at_once}");
    for about in ["voxels_changed", "dabs", "missed"] {
        assert_eq!(at_once[about], by_hand[about], "{what}: {about}");
    }
    assert!(bytes(&whole) == bytes(&running), "{what}");
}

fn brush(settings: Value) -> Value {
    json!({"brush":{"set":settings}})
}

#[test]
fn density_that_is_taken_away_or_added_does_not_lead_the_stroke() {
    let carve = json!({"radius_mm":4,"falloff":"hard","target":{"density":0.0}});
    lives_as_at_once("carving", &[brush(carve.clone())]);
    let mut erase = carve.clone();
    erase["erase"] = json!(true);
    erase["erase_density"] = json!({"to":20.0});
    lives_as_at_once("erasing to a value", &[brush(erase)]);
    // Deep enough that whole cells of what is skipped are empty.
    let dig = json!({"radius_mm":11,"falloff":"hard","target":{"density":0.0}});
    lives_as_at_once("digging", &[brush(dig)]);
    let heap = json!({"radius_mm":5,"target":{"density":250.0},"strength":0.7});
    lives_as_at_once("heaping up", &[brush(heap)]);
    // Under the iso-surface and the maximum too.
    for mode in [json!({"iso":105.0}), json!("mip")] {
        lives_as_at_once("carving", &[brush(carve.clone()), json!({"view":{"look":{"mode":mode}}})]);
    }
}

#[test]
fn what_looks_around_goes_where_a_script_goes_and_reads_what_was_there_at_the_start() {
    for operation in ["raise", "fill"] {
        let set = json!({"radius_mm":5,"target":{"density":0},"operation":operation,"height_mm":2,"reach_mm":1.5});
        lives_as_at_once(operation, &[brush(set)]);
    }
    let limits = json!({"radius_mm":5,"shape":"ellipsoid","ratio":0.4,"target":{"label":1},"within_mm":2.5,"connected":true,"mirror":{"axis":"x"}});
    lives_as_at_once("limits", &[brush(limits)]);
}

#[test]
fn the_picture_of_a_running_stroke_is_that_of_the_same_volume_read_again() {
    for operation in ["raise", "smooth", "fill"] {
        let set = json!({"radius_mm":6,"target":{"density":0},"operation":operation,"height_mm":2.5,"reach_mm":1.5});
        let Some(mut document) = ball(&[brush(set)]) else { return };
        run(&mut document, r#"{"view":{"look":{"mode":{"iso":105}}}}"#).unwrap();
        let first = document.picture(ViewName::ThreeD, [128, 128], None).unwrap();
        let line = to_and_fro(5);
        run(&mut document, &json!({"stroke":{"begin":{"points":points(&line)}}}).to_string()).unwrap();
        let mut running = document.picture(ViewName::ThreeD, [128, 128], None).unwrap();
        run(&mut document, r#"{"stroke":{"end":{}}}"#).unwrap();
        if operation == "fill" {
            // As one it is known at the end.
            running = document.picture(ViewName::ThreeD, [128, 128], None).unwrap();
        }
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap();
        let again = document.picture(ViewName::ThreeD, [128, 128], None).unwrap();
        assert!(first.colour != running.colour, "{operation} shows");
        assert!(running.colour == again.colour, "{operation}");
    }
}

#[test]
fn a_stroke_that_keeps_to_the_surface_keeps_to_the_one_at_its_start() {
    let carve = json!({"radius_mm":4,"falloff":"hard","target":{"density":0.0},"visible_only":true});
    lives_as_at_once("carving", &[brush(carve.clone())]);
    // What lay under the first layer is as it was.
    let Some(mut document) = ball(&[brush(carve)]) else { return };
    live(&mut document, &to_and_fro(5));
    let density = &document.state().unwrap().one().density;
    for z in 0..40 {
        for y in 0..64 {
            for x in 0..70 {
                let inside = 20.0 - DVec3::new(f64::from(x), f64::from(y), f64::from(z)).distance(DVec3::splat(31.5));
                let value = (105.0 + 20.0 * inside).clamp(0.0, 255.0) as u8;
                let now = density.value([x, y, z]).unwrap();
                assert!(now == f32::from(value) || now == 0.0 && inside < 2.0, "{inside} deep: {now} for {value}");
            }
        }
    }
}

#[test]
fn voxels_that_the_selection_takes_from_a_moved_part_do_not_lead_the_stroke() {
    let settings = [
        // Something is selected, so that parts draw what is not.
        brush(json!({"radius_mm":4,"target":{"selection":1.0},"falloff":"hard"})),
        json!({"stroke":{"paint":{"points":[{"at":{"index":[31,20,20]}}]}}}),
        json!({"part":{"split":{"by":{"plane":{"point":[0,31.5,0],"normal":[0,1,0]}}}}}),
    ];
    let Some(mut probe) = ball(&settings) else { return };
    let parts = run(&mut probe, r#"{"ask":{"parts":{}}}"#).unwrap();
    let front = parts["parts"][1]["id"].clone();
    let pose = json!({"rotation":[0,0,0,1],"translation":[0,15,0]});
    let moved = [json!({"part":{"move":{"id":front,"pose":pose}}}), brush(json!({"radius_mm":3}))];
    lives_as_at_once("selecting", &[settings.to_vec(), moved.to_vec()].concat());
}
