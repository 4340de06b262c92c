//! Fifty texts on the skin of a head: what they add to a picture of 512², and what a relaxed grid costs beside a plain one.

use super::cube::apply;
use super::head::{Failure, root};
use super::measure::{Report, measure, measure_by_turns};
use burin::document::{AnnotationId, Document, ViewName};
use serde_json::{Value, json};

const COUNT: u32 = 50;
const SIZE: [u32; 2] = [512; 2];
/// The skin's value.
const SKIN: f64 = 50.0;

/// The head in a document.
fn head() -> Result<Document, Failure> {
    let mut document = Document::new();
    let path = root().join("assets/ch2.nii.gz");
    apply(&mut document, json!({"volume": {"open": {"path": path}}}))?;
    apply(&mut document, json!({"view": {"size": {"view": "3d", "size": SIZE}}}))?;
    Ok(document)
}

/// A place on the skin in a direction from the middle of the head, mm.
fn on_skin(document: &mut Document, [x, y, z]: [f64; 3]) -> Result<Option<[f64; 3]>, Failure> {
    for step in (0..260).rev() {
        let way = 0.5 * f64::from(step);
        let mm = [x * way, -17.0 + y * way, 20.0 + z * way];
        let voxel = apply(document, json!({"ask": {"voxel": {"at": {"mm": mm}}}}))?;
        if voxel["density"].as_f64().is_some_and(|density| density >= SKIN) {
            return Ok(Some(mm));
        }
    }
    Ok(None)
}

/// Lays texts evenly over the upper half and more of a head.
fn written() -> Result<Document, Failure> {
    let mut document = head()?;
    let (mut laid, mut i) = (0, 0);
    while laid < COUNT {
        // A spiral over the sphere.
        let z = 0.95 - 1.1 * f64::from(i % 64) / 64.0;
        let turn = 2.399_963 * f64::from(i);
        let flat = (1.0 - z * z).sqrt();
        i += 1;
        let Some(at) = on_skin(&mut document, [flat * turn.cos(), flat * turn.sin(), z])? else { continue };
        let toward = [at[0] - turn.sin() * 9.0, at[1] + turn.cos() * 9.0, at[2]];
        let text = format!("Text {laid}");
        let add = json!({"annotation": {"add": {"at": {"mm": at}, "toward": {"mm": toward}, "text": text, "size_mm": 9.0,
            "value": SKIN}}});
        apply(&mut document, add)?;
        laid += 1;
    }
    Ok(document)
}

fn show(document: &mut Document, visible: bool) -> Result<(), Failure> {
    apply(document, json!({"history": {"begin": {}}}))?;
    for id in 0..COUNT {
        apply(document, json!({"annotation": {"set": {"id": id, "visible": visible}}}))?;
    }
    apply(document, json!({"history": {"end": {}}}))?;
    Ok(())
}

pub fn fifty(report: &mut Report) -> Result<(), Failure> {
    let modes: [(&str, Value); 2] = [("shaded", json!("dvr")), ("iso", json!({"iso": SKIN}))];
    let mut document = written()?;
    let mut bare = head()?;
    for (name, mode) in modes {
        let look = json!({"view": {"look": {"mode": mode, "shaded": true, "step_voxels": 1.0, "refine": false}}});
        let camera = json!({"view": {"orbit": {"azimuth_deg": 25.0, "elevation_deg": 20.0}}});
        for document in [&mut document, &mut bare] {
            apply(document, look.clone())?;
            apply(document, camera.clone())?;
        }
        show(&mut document, true)?;
        let with = document.picture(ViewName::ThreeD, SIZE, None)?;
        let without = bare.picture(ViewName::ThreeD, SIZE, None)?;
        let other = with.colour.iter().zip(&without.colour).filter(|(a, b)| a != b).count();
        if other < 2000 {
            return Err(format!("only {other} pixels show a text").into());
        }
        let times = measure_by_turns(3, 15, |which, _| -> Result<(), Failure> {
            let document = if which == 0 { &mut bare } else { &mut document };
            document.picture(ViewName::ThreeD, SIZE, None)?;
            Ok(())
        })?;
        let [plain, marked]: [_; 2] = times;
        report.row(&format!("{name}, no annotation"), plain, "");
        report.row(
            &format!("{name}, {COUNT} annotations"),
            marked,
            &format!("{:.3} of without", marked.cpu / plain.cpu),
        );
    }
    Ok(())
}

/// From a change of a text's place to its grid as it is wanted, 41² and 81² vertices; the plain grid within that.
pub fn relaxed(report: &mut Report) -> Result<(), Failure> {
    let mut document = head()?;
    let at = on_skin(&mut document, [0.3, 0.9, 0.35])?.ok_or("no skin was found")?;
    for (edge, size) in [(41, 40.0), (81, 80.0)] {
        for relaxed in [false, true] {
            let content = json!({"pattern": {"kind": "lines", "aspect": 1.0, "spacing_mm": 4.0, "line_mm": 1.0}});
            let add = json!({"annotation": {"add": {"at": {"mm": at}, "content": content, "size_mm": size, "value": SKIN,
                "relaxed": relaxed}}});
            let said = apply(&mut document, add)?;
            let id = said["id"].as_u64().ok_or("no number")? as u32;
            let found = (said["grid"]["columns"].as_u64(), said["grid"]["trimmed"].as_u64());
            let time = measure(2, 11, |i| -> Result<(), Failure> {
                // Another place by a hair, so that the grid is found anew.
                let to = [at[0], at[1] + 0.001 * (i % 7 + 1) as f64, at[2]];
                apply(&mut document, json!({"annotation": {"set": {"id": id, "at": {"mm": to}, "value": SKIN}}}))?;
                Ok(())
            })?;
            let name = if relaxed { "relaxed" } else { "plain" };
            report.row(&format!("{name}, {edge}² asked"), time, &format!("{found:?} columns, trimmed"));
            apply(&mut document, json!({"annotation": {"remove": {"id": AnnotationId(id)}}}))?;
        }
    }
    Ok(())
}
