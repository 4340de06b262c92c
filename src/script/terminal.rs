//! What is printed where a person may read it: names and headers come from files, and a terminal takes some characters for orders.
//!
//! Owns the escaping and the cutting of long values; knows neither commands nor files.

use serde_json::Value;
use std::fmt::Write;

/// Longest word that is printed whole, in characters: a path may have thousands.
const WORD: usize = 300;
/// What of a longer one is printed, at its beginning and at its end.
const ENDS: (usize, usize) = (200, 60);
/// Longest text.
const TEXT: usize = 4000;

/// A text on one line, without orders to a terminal, long words and long texts cut.
pub fn plain(text: &str) -> String {
    let mut out = String::new();
    for word in text.split_inclusive(' ') {
        let length = word.chars().count();
        if length > WORD {
            let (first, last) = ENDS;
            word.chars().take(first).for_each(|c| put(&mut out, c));
            let _ = write!(out, "…({} more)…", length - first - last);
            word.chars().skip(length - last).for_each(|c| put(&mut out, c));
        } else {
            word.chars().for_each(|c| put(&mut out, c));
        }
    }
    match out.char_indices().nth(TEXT) {
        Some((end, _)) => format!("{}…", &out[..end]),
        None => out,
    }
}

/// JSON on one line. Its own rules leave some orders to terminals as they are; these are escaped too.
pub fn json_line(value: &Value) -> String {
    let text = value.to_string();
    if !text.chars().any(is_order) {
        return text;
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_order(c) {
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out
}

fn put(out: &mut String, c: char) {
    if is_order(c) { out.extend(c.escape_default()) } else { out.push(c) }
}

/// Control characters, and those that turn the direction of writing about.
fn is_order(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}
