//! The menu of a look: how one volume, part, segment or the selection is shown in 3D apart from what it belongs to.
//!
//! Every row says what is inherited where nothing is said; the last button gives all of it up. Curves are edited in the panel of the
//! transfer function, which shows this one while it is asked to.

use crate::document::own_looks::LookChange;
use crate::document::{Command, Scene, VolumeCommand};
use crate::interact::readout;
use crate::ui::state::left_out::{ShownAlone, show_only};
use crate::ui::state::look_of::{Inherited, LookOf, whose};
use crate::ui::style::colour::ready_colours;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{Face, Scale, button, choice, controls_under, icon_button, line, row, slider};
use crate::ui::window::app::App;
use crate::volume::{Mode, TransferFunction, VolumeId};
use egui::{Response, Ui, vec2};

/// Width of the menu's controls: four choices and nine colours have room.
const CONTROLS: f32 = 286.0;

/// Width of a button in a row that has many: of a volume, of a segment.
pub(super) const NARROW: f32 = 16.0;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Inherited,
    Dvr,
    Iso,
    Mip,
}

#[derive(Clone, Copy, PartialEq)]
enum Light {
    Inherited,
    On,
    Off,
}

#[derive(Clone, Copy, PartialEq)]
enum Colours {
    Inherited,
    One,
    ByValue,
}

/// A surface is looked for among these values, and begins at this one.
struct Surfaces {
    ends: [f64; 2],
    first: f64,
}

impl App {
    /// The button that opens the menu, lit where there is a look for itself; `called` is how its names name the thing.
    pub(super) fn look_menu(&mut self, ui: &mut Ui, of: LookOf, called: &str) {
        let Some(own) = self.scene.as_ref().map(|scene| of.own(scene)) else { return };
        let tint = if own.is_some() { theme::ACCENT } else { theme::TEXT_WEAK };
        let name = format!("Look of {called}");
        let tip = match (&own, of) {
            (Some(_), _) => "It has a look of its own in 3D: opacity, mode, light, colours",
            (None, LookOf::Volume(_)) => "Give this volume a look of its own in 3D: mode, light, colours",
            (None, _) => "Give it a look of its own in 3D: opacity, mode, light, colours",
        };
        let narrow = matches!(of, LookOf::Volume(_) | LookOf::Segment(..));
        let size = if narrow { NARROW } else { ROW };
        let response = icon_button(ui, Face { size, ..Face::small(Icon::Look, &name, tip).tint(tint) });
        controls_under(&response, |ui| {
            ui.set_width(LABEL + GAP + CONTROLS);
            let width = ui.available_width();
            let whose = self.scene.as_ref().and_then(|scene| of.within(scene));
            let whose = whose.map_or_else(String::new, |volume| format!(" of {volume}"));
            line(ui, &format!("Look in 3D: {called}{whose}"), width, theme::TEXT);
            self.look_rows(ui, of, own);
        });
    }

    fn look_rows(&mut self, ui: &mut Ui, of: LookOf, own: Option<LookChange>) {
        let Some(scene) = self.scene.clone() else { return };
        let inherited = of.inherited(&scene);
        let has = own.is_some();
        let now = own.unwrap_or_default();
        let volume = matches!(of, LookOf::Volume(_));
        // How strongly a volume shows stands in its row.
        if !volume {
            row(ui, "Opacity", |ui| {
                let mut opacity = f64::from(now.opacity);
                let tip = "How strongly it shows; at 0 % it is not there and hides nothing";
                let response = slider(ui, ("Opacity of the look", tip), &mut opacity, 0.0..=1.0, Scale::PERCENT);
                if response.changed() {
                    let opacity = opacity as f32;
                    self.change_look(Some(&response), of, &scene, &LookChange { opacity, ..now.clone() });
                }
            });
        }
        self.mode_rows(ui, of, &scene, &now);
        row(ui, "Light", |ui| {
            let light = match now.lighting {
                None if volume && inherited.lighting.is_some() => Light::On,
                None if volume => Light::Off,
                None => Light::Inherited,
                Some(Some(_)) => Light::On,
                Some(None) => Light::Off,
            };
            let options = [
                (Light::Inherited, "As inherited", "Lit or not, like what it belongs to"),
                (Light::On, "On", "Lit from where you look, so that its shape is seen"),
                (Light::Off, "Off", "Its plain colours, without shades"),
            ];
            let chosen = choice(ui, "Light of the look", Some(light), &options[usize::from(volume)..]);
            let lighting = match chosen {
                None => return,
                Some(Light::Inherited) => None,
                Some(Light::On) => Some(Some(inherited.lighting.unwrap_or_default())),
                Some(Light::Off) => Some(None),
            };
            self.change_look(None, of, &scene, &LookChange { lighting, ..now.clone() });
        });
        self.colour_rows(ui, of, &scene, &now);
        ui.add_space(GAP);
        ui.horizontal(|ui| {
            let half = vec2((ui.available_width() - GAP) * 0.5, ROW);
            ui.add_enabled_ui(now.transfer.is_some(), |ui| {
                let tip =
                    "The panel “Transfer function” on the right shows its colours and opacities, to be changed there";
                if button(ui, half, "Edit its curve", tip) {
                    self.edit_curve(of);
                    ui.close();
                }
            });
            ui.add_enabled_ui(has, |ui| {
                let tip = match volume {
                    true => "Give up the look of its own: as all volumes that have none",
                    false => "Give up the look of its own: like what it belongs to",
                };
                if button(ui, half, "As inherited", tip) {
                    self.change_look(None, of, &scene, &LookChange::default());
                }
            });
        });
        if let LookOf::Segment(volume, id) = of {
            ui.separator();
            self.alone_row(ui, &scene, volume, id);
        }
    }

    /// Shows its curve in the panel of the transfer function; of a volume by taking it in hand, as all panels show that one.
    fn edit_curve(&mut self, of: LookOf) {
        let LookOf::Volume(volume) = of else { return self.transfer.edit(Some(of)) };
        self.transfer.edit(None);
        if self.scene.as_ref().is_some_and(|scene| scene.volumes.active != volume) {
            let (name, visible, opacity, look, pose) = (None, None, None, None, None);
            let set =
                VolumeCommand::Set { volume, name, visible, opacity, look, shared_look: false, pose, active: true };
            self.send(Command::Volume(set));
        }
    }

    /// Shows a segment alone in 3D, or beside those that are.
    fn alone_row(&mut self, ui: &mut Ui, scene: &Scene, volume: VolumeId, id: u16) {
        let alone = ShownAlone::of(scene, volume);
        let shown = alone.as_ref().is_none_or(|alone| alone.shows(id));
        ui.horizontal(|ui| {
            let half = vec2((ui.available_width() - GAP) * 0.5, ROW);
            let tip = "3D shows this segment alone; the others are hidden there, not gone";
            if button(ui, half, "Show only this one", tip) {
                self.send(show_only(Some([id].into()), volume));
            }
            ui.add_enabled_ui(alone.is_some(), |ui| {
                let (text, tip) = match shown {
                    true => ("Hide this one", "3D shows it no more among those that are shown alone"),
                    false => ("Show this one too", "3D shows it beside those that are shown alone"),
                };
                if button(ui, half, text, tip)
                    && let Some(alone) = &alone
                {
                    self.send(alone.with(id, !shown));
                }
            });
        });
    }

    fn mode_rows(&mut self, ui: &mut Ui, of: LookOf, scene: &Scene, now: &LookChange) {
        let inherited = of.inherited(scene);
        let volume = matches!(of, LookOf::Volume(_));
        let surfaces = self.surfaces(of, now.transfer.as_ref().unwrap_or(inherited.transfer));
        let seen = if volume { Some(now.mode.unwrap_or(inherited.mode)) } else { now.mode };
        row(ui, "Mode", |ui| {
            let kind = match seen {
                None => Kind::Inherited,
                Some(Mode::Dvr) => Kind::Dvr,
                Some(Mode::Iso(_)) => Kind::Iso,
                Some(Mode::Mip) => Kind::Mip,
            };
            let options = [
                (Kind::Inherited, "As inherited", "Shown in the way of what it belongs to"),
                (Kind::Dvr, "Volume", "Every value with its colour and opacity"),
                (Kind::Iso, "Surface", "The surface where it has one value"),
                (Kind::Mip, "Maximum", "The largest value along each line of sight"),
            ];
            let mode = match choice(ui, "Mode of the look", Some(kind), &options[usize::from(volume)..]) {
                None => return,
                Some(Kind::Inherited) => None,
                Some(Kind::Dvr) => Some(Mode::Dvr),
                Some(Kind::Iso) => Some(Mode::Iso(surfaces.first)),
                Some(Kind::Mip) => Some(Mode::Mip),
            };
            self.change_look(None, of, scene, &LookChange { mode, ..now.clone() });
        });
        let at = match seen {
            Some(Mode::Iso(value)) => Some(value),
            _ => None,
        };
        ui.add_enabled_ui(at.is_some(), |ui| {
            row(ui, "Surface at", |ui| {
                let mut value = at.unwrap_or(surfaces.first);
                let [min, max] = surfaces.ends;
                let scale = Scale { decimals: readout::decimals(readout::span([min, max])), ..Scale::PLAIN };
                let about = ("Surface value of the look", "The value on its surface (mode Surface)");
                let response = slider(ui, about, &mut value, min..=max, scale);
                if response.changed() {
                    let mode = Some(Mode::Iso(value));
                    self.change_look(Some(&response), of, scene, &LookChange { mode, ..now.clone() });
                }
            });
        });
    }

    fn colour_rows(&mut self, ui: &mut Ui, of: LookOf, scene: &Scene, now: &LookChange) {
        let Inherited { transfer: inherited, .. } = of.inherited(scene);
        let volume = matches!(of, LookOf::Volume(_));
        let base = now.transfer.as_ref().unwrap_or(inherited);
        let colours = match &now.transfer {
            None if !volume => Colours::Inherited,
            _ if base.colour.len() == 1 => Colours::One,
            _ => Colours::ByValue,
        };
        let own_colour = of.colour(scene);
        let in_one = |colour: [f32; 3]| {
            let at = base.opacity.first().map_or(0.0, |point| point.0);
            Some(TransferFunction { colour: vec![(at, colour)], ..base.clone() })
        };
        row(ui, "Colours", |ui| {
            let options = [
                (Colours::Inherited, "As inherited", "The colours and opacities of what it belongs to"),
                (Colours::One, "One colour", "One colour throughout, as opaque as before"),
                (Colours::ByValue, "By value", "Colours and opacities of its own: the panel on the right shows them"),
            ];
            // Of a volume that has none for itself, whichever is clicked is its own from then on.
            let lit = (!volume || now.transfer.is_some()).then_some(colours);
            let transfer = match choice(ui, "Colours of the look", lit, &options[usize::from(volume)..]) {
                None => return,
                Some(Colours::Inherited) => None,
                Some(Colours::One) => in_one(own_colour.unwrap_or([0.95, 0.95, 0.95])),
                Some(Colours::ByValue) => {
                    if !volume {
                        self.transfer.edit(Some(of));
                    }
                    Some(TransferFunction { colour: inherited.colour.clone(), ..base.clone() })
                }
            };
            self.change_look(None, of, scene, &LookChange { transfer, ..now.clone() });
        });
        ui.add_enabled_ui(colours == Colours::One, |ui| {
            row(ui, "", |ui| {
                let first = own_colour.map(|colour| (of.in_its_colour(), colour));
                let width = ui.available_width();
                if let Some(colour) = ready_colours(ui, width, first) {
                    self.change_look(None, of, scene, &LookChange { transfer: in_one(colour), ..now.clone() });
                }
            });
        });
    }

    /// Between which values a surface of it can lie, and where it is best begun.
    fn surfaces(&self, of: LookOf, function: &TransferFunction) -> Surfaces {
        let active = self.scene.as_ref().map(|scene| scene.volumes.active);
        let at_hand = match of {
            LookOf::Volume(id) | LookOf::Selection(id) | LookOf::Segment(id, _) => Some(id) == active,
            LookOf::Part(_) => true,
        };
        if let Some(open) = self.opened().filter(|_| at_hand) {
            return Surfaces { ends: open.ends(), first: function.first_surface(&open.histogram) };
        }
        // Of a volume whose values are not at hand: where half of what there is of opacity begins.
        let most = function.opacity.iter().map(|point| point.1).fold(0.0, f32::max);
        let (lo, hi) = function.domain();
        let first = function.opacity.iter().find(|point| point.1 >= most * 0.5).map_or(hi, |point| point.0);
        Surfaces { ends: [lo, hi], first }
    }

    /// Gives it what is wanted; a drag of a control is one step.
    fn change_look(&mut self, dragged: Option<&Response>, of: LookOf, scene: &Scene, wanted: &LookChange) {
        let commands = of.change(scene, wanted);
        match (dragged, &commands[..]) {
            (Some(response), [only]) => self.edit(response, only.clone()),
            _ => {
                self.end_group();
                commands.into_iter().for_each(|command| self.send(command));
            }
        }
    }
}

/// Says whose looks a panel changes, where there are several volumes or this one has its own.
pub(super) fn whose_line(ui: &mut Ui, scene: &Scene, what: &str) {
    if let Some((volume, own)) = whose(scene) {
        let width = ui.available_width();
        line(ui, &format!("{what} of {volume}: {own}"), width, theme::TEXT_WEAK);
    }
}
