//! What a save was asked for on the way to.

use crate::document::OpenAs;
use crate::ui::browse::names::shown;
use std::path::PathBuf;

/// What is opened in place of what is open.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum OpenTarget {
    /// A volume or a project.
    Path(PathBuf),
    /// A volume whose values mean something else than grey.
    Volume(PathBuf, OpenAs),
    /// What a crash left behind, and the file that it was of.
    Lost { id: String, origin: String },
}

impl OpenTarget {
    /// What the user knows it by.
    pub(crate) fn name(&self) -> String {
        let path = match self {
            Self::Path(path) | Self::Volume(path, _) => path.as_path(),
            Self::Lost { origin, .. } => std::path::Path::new(origin),
        };
        shown(path.file_name().unwrap_or(path.as_os_str()))
    }
}

/// What follows a save.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AfterSave {
    Close,
    Open(OpenTarget),
}
