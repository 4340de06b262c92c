//! The demo's head: settled from 26 directions, how much of the brain shows and what that costs; and its pictures.

use super::cube::apply;
use super::head::{Failure, root};
use super::measure::{Report, measure, measure_by_turns};
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

/// The demo's head at degree 0 with one sample a voxel, plain and refined by turns, and how far both are from a picture with eight
/// samples a voxel: the largest channel's difference over the head's pixels, of 255.
pub fn refine(report: &mut Report) -> Result<(), Failure> {
    let mut document = demo()?;
    apply(&mut document, json!({"explosion": {"degree": {"value": 0.0}}}))?;
    let looks = [("plain", 1.0, false), ("refined", 1.0, true)];
    let look =
        |(_, step, refine): (&str, f64, bool)| json!({"view": {"look": {"step_voxels": step, "refine": refine}}});
    for shaded in [true, false] {
        apply(&mut document, json!({"view": {"look": {"shaded": shaded}}}))?;
        let [plain, refined] = measure_by_turns(2, 11, |which, _| -> Result<(), Failure> {
            apply(&mut document, look(looks[which]))?;
            let turn = if which == 0 { 7.3 } else { 0.0 };
            apply(&mut document, json!({"view": {"orbit": {"azimuth_deg": turn, "elevation_deg": 0.0}}}))?;
            document.picture(ViewName::ThreeD, [512; 2], None)?;
            Ok(())
        })?;
        let mut picture = |l| -> Result<Vec<u8>, Failure> {
            apply(&mut document, look(l))?;
            Ok(document.picture(ViewName::ThreeD, [512; 2], None)?.to_rgba8(Some([0.05, 0.06, 0.075])))
        };
        let limit = picture(("limit", 0.125, false))?;
        for (l, time) in looks.into_iter().zip([plain, refined]) {
            let seen = picture(l)?;
            let pixels = limit.chunks_exact(4).zip(seen.chunks_exact(4));
            let mut far: Vec<u8> = pixels
                .filter(|(a, b)| a[..3] != limit[..3] || b[..3] != limit[..3])
                .map(|(a, b)| (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0))
                .collect();
            far.sort_unstable();
            let mean = far.iter().map(|&d| f64::from(d)).sum::<f64>() / far.len() as f64;
            let most = far[far.len() * 99 / 100];
            let words = if shaded { "shaded" } else { "unshaded" };
            let beside = format!("{:.2} of plain (CPU); mean {mean:.2}, 99 % within {most}", time.cpu / plain.cpu);
            report.row(&format!("demo head, {words}, {}", l.0), time, &beside);
        }
    }
    Ok(())
}
