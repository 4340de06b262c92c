//! What picks, pictures' channels and slices say of a box that has its own resolution, fields and look.

use super::maker::run;
use super::maker_gpu::block;
use super::pictures::channel;
use burin::document::{Document, ViewName};
use burin::math::DVec3;
use serde_json::{Value, json};

fn does(document: &mut Document, command: Value) -> Value {
    run(document, &command.to_string()).unwrap_or_else(|error| panic!("{command}: {error}"))
}

const SIZE: [u32; 2] = [120, 120];

/// The block from above, with a box in its upper face and a dab in that.
fn seen() -> Option<Document> {
    let mut document = block()?;
    let brush = json!({"target": {"selection": 1.0}, "falloff": "hard", "radius_mm": 2.0});
    for command in [
        json!({"sub_volume": {"add": {"lo": [20, 14, 10], "hi": [36, 30, 36], "scale": [4, 4, 2]}}}),
        json!({"view": {"look": {"mode": {"iso": 150}}}}),
        json!({"view": {"size": {"view": "3d", "size": SIZE}}}),
        json!({"view": {"size": {"view": "axial", "size": SIZE}}}),
        json!({"view": {"frame": {"from": [0, 0, 1]}}}),
        json!({"brush": {"set": brush}}),
        json!({"stroke": {"paint": {"points": [{"at": {"mm": [28, 22, 31]}}], "volume": 1}}}),
    ] {
        does(&mut document, command);
    }
    Some(document)
}

fn px_of(document: &Document, mm: [f64; 3]) -> [f64; 2] {
    let camera = document.state().unwrap().scene.views.camera;
    camera.project(DVec3::from_array(mm), SIZE).unwrap().0.to_array()
}

#[test]
fn a_pick_through_a_box_tells_the_boxs_voxel_and_what_is_selected_there() {
    let Some(mut document) = seen() else { return };
    let mut pick = |mm: [f64; 3]| {
        let px = px_of(&document, mm);
        does(&mut document, json!({"ask": {"pick": {"px": px}}}))["hit"].clone()
    };
    let close = |hit: &Value, expected: [f64; 3]| {
        let index: Vec<f64> = serde_json::from_value(hit["index"].clone()).unwrap();
        assert!((0..3).all(|a| (index[a] - expected[a]).abs() < 0.2), "{hit}");
    };
    let on_dab = pick([28.0, 22.0, 31.25]);
    assert_eq!((&on_dab["volume"], &on_dab["selected"]), (&json!(1), &json!(true)), "{on_dab}");
    close(&on_dab, [32.0, 32.0, 2.0 * 21.25]);
    let beside_dab = pick([33.0, 22.0, 31.25]);
    assert_eq!((&beside_dab["volume"], &beside_dab["selected"]), (&json!(1), &json!(false)), "{beside_dab}");
    let beside_box = pick([40.0, 22.0, 31.25]);
    assert_eq!((&beside_box["volume"], &beside_box["selected"]), (&json!(0), &json!(false)), "{beside_box}");
    close(&beside_box, [40.0, 22.0, 31.25]);
    // What the box shows for itself is told of it too.
    let voxel = does(&mut document, json!({"ask": {"voxel": {"at": {"index": [32, 32, 42]}, "volume": 1}}}));
    assert_eq!(voxel["selection"], json!(1.0), "{voxel}");
}

#[test]
fn channels_of_a_picture_name_the_box_where_its_voxels_show() {
    let Some(mut document) = seen() else { return };
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("p.exr");
    does(&mut document, json!({"render": {"image": {"path": path, "size": SIZE}}}));
    let at = |name: &str, mm: [f64; 3]| {
        let px = px_of(&document, mm);
        channel(&path, name)[px[1] as usize * SIZE[0] as usize + px[0] as usize]
    };
    let all = |mm| ["volume", "id", "selected"].map(|name| at(name, mm));
    assert_eq!(all([28.0, 22.0, 31.25]), [2.0, 1.0, 1.0], "on the dab");
    assert_eq!(all([33.0, 22.0, 31.25]), [2.0, 1.0, 0.0], "beside it in the box");
    assert_eq!(all([40.0, 22.0, 31.25]), [1.0, 1.0, 0.0], "beside the box");
    assert!((at("Z", [28.0, 22.0, 31.25]) - at("Z", [40.0, 22.0, 31.25])).abs() < 3.0, "one surface");
}

#[test]
fn slices_show_a_box_by_its_own_voxels_and_its_own_window() {
    let Some(mut document) = seen() else { return };
    // Half a voxel of the parent wide: no voxel of that could show it.
    let brush = json!({"target": {"density": 40}, "operation": "replace", "falloff": "hard", "radius_mm": 0.4});
    for command in [
        json!({"brush": {"set": brush}}),
        json!({"stroke": {"paint": {"points": [{"at": {"mm": [28.5, 22.5, 20.0]}}], "volume": 1}}}),
        json!({"view": {"window": {"volume": 0, "level": 125, "width": 250}}}),
        json!({"view": {"crosshair": {"at": {"mm": [28.5, 22.5, 20.0]}}}}),
    ] {
        does(&mut document, command);
    }
    let grey = |document: &mut Document, mm: [f64; 3]| {
        let picture = document.picture(ViewName::Axial, SIZE, None).unwrap();
        let state = document.state().unwrap();
        let grid = *state.at(None).unwrap().grid();
        let plane = burin::document::SlicePlane::new(&grid, &state.scene.views, ViewName::Axial).unwrap();
        // The pixel nearest to the place.
        let centre = |i: usize| burin::math::DVec2::new((i % 120) as f64 + 0.5, (i / 120) as f64 + 0.5);
        let off = |i: usize| plane.world(centre(i)).distance(DVec3::from_array(mm));
        let nearest = (0..picture.colour.len()).min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap();
        f64::from(picture.colour[nearest][1]) * 250.0
    };
    let [inside, beside] = [[28.5, 22.5, 20.0], [30.0, 22.5, 20.0]];
    assert!(grey(&mut document, inside) < 120.0, "the dab shows: {}", grey(&mut document, inside));
    assert!(
        (grey(&mut document, beside) - 200.0).abs() < 1.0,
        "the parent's window is its own: {}",
        grey(&mut document, beside)
    );
    does(&mut document, json!({"view": {"window": {"volume": 1, "level": 250, "width": 500}}}));
    assert!((grey(&mut document, beside) - 100.0).abs() < 1.0, "its own window: {}", grey(&mut document, beside));
    assert!((grey(&mut document, [45.0, 22.5, 20.0]) - 200.0).abs() < 1.0, "the parent's stays");
    does(&mut document, json!({"volume": {"set": {"volume": 1, "visible": false}}}));
    assert!((grey(&mut document, inside) - 200.0).abs() < 1.0, "hidden it hides nothing");
}
