//! Writing fields of 512³ voxels to NRRD (gzip), unedited and after a stroke.

use super::cube::{apply, document, stroke};
use super::head::Failure;
use super::measure::{Report, measure};
use serde_json::json;

pub fn export(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    let n = 512;
    let mut document = document(n, folder.path())?;
    for (field, edited) in [("density", false), ("density", true), ("selection", true), ("labels", true)] {
        if edited {
            let target = match field {
                "density" => json!({"density": 200.0}),
                "selection" => json!({"selection": 1.0}),
                _ => json!({"label": 3}),
            };
            stroke(&mut document, n, target, 0.0)?;
        }
        let path = folder.path().join("out.nrrd");
        let mut exported = json!(null);
        let time = measure(1, 3, |_| -> Result<(), Failure> {
            exported = apply(&mut document, json!({"volume": {"export": {"field": field, "path": path}}}))?;
            Ok(())
        })?;
        let said = &exported["exported"];
        let beside = format!(
            "{} MB, {} voxels changed",
            said["bytes"].as_u64().unwrap_or(0) / 1_000_000,
            said["voxels_changed"]
        );
        let name = format!("export {field}, 512³{}", if edited { ", after a stroke" } else { "" });
        report.row(&name, time, &beside);
    }
    Ok(())
}
