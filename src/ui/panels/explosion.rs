//! The degree of explosion and the forces behind it.

use crate::document::{Command, ExplosionCommand, PartCommand};
use crate::explode::Forces;
use crate::ui::style::theme::{GAP, ROW};
use crate::ui::style::widgets::{Scale, button, empty, row, slider, tick};
use crate::ui::window::app::App;
use crate::ui::window::folds::subsection;
use egui::{Ui, vec2};

impl App {
    pub(super) fn explosion_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let explosion = &scene.explosion;
        let (mut degree, forces, count) = (explosion.degree, explosion.forces, explosion.parts.len());
        let can = count > 1;
        ui.add_enabled_ui(can, |ui| {
            row(ui, "Degree", |ui| {
                let tip = "How far the parts move apart: 0 % whole, 100 % all the way";
                let response = slider(ui, ("Degree of explosion", tip), &mut degree, 0.0..=1.0, Scale::PERCENT);
                if response.changed() {
                    self.edit(&response, Command::Explosion(ExplosionCommand::Degree { value: degree }));
                }
            });
            ui.horizontal(|ui| {
                let each = vec2((ui.available_width() - GAP) * 0.5, ROW);
                let tip = "Finds what hides the selection and moves the parts until the selection is seen";
                if button(ui, each, "Settle", tip) {
                    self.send(Command::Explosion(ExplosionCommand::Settle {}));
                }
                if button(ui, each, "Join all parts", "One part again; undo brings the parts back") {
                    self.send(Command::Part(PartCommand::Reset {}));
                }
            });
        });
        // Its line is there also when there is nothing to say: the first cut moves nothing.
        ui.horizontal(|ui| {
            ui.set_min_height(ROW);
            if !can {
                empty(ui, "First cut it: Axis, Depth or Line split");
            } else if !self.snapshot.selected {
                empty(ui, "Select something first: paint a selection");
            }
        });
        self.force_rows(ui, forces);
    }

    fn force_rows(&mut self, ui: &mut Ui, forces: Forces) {
        subsection(ui, "Forces", |ui| {
            let mut new = forces;
            let scale = Scale { decimals: 2, ..Scale::PLAIN };
            for (label, name, tip, value) in [
                ("Return", "Return force", "Pulls every part back to its place", &mut new.return_constant),
                ("Explosion", "Explosion force", "Pushes parts away from the selection", &mut new.delta_explosion),
                ("Viewing", "Viewing force", "Pushes parts out of the line of sight", &mut new.delta_viewing),
                ("Spacing", "Spacing force", "Keeps parts apart from each other", &mut new.delta_spacing),
            ] {
                row(ui, label, |ui| {
                    let response = slider(ui, (name, tip), value, 0.0..=1.0, scale);
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
                if tick(ui, &mut on, text, tip) {
                    self.send(Command::Explosion(ExplosionCommand::Forces { forces: with(on) }));
                }
            };
            let tip = "Parts leave the line of sight to the selection, from wherever you look";
            check(ui, "Keep the view clear", tip, forces.viewing, &|viewing| Forces { viewing, ..forces });
            let tip = "Parts that hide nothing of the selection stay; the others move no farther than needed";
            check(ui, "Move only what hides the selection", tip, forces.measured_gain, &|measured_gain| Forces {
                measured_gain,
                ..forces
            });
            let tip = "All forces as they are when a volume is opened";
            if button(ui, vec2(ui.available_width(), ROW), "Forces as at first", tip) {
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
