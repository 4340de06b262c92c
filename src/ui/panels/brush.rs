//! The brush: what it paints, its footprint, and where it may.

use crate::document::Scene;
use crate::interact::readout;
use crate::interact::readout::LengthUnit;
use crate::interact::{Tool, brush_change};
use crate::paint::{Brush, EraseDensity, Falloff, FalloffCurve, Operation, Shape, Target, Tip};
use crate::ui::panels::brush_limits::limits_menu;
use crate::ui::panels::falloff::falloff_curve;
use crate::ui::style::colour::colour_button;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{Scale, choice, line, number, pick, row, slider, tick, tipped};
use crate::ui::thread::session::OpenDocument;
use crate::ui::window::app::App;
use crate::volume::Number;
use egui::{ComboBox, DragValue, Label, Response, RichText, Ui, vec2};

const TARGETS: [(&str, &str, &str); 4] = [
    ("selection", "Selection", "What is of interest: it stays when the rest moves away"),
    ("label", "Label", "Which segment a voxel belongs to (keys 1 … 9)"),
    ("colour", "Colour", "A colour over the volume"),
    ("density", "Density", "The volume's own values"),
];

const OPERATIONS: [(Operation, &str, &str); 13] = [
    (Operation::Replace, "Replace", "What was there gives way to what is painted"),
    (Operation::Add, "Add", "What is painted is added to what was there"),
    (Operation::Subtract, "Subtract", "What is painted is taken from what was there"),
    (Operation::Blend, "Blend", "A mixture of what was there and what is painted"),
    (Operation::Restore, "Restore the original", "What the file says comes back"),
    (Operation::Smooth, "Smooth", "Each value becomes more like the mean about it"),
    (
        Operation::Median,
        "Smooth, edges kept",
        "Each value becomes more like the median about it: specks go, edges stay",
    ),
    (Operation::Sharpen, "Sharpen", "Each value becomes less like the mean about it"),
    (Operation::Raise, "Raise the surface", "Adds matter: the surface moves outward"),
    (Operation::Lower, "Lower the surface", "Removes matter: the surface moves inward"),
    (Operation::Push, "Push in", "The surface is pushed in with all that is on it"),
    (Operation::Pull, "Pull out", "The surface is pulled out with all that is on it"),
    (Operation::Fill, "Fill in", "What is painted over is filled in smoothly from its rim"),
];

/// Of those, what works on colours too.
const PLAIN: usize = 5;

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
    pub(crate) fn paint_with(&mut self, target: Target) {
        let Some(scene) = &self.scene else { return };
        let new = Brush { target, ..*scene.brush };
        let change = brush_change(&scene.brush, &new);
        self.last_paint.insert(kind(target), target);
        if let Some(command) = change {
            self.send(command);
        }
        self.act(crate::interact::Action::Choose(Tool::Brush));
    }

    pub(super) fn brush_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let old = *scene.brush;
        let mut new = old;
        let middle = scene.window().level;
        let voxel = self.opened().map_or(1.0, |o| o.grid.voxel_mm());
        let ends = self.opened().map_or([0.0, 1.0], OpenDocument::ends);
        self.last_paint.insert(kind(old.target), old.target);
        if let Some(volume) = scene.active().filter(|volume| !volume.visible || volume.opacity <= 0.0) {
            let text = format!("{} is hidden: paint on it is not seen", volume.name);
            let width = ui.available_width();
            line(ui, &text, width, theme::WARNING);
        }

        let chosen = ui.horizontal(|ui| pick(ui, "Paint", Some(kind(old.target)), &TARGETS)).inner;
        if let Some(name) = chosen.filter(|&name| name != kind(old.target)) {
            new.target = self.last_paint.get(name).copied().unwrap_or(match name {
                "label" => Target::Label(1),
                "colour" => Target::Colour([0.90, 0.35, 0.25, 1.0]),
                "density" => Target::Density(middle),
                _ => Target::Selection(1.0),
            });
        }
        if let Some(scene) = &self.scene {
            target_row(ui, scene, readout::span(ends), &mut new);
        }
        // A click that isolates has no radius; nothing moves when the tool is another.
        if self.interaction.tool() == Tool::Isolate {
            self.pieces_row(ui);
        } else {
            radius_row(ui, voxel, &mut new);
        }
        row(ui, "Strength", |ui| {
            let mut strength = f64::from(new.strength);
            let tip = "How much one stroke changes: 100 % all the way";
            if slider(ui, ("Brush strength", tip), &mut strength, 0.0..=1.0, Scale::PERCENT).changed() {
                new.strength = strength as f32;
            }
        });
        row(ui, "Shape", |ui| {
            let options = [
                (Shape::Sphere, "Ball", "A ball, in every view"),
                (Shape::Disc, "Disc", "One voxel thick, on the slice"),
                (Shape::Ellipsoid, "Flat ball", "Flattened along the surface it lies on"),
            ];
            new.shape = choice(ui, "Shape", Some(new.shape), &options).unwrap_or(new.shape);
        });
        row(ui, "Edge", |ui| edge(ui, &mut new));
        if let Falloff::Curve(curve) = new.effective_falloff() {
            row(ui, "Curve", |ui| new.falloff = Falloff::Curve(falloff_curve(ui, curve)));
        }
        row(ui, "Overlap", |ui| {
            let options = [
                (Tip::Wash, "Even", "Going over a place again in the same stroke changes nothing more"),
                (Tip::BuildUp, "Builds up", "Going over a place again adds to it"),
            ];
            new.tip = choice(ui, "Overlap", Some(new.tip), &options).unwrap_or(new.tip);
        });
        row(ui, "Mode", |ui| {
            let width = ui.available_width() - ROW - GAP;
            ui.scope(|ui| {
                ui.set_min_width(width);
                ui.set_max_width(width);
                match new.target {
                    Target::Label(_) => label_mode(ui, &new),
                    _ => operation_box(ui, &mut new),
                }
            });
            if let Some(scene) = &self.scene {
                limits_menu(ui, scene, &mut self.mirror_points, voxel, &mut new);
            }
        });
        around_row(ui, voxel, &mut new);
        erase_row(ui, ends, &mut new);
        row(ui, "In 3D", |ui| {
            let tip = "Strokes in the 3D view keep to the surface that is seen: nothing behind it is painted";
            tick(ui, &mut new.visible_only, "Visible only", tip);
            self.focus_menu(ui, voxel);
        });
        range_row(ui, &mut new, ends);
        if let Some(command) = brush_change(&old, &new) {
            self.last_paint.insert(kind(new.target), new.target);
            self.send(command);
        }
        let other_label = new.target != old.target && matches!(new.target, Target::Label(_));
        if chosen.is_some() || other_label {
            self.act(crate::interact::Action::Choose(Tool::Brush));
        }
    }
}

fn radius_row(ui: &mut Ui, voxel: f64, new: &mut Brush) {
    row(ui, "Radius", |ui| {
        let LengthUnit { name: unit, per_mm: factor, .. } = LengthUnit::of(voxel);
        let decimals = readout::decimals(voxel * factor * 20.0);
        let scale = Scale { logarithmic: true, decimals, unit, factor };
        let range = (voxel * 0.5)..=80.0_f64.max(voxel * 20.0).max(new.radius_mm);
        let tip = "Radius of the brush: also [ and ], or Shift + wheel";
        slider(ui, ("Brush radius", tip), &mut new.radius_mm, range, scale);
    });
}

fn target_row(ui: &mut Ui, scene: &Scene, span: f64, new: &mut Brush) {
    match &mut new.target {
        Target::Selection(value) => {
            let mut interest = f64::from(*value);
            row(ui, "Interest", |ui| {
                let tip = "How much of interest what is painted is: at 50 % it half stays, half goes";
                if slider(ui, ("Interest", tip), &mut interest, 0.0..=1.0, Scale::PERCENT).changed() {
                    *value = interest as f32;
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
                let about = ("Colour opacity", "How much of the volume's own colour is covered");
                if slider(ui, about, &mut alpha, 0.0..=1.0, Scale::PERCENT).changed() {
                    *a = alpha as f32;
                }
            });
        }
        Target::Density(value) => {
            row(ui, "Value", |ui| {
                let about = ("Density to paint", "The value that is painted, in the volume's own unit");
                let width = ui.available_width();
                value_field(ui, width, about, value, span);
            });
        }
    }
}

fn label_box(ui: &mut Ui, scene: &Scene, id: &mut u16) {
    let named = |id: u16| {
        scene.segments().get(id).map_or_else(|| format!("{id}  new segment"), |s| format!("{id}  {}", s.name))
    };
    let (swatch, shown) = ui.allocate_exact_size(vec2(14.0, 14.0), egui::Sense::hover());
    let colour = crate::ui::views::overlay::paint_colour(Target::Label(*id), scene);
    ui.painter().rect_filled(swatch, 2.0, colour);
    shown.widget_info(|| {
        let mut info = egui::WidgetInfo::labeled(egui::Role::Image, true, "Colour of the label to paint");
        info.current_text_value = Some(crate::ui::style::colour::hex(scene.segments().colour_of(*id)));
        info
    });
    shown.on_hover_text("What is painted gets this colour; it is changed in the list of segments");
    let width = ui.available_width();
    let response =
        ComboBox::from_id_salt("label").width(width).truncate().selected_text(named(*id)).show_ui(ui, |ui| {
            for option in scene.segments().0.iter().map(|s| s.id).chain(scene.segments().free()) {
                ui.selectable_value(id, option, named(option)).on_hover_text("Paint this segment");
            }
        });
    tipped(response.response.accessible_name("Label to paint"), "The segment that is painted (keys 1 … 9)");
}

/// Labels replace, whatever the mode; where the brush is too weak for that its row says so.
fn label_mode(ui: &mut Ui, brush: &Brush) {
    let (text, colour) = match crate::interact::reach(brush) == 0.0 && brush.tip == Tip::Wash {
        true => ("needs a strength of 50 %", theme::WARNING),
        false => ("a label replaces", theme::TEXT_WEAK),
    };
    ui.add(Label::new(RichText::new(text).color(colour)).truncate());
}

/// How the brush ends at its rim: for labels there is nothing to choose.
fn edge(ui: &mut Ui, new: &mut Brush) {
    let label = matches!(new.target, Target::Label(_));
    let mut options = [
        (Falloff::Hard, "Hard", "Full strength up to the rim"),
        (Falloff::Linear, "Linear", "Evenly weaker from the middle to the rim"),
        (Falloff::Smooth, "Smooth", "Strong in the middle, fading softly to the rim"),
        (Falloff::Gaussian, "Bell", "A Gaussian bell: narrower than smooth"),
        (Falloff::Curve(FalloffCurve::of(new.falloff)), "Curve", "As you draw it below"),
    ];
    if label {
        let why = "A voxel is of a segment or is not: labels fill the whole radius up to a hard rim";
        options = options.map(|(falloff, name, _)| (falloff, name, why));
    }
    ui.add_enabled_ui(!label, |ui| {
        new.falloff = choice(ui, "Edge", Some(new.effective_falloff()), &options).unwrap_or(new.falloff);
    });
}

/// Whether strokes erase, and what that leaves.
fn erase_row(ui: &mut Ui, ends: [f64; 2], new: &mut Brush) {
    ui.horizontal(|ui| {
        ui.set_min_height(ROW);
        let left = ui.cursor().left();
        tick(ui, &mut new.erase, "Erase", "Strokes take away instead of painting; also while E is held");
        ui.add_space((left + LABEL + GAP - ui.cursor().left()).max(0.0));
        if !matches!(new.target, Target::Density(_)) {
            ui.add(Label::new(RichText::new("leaves nothing").color(theme::TEXT_WEAK)).truncate());
            return;
        }
        const FIELD: f32 = 72.0;
        let removes = matches!(new.erase_density, EraseDensity::To(_));
        let (name, width) = match removes {
            true => ("sets to", ui.available_width() - FIELD - GAP),
            false => ("restores the original", ui.available_width()),
        };
        let held = if removes { new.erase_density } else { EraseDensity::To(ends[0]) };
        let options = [
            (
                EraseDensity::Restore,
                "restores the original",
                "What the file says comes back; elsewhere nothing changes",
            ),
            (held, "sets to a value", "The value beside it takes the place of what is there"),
        ];
        let shown = ComboBox::from_id_salt("erase density").width(width).truncate().selected_text(name);
        let shown = shown.show_ui(ui, |ui| {
            for (erase, name, tip) in options {
                ui.selectable_value(&mut new.erase_density, erase, name).on_hover_text(tip);
            }
        });
        tipped(shown.response.accessible_name("What erasing density leaves"), "What is there after density was erased");
        if let EraseDensity::To(value) = &mut new.erase_density {
            let tip = "What erased density becomes: the value of air, say";
            value_field(ui, FIELD, ("Value after erasing", tip), value, readout::span(ends));
        }
    });
}

/// How far a mode looks around or moves the surface, where it does.
fn around_row(ui: &mut Ui, voxel: f64, new: &mut Brush) {
    let (label, about, length, most) = match new.operation {
        Operation::Smooth | Operation::Median | Operation::Sharpen => {
            let about = ("Size of the neighbourhood", "How far around a place its neighbours count");
            let most = if new.operation == Operation::Median { 5.0 } else { 8.0 };
            ("Size", about, &mut new.reach_mm, most)
        }
        Operation::Raise | Operation::Lower | Operation::Push | Operation::Pull => {
            ("Height", ("Height of the change", "How far the surface moves"), &mut new.height_mm, 12.0)
        }
        _ => return,
    };
    row(ui, label, |ui| {
        let LengthUnit { name: unit, per_mm: factor, .. } = LengthUnit::of(voxel);
        let scale = Scale { logarithmic: true, decimals: readout::decimals(voxel * factor * 20.0), unit, factor };
        let mut value = length.unwrap_or(voxel);
        if slider(ui, about, &mut value, (voxel * 0.1)..=(voxel * most), scale).changed() {
            *length = Some(value);
        }
    });
}

fn operation_box(ui: &mut Ui, new: &mut Brush) {
    let name = OPERATIONS.iter().find(|o| o.0 == new.operation).map_or("", |o| o.1);
    let width = ui.available_width();
    // All of them are in sight at once.
    let shown = ComboBox::from_id_salt("operation").width(width).height(360.0).truncate().selected_text(name);
    let response = shown.show_ui(ui, |ui| {
        let count = if new.target.has_neighbours() { OPERATIONS.len() } else { PLAIN };
        for &(operation, name, tip) in &OPERATIONS[..count] {
            ui.selectable_value(&mut new.operation, operation, name).on_hover_text(tip);
        }
    });
    let tip = "How what is painted meets what was there";
    tipped(response.response.accessible_name("Paint mode"), tip);
}

fn range_row(ui: &mut Ui, new: &mut Brush, ends: [f64; 2]) {
    let span = readout::span(ends);
    let mut on = new.range.is_some();
    if tick(ui, &mut on, "Paint only where the value is", "All other voxels stay as they are") {
        new.range = on.then_some(ends.map(Number::Real));
    }
    ui.add_enabled_ui(on, |ui| {
        row(ui, "from – to", |ui| {
            let old = new.range.map_or(ends, |range| range.map(Number::to_f64));
            let mut range = old;
            let dash = 8.0;
            let width = (ui.available_width() - dash - 2.0 * theme::GAP) * 0.5;
            let tip = "The smallest value that is painted";
            let low = value_field(ui, width, ("Lowest value to paint", tip), &mut range[0], span);
            let (rect, _) = ui.allocate_exact_size(vec2(dash, theme::ROW), egui::Sense::hover());
            ui.painter().hline(rect.x_range(), rect.center().y, egui::Stroke::new(1.0, theme::TEXT_WEAK));
            let tip = "The largest value that is painted";
            let high = value_field(ui, width, ("Highest value to paint", tip), &mut range[1], span);
            if low.changed() || high.changed() {
                // The end that was set is meant; the other one makes way.
                if high.changed() {
                    range[0] = range[0].min(range[1]);
                } else {
                    range[1] = range[1].max(range[0]);
                }
                // An end that nobody touched keeps digits that this row does not show.
                let held = new.range.unwrap_or(old.map(Number::Real));
                let end = |i: usize| if range[i] == old[i] { held[i] } else { Number::Real(range[i]) };
                new.range = Some([end(0), end(1)]);
            }
        });
    });
}

/// A value of a volume whose values span so much.
fn value_field(ui: &mut Ui, width: f32, about: (&str, &str), value: &mut f64, span: f64) -> Response {
    let field = DragValue::new(value).speed((span / 400.0).max(f64::MIN_POSITIVE));
    number(ui, width, about, "", field, move |x, chars| readout::field(x, span, chars))
}
