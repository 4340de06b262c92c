//! Scripts: lines in, lines out.

use super::maker::labelled;
use burin::document::{Command, Document, RenderCommand};
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
    let script = "# two commands\n\n{\"explosion\":{\"seed\":{\"value\":5}}}\n  {\"history\":{\"undo\":{}}}\n";
    let (outcome, lines) = answers(&mut labelled(), script, false);
    assert_eq!(outcome, Outcome { done: 2, failed: 0 });
    assert_eq!((&lines[0]["line"], &lines[0]["ok"]["step"]), (&3.into(), &"Seed of explosion points".into()));
    assert_eq!((&lines[1]["line"], &lines[1]["ok"]["undone"][0]), (&4.into(), &"Seed of explosion points".into()));
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
fn a_line_that_is_no_text_is_an_error_of_its_own() {
    let script = b"{\"selection\":{\"clear\":{}}}\n{\"sel\xff\n{\"selection\":{\"clear\":{}}}";
    let mut out = Vec::new();
    let outcome = run(&mut labelled(), &script[..], &mut out, true).unwrap();
    assert_eq!(outcome, Outcome { done: 2, failed: 1 });
    let second = String::from_utf8(out).unwrap().lines().nth(1).unwrap().to_owned();
    assert!(second.contains(r#""line":2"#) && second.contains("byte 6 found, UTF-8 expected"), "{second}");
}

#[test]
fn what_is_wrong_is_told_with_its_field() {
    let point = r#"{"at":{"mm":[0,0,0]}"#;
    for (line, expected) in [
        (r#"{"brush":{"set":{"radius_mm":"big"}}}"#.into(), "brush.set.radius_mm: invalid type: string"),
        (r#"{"brush":{"set":{"target":{"label":70000}}}}"#.into(), "brush.set.target.label: invalid value"),
        (r#"{"view":{"look":{"mode":{"iso":"a"}}}}"#.into(), "view.look.mode.iso: "),
        (
            r#"{"stroke":{"paint":{"points":[{"at":{"mm":[0,0]}}]}}}"#.into(),
            "stroke.paint.points[0].at.mm: invalid length 2",
        ),
        (
            format!(r#"{{"stroke":{{"paint":{{"points":[{point},"presure":1}}]}}}}}}"#),
            "points[0].presure: unknown field",
        ),
        (
            r#"{"ask":{"voxel":{"at":{"pixel":{"view":"axial","px":[1,2],"sise":[3,3]}}}}}"#.into(),
            "at.pixel.sise: unknown field",
        ),
        (r#"{"history":{"undo":{"steps":-1}}}"#.into(), "history.undo.steps: invalid value"),
        (r#"{"history":{"undo":{}},"view":{"back":{}}}"#.into(), "found 2 nouns (history, view), expected one a line"),
        (r#"{"history":{"undo":{},"redo":{}}}"#.into(), "found 2 verbs (undo, redo), expected one a line"),
        ("[1]".into(), "found no object"),
        (r#"{"selection":{"from_label":{"label":77}}}"#.into(), "label: 77 found, a segment's id, one of ["),
        (
            r#"{"part":{"move":{"id":1,"pose":{"rotation":[2,0,0,1],"translation":[0,0,0]}}}}"#.into(),
            "rotation [2, 0, 0, 1], translation [0, 0, 0] found, a unit quaternion",
        ),
        (r#"{"part":{"set":{"id":9}}}"#.into(), "part 9 does not exist; the parts are 1"),
    ] {
        let (_, lines) = answers(&mut labelled(), &line, false);
        let text = lines[0]["error"].as_str().unwrap();
        assert!(text.contains(expected), "{line}: {text}");
    }
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
    let schema = schema();
    let lines = schema["oneOf"].as_array().unwrap();
    let nouns: Vec<_> = lines.iter().map(|line| line["required"][0].as_str().unwrap()).collect();
    let expected = "project volume sub_volume transfer view brush stroke component selection segment part explosion \
                    annotation label cutaway history ask render";
    assert_eq!(nouns, expected.split(' ').collect::<Vec<_>>());
    for (line, noun) in lines.iter().zip(nouns) {
        // Each is an object of that one noun, whose verbs are told by the definition it refers to.
        let name = line["properties"][noun]["$ref"].as_str().unwrap().rsplit('/').next().unwrap();
        let verbs = schema["$defs"][name]["oneOf"].as_array().unwrap();
        assert!(verbs.iter().all(|verb| verb["required"].as_array().unwrap().len() == 1), "{noun}: {verbs:?}");
        assert_eq!((&line["additionalProperties"], verbs.is_empty()), (&Value::Bool(false), false), "{noun}");
    }
}

/// What is shipped is read by nobody until it is run, and running it takes a graphics device and minutes.
#[test]
fn scripts_that_are_shipped_are_commands_and_make_the_pictures_that_the_readme_shows() {
    let root = crate::common::root();
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let mut scripts = 0;
    for entry in std::fs::read_dir(root.join("assets")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "jsonl") {
            continue;
        }
        scripts += 1;
        for (i, line) in std::fs::read_to_string(&path).unwrap().lines().enumerate() {
            if line.starts_with('#') {
                continue;
            }
            let command = serde_json::from_str::<Command>(line);
            let command = command.unwrap_or_else(|e| panic!("{}, line {}: {e}", path.display(), i + 1));
            if let Command::Render(RenderCommand::Image { path: picture, .. }) = command
                && picture.starts_with("assets")
            {
                let told = readme.contains(&*picture.to_string_lossy());
                assert!(told && root.join(&picture).is_file(), "{}: {}", path.display(), picture.display());
            }
        }
    }
    assert!(scripts >= 7);
    for line in readme.lines().map(str::trim).filter(|line| line.starts_with("{\"")) {
        serde_json::from_str::<Command>(line).unwrap_or_else(|e| panic!("README.md: {line}: {e}"));
    }
}
