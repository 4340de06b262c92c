//! The question that is asked, with what was answered so far; drawn in `dialogs`.
//!
//! One at a time. Knows no window and sends no command.

use crate::ui::browse::Browser;
use crate::ui::browse::glance::Glance;
use crate::ui::browse::places::Place;
use crate::ui::state::path_purpose::Export;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::state::picture_wish::Picturing;
use crate::ui::state::saving::AfterSave;
use crate::ui::state::saving::OpenTarget;
use crate::ui::thread::session::Offer;
use std::path::PathBuf;

/// What is asked.
pub(crate) enum Dialog {
    /// A path for something, where the system has no dialog for that.
    Browse(Box<Browse>),
    /// The window closes with unsaved changes.
    Close,
    /// Something else is opened over unsaved changes.
    Replace(OpenTarget),
    /// Documents that crashes left behind.
    Lost(Vec<Lost>),
    /// What the values of a file mean.
    Meaning(Meaning),
    /// What is exported, and how.
    Export(Export),
    /// How a picture shall be.
    Picture(Box<Picturing>),
    /// What can be done about something that went wrong.
    Offer(Box<Offer>),
    /// Nothing: the window waits for a save, after which it closes or opens something else.
    Saving,
}

/// The file browser, and what for.
pub(crate) struct Browse {
    pub(crate) what: PathPurpose,
    pub(crate) browser: Browser,
    pub(crate) places: Vec<Place>,
    /// Keys that wait for the text before them.
    pub(crate) held: Vec<egui::Event>,
}

impl Dialog {
    /// How wide it is, at most.
    pub(crate) const fn width(&self) -> f32 {
        match self {
            Self::Browse(_) => 760.0,
            Self::Picture(_) => 800.0,
            Self::Meaning(_) | Self::Export(_) | Self::Offer(_) => 480.0,
            _ => 440.0,
        }
    }
}

/// The question.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Meaning {
    pub(crate) path: PathBuf,
    /// The header says so itself.
    pub(crate) named: bool,
    /// It comes beside what is open in any case.
    pub(crate) beside: bool,
}

/// A document that a crash left behind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lost {
    pub(crate) id: String,
    /// The file that was open.
    pub(crate) origin: String,
    /// How long ago it was changed last, in words; empty if nobody knows.
    pub(crate) age: String,
    /// Thrown away at the next click.
    pub(crate) doomed: bool,
}

/// What a dialog that runs beside the window came back with.
pub(crate) enum Chosen {
    /// A path, and what for.
    Path(PathPurpose, PathBuf),
    /// The system showed no dialog after all.
    NoDialog(PathPurpose),
    /// What a file looks like; which of the glances it was.
    Glanced(Glanced),
}

/// A file that was looked at.
pub(crate) struct Glanced {
    pub(crate) path: PathBuf,
    pub(crate) found: Glance,
    pub(crate) number: u64,
    /// It comes beside what is open.
    pub(crate) beside: bool,
}

/// A browser whose path was taken, until it is known whether it served.
pub(crate) struct Parked {
    pub(crate) browse: Box<Browse>,
    pub(crate) after_save: Option<AfterSave>,
}
