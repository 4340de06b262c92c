//! What is to be known of a command before and after it is done: what the window calls it meanwhile, and under which name its
//! refusals are kept.
//!
//! Knows commands and not what they do.

use crate::document::{Command, ExplosionCommand, HistoryCommand, ProjectCommand, SegmentCommand, VolumeCommand};
use serde_json::Value;

/// Whether another document is open afterwards.
pub(crate) fn opens(command: &Command) -> bool {
    matches!(
        command,
        Command::Volume(VolumeCommand::Open { .. })
            | Command::Project(ProjectCommand::Open { .. } | ProjectCommand::Recover { .. })
    )
}

/// A command's noun and verb, as `noun.verb`.
pub(crate) fn topic(command: &Command) -> String {
    let value = serde_json::to_value(command).unwrap_or_default();
    let first = |value: &Value| value.as_object().and_then(|o| o.iter().next().map(|(k, v)| (k.clone(), v.clone())));
    let Some((noun, inner)) = first(&value) else { return value.as_str().unwrap_or_default().to_owned() };
    let verb = first(&inner).map(|(verb, _)| verb).or_else(|| inner.as_str().map(str::to_owned));
    format!("{noun}.{}", verb.unwrap_or_default())
}

/// What the window says while a command runs that may take over a tenth of a second.
pub(crate) fn lasts(command: &Command) -> Option<String> {
    let name = |p: &std::path::Path| p.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    match command {
        Command::Volume(VolumeCommand::Open { path, .. }) | Command::Project(ProjectCommand::Open { path, .. }) => {
            Some(format!("Opening {}", name(path)))
        }
        Command::Volume(VolumeCommand::Export { path, .. }) => Some(format!("Exporting {}", name(path))),
        Command::Project(ProjectCommand::Recover { .. }) => Some("Recovering".into()),
        Command::Project(ProjectCommand::Save { .. }) => Some("Saving".into()),
        Command::Explosion(ExplosionCommand::Settle {}) => Some("Settling parts".into()),
        Command::Selection(_) => Some("Selecting".into()),
        Command::Segment(SegmentCommand::Remove { .. }) => Some("Removing a segment".into()),
        Command::Segment(SegmentCommand::Import { .. }) => Some("Importing segments".into()),
        Command::Render(_) => Some("Drawing a picture".into()),
        Command::History(HistoryCommand::Undo { .. }) => Some("Undoing".into()),
        Command::History(HistoryCommand::Redo { .. }) => Some("Redoing".into()),
        _ => None,
    }
}
