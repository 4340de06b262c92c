//! Pictures for files: sizes, supersampling, backgrounds, and equal bytes for equal runs.

use super::maker::run;
use super::maker_gpu::{block, cut};
use burin::document::{Document, ViewName};
use exr::prelude::read_first_flat_layer_from_file;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Draws a picture of 40 × 30 pixels, or as `extra` says; answers with its path and what was said.
fn render(document: &mut Document, folder: &Path, name: &str, extra: Value) -> Result<(PathBuf, Value), String> {
    let path = folder.join(name);
    let mut image = json!({ "path": path, "size": [40, 30] });
    image.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
    let said = run(document, &json!({"render":{"image":image}}).to_string()).map_err(|e| e.to_string())?;
    Ok((path, said))
}

fn png(path: &Path) -> image::RgbaImage {
    image::open(path).unwrap().to_rgba8()
}

/// A channel of an EXR, row by row.
pub fn channel(path: &Path, name: &str) -> Vec<f32> {
    let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
    let found = layer.channel_data.list.iter().find(|c| c.name.to_string() == name);
    found.unwrap_or_else(|| panic!("no channel {name}")).sample_data.values_as_f32().collect()
}

/// The block in its 8 parts, moved apart, seen from aside.
fn exploded() -> Option<Document> {
    let mut document = block()?;
    cut(&mut document);
    run(&mut document, r#"{"explosion":{"degree":{"value":0.6}}}"#).unwrap();
    run(&mut document, r#"{"explosion":{"settle":{}}}"#).unwrap();
    run(&mut document, r#"{"view":{"frame":{"from":[0.4,1,0.5],"zoom":1.2}}}"#).unwrap();
    Some(document)
}

#[test]
fn a_supersampled_picture_is_the_mean_of_the_larger_one() {
    let Some(mut document) = exploded() else { return };
    let folder = tempfile::tempdir().unwrap();
    for view in ["3d", "coronal"] {
        let mut draw = |name: &str, extra: Value| {
            let mut extra = extra;
            extra["view"] = json!(view);
            render(&mut document, folder.path(), name, extra).unwrap().0
        };
        for factor in [2, 3, 8] {
            let background = [0.2, 0.9, 0.4];
            let large_size = json!([40 * factor, 30 * factor]);
            let small = png(&draw("small.png", json!({ "supersample": factor, "background": background })));
            let large = png(&draw("large.png", json!({ "size": large_size, "background": background })));
            assert_eq!(small.dimensions(), (40, 30));
            let mut inner = 0;
            for (x, y, pixel) in small.enumerate_pixels() {
                for c in 0..3 {
                    let taps = (0..factor * factor).map(|i| (x * factor + i % factor, y * factor + i / factor));
                    let all: Vec<f64> = taps.map(|(x, y)| f64::from(large.get_pixel(x, y).0[c])).collect();
                    let mean = all.iter().sum::<f64>() / all.len() as f64;
                    assert!((mean - f64::from(pixel.0[c])).abs() <= 1.0, "{view} {factor} {x} {y}");
                    inner += usize::from(all.iter().any(|a| (a - all[0]).abs() > 20.0));
                }
            }
            assert!(inner > 20, "{view} {factor}: edges are among what was averaged: {inner}");
        }
    }
}

#[test]
fn depth_and_object_of_a_supersampled_picture_are_one_samples_own() {
    let Some(mut document) = exploded() else { return };
    let folder = tempfile::tempdir().unwrap();
    for factor in [2_usize, 3] {
        let small = render(&mut document, folder.path(), "s.exr", json!({ "supersample": factor })).unwrap().0;
        let size = json!([40 * factor, 30 * factor]);
        let large = render(&mut document, folder.path(), "l.exr", json!({ "size": size })).unwrap().0;
        let (z, id) = (channel(&small, "Z"), channel(&small, "id"));
        let (large_z, large_id) = (channel(&large, "Z"), channel(&large, "id"));
        let mut ids = std::collections::BTreeSet::new();
        for i in 0..40 * 30 {
            // The middle sample of an odd number, the nearest of the four about the middle of an even one.
            let middle: &[usize] = if factor == 2 { &[0, 1] } else { &[1] };
            let taps = middle.iter().flat_map(|y| middle.iter().map(move |x| (x, y)));
            let taps = taps.map(|(x, y)| (i / 40 * factor + y) * 40 * factor + i % 40 * factor + x);
            let nearest = taps.min_by(|a, b| large_z[*a].total_cmp(&large_z[*b])).unwrap();
            assert_eq!((z[i], id[i]), (large_z[nearest], large_id[nearest]), "{factor} {i}");
            ids.insert(id[i] as u32);
        }
        assert!(ids.len() > 4, "several parts show: {ids:?}");
    }
}

#[test]
fn a_picture_of_several_pieces_is_the_picture() {
    let Some(mut document) = exploded() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Wider and higher than a piece is, in few pixels.
    for size in [[4200, 8], [8, 2100]] {
        let camera = document.state().unwrap().scene.views.camera.zoomed(if size[0] > size[1] { 0.02 } else { 2.0 });
        let extra = json!({ "size": size, "camera": camera });
        let path = render(&mut document, folder.path(), "wide.png", extra).unwrap().0;
        let whole = document.picture(ViewName::ThreeD, size, Some(camera)).unwrap().to_rgba8(Some([0.0; 3]));
        let far = png(&path).as_raw().iter().zip(&whole).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        let drawn = whole.chunks(4).filter(|p| p[0] > 0).count();
        // At another corner a ray's last bit is another one.
        assert!(far * 200 < whole.len() && drawn * 10 > whole.len() / 4, "{size:?}: {far} of {drawn}");
    }
    let slice = json!({ "size": [2100, 40], "view": "axial" });
    let path = render(&mut document, folder.path(), "wide.png", slice).unwrap().0;
    let whole = document.picture(ViewName::Axial, [2100, 40], None).unwrap().to_rgba8(Some([0.0; 3]));
    let far = png(&path).as_raw().iter().zip(&whole).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert!(far * 200 < whole.len() && whole.chunks(4).any(|p| p[0] > 100), "{far}");
}

#[test]
fn what_lies_behind_is_the_looks_or_the_commands_or_nothing() {
    let Some(mut document) = block() else { return };
    let folder = tempfile::tempdir().unwrap();
    run(&mut document, r#"{"view":{"look":{"background":[0,0,1]}}}"#).unwrap();
    for view in ["3d", "axial"] {
        let mut corner = |extra: Value| {
            let mut extra = extra;
            extra["view"] = json!(view);
            let (path, said) = render(&mut document, folder.path(), "p.png", extra).unwrap();
            assert_eq!((&said["view"], &said["size"]), (&json!(view), &json!([40, 30])));
            assert_eq!(said["path"], json!(path.display().to_string()));
            png(&path).get_pixel(0, 0).0
        };
        assert_eq!(corner(json!({})), [0, 0, 255, 255]);
        assert_eq!(corner(json!({ "background": [1, 0.2, 0] })), [255, 51, 0, 255]);
        assert_eq!(corner(json!({ "transparent": true })), [0; 4]);
        assert_eq!(corner(json!({ "transparent": true, "supersample": 2 })), [0; 4]);
    }
}

#[test]
fn pictures_that_cannot_be_are_refused_with_what_can() {
    let Some(mut document) = block() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut refused = |extra: Value| render(&mut document, folder.path(), "p.png", extra).unwrap_err();
    assert_eq!(refused(json!({ "supersample": 0 })), "supersample: 0 found, 1 to 8 expected");
    assert_eq!(refused(json!({ "supersample": 9 })), "supersample: 9 found, 1 to 8 expected");
    assert!(refused(json!({ "size": [20_000, 4] })).contains("1 to 16384 pixels either way, 67108864 in all"));
    assert!(refused(json!({ "size": [16_384, 16_384] })).contains("67108864 in all"));
    assert!(refused(json!({ "background": [1, 2, 0] })).contains("red, green and blue of 0 to 1"));
    assert!(refused(json!({ "background": [1, 0, 0], "transparent": true })).contains("one of the two"));
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none(), "nothing is left");
}

#[test]
fn equal_runs_write_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut first: Vec<Vec<u8>> = Vec::new();
    for n in 0..3 {
        let Some(mut document) = exploded() else { return };
        let mut draw = |name: &str, extra: Value| {
            std::fs::read(render(&mut document, folder.path(), name, extra).unwrap().0).unwrap()
        };
        // Enough pixels that several threads have something to pack.
        let large = json!({ "size": [300, 200] });
        let all = vec![draw("a.exr", large.clone()), draw("a.png", large.clone())];
        // Another look about, and back: what is held by now is more.
        let turn = |document: &mut Document| {
            run(document, r#"{"view":{"orbit":{"azimuth_deg":70,"elevation_deg":20}}}"#).unwrap();
            document.picture(ViewName::ThreeD, [64, 64], None).unwrap();
            document.picture(ViewName::Axial, [64, 64], None).unwrap();
            run(document, r#"{"view":{"back":{}}}"#).unwrap();
        };
        turn(&mut document);
        for (name, before) in ["a.exr", "a.png"].into_iter().zip(&all) {
            let (path, _) = render(&mut document, folder.path(), name, large.clone()).unwrap();
            assert!(std::fs::read(path).unwrap() == *before, "{name} after a look about");
        }
        match n {
            0 => first = all,
            _ => assert!(first == all, "run {n}"),
        }
    }
}
