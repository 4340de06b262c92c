//! The line at the bottom: where the pointer is and what is there; what runs; whether work is saved.

use crate::document::{SlicePlane, ViewName};
use crate::explode::PartId;
use crate::gpu::ObjectId;
use crate::interact::readout;
use crate::math::DVec3;
use crate::ui::state::look_of::volume_name;
use crate::ui::style::theme;
use crate::ui::style::widgets::{from_right, spinner};
use crate::ui::window::app::{App, Busy};
use crate::volume::VolumeId;
use egui::{Button, Frame, Label, Margin, Panel, ProgressBar, RichText, TextStyle, Ui};

/// Seconds that nobody needs to be told of.
const AT_ONCE: f64 = 0.1;

impl App {
    pub(crate) fn status_bar(&mut self, ui: &mut Ui) {
        let frame = Frame::new().inner_margin(Margin::symmetric(10, 2));
        let bar = Panel::bottom("status").exact_size(26.0).frame(frame).show(ui, |ui| {
            ui.horizontal_centered(|ui| {
                ui.spacing_mut().item_spacing.x = 16.0;
                self.place_text(ui);
                from_right(ui, |ui| self.state_text(ui));
            });
        });
        self.backdrop.fill(bar.response.rect, theme::BAR);
    }

    /// World mm under the pointer: of the slice, or of the picked surface.
    fn place_under_pointer(&self) -> Option<DVec3> {
        let (scene, open) = (self.scene.as_ref()?, self.opened()?);
        let (view, px) = self.viewports.hovered?;
        let size = *self.viewports.sizes.get(&view)?;
        if view == ViewName::ThreeD {
            let hit = self.hit(px, size)?;
            let part = scene.explosion.parts.iter().find(|p| Some(p.id) == hit.part);
            return Some(part.map_or(hit.world, |p| open.poses.of(p).unapply(hit.world)));
        }
        SlicePlane::new(&open.grid, &scene.views, view).map(|p| p.world(px))
    }

    /// The part under the pointer in the 3D view.
    pub(crate) fn hovered_part(&self) -> Option<PartId> {
        let (view, px) = self.viewports.hovered?;
        let size = *self.viewports.sizes.get(&view)?;
        (view == ViewName::ThreeD).then(|| self.hit(px, size)?.part)?
    }

    fn place_text(&self, ui: &mut Ui) {
        let mono = |text: String| RichText::new(text).monospace().color(theme::TEXT);
        let Some(open) = self.opened() else {
            let hint = if self.busy.is_none() { "Open a file to begin" } else { "" };
            ui.label(RichText::new(hint).color(theme::TEXT_WEAK));
            return;
        };
        let Some(world) = self.place_under_pointer() else {
            ui.add(Label::new(RichText::new(self.interaction.tool().hint()).color(theme::TEXT_WEAK)).truncate());
            return;
        };
        let index = open.grid.index_from_world().transform_point3(world);
        let voxel = open.grid.voxel_at(index);
        let shown = |v: [u32; 3]| format!("{:>4} {:>4} {:>4}", v[0], v[1], v[2]);
        ui.add(
            Label::new(mono(voxel.map_or_else(|| "outside".into(), |v| format!("ijk {}", shown(v))))).selectable(false),
        );
        ui.add(Label::new(mono(format!("RAS {}", readout::place(world, open.grid.voxel_mm())))).selectable(false));
        let (value, label) = self.voxel_text();
        if voxel.is_some() {
            ui.add(Label::new(mono(value)).selectable(false));
        }
        if let Some(label) = label.filter(|_| voxel.is_some() || self.shown_object().is_some()) {
            ui.add(Label::new(RichText::new(label).color(theme::TEXT)).selectable(false).truncate());
        }
        let others = self.other_volumes();
        if !others.is_empty() {
            ui.add(Label::new(RichText::new(others).color(theme::TEXT_WEAK)).selectable(false).truncate());
        }
    }

    /// What the other visible volumes have under the pointer: the name of the segment, else the value. The segment that 3D shows is
    /// told already.
    fn other_volumes(&self) -> String {
        let (Some(scene), Some(probe)) = (&self.scene, &self.probe) else { return String::new() };
        let told = self.shown_object().filter(|object| object.segment().is_some()).and_then(ObjectId::volume);
        let others =
            probe.volumes.iter().filter(|other| ![Some(scene.volumes.active), told].contains(&Some(other.volume)));
        let told = others.filter_map(|other| {
            let values = other.values.as_ref()?;
            // The numbers of a label map are its segments'.
            let map = scene.volumes.all.get(&other.volume).is_some_and(|settings| settings.label_map);
            let number = || if map { "no segment".into() } else { readout::short(values.density.to_f64()) };
            let what = values.segment.clone().unwrap_or_else(number);
            Some(format!("{}: {what}", volume_name(&scene.volumes, other.volume)?))
        });
        told.collect::<Vec<_>>().join("   ")
    }

    /// Value and label of the voxel as the document answered last; in the 3D view what the picture shows there.
    fn voxel_text(&self) -> (String, Option<String>) {
        let values = self.probe.as_ref().and_then(|voxel| voxel.values.as_ref());
        let value = self
            .opened()
            .zip(values)
            .map_or_else(String::new, |(open, v)| format!("value {}", readout::value(v.density, open.voxel_type)));
        let shown = self.shown_object();
        let mut extra = Vec::new();
        if let Some(text) = shown.and_then(|object| self.volume_shown(object)) {
            extra.push(text);
        }
        let active = self.scene.as_ref().map(|scene| scene.volumes.active);
        let known = |volume: Option<VolumeId>, id: u16| {
            let name = self.scene.as_ref().zip(volume).and_then(|(scene, volume)| scene.segments_of(volume).get(id));
            format!("{id} {}", name.map_or("unnamed", |segment| segment.name.as_str()))
        };
        match shown {
            Some(object) if object.volume() != active => {
                extra.extend(object.segment().map(|id| known(object.volume(), id)));
            }
            // A picture without segments in it does not tell them apart.
            _ => {
                let drawn = shown.and_then(ObjectId::segment);
                let label = drawn.or_else(|| values.map(|v| v.label).filter(|&id| id != 0));
                extra.extend(label.map(|id| known(active, id)));
            }
        }
        let share = values.map(|v| v.selection).filter(|&share| share > 0.0);
        let percent = |share: f32| format!("selected {:.0} %", share * 100.0);
        match shown {
            Some(object) if object.is_selected() => extra.push("selected".into()),
            // Of what is selected by less than half the picture says nothing, and the voxel is the active volume's.
            Some(object) if object.volume() == active => extra.extend(share.filter(|&s| s < 0.5).map(percent)),
            Some(_) => {}
            None => extra.extend(share.map(percent)),
        }
        if let Some(part) =
            self.hovered_part().and_then(|id| self.scene.as_ref()?.explosion.parts.iter().find(|p| p.id == id))
        {
            extra.push(part.name.clone());
        }
        (value, (!extra.is_empty()).then(|| extra.join("  ·  ")))
    }

    /// What the 3D view shows under the pointer.
    fn shown_object(&self) -> Option<ObjectId> {
        let (view, px) = self.viewports.hovered.filter(|(view, _)| *view == ViewName::ThreeD)?;
        self.pictures.object(px, *self.viewports.sizes.get(&view)?)
    }

    /// Which volume that is, where there are several.
    fn volume_shown(&self, object: ObjectId) -> Option<String> {
        let volumes = &self.scene.as_ref().filter(|scene| scene.volumes.all.len() > 1)?.volumes;
        volume_name(volumes, object.volume()?)
    }

    fn state_text(&mut self, ui: &mut Ui) {
        if let Some(open) = self.opened() {
            let (text, colour) = match (&self.snapshot.project, self.snapshot.unsaved) {
                (_, true) => ("Unsaved changes", theme::WARNING),
                (Some(_), false) => ("Saved", theme::TEXT_WEAK),
                (None, false) => ("Nothing to save", theme::TEXT_WEAK),
            };
            ui.label(RichText::new(text).color(colour));
            let [i, j, k] = open.grid.dims;
            let text = format!("{i} × {j} × {k} {}", open.voxel_type.name());
            ui.label(RichText::new(text).color(theme::TEXT_WEAK));
        }
        match &self.snapshot.gpu {
            Some(Err(reason)) => {
                ui.label(RichText::new("No pictures").color(theme::ERROR)).on_hover_text(reason);
            }
            Some(Ok(name)) => {
                let (short, tip) = renderer(name);
                // A letter of it would tell nobody anything.
                let font = TextStyle::Body.resolve(ui.style());
                let wide = ui.painter().layout_no_wrap(short.clone(), font, theme::TEXT_WEAK).size().x;
                if wide <= ui.available_width() {
                    ui.label(RichText::new(short).color(theme::TEXT_WEAK)).on_hover_text(tip);
                }
            }
            None => {}
        }
        // What is over at once is not worth a word.
        let now = ui.input(|i| i.time);
        if let Some(busy) = self.busy.clone().filter(|busy| now - busy.since > AT_ONCE) {
            self.busy_text(ui, &busy);
        } else if self.behind_since.is_some_and(|since| now - since > AT_ONCE) {
            ui.label(RichText::new("Working").color(theme::TEXT));
            spinner(ui, 14.0);
        } else if self.snapshot.moving {
            ui.label(RichText::new("Parts are moving").color(theme::TEXT_WEAK));
        }
    }

    /// From the right: how to stop it, how far it is, what it is.
    fn busy_text(&mut self, ui: &mut Ui, busy: &Busy) {
        let seconds = ui.input(|i| i.time) - busy.since;
        if let Some(percent) = busy.percent {
            let cancel = Button::new(RichText::new("Cancel").color(theme::TEXT)).small();
            let tip = "Stops this; what is open stays as it was before";
            if ui.add_enabled(!busy.stopping, cancel).on_hover_text(tip).clicked() {
                self.stop();
            }
            let bar = ProgressBar::new(percent as f32 / 100.0).desired_width(96.0).desired_height(6.0);
            ui.add(bar.fill(theme::ACCENT));
        }
        let what = if busy.stopping { format!("Stopping: {}", busy.what) } else { busy.what.clone() };
        let share = busy.percent.map_or_else(String::new, |p| format!("  {p} %"));
        let time = if seconds >= 1.0 { format!("  {seconds:.0} s") } else { String::new() };
        ui.label(RichText::new(format!("{what}{share}{time}")).color(theme::TEXT));
        if busy.percent.is_none() {
            spinner(ui, 14.0);
        }
    }
}

/// What draws, in short and in full. A driver that draws on the processor is named by what it is.
fn renderer(name: &str) -> (String, String) {
    let software = ["llvmpipe", "lavapipe", "SwiftShader", "WARP", "Basic Render"];
    if software.iter().any(|s| name.contains(s)) {
        let tip = format!("Pictures are drawn by the processor ({name}): a graphics card would be much faster");
        return ("Software renderer".into(), tip);
    }
    let short = name.split(['(', ',', ';']).next().unwrap_or(name).trim().to_owned();
    (short, format!("Pictures are drawn by {name}"))
}
