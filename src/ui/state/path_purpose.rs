//! What a path is asked for: its words, its endings.
//!
//! Knows neither dialogs nor the document that is open.

use crate::io::{export_endings, mesh_endings, readers};
use crate::ui::browse::Asks;
use crate::ui::browse::Purpose;
use crate::ui::state::picture_wish::Wish;
use crate::volume::FieldKind;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::LazyLock;

/// The question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Export {
    pub(crate) field: FieldKind,
    /// The endings of the format, the usual one first.
    pub(crate) endings: &'static [&'static str],
    /// The segment whose surface is meant, where it is one.
    pub(crate) label: Option<u16>,
}

impl Export {
    /// Of a field, in the format that keeps most of it.
    pub(crate) fn of(field: FieldKind) -> Self {
        Self { field, endings: export_endings(field).first().copied().unwrap_or_default(), label: None }
    }

    /// Whether it is a surface.
    pub(crate) fn is_mesh(&self) -> bool {
        mesh_endings().any(|endings| endings == self.endings)
    }
}

/// How the names of files end that are opened, and of those that are told what they are.
static VOLUMES: LazyLock<Vec<&str>> =
    LazyLock::new(|| readers().iter().flat_map(|reader| reader.endings()).copied().chain([".dcm"]).collect());

/// What can be opened, in words.
pub(crate) fn formats() -> String {
    readers().iter().map(|reader| reader.title()).collect::<Vec<_>>().join(", ")
}

/// What a path is for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PathPurpose {
    Open,
    /// One more volume beside those that are open.
    Add,
    SaveAs,
    Export(Export),
    Image(Wish),
    Selection,
    Labels,
    /// What an annotation shows.
    Decal,
    /// The volume of this project, which is not where it was.
    Source(PathBuf),
}

impl PathPurpose {
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
            Self::Decal => "Choose a picture",
            Self::Source(_) => "Find the project's volume",
        }
    }

    /// On the button that does it.
    pub(crate) const fn action(&self) -> &'static str {
        match self {
            Self::Open | Self::Source(_) => "Open",
            Self::Add => "Add",
            Self::Decal => "Choose",
            Self::SaveAs | Self::Image(_) => "Save",
            Self::Export(_) => "Export",
            Self::Selection | Self::Labels => "Import",
        }
    }

    pub(crate) fn hint(&self) -> Cow<'static, str> {
        let said = match self {
            Self::Open => return format!("A volume, {}, or a Burin project", formats()).into(),
            Self::Add => {
                return format!("{}: a volume that comes beside what is open, on its own grid", formats()).into();
            }
            Self::SaveAs => "A project is a folder; it is made if it is not there",
            Self::Export(_) => "Where the file is written",
            Self::Image(_) => "Where the picture is written",
            Self::Selection => "A volume of the same place; what is above 0 is selected",
            Self::Labels => "A label map of the same place; each value becomes a segment",
            Self::Decal => "A PNG picture, which the next annotation lays on a surface",
            Self::Source(_) => "The file that the project was saved with; it is known by its content",
        };
        said.into()
    }

    pub(crate) fn purpose(&self) -> Purpose {
        match self {
            Self::Open | Self::Add | Self::Selection | Self::Labels | Self::Source(_) => {
                Purpose { asks: Asks::Open, endings: &VOLUMES }
            }
            Self::Decal => Purpose { asks: Asks::Open, endings: &[".png"] },
            Self::SaveAs => Purpose { asks: Asks::SaveFolder, endings: &[] },
            Self::Export(export) => Purpose { asks: Asks::SaveFile, endings: export.endings },
            Self::Image(Wish { exr: true, .. }) => Purpose { asks: Asks::SaveFile, endings: &[".exr"] },
            Self::Image(_) => Purpose { asks: Asks::SaveFile, endings: &[".png"] },
        }
    }
}
