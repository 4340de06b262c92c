//! What is exported, and to which format; the path is asked next.

use crate::io::{about_format, about_mesh_format, export_endings, mesh_endings};
use crate::paint::Target;
use crate::ui::state::dialog::Dialog;
use crate::ui::state::path_purpose::Export;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::style::theme;
use crate::ui::style::widgets::{cancel, primary};
use crate::ui::style::widgets::{choice, from_right_row, row, tipped};
use crate::ui::window::app::App;
use crate::volume::FieldKind;
use egui::{ComboBox, RichText, Ui};

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
        let surfaces = mesh_endings().filter_map(|endings| {
            let (name, about) = about_mesh_format(endings)?;
            Some((endings, name, about))
        });
        let surfaces: Vec<_> = surfaces.collect();
        let has_surface = matches!(export.field, FieldKind::Selection | FieldKind::Labels);
        if has_surface {
            row(ui, "Surface", |ui| {
                if let Some(endings) = choice(ui, "Surface", Some(export.endings), &surfaces) {
                    export.endings = endings;
                }
            });
        }
        export.label = export.label.filter(|_| export.is_mesh());
        if export.is_mesh() && export.field == FieldKind::Labels {
            self.surface_of(ui, &mut export);
        }
        ui.add_space(4.0);
        let what = match (export.is_mesh(), export.field) {
            (true, FieldKind::Selection) => "The closed surface of what is selected by a half or more",
            (true, _) => "The closed, smooth surface of a segment",
            _ => fields.iter().find(|f| f.0 == export.field).map_or("", |f| f.2),
        };
        let about = about_mesh_format(export.endings).map(|(_, about)| about);
        let about = about.unwrap_or_else(|| about_format(export.endings).unwrap_or_default().1);
        ui.label(RichText::new(format!("{what}. {about}.")).color(theme::TEXT_WEAK));
        ui.add_space(14.0);
        let (yes, no) = from_right_row(ui, |ui| {
            // A surface of labels is one of a segment.
            let lacks = export.is_mesh() && export.field == FieldKind::Labels && export.label.is_none();
            let yes = ui.add_enabled(!lacks, primary("Choose where…")).on_hover_text("Name and folder come next");
            (yes.clicked(), cancel(ui))
        });
        if yes {
            self.export_wish = export;
            self.ask(PathPurpose::Export(export));
            return None;
        }
        (!no).then_some(Dialog::Export(export))
    }

    /// Which segment's surface is meant: the one that is painted unless another is chosen.
    fn surface_of(&self, ui: &mut Ui, export: &mut Export) {
        let Some(scene) = &self.scene else { return };
        let segments = scene.segments();
        let painted = match scene.brush.target {
            Target::Label(id) => segments.get(id).map(|segment| segment.id),
            _ => None,
        };
        let known = export.label.filter(|id| segments.get(*id).is_some());
        export.label = known.or(painted).or(segments.0.first().map(|segment| segment.id));
        let named =
            |id: u16| segments.get(id).map_or_else(|| "no segment yet".to_owned(), |s| format!("{id}  {}", s.name));
        row(ui, "Segment", |ui| {
            let text = named(export.label.unwrap_or_default());
            let width = ui.available_width();
            let shown = ComboBox::from_id_salt("segment to export").width(width).truncate().selected_text(text);
            let shown = shown.show_ui(ui, |ui| {
                for segment in &segments.0 {
                    let text = named(segment.id);
                    ui.selectable_value(&mut export.label, Some(segment.id), text).on_hover_text("Export its surface");
                }
            });
            tipped(shown.response.accessible_name("Segment to export"), "The segment whose surface is written");
        });
    }
}
