//! How fields lie over each other: density with its grey window first, what is painted over it.

use crate::document::{Command, Layer, LayerChange, ViewCommand, Window};
use crate::interact::readout;
use crate::ui::state::look_of::LookOf;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{Face, Scale, icon_button, menu, number, slider};
use crate::ui::window::app::App;
use crate::volume::{FieldKind, VolumeId};
use egui::{Align2, DragValue, Sense, Ui, vec2};

const fn title(field: FieldKind) -> &'static str {
    match field {
        FieldKind::Density => "Density",
        FieldKind::Colour => "Colour",
        FieldKind::Selection => "Selection",
        FieldKind::Labels => "Segments",
    }
}

/// From the left of a row to its name: the eye and a gap.
const EYE: f32 = ROW + GAP;

/// Grey windows of CT in Hounsfield units as radiology has them: name, level, width.
const WINDOWS: [(&str, f64, f64); 6] = [
    ("Brain", 40.0, 80.0),
    ("Soft tissue, abdomen", 50.0, 400.0),
    ("Liver", 60.0, 150.0),
    ("Bone", 400.0, 1800.0),
    ("Lung", -600.0, 1500.0),
    ("Vessels with contrast", 300.0, 600.0),
];

impl App {
    pub(super) fn layer_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let (layers, window) = (FieldKind::ALL.map(|field| scene.layer(field)), scene.window());
        // Of several volumes the panels show the active one.
        let volume = (scene.volumes.all.len() > 1).then_some(scene.volumes.active);
        for layer in layers {
            self.layer_row(ui, (layer, volume), window);
        }
    }

    fn layer_row(&mut self, ui: &mut Ui, (layer, volume): (Layer, Option<VolumeId>), window: Window) {
        let name = title(layer.field);
        ui.horizontal(|ui| {
            ui.set_min_height(ROW);
            let (icon, tint) = if layer.visible { (Icon::Eye, theme::TEXT) } else { (Icon::EyeOff, theme::TEXT_WEAK) };
            let show = format!("Show layer {name}");
            let tip = match layer.field {
                FieldKind::Density => "Shown or hidden in slices; in 3D the transfer function decides",
                _ => "Shown or hidden, in slices and in 3D",
            };
            if icon_button(ui, Face::small(icon, &show, tip).tint(tint)).clicked() {
                self.send(Command::View(ViewCommand::Layer(LayerChange {
                    volume,
                    ..Layer { visible: !layer.visible, ..layer }.into()
                })));
            }
            let (rect, _) = ui.allocate_exact_size(vec2(LABEL - EYE, ROW), Sense::hover());
            let font = egui::TextStyle::Body.resolve(ui.style());
            ui.painter().text(rect.left_center(), Align2::LEFT_CENTER, name, font, theme::TEXT_WEAK);
            if layer.field == FieldKind::Density {
                self.window_fields(ui, window);
                return;
            }
            // Other fields show in 3D as they do in slices, until a script says otherwise.
            if layer.field == FieldKind::Labels || layer.opacity_3d.is_some() {
                self.strengths(ui, (layer, volume));
            } else {
                // All sliders end where that of the selection has its menu, and density's fields theirs.
                let end = ui.available_width() - ROW - GAP;
                let mut opacity = f64::from(layer.opacity);
                let about = (&*format!("Opacity of layer {name}"), "How strongly it lies over the grey values");
                let slid =
                    ui.allocate_ui(vec2(end, ROW), |ui| slider(ui, about, &mut opacity, 0.0..=1.0, Scale::PERCENT));
                if slid.inner.changed() {
                    let layer = Layer { opacity: opacity as f32, ..layer };
                    self.edit(&slid.inner, Command::View(ViewCommand::Layer(LayerChange { volume, ..layer.into() })));
                }
            }
            if layer.field == FieldKind::Selection
                && let Some(active) = self.scene.as_ref().map(|scene| scene.volumes.active)
            {
                self.look_menu(ui, LookOf::Selection(active), "the selection");
            }
        });
    }

    /// How strongly a field shows in slices and in 3D, where these are two questions.
    fn strengths(&mut self, ui: &mut Ui, (layer, volume): (Layer, Option<VolumeId>)) {
        let each = (ui.available_width() - ROW - 2.0 * GAP) * 0.5;
        let name = format!("Opacity of layer {}", title(layer.field));
        for (name, unit, now, tip) in [
            (name.clone(), "2D", layer.opacity, "How strongly it lies over the grey values of slices"),
            (
                format!("{name} in 3D"),
                "3D",
                layer.opacity_3d.unwrap_or(layer.opacity),
                "How strongly it colours what 3D shows: at 100 % in its own colours alone",
            ),
        ] {
            let mut percent = f64::from(now) * 100.0;
            let field =
                DragValue::new(&mut percent).range(0.0..=100.0).speed(0.5).prefix(format!("{unit} ")).suffix(" %");
            let about = (&*name, &*format!("{tip}. Drag, or click to type"));
            let response = number(ui, each, about, "2D %", field, |x, chars| readout::fixed(x, 0, chars));
            if response.changed() {
                let strength = (percent / 100.0) as f32;
                let layer = match unit {
                    "3D" => Layer { opacity_3d: Some(strength), ..layer },
                    _ => Layer { opacity: strength, ..layer },
                };
                self.edit(&response, Command::View(ViewCommand::Layer(LayerChange { volume, ..layer.into() })));
            }
        }
    }

    fn window_fields(&mut self, ui: &mut Ui, window: Window) {
        let speed = (window.width / 200.0).max(f64::MIN_POSITIVE);
        let width_of_menu = ROW;
        let each = (ui.available_width() - width_of_menu - 2.0 * theme::GAP) * 0.5;
        let (mut level, mut width) = (window.level, window.width);
        for (name, letter, value, tip) in [
            (
                "Window level",
                "L",
                &mut level,
                "Window level: the value shown as middle grey. Also right drag up on a slice",
            ),
            ("Window width", "W", &mut width, "Window width: from black to white. Also right drag across a slice"),
        ] {
            let now = *value;
            let field = DragValue::new(value).speed(speed).prefix(format!("{letter} "));
            let show = move |x, chars| readout::grey(x, window.width, chars);
            // In powers of ten the field may say less than one wants to know.
            let tip = format!("{tip}. Now {}", readout::short(now));
            let response = number(ui, each, (name, &tip), letter, field, show);
            if response.changed() {
                let (level, width) = if letter == "L" { (*value, window.width) } else { (window.level, *value) };
                let width = width.max(f64::MIN_POSITIVE);
                self.edit(&response, Command::View(ViewCommand::Window { level, width, volume: None }));
            }
        }
        let about = ("Ready windows", "", "Ready windows: from black to white for what you want to see");
        menu(ui, vec2(width_of_menu, ROW), about, |ui| self.windows_menu(ui));
    }

    fn windows_menu(&mut self, ui: &mut Ui) {
        let Some(open) = self.opened() else { return };
        let histogram = open.histogram.clone();
        let [min, max] = open.ends();
        let automatic = Window::from_histogram(&histogram);
        let width = readout::span([min, max]).max(f64::MIN_POSITIVE);
        let whole = Window { level: min * 0.5 + max * 0.5, width };
        let ready = WINDOWS.iter().map(|&(name, level, width)| (name, Window { level, width }));
        let ready = ready.take(if histogram.is_hounsfield() { WINDOWS.len() } else { 0 });
        for (name, window) in [("Automatic", automatic), ("All values", whole)].into_iter().chain(ready) {
            let Window { level, width } = window;
            let tip = format!("Level {}, width {}", readout::short(level), readout::short(width));
            if ui.button(name).on_hover_text(tip).clicked() {
                self.send(Command::View(ViewCommand::Window { level, width, volume: None }));
            }
        }
    }
}
