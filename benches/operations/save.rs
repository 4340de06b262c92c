//! A save after a small stroke: bytes written follow the edit, not the volume.

use super::cube::{apply, document, stroke};
use super::head::Failure;
use super::measure::{Report, Time, measure};
use serde_json::{Value, json};

pub fn save(report: &mut Report) -> Result<(), Failure> {
    for n in [128, 512] {
        let folder = tempfile::tempdir()?;
        let mut document = document(n, folder.path())?;
        let project = folder.path().join("project");
        let mut saved = Value::Null;
        let first = measure(0, 1, |_| -> Result<(), Failure> {
            saved = apply(&mut document, json!({"project": {"save": {"path": project}}}))?;
            Ok(())
        })?;
        report.row(&format!("first save, {n}³"), first, &said(&saved));
        let (mut times, mut most) = (Vec::new(), Value::Null);
        for i in 0..7 {
            stroke(&mut document, n, json!({"selection": 1.0}), f64::from(i) * 2.0)?;
            times.push(measure(0, 1, |_| -> Result<(), Failure> {
                most = apply(&mut document, json!({"project": {"save": {}}}))?;
                Ok(())
            })?);
        }
        report.row(&format!("save after a stroke, {n}³"), Time::median(times), &said(&most));
    }
    Ok(())
}

fn said(answer: &Value) -> String {
    let saved = &answer["saved"];
    format!(
        "{} kB written, {} files linked",
        saved["bytes_written"].as_u64().unwrap_or(0) / 1000,
        saved["files_linked"]
    )
}
