//! Numbers in place of texts, with a key.
//!
//! Where texts would crowd the picture, each label bears a number, placed as a text is, and a list says what the numbers mean.
//! Numbers follow the order in which labels are given, so they stay while the scene moves. Owns nothing; knows no fonts: the caller
//! measures the numbers.

use crate::annotate::labels::types::Label;
use glam::DVec2;

/// One line of a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyLine {
    /// From 1 on.
    pub number: usize,
    /// The label that bears it.
    pub id: u64,
    /// What it stands for.
    pub text: String,
}

/// Numbers labels in their order from 1 on: each label's size becomes that of its number, as `measure` says (px). Returns the key.
///
/// `texts[n]` is what `labels[n]` would say; a missing one is empty.
pub fn key_lines(labels: &mut [Label], texts: &[String], measure: &dyn Fn(&str) -> DVec2) -> Vec<KeyLine> {
    labels
        .iter_mut()
        .enumerate()
        .map(|(n, label)| {
            label.size = measure(&(n + 1).to_string());
            KeyLine { number: n + 1, id: label.id, text: texts.get(n).cloned().unwrap_or_default() }
        })
        .collect()
}
