//! How files and projects come into the window: by a path, by the command line, and after a crash.

use crate::document::{Command, OpenAs, ProjectCommand, USUAL_COMPONENT, VolumeCommand};
use crate::ui::window::app::App;
use std::path::{Path, PathBuf};

/// How strongly a measurement shows that is laid over others.
const OVER: f32 = 0.5;

impl App {
    /// Opens whatever a path is: a project folder or a volume. What is open is replaced.
    pub fn open(&mut self, path: &Path) {
        // A dialog of the system may show a project's files and not let the folder be chosen.
        let manifest = path.file_name().is_some_and(|name| name == "project.json");
        let path = if manifest { path.parent().unwrap_or(path) } else { path };
        if path.is_dir() {
            self.send(Command::Project(ProjectCommand::Open { path: path.into(), source: None, generation: None }));
        } else {
            self.open_as(path.into(), OpenAs::Image);
        }
    }

    /// Opens a volume.
    pub(crate) fn open_as(&mut self, path: PathBuf, open_as: OpenAs) {
        self.send(Command::Volume(VolumeCommand::Open {
            path,
            component: USUAL_COMPONENT,
            frame: 0,
            range: None,
            open_as,
        }));
    }

    /// Opens a volume beside what is open.
    pub(crate) fn add_volume(&mut self, path: PathBuf, open_as: OpenAs) {
        // What is measured would cover what it is laid over; labels leave it to be seen.
        let opacity = (open_as == OpenAs::Image && self.opened().is_some()).then_some(OVER);
        self.send(Command::Volume(VolumeCommand::Add {
            path,
            component: USUAL_COMPONENT,
            frame: 0,
            range: None,
            open_as,
            name: None,
            opacity,
        }));
    }

    /// First thing: opens what was named, and asks for what a crash left behind.
    pub(crate) fn start(&mut self, open: Option<&Path>, warning: Option<String>) {
        if let Some(warning) = warning {
            self.warn_until("project.save", warning);
        }
        if let Some(path) = open {
            self.open_asked(path.into());
        }
        self.send(Command::Project(ProjectCommand::Lost {}));
    }
}
