//! One slice picture, each a voxel further: what the window draws while the wheel turns.

use super::cube::{apply, document};
use super::head::Failure;
use super::measure::{Report, measure};
use burin::document::ViewName;
use serde_json::json;

pub fn slices(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    for n in [128, 512] {
        let mut document = document(n, folder.path())?;
        for view in [ViewName::Axial, ViewName::Coronal, ViewName::Sagittal] {
            let mut last = None;
            let time = measure(3, 15, |_| -> Result<(), Failure> {
                apply(&mut document, json!({"view": {"scroll": {"view": view, "voxels": 1}}}))?;
                last = Some(document.picture(view, [512; 2], None)?);
                Ok(())
            })?;
            let again = document.picture(view, [512; 2], None)?;
            if last.is_none_or(|p| p.colour != again.colour) {
                return Err("a timed slice differs from the untimed one".into());
            }
            report.row(&format!("{} slice of {n}³, 512×512", view.name()), time, "");
        }
    }
    Ok(())
}
