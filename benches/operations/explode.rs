//! The demo's head settled from 26 directions: how much of the brain shows, and what it costs.

use super::head::Failure;
use super::measure::{Report, measure};
use burin::document::Document;
use serde_json::{Value, json};

fn apply(document: &mut Document, command: Value) -> Result<Value, Failure> {
    Ok(document.apply(serde_json::from_value(command)?)?)
}

/// Every direction of the 3×3×3 neighbourhood but its middle.
fn directions() -> Vec<[f64; 3]> {
    (0..27)
        .map(|i| [f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1)])
        .filter(|d| d.iter().any(|&x| x != 0.0))
        .collect()
}

pub fn visibility(report: &mut Report) -> Result<(), Failure> {
    let mut document = Document::new();
    let demo = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/demo.jsonl"))?;
    std::env::set_current_dir(env!("CARGO_MANIFEST_DIR"))?;
    for line in demo.lines().filter(|l| l.starts_with('{') && !l.contains("\"project\"") && !l.contains("\"settle\"")) {
        apply(&mut document, serde_json::from_str(line)?)?;
    }
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
