//! Hours of work take no more memory than minutes.
//!
//! The child is this test binary again, so that no other test's memory is counted: it draws, picks, slices, strokes and undoes,
//! and says how much of its memory is resident on the way.

use super::maker::run;
use super::maker_gpu::{block, cut};
use burin::document::ViewName;
use serde_json::{Value, json};
use std::process::Command as Process;

/// Of pictures, slices and picks each, with a stroke and an undo in every fifth.
const ROUNDS: usize = 1000;
/// Targets and operations that take turns.
const BRUSHES: [(&str, &str); 8] = [
    (r#"{"selection": 1.0}"#, "replace"),
    (r#"{"density": 30.0}"#, "add"),
    (r#"{"colour": [0.9, 0.1, 0.2, 0.7]}"#, "blend"),
    (r#"{"label": 3}"#, "replace"),
    (r#"{"selection": 0.5}"#, "subtract"),
    (r#"{"density": 77.0}"#, "replace"),
    (r#"{"colour": [0.1, 0.8, 0.3, 1.0]}"#, "add"),
    (r#"{"label": 2}"#, "subtract"),
];
/// After so many all forms of the shaders have been drawn.
const WARM: usize = 200;
/// What may be more after the last round than when it was warm.
const MOST_GROWTH_KB: u64 = 16 << 10;

/// Resident memory of this process.
#[cfg(target_os = "linux")]
fn resident_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "a child process of an_hour_of_pictures_and_strokes_takes_no_more_memory_than_its_first_minute"]
fn draws_paints_and_says_its_memory() {
    let (Some(mut document), Some(mut boxed), Some(mut written)) = (block(), block(), block()) else { return };
    cut(&mut document);
    let add = json!({"sub_volume": {"add": {"lo": [20, 8, 20], "hi": [40, 30, 36], "scale": 2}}});
    run(&mut boxed, &add.to_string()).unwrap();
    let front = json!({"index": [32, 39.5, 20]});
    for line in [
        json!({"annotation": {"add": {"at": front, "toward": {"index": [40, 39.5, 20]}, "text": "Text", "size_mm": 5, "value": 100}}}),
        json!({"label": {"add": {"at": front, "text": "Label"}}}),
        json!({"cutaway": {"add": {"at": {"index": [46, 39.5, 22]}, "toward": {"index": [50, 39.5, 22]}, "value": 100,
            "width_mm": 9, "depth_mm": 6}}}),
    ] {
        run(&mut written, &line.to_string()).unwrap();
    }
    for round in 1..=ROUNDS {
        // Every fourth one of what is written, with its grids found anew in every tenth of them.
        if round % 4 == 2 {
            let mut say = |line: Value| drop(run(&mut written, &line.to_string()).unwrap());
            let mode = [json!("dvr"), json!({"iso": 100.0}), json!("mip")][round / 4 % 3].clone();
            say(json!({"view": {"look": {"mode": mode, "shaded": round % 24 < 12}}}));
            say(json!({"view": {"orbit": {"azimuth_deg": round % 17, "elevation_deg": 0.3}}}));
            if round % 40 == 2 {
                say(json!({"brush": {"set": {"radius_mm": 3, "target": {"density": 60.0}, "operation": "add"}}}));
                say(json!({"stroke": {"paint": {"points": [{"at": {"index": [30 + round % 12, 38, 20]}}]}}}));
                say(json!({"history": {"undo": {}}}));
            }
            written.picture(ViewName::ThreeD, [24 + (round % 5) as u32, 24], None).unwrap();
            written.label_anchors().unwrap();
        }
        // Every fourth time one with a box of finer voxels, every eighth with a focus.
        if round % 4 == 0 {
            let mut say = |line: Value| drop(run(&mut boxed, &line.to_string()).unwrap());
            let mode = [json!("dvr"), json!({"iso": 100.0}), json!("mip")][round / 4 % 3].clone();
            say(json!({"view": {"look": {"mode": mode, "shaded": round % 24 < 12}}}));
            say(json!({"view": {"orbit": {"azimuth_deg": round % 17, "elevation_deg": 0.3}}}));
            let focus =
                json!({"on": round % 8 == 0, "distance_mm": 3.0 + (round % 5) as f64, "at": {"mm": [32, 20, 30]}});
            say(json!({"view": {"focus": focus}}));
            if round % 20 == 0 {
                say(json!({"brush": {"set": {"radius_mm": 3, "target": {"density": 60.0}, "operation": "add"}}}));
                say(json!({"stroke": {"paint": {"points": [{"at": {"index": [16 + round % 12, 20, 30]}}]}}}));
                say(json!({"history": {"undo": {}}}));
            }
            boxed.picture(ViewName::ThreeD, [16 + (round % 5) as u32, 16], None).unwrap();
        }
        let mut say = |line: Value| drop(run(&mut document, &line.to_string()).unwrap());
        // Another mode, projection and size each time, as hands on the panels, the mouse and the window's border give them.
        let mode = [json!("dvr"), json!({"iso": 100.0}), json!("mip"), json!("dvr")][round % 4].clone();
        say(json!({"view": {"look": {"mode": mode, "shaded": round % 8 < 4}}}));
        say(json!({"view": {"orbit": {"azimuth_deg": round % 17, "elevation_deg": 0.3}}}));
        say(json!({"ask": {"pick": {"px": [8.0, 8.0], "size": [16, 16]}}}));
        if round % 5 == 0 {
            let (target, operation) = BRUSHES[round / 5 % BRUSHES.len()];
            let target: Value = serde_json::from_str(target).unwrap();
            let radius = 1.0 + (round % 4) as f64;
            say(json!({"brush": {"set": {"radius_mm": radius, "target": target, "operation": operation}}}));
            say(json!({"stroke": {"paint": {"points": [{"at": {"index": [10 + round % 40, 20, 20]}}]}}}));
            say(json!({"history": {"undo": {}}}));
        }
        let edge = 16 + (round % 5) as u32;
        document.picture(ViewName::ThreeD, [edge, 16], None).unwrap();
        let slice = [ViewName::Axial, ViewName::Coronal, ViewName::Sagittal][round % 3];
        document.picture(slice, [16, edge], None).unwrap();
        if round % 100 == 0 {
            println!("resident {round} {}", resident_kb());
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_hour_of_pictures_and_strokes_takes_no_more_memory_than_its_first_minute() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let child = Process::new(std::env::current_exe().unwrap())
        .args(["--exact", "document::memory::draws_paints_and_says_its_memory", "--ignored", "--nocapture"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&child.stdout);
    let resident: Vec<u64> = said
        .lines()
        .filter_map(|l| l.split_once("resident "))
        .map(|(_, numbers)| numbers.split_whitespace().nth(1).unwrap().parse().unwrap())
        .collect();
    assert_eq!(resident.len(), ROUNDS / 100, "{said}{}", String::from_utf8_lossy(&child.stderr));
    let grown = resident[resident.len() - 1].saturating_sub(resident[WARM / 100 - 1]);
    assert!(grown <= MOST_GROWTH_KB, "{grown} kB more after {ROUNDS} rounds than after {WARM}: {resident:?}");
}
