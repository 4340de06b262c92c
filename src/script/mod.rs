//! Scripts: one command a line as JSON, one answer a line.
//!
//! A line is a [`Command`]; blank lines and lines that start with `#` are passed over. Every command answers with one JSON
//! object: `{"line":3,"ok":{…}}` or `{"line":3,"error":"…"}`. The first error ends the script unless it is told to go on.
//! Nothing is saved unless a line says so. Knows no GPU and no window.

mod terminal;

pub use terminal::{json_line, plain};

use crate::document::{Command, Document};
use serde_json::{Value, json};
use std::io::{BufRead, Read, Write};

/// No command is longer: what is has no end, or is no script.
const MAX_LINE_BYTES: u64 = 64 << 20;

/// How a script went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Commands that were done.
    pub done: u64,
    /// Commands that failed.
    pub failed: u64,
}

/// Runs a script; answers are written as they come. With `keep_going` a failed command does not end it.
///
/// # Errors
/// If the script cannot be read or an answer cannot be written.
pub fn run(
    document: &mut Document,
    mut script: impl BufRead,
    mut answers: impl Write,
    keep_going: bool,
) -> std::io::Result<Outcome> {
    let mut outcome = Outcome::default();
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        if (&mut script).take(MAX_LINE_BYTES + 1).read_until(b'\n', &mut line)? == 0 {
            break;
        }
        let endless = line.len() as u64 > MAX_LINE_BYTES;
        let result = match std::str::from_utf8(&line).map(str::trim) {
            _ if endless => {
                Err(format!("not a command: over {MAX_LINE_BYTES} bytes found, a line's end before expected"))
            }
            Ok(line) if line.is_empty() || line.starts_with('#') => continue,
            Ok(line) => perform(document, line),
            Err(error) => Err(format!("not a command: byte {} found, UTF-8 expected", error.valid_up_to() + 1)),
        };
        let answer = match &result {
            Ok(answer) => json!({ "line": number, "ok": answer }),
            Err(error) => json!({ "line": number, "error": error }),
        };
        writeln!(answers, "{}", json_line(&answer))?;
        answers.flush()?;
        match result {
            Ok(_) => outcome.done += 1,
            Err(_) => outcome.failed += 1,
        }
        if endless || (outcome.failed > 0 && !keep_going) {
            break;
        }
    }
    Ok(outcome)
}

/// Does one line.
///
/// # Errors
/// What is wrong with the line, or why it cannot be done, in words.
pub fn perform(document: &mut Document, line: &str) -> Result<Value, String> {
    let command = parse(line).map_err(|e| format!("not a command: {e}; `burin schema` lists them"))?;
    document.apply(command).map_err(|e| e.to_string())?.to_json()
}

/// A line as a command; what is wrong is told with the path of the field.
fn parse(line: &str) -> Result<Command, String> {
    let mut json = serde_json::Deserializer::from_str(line);
    let command = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        // JSON's own parser only misses a comma or a brace where there are two nouns or two verbs.
        let found = serde_json::from_str(line).ok().and_then(|value| too_many(&value));
        match (found, path.as_str()) {
            (Some(found), _) => found,
            (None, ".") => error.into_inner().to_string(),
            (None, path) => format!("{path}: {}", error.into_inner()),
        }
    })?;
    json.end().map_err(|error| error.to_string())?;
    Ok(command)
}

/// What is wrong with a line that is not one noun with one verb.
fn too_many(line: &Value) -> Option<String> {
    let Value::Object(nouns) = line else {
        return Some("found no object, expected {\"noun\":{\"verb\":{…}}}".into());
    };
    let several = |what: &str, map: &serde_json::Map<String, Value>| {
        let names: Vec<&str> = map.keys().map(String::as_str).collect();
        (names.len() != 1).then(|| format!("found {} {what}s ({}), expected one a line", names.len(), names.join(", ")))
    };
    several("noun", nouns).or_else(|| nouns.values().next()?.as_object().and_then(|verbs| several("verb", verbs)))
}

/// The JSON Schema of a line.
pub fn schema() -> Value {
    schemars::schema_for!(Command).to_value()
}
