//! The degree of explosion and the forces behind it.

use crate::document::{Command, ExplosionCommand, PartCommand};
use crate::explode::Forces;
use crate::ui::app::App;
use crate::ui::widgets::{Scale, empty, row, slider, subsection};
use egui::{Ui, vec2};

impl App {
    pub(super) fn explosion_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let explosion = &scene.explosion;
        let (mut degree, forces, count) = (explosion.degree, explosion.forces, explosion.parts.len());
        let can = count > 1;
        ui.add_enabled_ui(can, |ui| {
            row(ui, "Degree", |ui| {
                let response = slider(ui, "Degree of explosion", &mut degree, 0.0..=1.0, Scale::PERCENT);
                if response.changed() {
                    self.edit(&response, Command::Explosion(ExplosionCommand::Degree { value: degree }));
                }
            });
            ui.horizontal(|ui| {
                let each = (ui.available_width() - 4.0) * 0.5;
                let settle = egui::Button::new("Settle").min_size(vec2(each, 22.0));
                let tip = "Measure what hides the selection, and move the parts until it is seen";
                if ui.add(settle).on_hover_text(tip).clicked() {
                    self.send(Command::Explosion(ExplosionCommand::Settle {}));
                }
                let join = egui::Button::new("Join all parts").min_size(vec2(each, 22.0));
                if ui.add(join).on_hover_text("One part again; undo brings the parts back").clicked() {
                    self.send(Command::Part(PartCommand::Reset {}));
                }
            });
        });
        if !can {
            empty(ui, "Cut the volume first: Axis, Depth or Line split.");
        }
        self.force_rows(ui, forces);
    }

    fn force_rows(&mut self, ui: &mut Ui, forces: Forces) {
        subsection(ui, "Forces", false, |ui| {
            let mut new = forces;
            let scale = Scale { decimals: 2, ..Scale::default() };
            for (label, name, value, top) in [
                ("Return", "Return force", &mut new.return_constant, 1.0),
                ("Explosion", "Explosion force", &mut new.delta_explosion, 1.0),
                ("Viewing", "Viewing force", &mut new.delta_viewing, 1.0),
                ("Spacing", "Spacing force", &mut new.delta_spacing, 1.0),
            ] {
                row(ui, label, |ui| {
                    let response = slider(ui, name, value, 0.0..=top, scale);
                    if response.changed() {
                        self.edit(
                            &response,
                            Command::Explosion(ExplosionCommand::Forces { forces: new_with(forces, name, *value) }),
                        );
                    }
                });
            }
            let mut check = |ui: &mut Ui, text: &str, tip: &str, now: bool, with: &dyn Fn(bool) -> Forces| {
                let mut on = now;
                if ui.checkbox(&mut on, text).on_hover_text(tip).changed() {
                    self.send(Command::Explosion(ExplosionCommand::Forces { forces: with(on) }));
                }
            };
            let tip = "Parts leave the line of sight to the selection";
            check(ui, "Clear the view", tip, forces.viewing, &|viewing| Forces { viewing, ..forces });
            let tip = "Only parts that hide the selection are pushed, as far as it takes";
            check(ui, "Measure what hides", tip, forces.measured_gain, &|measured_gain| Forces {
                measured_gain,
                ..forces
            });
            if ui.button("Standard forces").clicked() {
                self.send(Command::Explosion(ExplosionCommand::Forces { forces: Forces::default() }));
            }
        });
    }
}

fn new_with(mut forces: Forces, name: &str, value: f64) -> Forces {
    match name {
        "Return force" => forces.return_constant = value,
        "Explosion force" => forces.delta_explosion = value,
        "Viewing force" => forces.delta_viewing = value,
        _ => forces.delta_spacing = value,
    }
    forces
}
