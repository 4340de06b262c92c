//! The 3D view's mode and shading.

use crate::document::{Command, ViewCommand};
use crate::interact::readout;
use crate::ui::panels::look_menu::whose_line;
use crate::ui::style::colour::colour_button;
use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use crate::ui::style::widgets::{Scale, choice, from_right, row, slider, tick};
use crate::ui::window::app::App;
use crate::volume::{Lighting, Mode};
use egui::{RichText, Ui};

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Dvr,
    Iso,
    Mip,
}

fn look(mode: Option<Mode>, shaded: Option<bool>, lighting: Option<Lighting>, background: Option<[f32; 3]>) -> Command {
    Command::View(ViewCommand::Look { mode, shaded, lighting, step_voxels: None, refine: None, background })
}

fn sampling(step_voxels: Option<f64>, refine: bool) -> Command {
    let (mode, shaded, lighting, background) = (None, None, None, None);
    Command::View(ViewCommand::Look { mode, shaded, lighting, step_voxels, refine: Some(refine), background })
}

impl App {
    pub(super) fn look_panel(&mut self, ui: &mut Ui) {
        let (Some(scene), Some(open)) = (&self.scene, &self.snapshot.open) else { return };
        let now = scene.look_of(scene.volumes.active);
        whose_line(ui, scene, "Look");
        let [min, max] = open.ends();
        let kind = match now.mode {
            Mode::Dvr => Kind::Dvr,
            Mode::Iso(_) => Kind::Iso,
            Mode::Mip => Kind::Mip,
        };
        let first = scene.transfer_of(scene.volumes.active).first_surface(&open.histogram);
        ui.horizontal(|ui| {
            let options = [
                (Kind::Dvr, "Volume", "Every value with the colour and opacity of the transfer function"),
                (Kind::Iso, "Surface", "The surface where the volume has one value"),
                (Kind::Mip, "Maximum", "The largest value along each line of sight"),
            ];
            let mode = choice(ui, "Mode", Some(kind), &options).map(|k| match k {
                Kind::Dvr => Mode::Dvr,
                Kind::Iso => Mode::Iso(first),
                Kind::Mip => Mode::Mip,
            });
            if mode.is_some() {
                self.send(look(mode, None, None, None));
            }
        });
        ui.add_enabled_ui(kind == Kind::Iso, |ui| {
            row(ui, "Surface at", |ui| {
                let mut value = if let Mode::Iso(value) = now.mode { value } else { first };
                let scale = Scale { decimals: readout::decimals(readout::span([min, max])), ..Scale::PLAIN };
                let about = ("Surface value", "The value on the surface (mode Surface)");
                let response = slider(ui, about, &mut value, min..=max, scale);
                if response.changed() {
                    self.edit(&response, look(Some(Mode::Iso(value)), None, None, None));
                }
            });
        });
        ui.horizontal(|ui| {
            ui.set_min_height(ROW);
            let mut shaded = now.lighting.is_some();
            ui.add_enabled_ui(kind != Kind::Mip, |ui| {
                let tip = "Lit from where you look, so that shapes are seen; mode Maximum needs no light";
                if tick(ui, &mut shaded, "Headlight", tip) {
                    self.send(look(None, Some(shaded), None, None));
                }
            });
            ui.add_enabled_ui(kind == Kind::Dvr, |ui| {
                let mut refine = now.refine;
                let tip = "No rings like the grain of wood on smooth surfaces: each sample stands for all that lies since the one \
                           before it, and takes a little longer (mode Volume)";
                if tick(ui, &mut refine, "Smooth", tip) {
                    self.send(sampling(None, refine));
                }
            });
            from_right(ui, |ui| {
                let mut background = now.background;
                let response = colour_button(ui, "Background of the 3D view", &mut background);
                if response.changed() {
                    self.edit(&response, look(None, None, None, Some(background)));
                }
                ui.label(RichText::new("Background").color(theme::TEXT_WEAK));
            });
        });
        row(ui, "Detail", |ui| {
            let mut detail = 1.0 / now.step_voxels;
            let scale = Scale { logarithmic: true, decimals: 2, unit: " ×", ..Scale::PLAIN };
            let tip = "Samples along each line of sight, per voxel: more gives a smoother picture and takes longer";
            let response = slider(ui, ("Detail of the 3D view", tip), &mut detail, 0.25..=4.0, scale);
            if response.changed() {
                self.edit(&response, sampling(Some(1.0 / detail), now.refine));
            }
        });
    }
}
