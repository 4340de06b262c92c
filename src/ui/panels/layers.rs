//! How fields lie over each other: density with its grey window first, what is painted over it.

use crate::document::{Command, Layer, ViewCommand, Window};
use crate::ui::app::App;
use crate::ui::icons::Icon;
use crate::ui::theme::{self, LABEL, ROW};
use crate::ui::widgets::{Face, Scale, icon_button, slider};
use crate::volume::FieldKind;
use egui::{Align2, DragValue, Sense, Ui, vec2};

const fn title(field: FieldKind) -> &'static str {
    match field {
        FieldKind::Density => "Density",
        FieldKind::Colour => "Colour",
        FieldKind::Selection => "Selection",
        FieldKind::Labels => "Segments",
    }
}

impl App {
    pub(super) fn layer_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let (layers, window) = (FieldKind::ALL.map(|field| scene.layer(field)), scene.window);
        for layer in layers {
            self.layer_row(ui, layer, window);
        }
    }

    fn layer_row(&mut self, ui: &mut Ui, layer: Layer, window: Window) {
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
                self.send(Command::View(ViewCommand::Layer(Layer { visible: !layer.visible, ..layer })));
            }
            let (rect, _) = ui.allocate_exact_size(vec2(LABEL - 26.0, ROW), Sense::hover());
            let font = egui::TextStyle::Body.resolve(ui.style());
            ui.painter().text(rect.left_center(), Align2::LEFT_CENTER, name, font, theme::TEXT_WEAK);
            if layer.field == FieldKind::Density {
                self.window_fields(ui, window);
                return;
            }
            let mut opacity = f64::from(layer.opacity);
            let response = slider(ui, &format!("Opacity of layer {name}"), &mut opacity, 0.0..=1.0, Scale::PERCENT);
            if response.changed() {
                self.edit(&response, Command::View(ViewCommand::Layer(Layer { opacity: opacity as f32, ..layer })));
            }
        });
    }

    fn window_fields(&mut self, ui: &mut Ui, window: Window) {
        let speed = (window.width / 200.0).max(f64::MIN_POSITIVE);
        let each = (ui.available_width() - theme::GAP) * 0.5;
        let (mut level, mut width) = (window.level, window.width);
        for (name, letter, value) in [("Window level", "L", &mut level), ("Window width", "W", &mut width)] {
            let field = DragValue::new(value).speed(speed).max_decimals(2).prefix(format!("{letter} "));
            let response = ui.add_sized(vec2(each, ROW - 2.0), field).accessible_name(name);
            let response = response.on_hover_text(format!("{name} of the slices: right drag on a slice"));
            if response.changed() {
                let (level, width) = if letter == "L" { (*value, window.width) } else { (window.level, *value) };
                let width = width.max(f64::MIN_POSITIVE);
                self.edit(&response, Command::View(ViewCommand::Window { level, width }));
            }
        }
    }
}
