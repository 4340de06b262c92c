//! The 3D view's mode and shading.

use crate::document::{Command, ViewCommand};
use crate::ui::app::App;
use crate::ui::colour::colour_button;
use crate::ui::widgets::{Scale, choice, row, slider};
use crate::volume::{Lighting, Mode};
use egui::Ui;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Dvr,
    Iso,
    Mip,
}

fn look(
    mode: Option<Mode>,
    shaded: Option<bool>,
    lighting: Option<Lighting>,
    step: Option<f64>,
    background: Option<[f32; 3]>,
) -> Command {
    Command::View(ViewCommand::Look { mode, shaded, lighting, step_voxels: step, background })
}

impl App {
    pub(super) fn look_panel(&mut self, ui: &mut Ui) {
        let (Some(scene), Some(open)) = (&self.scene, &self.snapshot.open) else { return };
        let now = scene.look;
        let (min, max) = (open.statistics.min, open.statistics.max);
        let kind = match now.mode {
            Mode::Dvr => Kind::Dvr,
            Mode::Iso(_) => Kind::Iso,
            Mode::Mip => Kind::Mip,
        };
        // Where opacity begins is a sensible first surface.
        let first = scene.transfer.opacity.iter().rfind(|p| p.1 <= 0.0).map_or((min + max) * 0.5, |p| p.0);
        row(ui, "Mode", |ui| {
            let options = [
                (Kind::Dvr, "Volume", "Colour and opacity along the ray"),
                (Kind::Iso, "Surface", "The surface at one value"),
                (Kind::Mip, "Maximum", "The largest value along the ray"),
            ];
            let mode = choice(ui, "Mode", Some(kind), &options).map(|k| match k {
                Kind::Dvr => Mode::Dvr,
                Kind::Iso => Mode::Iso(first),
                Kind::Mip => Mode::Mip,
            });
            if mode.is_some() {
                self.send(look(mode, None, None, None, None));
            }
        });
        if let Mode::Iso(mut value) = now.mode {
            row(ui, "Value", |ui| {
                let scale = Scale { decimals: if max - min > 50.0 { 0 } else { 3 }, ..Scale::default() };
                let response = slider(ui, "Surface value", &mut value, min..=max, scale);
                if response.changed() {
                    self.edit(&response, look(Some(Mode::Iso(value)), None, None, None, None));
                }
            });
        }
        row(ui, "Shading", |ui| {
            let mut shaded = now.lighting.is_some();
            ui.add_enabled_ui(kind != Kind::Mip, |ui| {
                if ui.checkbox(&mut shaded, "Headlight").changed() {
                    self.send(look(None, Some(shaded), None, None, None));
                }
            });
        });
        row(ui, "Background", |ui| {
            let mut background = now.background;
            let response = colour_button(ui, "Background of the 3D view", &mut background);
            if response.changed() {
                self.edit(&response, look(None, None, None, None, Some(background)));
            }
        });
        row(ui, "Step", |ui| {
            let mut step = now.step_voxels;
            let scale = Scale { decimals: 2, unit: " vx", ..Scale::default() };
            let response = slider(ui, "Step along the ray", &mut step, 0.25..=4.0, scale);
            let response = response.on_hover_text("Voxels between samples: smaller is finer and slower");
            if response.changed() {
                self.edit(&response, look(None, None, None, Some(step), None));
            }
        });
    }
}
