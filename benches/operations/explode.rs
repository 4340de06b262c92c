//! The demo's head: settled from 26 directions, how much of the brain shows and what that costs; and its pictures.

use super::cube::apply;
use super::head::{Failure, root};
use super::measure::{Report, measure};
use burin::document::{Document, ViewName};
use serde_json::json;

/// The demo's document before it is settled.
fn demo() -> Result<Document, Failure> {
    let mut document = Document::new();
    let demo = std::fs::read_to_string(root().join("assets/demo.jsonl"))?;
    std::env::set_current_dir(root())?;
    for line in demo.lines().filter(|l| l.starts_with('{') && !l.contains("\"project\"") && !l.contains("\"settle\"")) {
        apply(&mut document, serde_json::from_str(line)?)?;
    }
    Ok(document)
}

/// Every direction of the 3×3×3 neighbourhood but its middle.
fn directions() -> Vec<[f64; 3]> {
    (0..27)
        .map(|i| [f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1)])
        .filter(|d| d.iter().any(|&x| x != 0.0))
        .collect()
}

pub fn visibility(report: &mut Report) -> Result<(), Failure> {
    let mut document = demo()?;
    let (mut least, mut rounds, mut steps) = (1.0_f64, 0, 0);
    let all = directions();
    let time = measure(0, all.len(), |i| -> Result<(), Failure> {
        apply(
            &mut document,
            json!({"view": {"frame": {"from": all[i], "up": if all[i][0] == 0.0 && all[i][1] == 0.0 { [0, 1, 0] } else { [0, 0, 1] }}}}),
        )?;
        let settled = apply(&mut document, json!({"explosion": {"settle": {}}}))?;
        rounds = rounds.max(settled["rounds"].as_u64().unwrap_or(0));
        steps = steps.max(settled["steps"].as_u64().unwrap_or(0));
        let seen = apply(&mut document, json!({"ask": {"visibility": {"size": [512, 512]}}}))?;
        let share = seen["share"].as_f64().ok_or(format!("no share in {seen}"))?;
        report.note(&format!(
            "from {:?}: {:.2} % visible, {} rounds, {} steps",
            all[i],
            share * 100.0,
            settled["rounds"],
            settled["steps"]
        ));
        least = least.min(share);
        Ok(())
    })?;
    let beside = format!("least {:.2} % of the brain, at most {rounds} rounds and {steps} steps", least * 100.0);
    report.row("demo head settled, one of 26 directions", time, &beside);
    Ok(())
}

/// The demo's pictures while the view turns: shaded, the brain selected, at three degrees of explosion.
pub fn pictures(report: &mut Report) -> Result<(), Failure> {
    let mut document = demo()?;
    for degree in [0.0, 0.5, 1.0] {
        apply(&mut document, json!({"explosion": {"degree": {"value": degree}}}))?;
        apply(&mut document, json!({"explosion": {"settle": {}}}))?;
        let mut last = None;
        let time = measure(2, 11, |_| -> Result<(), Failure> {
            apply(&mut document, json!({"view": {"orbit": {"azimuth_deg": 7.3, "elevation_deg": 0.0}}}))?;
            last = Some(document.picture(ViewName::ThreeD, [512; 2], None)?);
            Ok(())
        })?;
        let again = document.picture(ViewName::ThreeD, [512; 2], None)?;
        if last.is_none_or(|p| p.colour != again.colour) {
            return Err("a timed picture differs from the untimed one".into());
        }
        report.row(&format!("demo head at degree {degree}, 512×512"), time, "");
    }
    Ok(())
}
