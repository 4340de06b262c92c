//! What was said to the person: the list of messages, and the word over the views.

use crate::ui::thread::session::Severity;
use std::path::PathBuf;

/// A message of the list.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Message {
    pub(crate) severity: Severity,
    pub(crate) text: String,
    /// What was written.
    pub(crate) path: Option<PathBuf>,
    /// The command that failed, as `noun.verb`.
    pub(crate) topic: Option<String>,
}

/// The word over the views.
#[derive(Clone, Debug)]
pub(crate) struct Toast {
    pub(crate) message: Message,
    /// Seconds of egui's clock; `None` before it is first seen.
    pub(crate) until: Option<f64>,
}
