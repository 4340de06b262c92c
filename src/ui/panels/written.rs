//! Annotations and cutaways: what the tools for them will make, the list of those that are there, and the one that is picked.

use crate::document::{
    Annotation, AnnotationChange, AnnotationCommand, AnnotationId, Command, Content, Cutaway, CutawayChange,
    CutawayCommand, CutawayId, Outline, PatternKind,
};
use crate::interact::readout;
use crate::interact::{Tool, Writing, WritingKind, Written};
use crate::ui::panels::look_menu::NARROW;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::style::colour::colour_button;
use crate::ui::style::icons::Icon;
use crate::ui::style::naming::{Named, name_field, text_field};
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{
    Face, Scale, button, empty, from_right, icon_button, line, list, number, row, slider, tick, tipped,
};
use crate::ui::window::app::App;
use egui::{Align2, ComboBox, DragValue, Label, Rect, Response, RichText, TextEdit, Ui, vec2};

/// Rows of the list that are in sight.
const ROWS: usize = 4;
/// Between two of them.
const BETWEEN: f32 = 2.0;

const KINDS: [(WritingKind, &str, &str); 5] = [
    (WritingKind::Text, "Text", "Letters that lie on the surface"),
    (WritingKind::Arrow, "Arrow", "From where the drag begins to where it ends"),
    (WritingKind::Ruler, "Ruler", "The shortest way on the surface between both ends of the drag, with its length"),
    (WritingKind::Pattern, "Pattern", "Hatching on a square of the surface"),
    (WritingKind::Image, "Image", "A PNG picture, with what is transparent in it"),
];

const PATTERNS: [(PatternKind, &str); 5] = [
    (PatternKind::Lines, "Lines"),
    (PatternKind::Cross, "Crossed lines"),
    (PatternKind::Dots, "Dots"),
    (PatternKind::Checker, "Checkers"),
    (PatternKind::Frame, "Frame"),
];

impl App {
    /// Whether there is something to list.
    pub(super) fn lists_annotations(&self) -> bool {
        let scene = self.scene.as_ref();
        scene.is_some_and(|scene| !scene.annotations.all.is_empty() || !scene.cutaways.all.is_empty())
    }

    pub(super) fn annotation_panel(&mut self, ui: &mut Ui) {
        match self.interaction.tool() {
            Tool::Annotate => self.new_annotation(ui),
            Tool::Cutaway => self.new_cutaway(ui),
            _ => {}
        }
        self.annotation_list(ui);
        match self.writing.picked {
            Some(Written::Annotation(id)) => self.annotation_rows(ui, id),
            Some(Written::Cutaway(id)) => self.cutaway_rows(ui, id),
            _ => {}
        }
    }

    fn new_annotation(&mut self, ui: &mut Ui) {
        row(ui, "New", |ui| {
            let name = KINDS.iter().find(|kind| kind.0 == self.writing.kind).map_or("", |kind| kind.1);
            let width = ui.available_width();
            let shown = ComboBox::from_id_salt("kind of annotation").width(width).truncate().selected_text(name);
            let shown = shown.show_ui(ui, |ui| {
                for (kind, name, tip) in KINDS {
                    ui.selectable_value(&mut self.writing.kind, kind, name).on_hover_text(tip);
                }
            });
            tipped(shown.response.accessible_name("Kind of a new annotation"), "What a drag in the 3D view makes");
        });
        match self.writing.kind {
            WritingKind::Text => {
                let about = ("Text of a new annotation", "What the next one says");
                row(ui, "Text", |ui| draft_field(ui, about, &mut self.writing.text));
            }
            WritingKind::Pattern => row(ui, "Pattern", |ui| pattern_box(ui, &mut self.writing.pattern)),
            WritingKind::Image => row(ui, "File", |ui| self.image_button(ui)),
            // Their ends are drawn.
            WritingKind::Arrow | WritingKind::Ruler => {}
        }
        if self.writing.kind != WritingKind::Arrow {
            row(ui, size_label(self.writing.kind.has_letters()), |ui| {
                let mut size = self.writing.size_mm();
                if length(ui, ("Size of a new annotation", size_tip(self.writing.kind.has_letters())), &mut size)
                    .changed()
                {
                    self.writing.sizes_mm.insert(self.writing.kind, size);
                }
            });
        }
        if self.writing.kind != WritingKind::Image {
            row(ui, "Colour", |ui| {
                let Writing { colour, halo, .. } = &mut self.writing;
                colour_button(ui, "Colour of a new annotation", colour);
                ui.add_space(GAP);
                if let Some(changed) = halo_fields(ui, "a new annotation", *halo).map(|(_, halo)| halo) {
                    *halo = changed;
                }
            });
        }
    }

    fn image_button(&mut self, ui: &mut Ui) {
        let name = self.writing.image.as_deref().and_then(|path| path.rsplit(['/', '\\']).next().map(str::to_owned));
        let text = name.unwrap_or_else(|| "Choose a picture…".into());
        let size = vec2(ui.available_width(), ROW);
        if button(ui, size, &text, "The PNG file that the next annotation shows") {
            self.ask(PathPurpose::Decal);
        }
    }

    fn new_cutaway(&mut self, ui: &mut Ui) {
        let extent = self.writing.extent_mm;
        empty(ui, "A new cutaway");
        row(ui, "Depth", |ui| {
            let mut depth = self.writing.depth_mm();
            let about = ("Depth of a new cutaway", "How far the floor of the next one lies behind the surface");
            if slider(ui, about, &mut depth, depth_range(extent), millimetres(extent)).changed() {
                self.writing.depth_mm = Some(depth);
            }
        });
        row(ui, "Rim", |ui| {
            let mut rim = self.writing.rim_mm();
            let about = ("Rim of a new cutaway", "How wide the visible edge of the next one is; 0: none");
            if slider(ui, about, &mut rim, rim_range(extent), narrow_millimetres(extent)).changed() {
                self.writing.rim_mm = Some(rim);
            }
        });
        let tip = "Selected matter stands in the next cutaway as it was";
        tick(ui, &mut self.writing.spare_selection, "Spare selected matter", tip);
    }

    fn annotation_list(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let annotations: Vec<_> = scene.annotations.all.iter().map(|(id, one)| (*id, one.clone())).collect();
        let cutaways: Vec<_> = scene.cutaways.all.iter().map(|(id, one)| (*id, one.clone())).collect();
        let count = annotations.len() + cutaways.len();
        if count == 0 {
            empty(ui, "None yet. Drag in the 3D view to make one.");
            return;
        }
        ui.add_space(GAP);
        let rows = count.min(ROWS) as f32;
        let height = rows * ROW + (rows - 1.0) * BETWEEN;
        self.backdrop.detail(ui, Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), height)), theme::DEEP);
        list(ui, "annotations", height, ROW, count, true, |ui, range| {
            for at in range {
                match (annotations.get(at), cutaways.get(at.saturating_sub(annotations.len()))) {
                    (Some((id, one)), _) => self.annotation_row(ui, *id, one),
                    (None, Some((id, one))) => self.cutaway_row(ui, *id, one),
                    (None, None) => {}
                }
            }
        });
        ui.add_space(GAP);
    }

    fn annotation_row(&mut self, ui: &mut Ui, id: AnnotationId, one: &Annotation) {
        let set = |change: AnnotationChange| {
            Command::Annotation(AnnotationCommand::Set(AnnotationChange { id: Some(id), ..change }))
        };
        ui.push_id(("annotation", id.0), |ui| {
            ui.horizontal(|ui| {
                self.picked_ground(ui, Written::Annotation(id));
                let show = format!("Show annotation {}", one.name);
                if eye(ui, one.visible, &show, "Show or hide this annotation") {
                    self.send(set(AnnotationChange { visible: Some(!one.visible), ..AnnotationChange::default() }));
                }
                let mut colour = one.colour;
                let response = colour_button(ui, &format!("Colour of annotation {}", one.name), &mut colour);
                if response.changed() {
                    let change = AnnotationChange { colour: Some(colour), ..AnnotationChange::default() };
                    self.edit_slowly(&response, set(change));
                }
                let about = (&*format!("Name of annotation {}", id.0), "Click to pick it, double-click to rename it");
                if let Some(name) = self.name_and_trash(ui, about, (&one.name, Written::Annotation(id))) {
                    self.send(set(AnnotationChange { name: Some(name), ..AnnotationChange::default() }));
                }
            });
        });
    }

    fn cutaway_row(&mut self, ui: &mut Ui, id: CutawayId, one: &Cutaway) {
        let set =
            |change: CutawayChange| Command::Cutaway(CutawayCommand::Set(CutawayChange { id: Some(id), ..change }));
        ui.push_id(("cutaway", id.0), |ui| {
            ui.horizontal(|ui| {
                self.picked_ground(ui, Written::Cutaway(id));
                let show = format!("Open {}", one.name);
                if eye(ui, one.open, &show, "Open or close this cutaway") {
                    self.send(set(CutawayChange { open: Some(!one.open), ..CutawayChange::default() }));
                }
                let mut colour = one.rim.colour;
                let response = colour_button(ui, &format!("Rim colour of {}", one.name), &mut colour);
                if response.changed() {
                    let change = CutawayChange { rim_colour: Some(colour), ..CutawayChange::default() };
                    self.edit_slowly(&response, set(change));
                }
                let about = (&*format!("Name of cutaway {}", id.0), "Click to pick it, double-click to rename it");
                if let Some(name) = self.name_and_trash(ui, about, (&one.name, Written::Cutaway(id))) {
                    self.send(set(CutawayChange { name: Some(name), ..CutawayChange::default() }));
                }
            });
        });
    }

    /// Behind the row of what is picked.
    pub(super) fn picked_ground(&self, ui: &Ui, one: Written) {
        if self.writing.picked == Some(one) {
            let full = Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), ROW));
            ui.painter().rect_filled(full, theme::ROUND, theme::ACCENT_FILL);
        }
    }

    /// The rest of a row: its name, which picks it, and what takes it away. Answers a new name.
    pub(super) fn name_and_trash(
        &mut self,
        ui: &mut Ui,
        about: (&str, &str),
        (name, one): (&str, Written),
    ) -> Option<String> {
        let width = ui.available_width() - NARROW - GAP;
        let named = name_field(ui, about, name, width);
        let remove = format!("Remove {name}");
        let face = Face { size: NARROW, ..Face::small(Icon::Trash, &remove, "Take it away; undo brings it back") };
        if from_right(ui, |ui| icon_button(ui, face).clicked()) {
            self.send(one.remove());
        }
        match named {
            Some(Named::Chosen) => {
                self.writing.picked = if self.writing.picked == Some(one) { None } else { Some(one) };
                None
            }
            Some(Named::Anew(name)) => Some(name),
            None => None,
        }
    }

    /// The annotation that is picked, in numbers.
    fn annotation_rows(&mut self, ui: &mut Ui, id: AnnotationId) {
        let Some(one) = self.scene.as_ref().and_then(|scene| scene.annotations.all.get(&id)).cloned() else { return };
        let set = |change: AnnotationChange| {
            Command::Annotation(AnnotationCommand::Set(AnnotationChange { id: Some(id), ..change }))
        };
        caption(ui, &one.name);
        let letters = matches!(one.content, Content::Text { .. } | Content::Ruler { .. });
        if let Content::Text { text, .. } = &one.content {
            row(ui, "Text", |ui| {
                let width = ui.available_width();
                let about = ("Text of the annotation", "What it says; Enter or leave the field to lay it anew");
                if let Some(text) = text_field(ui, about, text, width) {
                    self.send(set(AnnotationChange { text: Some(text), ..AnnotationChange::default() }));
                }
            });
        }
        row(ui, size_label(letters), |ui| {
            let mut size = one.size_mm;
            let response = length(ui, ("Size of the annotation", size_tip(letters)), &mut size);
            if response.changed() {
                let change = AnnotationChange { size_mm: Some(size), ..AnnotationChange::default() };
                self.edit_slowly(&response, set(change));
            }
        });
        row(ui, "Opacity", |ui| {
            let mut opacity = f64::from(one.opacity);
            let about = ("Opacity of the annotation", "How much of the surface it covers");
            let response = slider(ui, about, &mut opacity, 0.0..=1.0, Scale::PERCENT);
            if response.changed() {
                let change = AnnotationChange { opacity: Some(opacity as f32), ..AnnotationChange::default() };
                self.edit_slowly(&response, set(change));
            }
        });
        ui.horizontal(|ui| {
            ui.set_min_height(ROW);
            ui.add_space(LABEL + GAP);
            if let Some((response, halo)) = halo_fields(ui, "the annotation", one.halo) {
                let change = AnnotationChange { halo, no_halo: halo.is_none(), ..AnnotationChange::default() };
                self.edit_slowly(&response, set(change));
            }
            let mut lit = one.lit;
            if tick(ui, &mut lit, "Lit", "Lit as the surface is that it lies on; else as bright everywhere") {
                self.send(set(AnnotationChange { lit: Some(lit), ..AnnotationChange::default() }));
            }
        });
        self.remark_rows(ui, Written::Annotation(id));
    }

    /// The cutaway that is picked, in numbers.
    fn cutaway_rows(&mut self, ui: &mut Ui, id: CutawayId) {
        let Some(one) = self.scene.as_ref().and_then(|scene| scene.cutaways.all.get(&id)).cloned() else { return };
        let extent = self.writing.extent_mm;
        let set =
            |change: CutawayChange| Command::Cutaway(CutawayCommand::Set(CutawayChange { id: Some(id), ..change }));
        caption(ui, &one.name);
        row(ui, "Depth", |ui| {
            let mut depth = one.depth_mm;
            let about = ("Depth of the cutaway", "How far its floor lies behind the surface");
            let response = slider(ui, about, &mut depth, depth_range(extent), millimetres(extent));
            if response.changed() {
                let change = CutawayChange { depth_mm: Some(depth), ..CutawayChange::default() };
                self.edit_slowly(&response, set(change));
            }
        });
        // That of a lasso is drawn and has no two lengths.
        if let Outline::Grid { width_mm, height_mm } = one.outline {
            for (label, name, now) in
                [("Width", "Width of the cutaway", width_mm), ("Height", "Height of the cutaway", height_mm)]
            {
                row(ui, label, |ui| {
                    let mut value = now;
                    let about = (name, "Measured on the surface");
                    let response = slider(ui, about, &mut value, depth_range(extent), millimetres(extent));
                    if response.changed() {
                        let (width_mm, height_mm) =
                            if label == "Width" { (Some(value), None) } else { (None, Some(value)) };
                        let change = CutawayChange { width_mm, height_mm, ..CutawayChange::default() };
                        self.edit_slowly(&response, set(change));
                    }
                });
            }
        }
        row(ui, "Rim", |ui| {
            let mut rim = one.rim.width_mm;
            let about = ("Rim of the cutaway", "How wide its visible edge is; 0: none");
            let response = slider(ui, about, &mut rim, rim_range(extent), narrow_millimetres(extent));
            if response.changed() {
                let change = CutawayChange { rim_mm: Some(rim), ..CutawayChange::default() };
                self.edit_slowly(&response, set(change));
            }
        });
        let mut spare = one.spares.selection;
        if tick(ui, &mut spare, "Spare selected matter", "Selected matter stands in it as it was") {
            self.send(set(CutawayChange { spare_selection: Some(spare), ..CutawayChange::default() }));
        }
        let mut shaded = one.shaded;
        if tick(ui, &mut shaded, "Darker with depth", "Its walls and its floor are the darker the deeper they lie") {
            self.send(set(CutawayChange { shaded: Some(shaded), ..CutawayChange::default() }));
        }
        self.remark_rows(ui, Written::Cutaway(id));
    }

    /// What was said of how one lies, and a size at which it would lie better.
    fn remark_rows(&mut self, ui: &mut Ui, one: Written) {
        let Some(remark) = self.scene.as_ref().and_then(|scene| self.remarks.of(one, scene)).cloned() else { return };
        for said in &remark.said {
            let text = RichText::new(readout::sentence(&format!("{said}."))).color(theme::WARNING);
            ui.add(Label::new(text).wrap());
        }
        if let (Some(mm), Written::Annotation(id)) = (remark.fitting_mm, one) {
            let text = format!("Make it {} mm", rounded_down(mm));
            let tip = "The largest size at which the surface bends it little";
            if button(ui, vec2(ui.available_width(), ROW), &text, tip) {
                let size_mm = Some(rounded_down(mm));
                let change = AnnotationChange { id: Some(id), size_mm, ..AnnotationChange::default() };
                self.send(Command::Annotation(AnnotationCommand::Set(change)));
            }
        }
    }
}

/// Whose rows follow.
fn caption(ui: &mut Ui, name: &str) {
    let width = ui.available_width();
    line(ui, &format!("Picked: {name}"), width, theme::TEXT_WEAK);
}

/// Three digits, never more than it is.
fn rounded_down(mm: f64) -> f64 {
    let digits = 10.0_f64.powf(2.0 - mm.abs().max(1e-12).log10().floor());
    (mm * digits).floor() / digits
}

fn size_label(letters: bool) -> &'static str {
    if letters { "Letters" } else { "Width" }
}

fn size_tip(letters: bool) -> &'static str {
    if letters { "Height of its letters on the surface" } else { "Its width on the surface" }
}

fn depth_range(extent: f64) -> std::ops::RangeInclusive<f64> {
    extent * 0.002..=extent * 0.6
}

fn rim_range(extent: f64) -> std::ops::RangeInclusive<f64> {
    0.0..=extent * 0.03
}

fn millimetres(extent: f64) -> Scale {
    Scale { logarithmic: true, decimals: readout::decimals(extent), unit: " mm", factor: 1.0 }
}

fn narrow_millimetres(extent: f64) -> Scale {
    Scale { logarithmic: false, decimals: readout::decimals(extent * 0.03), unit: " mm", factor: 1.0 }
}

/// A length that is dragged or typed.
fn length(ui: &mut Ui, about: (&str, &str), mm: &mut f64) -> Response {
    let speed = mm.abs().max(1e-6) * 0.01;
    let width = ui.available_width();
    let field = DragValue::new(mm).range(1e-6..=1e6).speed(speed).suffix(" mm");
    number(ui, width, about, " mm", field, |x, chars| readout::fixed(x, readout::decimals(x * 2.0), chars))
}

/// Whether letters have a halo, and its colour; what it was changed to.
fn halo_fields(ui: &mut Ui, whose: &str, halo: Option<[f32; 3]>) -> Option<(Response, Option<[f32; 3]>)> {
    let mut on = halo.is_some();
    let ticked =
        tipped(ui.checkbox(&mut on, "Halo"), "A line about letters and shapes, so that they are read on anything");
    if ticked.changed() {
        return Some((ticked, on.then_some(Annotation::PAPER)));
    }
    let mut colour = halo?;
    let response = colour_button(ui, &format!("Halo of {whose}"), &mut colour);
    response.changed().then_some((response, Some(colour)))
}

fn pattern_box(ui: &mut Ui, pattern: &mut PatternKind) {
    let name = PATTERNS.iter().find(|p| p.0 == *pattern).map_or("", |p| p.1);
    let width = ui.available_width();
    let shown = ComboBox::from_id_salt("pattern").width(width).truncate().selected_text(name);
    let shown = shown.show_ui(ui, |ui| {
        for (kind, name) in PATTERNS {
            ui.selectable_value(pattern, kind, name);
        }
    });
    tipped(shown.response.accessible_name("Pattern of a new annotation"), "What fills the square");
}

/// A text that the window keeps for what comes next.
pub(super) fn draft_field(ui: &mut Ui, about: (&str, &str), text: &mut String) {
    let width = ui.available_width();
    let edit = TextEdit::singleline(text).desired_width(width - 8.0).align(Align2::LEFT_CENTER);
    tipped(ui.add_sized(vec2(width, ROW), edit).accessible_name(about.0), about.1);
}

fn eye(ui: &mut Ui, on: bool, name: &str, tip: &str) -> bool {
    let (icon, tint) = if on { (Icon::Eye, theme::TEXT) } else { (Icon::EyeOff, theme::TEXT_WEAK) };
    icon_button(ui, Face { size: NARROW, ..Face::small(icon, name, tip) }.tint(tint)).clicked()
}

/// The same for the list of labels.
pub(super) fn eye_of(ui: &mut Ui, on: bool, name: &str) -> bool {
    eye(ui, on, name, "Show or hide this label")
}
