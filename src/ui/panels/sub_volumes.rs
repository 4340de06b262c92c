//! A sub-volume in numbers: its faces, how finely it is divided, what it may take; and baking it into what it is cut out of.

use crate::document::{Command, Scale, SubVolume, SubVolumeCommand};
use crate::interact::{Tool, readout};
use crate::ui::panels::look_menu::NARROW;
use crate::ui::state::look_of::volume_name;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{Face, button, controls_under, icon_button, line, number, row};
use crate::ui::window::app::App;
use crate::volume::{SubBox, VolumeId};
use egui::{DragValue, Ui, vec2};

impl App {
    /// The sign in its row, and what opens under it.
    pub(super) fn box_menu(&mut self, ui: &mut Ui, (id, called): (VolumeId, &str), place: SubVolume) {
        let name = format!("Box of volume {called}");
        let face =
            Face::small(Icon::Tool(Tool::SubVolume), &name, "The box of this sub-volume: faces, fineness, baking");
        let response = icon_button(ui, Face { size: NARROW, ..face.tint(theme::TEXT_WEAK) });
        controls_under(&response, |ui| {
            ui.set_width(LABEL + 180.0);
            let width = ui.available_width();
            line(ui, called, width, theme::TEXT);
            self.box_fields(ui, id, place);
            let sample_bytes = self.opened().and_then(|open| open.sample_bytes.get(&id).copied()).unwrap_or_default();
            line(ui, &readout::box_size(&place.of, sample_bytes), width, theme::TEXT_WEAK);
            let parent = self.scene.as_ref().and_then(|scene| volume_name(&scene.volumes, place.parent));
            let bake = format!("Bake into {}", parent.unwrap_or_default());
            let tip = "Adds what was edited here to the coarser voxels and takes the box away; one step of undo";
            if button(ui, vec2(width, ROW), &bake, tip) {
                self.send(Command::SubVolume(SubVolumeCommand::Bake { volume: id, remove: true }));
            }
        });
    }

    fn box_fields(&mut self, ui: &mut Ui, id: VolumeId, SubVolume { of, .. }: SubVolume) {
        let axes = [("Along i", "i"), ("Along j", "j"), ("Along k", "k")];
        for (axis, (label, letter)) in axes.into_iter().enumerate() {
            row(ui, label, |ui| {
                let width = (ui.available_width() - 2.0 * GAP) / 3.0;
                for last in [false, true] {
                    let (now, range) = match last {
                        false => (of.lo[axis], 0..=of.hi[axis] - 1),
                        true => (of.hi[axis], of.lo[axis] + 1..=u32::MAX),
                    };
                    let mut value = now;
                    let end = if last { "Last" } else { "First" };
                    let about = format!("{end} voxel along {letter}");
                    let tip = format!("{end} voxel of the box, counted in the volume that it is cut out of");
                    let field = DragValue::new(&mut value).range(range).speed(0.2);
                    let shown = |x: f64, chars| readout::fixed(x, 0, chars);
                    if number(ui, width, (&about, &tip), "", field, shown).changed() {
                        let mut to = of;
                        if last {
                            to.hi[axis] = value
                        } else {
                            to.lo[axis] = value
                        }
                        self.change_box(id, of, to);
                    }
                }
                let about = format!("Samples a voxel along {letter}");
                if let Some(scale) = fineness(ui, width, &about, of.scale[axis]) {
                    let mut to = of;
                    to.scale[axis] = scale;
                    self.change_box(id, of, to);
                }
            });
        }
        row(ui, "Fineness", |ui| {
            let (width, finest) = (ui.available_width(), of.scale.into_iter().fold(1, u32::max));
            if let Some(scale) = fineness(ui, width, "Samples a voxel along all axes", finest) {
                self.change_box(id, of, SubBox { scale: [scale; 3], ..of });
            }
        });
    }

    fn change_box(&mut self, volume: VolumeId, from: SubBox, to: SubBox) {
        let (lo, hi) = ((from.lo != to.lo).then_some(to.lo), (from.hi != to.hi).then_some(to.hi));
        let scale = (from.scale != to.scale).then_some(Scale::Each(to.scale));
        self.send(Command::SubVolume(SubVolumeCommand::Set { volume, lo, hi, scale, discard: false }));
    }
}

/// A field for samples a voxel; what it is changed to.
fn fineness(ui: &mut Ui, width: f32, about: &str, now: u32) -> Option<u32> {
    let mut scale = now;
    let field = DragValue::new(&mut scale).range(1..=SubBox::FINEST).speed(0.03).suffix("×");
    let about = (about, "How many samples lie in a voxel, 1 to 8");
    number(ui, width, about, "×", field, |x, chars| readout::fixed(x, 0, chars)).changed().then_some(scale)
}
