//! What a path is asked for: its words, its endings, the name that is offered first.

use crate::document::ViewName;
use crate::ui::browse::{Asks, Purpose};
use crate::ui::dialogs::export::Export;
use crate::ui::dialogs::picture::Wish;
use crate::ui::window::app::App;
use crate::volume::FieldKind;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Files that are opened, and those that are told what they are.
const VOLUMES: &[&str] = &[".nii", ".nii.gz", ".nrrd", ".nhdr", ".hdr", ".dcm"];

/// What a path is for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum What {
    Open,
    SaveAs,
    Export(Export),
    Image(Wish),
    Selection,
    Labels,
    /// The volume of this project, which is not where it was.
    Source(PathBuf),
}

impl What {
    pub(super) const fn title(&self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::SaveAs => "Save project",
            Self::Export(Export { field: FieldKind::Labels, .. }) => "Export labels",
            Self::Export(Export { field: FieldKind::Selection, .. }) => "Export selection",
            Self::Export(Export { field: FieldKind::Colour, .. }) => "Export colour",
            Self::Export(_) => "Export density",
            Self::Image(_) => "Save picture",
            Self::Selection => "Import selection",
            Self::Labels => "Import labels",
            Self::Source(_) => "Find the project's volume",
        }
    }

    /// On the button that does it.
    pub(super) const fn action(&self) -> &'static str {
        match self {
            Self::Open | Self::Source(_) => "Open",
            Self::SaveAs | Self::Image(_) => "Save",
            Self::Export(_) => "Export",
            Self::Selection | Self::Labels => "Import",
        }
    }

    pub(super) const fn hint(&self) -> &'static str {
        match self {
            Self::Open => "A volume (.nii, .nii.gz, .nrrd) or a Burin project",
            Self::SaveAs => "A project is a folder; it is made if it is not there",
            Self::Export(_) => "Where the file is written",
            Self::Image(_) => "Where the picture is written",
            Self::Selection => "A volume of the same place; what is above 0 is selected",
            Self::Labels => "A label map of the same place; each value becomes a segment",
            Self::Source(_) => "The file that the project was saved with; it is known by its content",
        }
    }

    pub(super) const fn purpose(&self) -> Purpose {
        match self {
            Self::Open | Self::Selection | Self::Labels | Self::Source(_) => {
                Purpose { asks: Asks::Open, endings: VOLUMES }
            }
            Self::SaveAs => Purpose { asks: Asks::SaveFolder, endings: &[] },
            Self::Export(export) => Purpose { asks: Asks::SaveFile, endings: export.endings },
            Self::Image(Wish { exr: true, .. }) => Purpose { asks: Asks::SaveFile, endings: &[".exr"] },
            Self::Image(_) => Purpose { asks: Asks::SaveFile, endings: &[".png"] },
        }
    }

    /// What is written is called this first: as the document, with an ending of its own.
    pub(super) fn name(&self, app: &App) -> OsString {
        let mut name = stem(app);
        match self {
            Self::Open | Self::Selection | Self::Labels | Self::Source(_) => return OsString::new(),
            Self::SaveAs => name.push(".burin"),
            Self::Export(Export { field, endings }) => {
                let ending = endings.first().copied().unwrap_or_default();
                // Segments are named by their ending already.
                let what = if ending == ".seg.nrrd" { String::new() } else { format!("-{}", field.name()) };
                name.push(format!("{what}{ending}"));
            }
            Self::Image(wish) => {
                if wish.view != ViewName::ThreeD {
                    name.push(format!("-{}", wish.view.name()));
                }
                name.push(if wish.exr { ".exr" } else { ".png" });
            }
        }
        name
    }
}

/// The document's name without its ending.
fn stem(app: &App) -> OsString {
    let Some(open) = app.opened() else { return OsString::new() };
    let path = app.snapshot.place(open);
    let Some(name) = path.file_name() else { return "volume".into() };
    // Endings are text, whatever the rest is.
    let Some(text) = name.to_str() else { return path.file_stem().unwrap_or(name).to_owned() };
    let lower = text.to_lowercase();
    let endings = [".seg.nrrd", ".nii.gz", ".burin", ".nrrd", ".nhdr", ".nii", ".hdr"];
    let cut = endings.iter().find(|e| lower.ends_with(**e)).map_or(0, |e| e.len());
    text[..text.len() - cut].into()
}

impl App {
    /// The folder where a dialog begins: for what is written beside the document, else where something was opened last.
    pub(super) fn folder_for(&self, what: &What) -> PathBuf {
        let beside = self.opened().map(|open| {
            let path = self.snapshot.place(open);
            path.parent().map(Path::to_path_buf).unwrap_or_default()
        });
        // The sample lies where nobody looks for his work.
        let beside = beside.filter(|folder| !self.recent.owns(folder) && folder.is_dir());
        let last = self.recent.folders().into_iter().next();
        let folder = match what {
            What::Open | What::Selection | What::Labels | What::Source(_) => last.or(beside),
            What::SaveAs | What::Export(_) | What::Image(_) => beside.or(last),
        };
        folder
            .or_else(|| self.home.clone())
            .or_else(|| std::env::current_dir().ok())
            .unwrap_or_else(|| PathBuf::from("/"))
    }
}
