//! Pictures of strokes over the faces of boxes: when the stroke has ended they are those of the same volumes opened again.

use super::boxes::{does, opened};
use super::maker_gpu::block;
use burin::document::Document;
use serde_json::{Value, json};
use std::path::Path;

fn picture(document: &mut Document, folder: &Path) -> Vec<u8> {
    let path = folder.join("picture.png");
    does(document, json!({"render": {"image": {"path": path, "size": [96, 96]}}}));
    let pixels = image::open(&path).unwrap().into_rgba8().into_raw();
    std::fs::remove_file(path).unwrap();
    pixels
}

fn differing(a: &[u8], b: &[u8]) -> (usize, u8) {
    let off = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    (off.clone().filter(|d| *d > 0).count(), off.max().unwrap())
}

#[test]
fn a_stroke_over_faces_looks_as_it_will_when_it_is_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let brushes: [(Value, Value); 4] = [
        (json!({"target": {"density": 160}, "operation": "subtract", "falloff": "smooth"}), json!("dvr")),
        (json!({"target": {"density": 60}, "operation": "replace", "falloff": "hard"}), json!({"iso": 150})),
        (json!({"target": {"colour": [0, 0.2, 1, 1]}, "operation": "replace", "falloff": "gaussian"}), json!("dvr")),
        (json!({"target": {"selection": 1}, "operation": "replace", "falloff": "smooth"}), json!({"iso": 150})),
    ];
    for (at, (brush, mode)) in brushes.into_iter().enumerate() {
        let Some(mut document) = block() else { return };
        let scale = [2, 4, 3, 5][at];
        for command in [
            json!({"sub_volume": {"add": {"lo": [20, 14, 22], "hi": [36, 30, 36], "scale": scale}}}),
            json!({"sub_volume": {"add": {"lo": [36, 14, 22], "hi": [44, 30, 36], "scale": 2}}}),
            json!({"view": {"look": {"mode": mode, "refine": false}}}),
            json!({"view": {"frame": {"from": [0.2, 0.1, 1]}}}),
            json!({"brush": {"set": brush}}),
            json!({"brush": {"set": {"radius_mm": 4}}}),
        ] {
            does(&mut document, command);
        }
        let before = picture(&mut document, folder.path());
        // Over the volume, the first box, the face between both, the second one, and out again.
        let points = json!([{"at": {"mm": [15, 20, 31]}}, {"at": {"mm": [48, 24, 31]}}]);
        does(&mut document, json!({"stroke": {"paint": {"points": points}}}));
        let after = picture(&mut document, folder.path());
        assert!(differing(&before, &after).0 > 500, "{at}: it shows");
        let path = folder.path().join(format!("{at}.burin"));
        does(&mut document, json!({"project": {"save": {"path": path}}}));
        drop(document);
        let again = picture(&mut opened(&path), folder.path());
        assert_eq!(differing(&again, &after), (0, 0), "{at}: opened again");
    }
}
