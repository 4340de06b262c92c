//! Strokes of 2,000 dabs, event by event: what a frame of a running stroke waits for, at its beginning and at its end.
//!
//! A frame is an event of the pointer, four dabs further on, and a picture after it, which waits for the device. The way goes to and fro over
//! a face of a cube, so that every frame meets new ground as the first one does.

use super::cube::{apply, over};
use super::head::Failure;
use super::measure::{Report, Time, median};
use burin::document::{Document, ViewName};
use serde_json::{Value, json};
use std::time::Instant;

const SIDE: u32 = 160;
const RADIUS_MM: f64 = 5.0;
/// Dabs lie a quarter of the radius apart.
const DABS_A_FRAME: f64 = 4.0;
const FRAMES: usize = 500;
/// Frames of a hundred dabs.
const HUNDRED: usize = 25;

/// Where the hand is after a way of so many mm: rows over the upper face, 2 mm apart.
fn place(way: f64) -> [f64; 3] {
    let (from, to) = (f64::from(SIDE) * 0.25 + 6.0, f64::from(SIDE) * 0.75 - 6.0);
    let (row, along) = ((way / (to - from)).floor(), way % (to - from));
    let x = if row % 2.0 == 0.0 { from + along } else { to - along };
    [x, from + 2.0 * row, f64::from(SIDE) * 0.75 - 1.0]
}

/// A cube of about 180 in clear space, seen from above.
fn canvas(folder: &std::path::Path) -> Result<Document, Failure> {
    let mut voxels = vec![0_u8; (SIDE as usize).pow(3)];
    let inside = SIDE / 4..SIDE * 3 / 4;
    for (i, voxel) in (0_u32..).zip(&mut voxels) {
        let at = [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
        if at.iter().all(|v| inside.contains(v)) {
            *voxel = 176 + (i.wrapping_mul(2_654_435_761) >> 29) as u8;
        }
    }
    let mut document = over(voxels, SIDE, folder)?;
    let function = json!({"colour": [[0, [1.0, 0.8, 0.6]]], "opacity": [[90, 0.0], [110, 0.9]], "unit_mm": 1.0});
    apply(&mut document, json!({"transfer": {"set": {"function": function}}}))?;
    apply(&mut document, json!({"view": {"frame": {"from": [0.0, 0.3, 1.0]}}}))?;
    apply(&mut document, json!({"view": {"size": {"view": "3d", "size": [320, 240]}}}))?;
    Ok(document)
}

/// Milliseconds of every frame, and of the stroke's end.
fn frames(document: &mut Document, count: usize) -> Result<(Vec<f64>, f64), Failure> {
    let at = |way: f64| json!([{"at": {"mm": place(way)}}]);
    let step = RADIUS_MM * 0.25 * DABS_A_FRAME;
    apply(document, json!({"stroke": {"begin": {"points": at(0.0)}}}))?;
    let mut times = Vec::new();
    for i in 1..=count {
        let begun = Instant::now();
        apply(document, json!({"stroke": {"extend": {"points": at(step * i as f64)}}}))?;
        document.picture(ViewName::ThreeD, [64, 48], None)?;
        times.push(begun.elapsed().as_secs_f64() * 1e3);
    }
    let begun = Instant::now();
    apply(document, json!({"stroke": {"end": {}}}))?;
    Ok((times, begun.elapsed().as_secs_f64() * 1e3))
}

pub fn running(report: &mut Report) -> Result<(), Failure> {
    let plain = |target: Value, operation: &str| json!({"target": target, "operation": operation, "any_value": true});
    let density = |operation: &str| {
        let mut brush = plain(json!({"density": 60.0}), operation);
        brush["height_mm"] = json!(1.5);
        brush
    };
    let limited = |limit: (&str, Value)| {
        let mut brush = plain(json!({"density": 200.0}), "replace");
        brush[limit.0] = limit.1;
        brush
    };
    let kinds: [(&str, Value, bool); 12] = [
        ("selection", plain(json!({"selection": 1.0}), "replace"), false),
        ("colour", plain(json!({"colour": [0.9, 0.3, 0.1, 0.8]}), "blend"), false),
        ("labels", plain(json!({"label": 3}), "replace"), false),
        ("density, add", density("add"), false),
        ("density, smooth", density("smooth"), false),
        ("density, median", density("median"), false),
        ("density, raise", density("raise"), false),
        ("density, push", density("push"), false),
        ("density, fill", density("fill"), false),
        ("density, connected", limited(("connected", json!(true))), false),
        ("density, visible", limited(("visible_only", json!(true))), false),
        ("density, in a box of 2×", density("add"), true),
    ];
    for (name, brush, boxed) in kinds {
        let folder = tempfile::tempdir()?;
        let mut document = canvas(folder.path())?;
        if boxed {
            let (lo, hi) = (SIDE / 4 - 8, SIDE * 3 / 4 + 8);
            apply(
                &mut document,
                json!({"sub_volume": {"add": {"lo": [lo, lo, hi - 24], "hi": [hi, hi, hi], "scale": 2}}}),
            )?;
        }
        let mut all = json!({"radius_mm": RADIUS_MM, "falloff": "smooth", "shape": "sphere"});
        all.as_object_mut().ok_or("a brush")?.extend(brush.as_object().cloned().unwrap_or_default());
        apply(&mut document, json!({"brush": {"set": all}}))?;
        // What is compiled and uploaded once is no frame's of the stroke.
        frames(&mut document, HUNDRED)?;
        apply(&mut document, json!({"history": {"undo": {}}}))?;
        let (times, end) = frames(&mut document, FRAMES)?;
        let [first, last] = [&times[..HUNDRED], &times[FRAMES - HUNDRED..]].map(|part| median(part.to_vec()));
        let worst = times.iter().copied().fold(0.0, f64::max);
        let beside = format!(
            "{:.2} of the first 100's {first:.1}; all {:.1}, worst {worst:.1}, the end {end:.0}",
            last / first,
            median(times.clone())
        );
        report.row(&format!("a frame after 1,900 dabs: {name}"), Time { wall: last, cpu: 0.0 }, &beside);
    }
    Ok(())
}
