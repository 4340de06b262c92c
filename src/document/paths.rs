//! The paths in commands: which there are, and what of them is taken for what.
//!
//! Scripts have no shell that knows `~`. A file that is written must be no file that the document reads, and none that a project
//! keeps. Knows commands and files, not what is done with them.

use crate::document::command::files::{ProjectCommand, RenderCommand, VolumeCommand};
use crate::document::command::sub_volumes::SubVolumeCommand;
use crate::document::command::{Command, SegmentCommand, SelectionCommand};
use crate::document::disk::lock::LOCK;
use crate::document::disk::source_files::SourceFiles;
use crate::document::error::DocumentError;
use crate::document::project::manifest::PROJECT;
use crate::document::project::read::{check_project, generation_of};
use crate::io::FileMark;
use crate::volume::VolumeId;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Command {
    /// Every path that it names, the one that it is about first.
    fn paths_mut(&mut self) -> Vec<&mut PathBuf> {
        match self {
            Self::Project(command) => match command {
                ProjectCommand::Open { path, source, .. } => std::iter::once(path).chain(source.as_mut()).collect(),
                ProjectCommand::Save { path, .. } => path.as_mut().into_iter().collect(),
                ProjectCommand::Lost {} | ProjectCommand::Recover { .. } | ProjectCommand::Forget { .. } => Vec::new(),
            },
            Self::Volume(
                VolumeCommand::Open { path, .. } | VolumeCommand::Add { path, .. } | VolumeCommand::Export { path, .. },
            )
            | Self::Selection(SelectionCommand::Import { path, .. })
            | Self::Segment(SegmentCommand::Import { path, .. })
            | Self::SubVolume(SubVolumeCommand::Export { path, .. })
            | Self::Render(RenderCommand::Image { path, .. }) => vec![path],
            Self::Selection(
                SelectionCommand::FromLabel { .. } | SelectionCommand::Clear { .. } | SelectionCommand::Set { .. },
            )
            | Self::Segment(
                SegmentCommand::Set { .. } | SegmentCommand::Remove { .. } | SegmentCommand::ShowOnly { .. },
            )
            | Self::Volume(VolumeCommand::Remove { .. } | VolumeCommand::Set { .. })
            | Self::SubVolume(
                SubVolumeCommand::Add { .. }
                | SubVolumeCommand::Set { .. }
                | SubVolumeCommand::Remove { .. }
                | SubVolumeCommand::Bake { .. },
            )
            | Self::Transfer(_)
            | Self::View(_)
            | Self::Brush(_)
            | Self::Stroke(_)
            | Self::Component(_)
            | Self::Part(_)
            | Self::Explosion(_)
            | Self::Annotation(_)
            | Self::Label(_)
            | Self::Cutaway(_)
            | Self::History(_)
            | Self::Ask(_) => Vec::new(),
        }
    }

    /// The file or folder that it is about.
    pub fn path(&self) -> Option<PathBuf> {
        self.clone().paths_mut().into_iter().next().map(std::mem::take)
    }

    /// The command with `~` at a path's beginning taken for the home folder.
    ///
    /// # Errors
    /// If a path is empty.
    pub(crate) fn at_home(mut self) -> Result<Self, DocumentError> {
        for path in self.paths_mut() {
            if path.as_os_str().is_empty() {
                return Err(DocumentError::invalid("path", "nothing", "the name of a file or folder"));
            }
            *path = at_home(std::mem::take(path));
        }
        Ok(self)
    }
}

/// A path with `~` at its beginning taken for the home folder, unless something is there that is named so.
pub fn at_home(path: PathBuf) -> PathBuf {
    let home = std::env::var_os("HOME").filter(|home| !home.is_empty());
    match (path.strip_prefix("~"), home) {
        (Ok(rest), Some(home)) if path.symlink_metadata().is_err() => PathBuf::from(home).join(rest),
        _ => path,
    }
}

/// Fails if to write to `path` would harm a file that the document reads, or a project.
///
/// # Errors
/// The reason, with the file.
pub(crate) fn check_target(path: &Path, files: &BTreeMap<VolumeId, Arc<SourceFiles>>) -> Result<(), DocumentError> {
    let refused = |expected: String| Err(DocumentError::invalid("path", path.display(), expected));
    let lead = leads_to(path);
    let mark = FileMark::of(path).ok();
    for file in files.values().flat_map(|files| files.files()) {
        let now = FileMark::of(&file.path).ok();
        let same = mark.as_ref().is_some_and(|m| m.is_same_file(file) || now.is_some_and(|n| m.is_same_file(&n)));
        if same || lead == leads_to(&file.path) {
            return refused(format!("another file than {}, which the volume is read from", file.path.display()));
        }
    }
    let inside = |dir: &Path| check_project(dir).is_ok();
    for below in lead.ancestors() {
        // A step upward (`..`) that nothing is there to resolve has no name of its own.
        let (Some(dir), Some(name)) = (below.parent(), below.file_name()) else { continue };
        let name = name.to_string_lossy();
        let kept = generation_of(&name).is_some()
            || [LOCK, PROJECT, "project.new"].contains(&&*name)
            || name.starts_with("journal-");
        if kept && inside(dir) {
            return refused(format!("a place that the project {} does not keep itself in", dir.display()));
        }
    }
    Ok(())
}

/// Where a path leads, links followed, also if nothing is there yet.
fn leads_to(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let folder = || Some(absolute.parent()?.canonicalize().ok()?.join(absolute.file_name()?));
    absolute.canonicalize().ok().or_else(folder).unwrap_or(absolute)
}
