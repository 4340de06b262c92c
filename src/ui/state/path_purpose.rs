//! What a path is asked for: its words, its endings.
//!
//! Knows neither dialogs nor the document that is open.

use crate::io::export_endings;
use crate::ui::browse::Asks;
use crate::ui::browse::Purpose;
use crate::ui::state::picture_wish::Wish;
use crate::volume::FieldKind;
use std::path::PathBuf;

/// The question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Export {
    pub(crate) field: FieldKind,
    /// The endings of the format, the usual one first.
    pub(crate) endings: &'static [&'static str],
}

impl Export {
    /// Of a field, in the format that keeps most of it.
    pub(crate) fn of(field: FieldKind) -> Self {
        Self { field, endings: export_endings(field).first().copied().unwrap_or_default() }
    }
}

/// Files that are opened, and those that are told what they are.
pub(crate) const VOLUMES: &[&str] = &[".nii", ".nii.gz", ".nrrd", ".nhdr", ".hdr", ".dcm"];

/// What a path is for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum What {
    Open,
    /// One more volume beside those that are open.
    Add,
    SaveAs,
    Export(Export),
    Image(Wish),
    Selection,
    Labels,
    /// The volume of this project, which is not where it was.
    Source(PathBuf),
}

impl What {
    pub(crate) const fn title(&self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::Add => "Add a volume",
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
    pub(crate) const fn action(&self) -> &'static str {
        match self {
            Self::Open | Self::Source(_) => "Open",
            Self::Add => "Add",
            Self::SaveAs | Self::Image(_) => "Save",
            Self::Export(_) => "Export",
            Self::Selection | Self::Labels => "Import",
        }
    }

    pub(crate) const fn hint(&self) -> &'static str {
        match self {
            Self::Open => "A volume (.nii, .nii.gz, .nrrd) or a Burin project",
            Self::Add => "A volume (.nii, .nii.gz, .nrrd) that comes beside what is open, on its own grid",
            Self::SaveAs => "A project is a folder; it is made if it is not there",
            Self::Export(_) => "Where the file is written",
            Self::Image(_) => "Where the picture is written",
            Self::Selection => "A volume of the same place; what is above 0 is selected",
            Self::Labels => "A label map of the same place; each value becomes a segment",
            Self::Source(_) => "The file that the project was saved with; it is known by its content",
        }
    }

    pub(crate) const fn purpose(&self) -> Purpose {
        match self {
            Self::Open | Self::Add | Self::Selection | Self::Labels | Self::Source(_) => {
                Purpose { asks: Asks::Open, endings: VOLUMES }
            }
            Self::SaveAs => Purpose { asks: Asks::SaveFolder, endings: &[] },
            Self::Export(export) => Purpose { asks: Asks::SaveFile, endings: export.endings },
            Self::Image(Wish { exr: true, .. }) => Purpose { asks: Asks::SaveFile, endings: &[".exr"] },
            Self::Image(_) => Purpose { asks: Asks::SaveFile, endings: &[".png"] },
        }
    }
}
