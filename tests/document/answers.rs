//! What scripts read: every command's answer, as the program gave it before answers were types.
//!
//! `tests/fixtures/answers` has pairs of lines, a command and its answer, with `@` for the folder that the files lie in.

use super::maker::write_nrrd;
use burin::document::Document;
use burin::math::DVec3;
use burin::script::perform;
use burin::volume::Grid;
use serde_json::{Value, json};
use std::path::Path;

/// How much room something takes, which any change of a format changes.
const SIZES: [&str; 5] = ["memory", "disk", "bytes", "bytes_written", "files_linked"];

/// Whether an answer is as expected: the same keys in the same order, the same words, and numbers that differ by rounding alone.
fn compare(found: &Value, expected: &Value, rounding: f64, at: &str) {
    match (found, expected) {
        (Value::Object(found), Value::Object(expected)) => {
            assert!(found.keys().eq(expected.keys()), "{at}: {:?} found, {:?} expected", found, expected);
            for (key, value) in expected.iter().filter(|(key, _)| !SIZES.contains(&key.as_str())) {
                compare(&found[key], value, rounding, &format!("{at}.{key}"));
            }
        }
        (Value::Array(found), Value::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{at}: {found:?} found, {expected:?} expected");
            for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                compare(found, expected, rounding, &format!("{at}[{i}]"));
            }
        }
        (Value::Number(a), Value::Number(b)) if a.is_f64() && b.is_f64() => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= rounding * (1.0 + b.abs()), "{at}: {a} found, {b} expected");
        }
        _ => assert_eq!(found, expected, "{at}"),
    }
}

/// Does the commands of a list on files in a folder and compares the answers.
fn hold(folder: &Path, list: &str, document: &mut Document, rounding: f64) {
    let grid = Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&folder.join("v.nrrd"), &grid, |[x, y, z]| (x + 2 * y + 3 * z) as f32);
    write_nrrd(&folder.join("l.nrrd"), &grid, |[x, y, _]| if y > 4 { (x / 4 + 1) as f32 } else { 0.0 });
    write_nrrd(&folder.join("s.nrrd"), &grid, |[x, ..]| x as f32);
    let list = list.replace('@', folder.to_str().unwrap());
    let mut lines = list.lines();
    while let (Some(line), Some(expected)) = (lines.next(), lines.next()) {
        let answer = perform(document, line).unwrap_or_else(|error| panic!("{line}: {error}"));
        compare(&answer, &serde_json::from_str(expected).unwrap(), rounding, line);
    }
}

#[test]
fn every_command_without_a_gpu_answers_with_the_same_names_and_values() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::new();
    document.keep_unsaved_in(folder.path().join("state"));
    hold(folder.path(), include_str!("../fixtures/answers/host.jsonl"), &mut document, 1e-12);
}

#[test]
fn every_command_that_needs_a_gpu_answers_with_the_same_names_and_values() {
    let mut document = Document::new();
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // Where a surface is seen is a matter of the device.
    hold(folder.path(), include_str!("../fixtures/answers/gpu.jsonl"), &mut document, 1e-3);
}

#[test]
fn a_warning_beside_an_answer_is_one_sentence_under_its_own_name() {
    use burin::document::answers::{Answer, Said, SeedSaid, StepSaid};
    let step = StepSaid { step: Some("Seed".into()), ..StepSaid::default() };
    let trouble = vec!["the disk is full".to_owned(), "so is the other".to_owned()];
    let answer = Answer { said: Said::from(SeedSaid { seed: 7 }), step: Some(step), trouble };
    let expected = json!({"seed":7,"step":"Seed","warning":"the disk is full; so is the other"});
    assert_eq!(answer.to_json().unwrap(), expected);
    assert_eq!(answer.warnings().collect::<Vec<_>>(), ["the disk is full", "so is the other"]);
    assert_eq!(Answer::default().to_json().unwrap(), json!({}));
}
