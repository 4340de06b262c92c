//! Undo and redo of a stroke: what it costs must follow its bricks and not the volume.

use super::cube::{apply, document, stroke};
use super::head::Failure;
use super::measure::{Report, Time, measure};
use serde_json::json;

pub fn undo(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    for (name, target) in [("density", json!({"density": 200.0})), ("labels", json!({"label": 3}))] {
        let mut times: Vec<[Time; 2]> = Vec::new();
        for n in [128, 512] {
            let mut document = document(n, folder.path())?;
            let painted = stroke(&mut document, n, target.clone(), 0.0)?;
            let field = json!({"ask": {"field": {"field": name}}});
            let before = apply(&mut document, field.clone())?;
            let mut steps = [Vec::new(), Vec::new()];
            for _ in 0..9 {
                for (way, steps) in ["undo", "redo"].iter().zip(&mut steps) {
                    steps.push(measure(0, 1, |_| apply(&mut document, json!({"history": {*way: {}}})).map(|_| ()))?);
                }
            }
            if apply(&mut document, field)? != before || painted["voxels_changed"] == 0 {
                return Err("undo and redo did not bring the stroke back".into());
            }
            times.push(steps.map(Time::median));
        }
        let [small, large] = times[..] else { return Err("two sizes".into()) };
        for (i, way) in ["undo", "redo"].iter().enumerate() {
            report.row(&format!("{way} a stroke on {name}, 128³"), small[i], "");
            let beside = format!("{:.2} of 128³ (CPU)", large[i].cpu / small[i].cpu);
            report.row(&format!("{way} a stroke on {name}, 512³"), large[i], &beside);
        }
    }
    Ok(())
}
