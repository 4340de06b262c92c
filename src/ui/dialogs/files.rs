//! Asking for a path, and what becomes of it: by the system's dialog where there is one, else by the browser.
//!
//! The browser is put aside while the document does what was asked, and comes back with what was typed if that fails.

use crate::document::{Command, ProjectCommand, SegmentCommand, SelectionCommand, VolumeCommand};
use crate::io::without_numbers;
use crate::ui::browse::names::shown;
use crate::ui::browse::{Asks, Browser, Wake, places};
use crate::ui::state::dialog::Chosen;
use crate::ui::state::dialog::Parked;
use crate::ui::state::dialog::{Browse, Dialog};
use crate::ui::state::path_purpose::Export;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::thread::session::Severity;
use crate::ui::window::app::App;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Nobody says no to a dialog faster: there was none.
const TOO_FAST: Duration = Duration::from_millis(400);

impl App {
    /// The same with the system's file dialogs, if it has any; without them the window's own browser asks for paths.
    pub fn with_system_dialogs(mut self) -> Self {
        self.system_dialogs = has_file_dialog();
        self
    }

    /// Asks for a path.
    pub(crate) fn ask(&mut self, what: PathPurpose) {
        self.parked = None;
        if !self.system_dialogs {
            self.browse(what);
            return;
        }
        let (folder, name) = (self.folder_for(&what), self.offered_name(&what));
        let (back, wake, asked) = (self.chosen.0.clone(), self.wake(), what.clone());
        // The system's dialog answers when the user does; the window goes on.
        let started = std::thread::Builder::new().name("file dialog".into()).spawn(move || {
            let begun = Instant::now();
            let answer = match by_system(&asked, &folder, &name) {
                Some(path) => Chosen::Path(asked, path),
                None if begun.elapsed() < TOO_FAST => Chosen::NoDialog(asked),
                None => return,
            };
            // Nobody there: the window was closed meanwhile.
            let _gone = back.send(answer);
            wake();
        });
        if started.is_err() {
            self.browse(what);
        }
    }

    fn browse(&mut self, what: PathPurpose) {
        let folder = self.folder_for(&what);
        let name = self.offered_name(&what);
        let browser = Browser::new(what.purpose(), &folder, &name.to_string_lossy(), self.home.clone(), self.wake());
        self.show_browser(what, browser);
    }

    fn show_browser(&mut self, what: PathPurpose, browser: Browser) {
        let places = places(self.home.as_deref(), &self.recent.folders());
        self.dialog = Some(Dialog::Browse(Box::new(Browse { what, browser, places, held: Vec::new() })));
    }

    /// Takes the path of the system's dialog, which gives no endings.
    fn given(&mut self, what: PathPurpose, path: PathBuf) {
        if what.purpose().asks != Asks::SaveFile {
            return self.choose(what, path);
        }
        match Browser::given(what.purpose(), &path, self.home.clone(), self.wake()) {
            Ok(path) => self.choose(what, path),
            Err(browser) => self.show_browser(what, *browser),
        }
    }

    /// Draws the window again when something has come from another thread.
    pub(crate) fn wake(&self) -> Wake {
        let ctx = self.context.clone();
        Arc::new(move || ctx.request_repaint())
    }

    fn take_choices(&mut self) {
        let later = std::mem::take(&mut self.later);
        let choices: Vec<_> = later.into_iter().chain(self.chosen.1.try_iter()).collect();
        for choice in choices {
            match choice {
                Chosen::Path(what, path) => self.given(what, path),
                Chosen::Glanced(glanced) => self.glanced(glanced),
                Chosen::NoDialog(what) => {
                    self.system_dialogs = false;
                    if self.dialog.is_none() {
                        self.browse(what);
                    }
                }
            }
        }
    }

    /// Takes the browser's path; the browser waits for the end.
    pub(super) fn choose_by(&mut self, browse: Box<Browse>, path: PathBuf) {
        let what = browse.what.clone();
        self.parked = Some(Parked { browse, after_save: self.after_save.clone() });
        self.choose(what, path);
    }

    fn choose(&mut self, what: PathPurpose, path: PathBuf) {
        match what {
            PathPurpose::Open => self.look_at(path, false),
            PathPurpose::Add => self.look_at(path, true),
            PathPurpose::Source(project) => self.send(Command::Project(ProjectCommand::Open {
                path: project,
                source: Some(path),
                generation: None,
            })),
            PathPurpose::SaveAs => self.send_save(Some(path)),
            PathPurpose::Export(Export { field, label, .. }) => {
                self.send(Command::Volume(VolumeCommand::Export { field, label, path, volume: None }))
            }
            PathPurpose::Image(wish) => {
                if let Some(scene) = &self.scene {
                    let command = wish.command(scene, path);
                    self.send(Command::Render(command));
                }
            }
            PathPurpose::Decal => {
                self.parked = None;
                self.writing.image = Some(path.to_string_lossy().into_owned());
            }
            PathPurpose::Labels => {
                self.send(Command::Segment(SegmentCommand::Import { path, component: 0, frame: 0, volume: None }))
            }
            PathPurpose::Selection => {
                let import = SelectionCommand::Import { path, threshold: 0.0, soften_mm: 0.0, volume: None };
                self.send(Command::Selection(import));
            }
        }
    }

    /// What a browser's path was taken for is done.
    pub(crate) fn file_done(&mut self, command: &Command) {
        self.parked.take_if(|parked| serves(&parked.browse.what, command));
    }

    /// Whether a project's volume is being named: the browser comes back if it is another one.
    pub(crate) fn names_source(&self) -> bool {
        self.parked.as_ref().is_some_and(|parked| matches!(parked.browse.what, PathPurpose::Source(_)))
    }

    /// It failed: the browser comes back as it was, with the reason. Answers whether it did.
    pub(crate) fn file_failed(&mut self, command: &Command, reason: &str) -> bool {
        let Some(parked) = self.parked.take_if(|parked| serves(&parked.browse.what, command)) else { return false };
        if self.dialog.is_some() {
            return false;
        }
        let Parked { mut browse, after_save } = parked;
        browse.browser.fail(shown(without_numbers(reason).as_ref()));
        browse.browser.refresh();
        self.after_save = after_save;
        self.dialog = Some(Dialog::Browse(browse));
        true
    }

    fn take_drops(&mut self, ctx: &egui::Context) {
        let dropped: Vec<_> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_path_buf()).collect());
        let Some(path) = dropped.first() else { return };
        // What is asked is answered first.
        if !matches!(self.dialog, None | Some(Dialog::Browse(_))) {
            return;
        }
        self.dialog = None;
        if dropped.len() > 1 {
            let name = shown(path.file_name().unwrap_or(path.as_os_str()));
            let text =
                format!("{} files were dropped; one document is open at a time, so {name} is opened.", dropped.len());
            self.say(Severity::Note, text);
        }
        self.open_asked(path.clone());
    }

    /// What came from outside the window since the last frame.
    pub(crate) fn take_files(&mut self, ctx: &egui::Context) {
        self.take_choices();
        self.take_drops(ctx);
        self.recent.poll();
    }
}

/// Whether a command is what a path was asked for.
fn serves(what: &PathPurpose, command: &Command) -> bool {
    match command {
        Command::Volume(VolumeCommand::Open { .. }) => *what == PathPurpose::Open,
        Command::Volume(VolumeCommand::Add { .. }) => matches!(what, PathPurpose::Add | PathPurpose::Open),
        Command::Project(ProjectCommand::Open { .. }) => matches!(what, PathPurpose::Open | PathPurpose::Source(_)),
        Command::Project(ProjectCommand::Save { .. }) => *what == PathPurpose::SaveAs,
        Command::Volume(VolumeCommand::Export { .. }) => matches!(what, PathPurpose::Export(_)),
        Command::Render(_) => matches!(what, PathPurpose::Image(_)),
        Command::Selection(SelectionCommand::Import { .. }) => {
            matches!(what, PathPurpose::Selection | PathPurpose::Open)
        }
        Command::Segment(SegmentCommand::Import { .. }) => matches!(what, PathPurpose::Labels | PathPurpose::Open),
        _ => false,
    }
}

fn by_system(what: &PathPurpose, folder: &Path, name: &std::ffi::OsStr) -> Option<PathBuf> {
    let mut ask = rfd::FileDialog::new().set_title(what.title()).set_directory(folder);
    if !name.is_empty() {
        ask = ask.set_file_name(name.to_string_lossy());
    }
    match what {
        PathPurpose::Open => {
            // A project is a folder, which cannot be picked here: its manifest stands for it.
            let extensions = ["nii", "gz", "nrrd", "nhdr", "hdr", "json"];
            ask.add_filter("Volumes and projects", &extensions).add_filter("All files", &["*"]).pick_file()
        }
        PathPurpose::Add | PathPurpose::Selection | PathPurpose::Labels | PathPurpose::Source(_) => {
            ask.add_filter("Volumes", &["nii", "gz", "nrrd", "nhdr", "hdr"]).pick_file()
        }
        PathPurpose::Decal => ask.add_filter("Pictures", &["png"]).pick_file(),
        PathPurpose::SaveAs | PathPurpose::Export(_) | PathPurpose::Image(_) => ask.save_file(),
    }
}

/// Whether the system can show a file dialog: on Linux that takes a session bus with a portal on it.
/// `BURIN_WITHOUT_PORTAL` says no.
fn has_file_dialog() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|a| !a.is_empty());
    if set("BURIN_WITHOUT_PORTAL") {
        return false;
    }
    cfg!(any(target_os = "windows", target_os = "macos"))
        || (set("DBUS_SESSION_BUS_ADDRESS") && set("XDG_CURRENT_DESKTOP"))
}
