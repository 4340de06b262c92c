//! The list of parts: colour, name, visibility, pin.

use crate::document::{Command, PartCommand};
use crate::explode::Part;
use crate::ui::state::look_of::LookOf;
use crate::ui::style::colour::{colour_button_with, strike_out};
use crate::ui::style::icons::Icon;
use crate::ui::style::naming::{Named, name_field};
use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use crate::ui::style::widgets::{Face, from_right, icon_button, list, tipped};
use crate::ui::window::app::App;
use egui::{Button, Rect, Ui, vec2};

impl App {
    pub(super) fn part_panel(&mut self, ui: &mut Ui, height: f32) {
        let Some(scene) = &self.scene else { return };
        let parts = scene.explosion.parts.clone();
        self.pointed_part = None;
        self.backdrop.detail(ui, Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), height)), theme::DEEP);
        list(ui, "parts", height, ROW, parts.len(), false, |ui, range| {
            for part in &parts[range] {
                self.part_row(ui, part);
            }
        });
    }

    fn part_row(&mut self, ui: &mut Ui, part: &Part) {
        let id = part.id;
        let set = |name: Option<String>,
                   colour: Option<[f32; 3]>,
                   own_colour: bool,
                   visible: Option<bool>,
                   pinned: Option<bool>| {
            Command::Part(PartCommand::Set {
                id,
                name,
                colour,
                own_colour,
                visible,
                pinned,
                importance: None,
                look: None,
            })
        };
        ui.push_id(("part", id.0), |ui| {
            let row = ui.horizontal(|ui| {
                let hovered = self.hovered_part() == Some(id);
                if hovered {
                    let full = egui::Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), ROW));
                    ui.painter().rect_filled(full, theme::ROUND, theme::CONTROL);
                }
                let mut colour = part.colour.unwrap_or([0.55, 0.55, 0.57]);
                let mut own = false;
                let response = colour_button_with(ui, &format!("Colour of {}", part.name), &mut colour, |ui| {
                    ui.separator();
                    let own_colours = ui.add_enabled(part.colour.is_some(), Button::new("The volume's own colours"));
                    if tipped(own_colours, "No colour of the part's own: as the transfer function says").clicked() {
                        own = true;
                        ui.close();
                    }
                });
                if part.colour.is_none() {
                    strike_out(ui, response.rect);
                }
                if own {
                    self.send(set(None, None, true, None, None));
                } else if response.changed() {
                    self.edit(&response, set(None, Some(colour), false, None, None));
                }
                let width = ui.available_width() - 3.0 * 26.0;
                let about = (&*format!("Name of part {}", id.0), "Double-click to rename this part");
                if let Some(Named::Anew(name)) = name_field(ui, about, &part.name, width) {
                    self.send(set(Some(name), None, false, None, None));
                }
                from_right(ui, |ui| {
                    let pin = format!("Pin {}", part.name);
                    let tint = if part.held.is_some() { theme::WARNING } else { theme::TEXT_WEAK };
                    let tip = "A pinned part stays where it is, whatever the forces say";
                    if icon_button(ui, Face::small(Icon::Pin, &pin, tip).tint(tint).on(part.held.is_some())).clicked() {
                        self.send(set(None, None, false, None, Some(part.held.is_none())));
                    }
                    let show = format!("Show {}", part.name);
                    let (icon, tint) =
                        if part.visible { (Icon::Eye, theme::TEXT) } else { (Icon::EyeOff, theme::TEXT_WEAK) };
                    if icon_button(ui, Face::small(icon, &show, "Show or hide this part").tint(tint)).clicked() {
                        self.send(set(None, None, false, Some(!part.visible), None));
                    }
                    self.look_menu(ui, LookOf::Part(id), &part.name);
                });
            });
            if ui.rect_contains_pointer(row.response.rect) {
                self.pointed_part = Some(id);
            }
        });
    }
}
