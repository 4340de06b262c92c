//! What a path is asked for: its words, its endings, the name that is offered first.

use crate::document::ViewName;
use crate::io::{about_format, export_endings, readers};
use crate::ui::state::path_purpose::Export;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::window::app::App;
use crate::volume::FieldKind;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The document's name without its ending.
fn stem(app: &App) -> OsString {
    let Some(open) = app.opened() else { return OsString::new() };
    let path = app.snapshot.place(open);
    let Some(name) = path.file_name() else { return "volume".into() };
    // Endings are text, whatever the rest is.
    let Some(text) = name.to_str() else { return path.file_stem().unwrap_or(name).to_owned() };
    let lower = text.to_lowercase();
    let read = readers().iter().flat_map(|reader| reader.endings());
    let written = export_endings(FieldKind::Labels).into_iter().flatten();
    let endings = read.chain(written).copied().chain([".burin"]).filter(|ending| lower.ends_with(ending));
    let cut = endings.map(str::len).max().unwrap_or(0);
    text[..text.len() - cut].into()
}

impl App {
    /// What is written is called this first: as the document, with an ending of its own.
    pub(super) fn offered_name(&self, what: &PathPurpose) -> OsString {
        let mut name = stem(self);
        match what {
            PathPurpose::Open
            | PathPurpose::Add
            | PathPurpose::Selection
            | PathPurpose::Labels
            | PathPurpose::Decal
            | PathPurpose::Source(_) => return OsString::new(),
            PathPurpose::SaveAs => name.push(".burin"),
            PathPurpose::Export(Export { field, endings, label }) => {
                let ending = endings.first().copied().unwrap_or_default();
                // What holds labels only is named by its ending already.
                let named = about_format(endings).is_some_and(|(_, _, labels_only)| labels_only);
                let segment = label.and_then(|id| self.scene.as_ref()?.segments().get(id));
                let what = match segment {
                    // What is called anything, a file may not be.
                    Some(segment) => format!("-{}", segment.name.replace(['/', '\\', ':'], "-")),
                    None if named => String::new(),
                    None => format!("-{}", field.name()),
                };
                name.push(format!("{what}{ending}"));
            }
            PathPurpose::Image(wish) => {
                if wish.view != ViewName::ThreeD {
                    name.push(format!("-{}", wish.view.name()));
                }
                name.push(if wish.exr { ".exr" } else { ".png" });
            }
        }
        name
    }

    /// The folder where a dialog begins: for what is written beside the document, else where something was opened last.
    pub(super) fn folder_for(&self, what: &PathPurpose) -> PathBuf {
        let beside = self.opened().map(|open| {
            let path = self.snapshot.place(open);
            path.parent().map(Path::to_path_buf).unwrap_or_default()
        });
        // The sample lies where nobody looks for his work.
        let beside = beside.filter(|folder| !self.recent.owns(folder) && folder.is_dir());
        let last = self.recent.folders().into_iter().next();
        let folder = match what {
            PathPurpose::Open
            | PathPurpose::Add
            | PathPurpose::Selection
            | PathPurpose::Labels
            | PathPurpose::Decal
            | PathPurpose::Source(_) => last.or(beside),
            PathPurpose::SaveAs | PathPurpose::Export(_) | PathPurpose::Image(_) => beside.or(last),
        };
        folder
            .or_else(|| self.home.clone())
            .or_else(|| std::env::current_dir().ok())
            .unwrap_or_else(|| PathBuf::from("/"))
    }
}
