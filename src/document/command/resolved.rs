//! A command with all that it depends on beside the document: what a step of history keeps, so that it can be done again elsewhere.
//!
//! Pixels have become points of the world, a stroke has its brush, a file that was read its hash. What JSON cannot say (the name of a file that
//! is not UTF-8) is not kept. Owns what is kept of a group; knows not how places are found.

use crate::document::command::Command;
use crate::document::command::parts::{ExplosionCommand, PartCommand};
use crate::document::command::views::TransferCommand;
use crate::math::Camera;
use crate::paint::Brush;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A command that can be done again elsewhere: places in world mm, the brush and camera that counted, files by hash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResolvedCommand {
    /// The command as a script would say it, its places in world mm.
    pub command: Command,
    /// What a stroke was painted with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brush: Option<Brush>,
    /// The 3D view's camera, where the command depends on what was visible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// The files that it read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileRead>,
}

/// A file as it was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FileRead {
    /// Where it lay.
    pub path: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// Its hash, in hexadecimal digits.
    pub blake3: String,
}

impl ResolvedCommand {
    /// A command that reads no file and depends on no picture.
    pub(crate) fn plain(command: Command) -> Self {
        Self { command, brush: None, camera: None, files: Vec::new() }
    }

    /// Whether nothing is left of an earlier command once this one is done: it sets all that the earlier one set.
    fn supersedes(&self, earlier: &Self) -> bool {
        match (&earlier.command, &self.command) {
            (
                Command::Transfer(TransferCommand::Set { volume: a, .. }),
                Command::Transfer(TransferCommand::Set { volume: b, .. }),
            ) => a == b,
            (
                Command::Explosion(ExplosionCommand::Degree { .. }),
                Command::Explosion(ExplosionCommand::Degree { .. }),
            )
            | (
                Command::Explosion(ExplosionCommand::Forces { .. }),
                Command::Explosion(ExplosionCommand::Forces { .. }),
            ) => true,
            (Command::Part(PartCommand::Move { id: a, .. }), Command::Part(PartCommand::Move { id: b, .. })) => a == b,
            _ => false,
        }
    }
}

/// Adds the commands of a later step to those of an earlier one of the same group: of a slider's drag the last counts.
pub(crate) fn join(commands: &mut Vec<ResolvedCommand>, later: Vec<ResolvedCommand>) {
    for command in later {
        while commands.last().is_some_and(|last| command.supersedes(last)) {
            commands.pop();
        }
        commands.push(command);
    }
}
