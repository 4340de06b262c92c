//! What is exported, and to which format; the path is asked next.

use super::{Dialog, What, cancel, primary};
use crate::ui::app::App;
use crate::ui::theme;
use crate::ui::widgets::{choice, from_right_row, row};
use crate::volume::FieldKind;
use egui::{RichText, Ui};

/// A format that volumes are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ui) enum Format {
    Nrrd,
    SegNrrd,
    Nifti,
}

impl Format {
    /// Those that hold a field.
    const fn of(field: FieldKind) -> &'static [Self] {
        match field {
            FieldKind::Labels => &[Self::SegNrrd, Self::Nrrd, Self::Nifti],
            FieldKind::Density | FieldKind::Selection | FieldKind::Colour => &[Self::Nrrd, Self::Nifti],
        }
    }

    /// The ending of its files, and others that serve.
    pub(super) const fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Nrrd => &[".nrrd"],
            Self::SegNrrd => &[".seg.nrrd"],
            Self::Nifti => &[".nii.gz", ".nii"],
        }
    }

    const fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Nrrd => ("NRRD", "One file with its place in space; 3D Slicer, ITK and Python read it"),
            Self::SegNrrd => ("Segments (.seg.nrrd)", "With names and colours, as 3D Slicer has segmentations"),
            Self::Nifti => ("NIfTI (.nii.gz)", "FSL, FreeSurfer, ITK-SNAP, nibabel read it"),
        }
    }
}

/// The question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ui) struct Export {
    pub(super) field: FieldKind,
    pub(super) format: Format,
}

impl Export {
    /// Of a field, in the format that keeps most of it.
    pub(in crate::ui) const fn of(field: FieldKind) -> Self {
        Self { field, format: Format::of(field)[0] }
    }
}

impl App {
    /// Asks what is exported.
    pub(in crate::ui) fn ask_export(&mut self) {
        if self.opened().is_some() {
            self.dialog = Some(Dialog::Export(self.export_wish));
        }
    }

    pub(super) fn export_dialog(&mut self, ui: &mut Ui, mut export: Export) -> Option<Dialog> {
        ui.heading("Export");
        ui.add_space(8.0);
        let fields = [
            (FieldKind::Density, "Density", "The values of the volume, as they were painted"),
            (FieldKind::Labels, "Labels", "The segments: which voxel belongs to which"),
            (FieldKind::Selection, "Selection", "How much each voxel is selected, 0 to 1"),
            (FieldKind::Colour, "Colour", "Painted colour, red, green, blue and how much of it"),
        ];
        row(ui, "What", |ui| {
            if let Some(field) = choice(ui, "What", Some(export.field), &fields) {
                export = Export::of(field);
            }
        });
        let formats: Vec<_> = Format::of(export.field).iter().map(|f| (*f, f.name().0, f.name().1)).collect();
        row(ui, "Format", |ui| {
            if let Some(format) = choice(ui, "Format", Some(export.format), &formats) {
                export.format = format;
            }
        });
        ui.add_space(4.0);
        let about = fields.iter().find(|f| f.0 == export.field).map_or("", |f| f.2);
        ui.label(RichText::new(format!("{about}. {}.", export.format.name().1)).color(theme::TEXT_WEAK));
        ui.add_space(14.0);
        let (yes, no) = from_right_row(ui, |ui| {
            let yes = ui.add(primary("Choose where…")).on_hover_text("Name and folder come next");
            (yes.clicked(), cancel(ui))
        });
        if yes {
            self.export_wish = export;
            self.ask(What::Export(export));
            return None;
        }
        (!no).then_some(Dialog::Export(export))
    }
}
