//! Scripts: lines in, lines out.

use super::maker::labelled;
use burin::document::Document;
use burin::script::{Outcome, run, schema};
use serde_json::Value;

fn answers(document: &mut Document, script: &str, keep_going: bool) -> (Outcome, Vec<Value>) {
    let mut out = Vec::new();
    let outcome = run(document, script.as_bytes(), &mut out, keep_going).unwrap();
    let lines = String::from_utf8(out).unwrap();
    (outcome, lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect())
}

#[test]
fn one_answer_a_command_with_its_line() {
    let script = "# two commands\n\n{\"view\":{\"window\":{\"level\":5,\"width\":2}}}\n  {\"history\":{\"undo\":{}}}\n";
    let (outcome, lines) = answers(&mut labelled(), script, false);
    assert_eq!(outcome, Outcome { done: 2, failed: 0 });
    assert_eq!((&lines[0]["line"], &lines[0]["ok"]["step"]), (&3.into(), &"Window".into()));
    assert_eq!((&lines[1]["line"], &lines[1]["ok"]["undone"][0]), (&4.into(), &"Window".into()));
}

#[test]
fn the_first_error_ends_it_unless_told_to_go_on() {
    let script = "{\"nonsense\":1}\n{\"selection\":{\"clear\":{}}}\n{\"selection\":{\"clear\":{\"x\":1}}}\n";
    let (outcome, lines) = answers(&mut labelled(), script, false);
    assert_eq!((outcome.failed, lines.len()), (1, 1));
    assert!(lines[0]["error"].as_str().unwrap().contains("unknown variant `nonsense`"));
    let (outcome, lines) = answers(&mut labelled(), script, true);
    assert_eq!((outcome, lines.len()), (Outcome { done: 1, failed: 2 }, 3));
}

#[test]
fn hostile_lines_are_answers() {
    let deep = "[".repeat(100_000);
    for line in ["\u{0}", "{", "null", "[1]", "{\"view\":{\"window\":{\"level\":1e999,\"width\":1}}}", &deep] {
        let (outcome, lines) = answers(&mut labelled(), line, false);
        assert_eq!((outcome.failed, lines.len()), (1, 1), "{line:.20}");
    }
}

#[test]
fn the_same_script_gives_the_same_answers() {
    let script = "{\"segment\":{\"set\":{\"id\":3,\"name\":\"x\"}}}\n{\"selection\":{\"from_label\":{\"label\":2}}}\n\
                  {\"part\":{\"split\":{\"by\":{\"line\":{\"from\":[0,200],\"to\":[511,300]}}}}}\n\
                  {\"ask\":{\"scene\":{}}}\n{\"ask\":{\"field\":{\"field\":\"selection\"}}}\n";
    assert_eq!(answers(&mut labelled(), script, false), answers(&mut labelled(), script, false));
}

#[test]
fn the_schema_knows_every_noun() {
    let text = schema().to_string();
    for noun in
        ["project", "volume", "transfer", "view", "brush", "stroke", "selection", "segment", "part", "explosion"]
    {
        assert!(text.contains(&format!("\"{noun}\"")), "{noun}");
    }
}
