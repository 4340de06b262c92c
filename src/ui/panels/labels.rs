//! Labels: what the tool for them will write, the list of those that are there, and how all of them look.

use crate::document::{Command, LabelChange, LabelCommand, LabelId, Named};
use crate::interact::{Tool, Written, readout};
use crate::ui::panels::written::{draft_field, eye_of};
use crate::ui::style::colour::colour_button;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, ROW};
use crate::ui::style::widgets::{button, empty, list, number, row, tick};
use crate::ui::window::app::App;
use egui::{DragValue, Rect, Ui, vec2};

/// Rows of the list that are in sight.
const ROWS: usize = 5;
/// Between two of them.
const BETWEEN: f32 = 2.0;

impl App {
    /// Whether there is something to list.
    pub(super) fn lists_labels(&self) -> bool {
        self.scene.as_ref().is_some_and(|scene| !scene.labels.all.is_empty())
    }

    pub(super) fn label_panel(&mut self, ui: &mut Ui) {
        if self.interaction.tool() == Tool::Label {
            let about = ("Text of a new label", "What the next one says");
            row(ui, "Text", |ui| draft_field(ui, about, &mut self.writing.label));
        }
        self.label_list(ui);
        let tip = "A label for every visible segment that has voxels and no label yet, at the place deepest inside it";
        if button(ui, vec2(ui.available_width(), ROW), "Label all segments", tip) {
            self.send(Command::Label(LabelCommand::FromSegments { volume: None, segments: None }));
        }
        self.label_style(ui);
    }

    fn label_list(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let labels: Vec<_> = scene.labels.all.iter().map(|(id, one)| (*id, one.clone())).collect();
        if labels.is_empty() {
            empty(ui, "None yet. Click at a place in the 3D view.");
            return;
        }
        let rows = labels.len().min(ROWS) as f32;
        let height = rows * ROW + (rows - 1.0) * BETWEEN;
        self.backdrop.detail(ui, Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), height)), theme::DEEP);
        list(ui, "labels", height, ROW, labels.len(), true, |ui, range| {
            for (id, one) in &labels[range] {
                let what = match one.at {
                    Named::Point { .. } => "a place",
                    Named::Segment { .. } => "a segment",
                    Named::Part(_) => "a part",
                    Named::Annotation(_) => "an annotation",
                };
                self.label_row(ui, *id, (&one.text, one.visible), what);
            }
        });
        ui.add_space(GAP);
    }

    fn label_row(&mut self, ui: &mut Ui, id: LabelId, (text, visible): (&str, bool), what: &str) {
        let set = |change: LabelChange| Command::Label(LabelCommand::Set(LabelChange { id: Some(id), ..change }));
        ui.push_id(("label", id.0), |ui| {
            ui.horizontal(|ui| {
                self.picked_ground(ui, Written::Label(id));
                if eye_of(ui, visible, &format!("Show label {text}")) {
                    self.send(set(LabelChange { visible: Some(!visible), ..LabelChange::default() }));
                }
                let tip = format!("Names {what}. Click to pick it, double-click to write another text");
                let about = (&*format!("Text of label {}", id.0), &*tip);
                if let Some(text) = self.name_and_trash(ui, about, (text, Written::Label(id))) {
                    self.send(set(LabelChange { text: Some(text), ..LabelChange::default() }));
                }
            });
        });
    }

    fn label_style(&mut self, ui: &mut Ui) {
        let Some(style) = self.scene.as_ref().map(|scene| scene.labels.style) else { return };
        let change = |visible, numbers, size_px, colour, own_colour| {
            Command::Label(LabelCommand::Style { visible, numbers, size_px, colour, own_colour })
        };
        row(ui, "Show", |ui| {
            let (mut visible, mut numbers) = (style.visible, style.numbers);
            if tick(ui, &mut visible, "Labels", "Whether pictures show labels at all") {
                self.send(change(Some(visible), None, None, None, false));
            }
            if tick(ui, &mut numbers, "Numbers", "Numbers in the picture, and what they mean beside it") {
                self.send(change(None, Some(numbers), None, None, false));
            }
        });
        row(ui, "Letters", |ui| {
            let mut size = style.size_px;
            let field = DragValue::new(&mut size).range(6.0..=96.0).speed(0.1).suffix(" px");
            let about = ("Size of labels", "Height of their letters. Drag, or click to type");
            let response = number(ui, 72.0, about, " px", field, |x, chars| readout::fixed(x, 0, chars));
            if response.changed() {
                self.edit(&response, change(None, None, Some(size.clamp(6.0, 96.0)), None, false));
            }
            let background = self.scene.as_ref().map_or([0.0; 3], |scene| scene.look.background);
            let [mut colour, _] = style.inks(background);
            let mut own = style.colour.is_some();
            let tip = "A colour for all labels; else what stands out from the background";
            if tick(ui, &mut own, "Colour", tip) {
                self.send(change(None, None, None, own.then_some(colour), !own));
            }
            if own {
                let response = colour_button(ui, "Colour of labels", &mut colour);
                if response.changed() {
                    self.edit(&response, change(None, None, None, Some(colour), false));
                }
            }
        });
    }
}
