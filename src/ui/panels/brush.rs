//! The brush: what it paints, its footprint, and where it may.

use crate::document::Scene;
use crate::interact::{Tool, brush_change};
use crate::paint::{Brush, Falloff, Operation, Shape, Target, Tip};
use crate::ui::app::App;
use crate::ui::colour::colour_button;
use crate::ui::theme;
use crate::ui::widgets::{Scale, choice, row, slider};
use egui::{Checkbox, ComboBox, DragValue, Response, RichText, Ui, vec2};

const TARGETS: [(&str, &str, &str); 4] = [
    ("selection", "Selection", "Degree of interest: what stays when the rest moves away"),
    ("label", "Label", "The segment's number (1 … 9)"),
    ("colour", "Colour", "A colour over the volume"),
    ("density", "Density", "The volume's own values"),
];

const OPERATIONS: [(Operation, &str); 5] = [
    (Operation::Replace, "Replace"),
    (Operation::Add, "Add"),
    (Operation::Subtract, "Subtract"),
    (Operation::Blend, "Blend"),
    (Operation::Restore, "Restore the original"),
];

const fn kind(target: Target) -> &'static str {
    match target {
        Target::Selection(_) => "selection",
        Target::Label(_) => "label",
        Target::Colour(_) => "colour",
        Target::Density(_) => "density",
    }
}

impl App {
    /// Paints with this from now on, and takes the brush in hand.
    pub(in crate::ui) fn paint_with(&mut self, target: Target) {
        let Some(scene) = &self.scene else { return };
        let new = Brush { target, ..scene.brush };
        let change = brush_change(&scene.brush, &new);
        self.last_paint.insert(kind(target), target);
        if let Some(command) = change {
            self.send(command);
        }
        self.act(crate::interact::Action::Choose(Tool::Brush));
    }

    pub(super) fn brush_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let old = scene.brush;
        let mut new = old;
        let middle = scene.window.level;
        let voxel = self.opened().map_or(1.0, |o| o.grid.voxel_mm());
        self.last_paint.insert(kind(old.target), old.target);

        let chosen = row(ui, "Paint", |ui| choice_short(ui, kind(old.target)));
        if let Some(name) = chosen {
            new.target = self.last_paint.get(name).copied().unwrap_or(match name {
                "label" => Target::Label(1),
                "colour" => Target::Colour([0.90, 0.35, 0.25, 1.0]),
                "density" => Target::Density(middle),
                _ => Target::Selection(1.0),
            });
        }
        if let Some(scene) = &self.scene {
            target_row(ui, scene, &mut new);
        }
        row(ui, "Radius", |ui| {
            let scale = Scale { logarithmic: true, decimals: 1, unit: " mm", percent: false };
            let range = (voxel * 0.5)..=80.0_f64.max(voxel * 20.0).max(new.radius_mm);
            slider(ui, "Brush radius", &mut new.radius_mm, range, scale).on_hover_text("[ and ], or Shift + wheel");
        });
        row(ui, "Strength", |ui| {
            let mut strength = f64::from(new.strength);
            if slider(ui, "Brush strength", &mut strength, 0.0..=1.0, Scale::PERCENT).changed() {
                new.strength = strength as f32;
            }
        });
        if matches!(new.target, Target::Label(_)) && crate::interact::reach(&new) == 0.0 && new.tip == Tip::Wash {
            ui.label(RichText::new("Labels take a strength of 50 % or more.").color(theme::WARNING));
        }
        row(ui, "Shape", |ui| {
            let options = [
                (Shape::Sphere, "Ball", "A ball, in every view"),
                (Shape::Disc, "Disc", "One voxel thick, on the slice"),
            ];
            new.shape = choice(ui, "Shape", Some(new.shape), &options).unwrap_or(new.shape);
        });
        row(ui, "Edge", |ui| {
            let options =
                [(Falloff::Hard, "Hard", ""), (Falloff::Linear, "Linear", ""), (Falloff::Smooth, "Smooth", "")];
            new.falloff = choice(ui, "Edge", Some(new.falloff), &options).unwrap_or(new.falloff);
        });
        row(ui, "Dabs", |ui| {
            let options = [
                (Tip::Wash, "Wash", "Passing twice changes nothing more"),
                (Tip::BuildUp, "Build up", "Every pass adds"),
            ];
            new.tip = choice(ui, "Dabs", Some(new.tip), &options).unwrap_or(new.tip);
        });
        if !matches!(new.target, Target::Label(_)) {
            row(ui, "Mode", |ui| operation_box(ui, &mut new));
        }
        row(ui, "Erase", |ui| {
            ui.checkbox(&mut new.erase, "Take away (hold E)").on_hover_text("Also while E is held");
        });
        range_row(ui, &mut new, self.opened().map(|o| (o.statistics.min, o.statistics.max)));
        if let Some(command) = brush_change(&old, &new) {
            self.last_paint.insert(kind(new.target), new.target);
            self.send(command);
        }
    }
}

/// Four targets on two lines would cost height; their short names fit on one.
fn choice_short(ui: &mut Ui, now: &'static str) -> Option<&'static str> {
    let options: Vec<_> =
        TARGETS.iter().map(|&(key, name, tip)| (key, if key == "selection" { "Select" } else { name }, tip)).collect();
    // Four words have to fit beside the label in the narrowest panel.
    ui.style_mut().text_styles.insert(egui::TextStyle::Button, egui::FontId::proportional(12.0));
    choice(ui, "Paint", Some(now), &options)
}

fn target_row(ui: &mut Ui, scene: &Scene, new: &mut Brush) {
    match &mut new.target {
        Target::Selection(value) => {
            let mut degree = f64::from(*value);
            row(ui, "Degree", |ui| {
                if slider(ui, "Degree of interest", &mut degree, 0.0..=1.0, Scale::PERCENT).changed() {
                    *value = degree as f32;
                }
            });
        }
        Target::Label(id) => {
            row(ui, "Label", |ui| label_box(ui, scene, id));
        }
        Target::Colour([r, g, b, a]) => {
            row(ui, "Colour", |ui| {
                let mut rgb = [*r, *g, *b];
                if colour_button(ui, "Paint colour", &mut rgb).changed() {
                    [*r, *g, *b] = rgb;
                }
                let mut alpha = f64::from(*a);
                if slider(ui, "Colour opacity", &mut alpha, 0.0..=1.0, Scale::PERCENT).changed() {
                    *a = alpha as f32;
                }
            });
        }
        Target::Density(value) => {
            row(ui, "Value", |ui| number(ui, "Density to paint", value));
        }
    }
}

fn label_box(ui: &mut Ui, scene: &Scene, id: &mut u16) {
    let named =
        |id: u16| scene.segments.get(id).map_or_else(|| format!("{id}  new segment"), |s| format!("{id}  {}", s.name));
    let swatch = ui.allocate_exact_size(vec2(14.0, 14.0), egui::Sense::hover()).0;
    ui.painter().rect_filled(swatch, 2.0, crate::ui::overlay::paint_colour(Target::Label(*id), scene));
    let width = ui.available_width() - 8.0;
    let response =
        ComboBox::from_id_salt("label").width(width).truncate().selected_text(named(*id)).show_ui(ui, |ui| {
            let next = scene.segments.0.last().map_or(1, |s| s.id.saturating_add(1));
            for option in scene.segments.0.iter().map(|s| s.id).chain([next]) {
                ui.selectable_value(id, option, named(option));
            }
        });
    response.response.accessible_name("Label to paint");
}

fn operation_box(ui: &mut Ui, new: &mut Brush) {
    let name = OPERATIONS.iter().find(|o| o.0 == new.operation).map_or("", |o| o.1);
    let width = ui.available_width() - 8.0;
    let response = ComboBox::from_id_salt("operation").width(width).selected_text(name).show_ui(ui, |ui| {
        for (operation, name) in OPERATIONS {
            ui.selectable_value(&mut new.operation, operation, name);
        }
    });
    response.response.accessible_name("Paint mode");
}

fn range_row(ui: &mut Ui, new: &mut Brush, span: Option<(f64, f64)>) {
    let (min, max) = span.unwrap_or((0.0, 1.0));
    row(ui, "Only values", |ui| {
        let mut on = new.range.is_some();
        if ui.add(Checkbox::without_text(&mut on)).accessible_name("Only values in a range").changed() {
            new.range = on.then_some([min, max]);
        }
        ui.add_enabled_ui(on, |ui| {
            let mut range = new.range.unwrap_or([min, max]);
            let width = (ui.available_width() - 22.0) * 0.5;
            let speed = ((max - min) / 400.0).max(f64::MIN_POSITIVE);
            let field = |ui: &mut Ui, value: &mut f64, name: &str| -> Response {
                ui.add_sized(vec2(width, theme::ROW - 2.0), DragValue::new(value).speed(speed).max_decimals(3))
                    .accessible_name(name)
            };
            let low = field(ui, &mut range[0], "Lowest value to paint");
            ui.label("–");
            let high = field(ui, &mut range[1], "Highest value to paint");
            if low.changed() || high.changed() {
                range[1] = range[1].max(range[0]);
                new.range = Some(range);
            }
        });
    });
}

fn number(ui: &mut Ui, name: &str, value: &mut f64) {
    let width = ui.available_width();
    ui.add_sized(vec2(width, theme::ROW - 2.0), DragValue::new(value).speed(0.5).max_decimals(4)).accessible_name(name);
}
