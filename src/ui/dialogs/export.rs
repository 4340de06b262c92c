//! What is exported, and to which format; the path is asked next.

use crate::io::{about_format, export_endings};
use crate::ui::state::dialog::Dialog;
use crate::ui::state::path_purpose::Export;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::style::theme;
use crate::ui::style::widgets::{cancel, primary};
use crate::ui::style::widgets::{choice, from_right_row, row};
use crate::ui::window::app::App;
use crate::volume::FieldKind;
use egui::{RichText, Ui};

impl App {
    /// Asks what is exported.
    pub(crate) fn ask_export(&mut self) {
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
        let formats = export_endings(export.field).into_iter().map(|endings| {
            let (name, about, _) = about_format(endings).unwrap_or_default();
            (endings, name, about)
        });
        let formats: Vec<_> = formats.collect();
        row(ui, "Format", |ui| {
            if let Some(endings) = choice(ui, "Format", Some(export.endings), &formats) {
                export.endings = endings;
            }
        });
        ui.add_space(4.0);
        let what = fields.iter().find(|f| f.0 == export.field).map_or("", |f| f.2);
        let (_, about, _) = about_format(export.endings).unwrap_or_default();
        ui.label(RichText::new(format!("{what}. {about}.")).color(theme::TEXT_WEAK));
        ui.add_space(14.0);
        let (yes, no) = from_right_row(ui, |ui| {
            let yes = ui.add(primary("Choose where…")).on_hover_text("Name and folder come next");
            (yes.clicked(), cancel(ui))
        });
        if yes {
            self.export_wish = export;
            self.ask(PathPurpose::Export(export));
            return None;
        }
        (!no).then_some(Dialog::Export(export))
    }
}
