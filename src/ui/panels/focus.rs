//! What the 3D view looks at while somebody paints: what is near the brush as it is, the rest faintly or as contours.

use crate::document::{Command, FarMatter, FocusChange, ViewCommand, ViewFocus};
use crate::interact::readout;
use crate::interact::readout::LengthUnit;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL};
use crate::ui::style::widgets::{Face, Scale, choice, controls_under, icon_button, row, slider};
use crate::ui::window::app::App;
use egui::Ui;

const CONTROLS: f32 = 240.0;

impl App {
    /// The button at the end of a row, lit while there is a focus, and its menu; `voxel`: the smallest spacing, mm.
    pub(super) fn focus_menu(&mut self, ui: &mut Ui, voxel: f64) {
        let Some(focus) = self.scene.as_ref().map(|scene| *scene.focus) else { return };
        let tint = if focus.on { theme::ACCENT } else { theme::TEXT_WEAK };
        let tip = "How the 3D view draws what is far from the brush";
        let layout = egui::Layout::right_to_left(egui::Align::Center);
        let face = Face::small(Icon::Look, "Focus on the brush", tip).tint(tint);
        let response = ui.with_layout(layout, |ui| icon_button(ui, face)).inner;
        controls_under(&response, |ui| {
            ui.set_width(LABEL + GAP + CONTROLS);
            self.focus_rows(ui, focus, voxel);
        });
    }

    fn focus_rows(&mut self, ui: &mut Ui, focus: ViewFocus, voxel: f64) {
        let now = focus.on.then_some(focus.far);
        let options = [
            (None, "Off", "All of the 3D view is drawn alike"),
            (Some(FarMatter::Faded), "Faded", "What is far from the brush is see-through"),
            (Some(FarMatter::Contour), "Contours", "Of what is far from the brush only outlines are drawn"),
        ];
        if let Some(picked) = row(ui, "Far matter", |ui| choice(ui, "Far from the brush", Some(now), &options)) {
            let change = FocusChange { on: Some(picked.is_some()), far: picked, ..FocusChange::default() };
            self.send(Command::View(ViewCommand::Focus(change)));
        }
        if !focus.on {
            return;
        }
        let LengthUnit { name: unit, per_mm: factor, .. } = LengthUnit::of(voxel);
        let scale = Scale { logarithmic: true, decimals: readout::decimals(voxel * factor * 20.0), unit, factor };
        let (mut distance, mut opacity) = (focus.distance_mm, f64::from(focus.opacity));
        let range = voxel..=(voxel * 200.0).max(distance);
        let about = ("Distance from the brush", "How far about the brush's footprint all is drawn as it is");
        let slid = row(ui, "Distance", |ui| slider(ui, about, &mut distance, range, scale));
        if slid.changed() {
            let change = FocusChange { distance_mm: Some(distance), ..FocusChange::default() };
            self.edit(&slid, Command::View(ViewCommand::Focus(change)));
        }
        let about = ("Opacity of what is far", "How much is seen of what lies farther: 0 % nothing");
        let slid = row(ui, "Opacity", |ui| slider(ui, about, &mut opacity, 0.0..=1.0, Scale::PERCENT));
        if slid.changed() {
            let change = FocusChange { opacity: Some(opacity as f32), ..FocusChange::default() };
            self.edit(&slid, Command::View(ViewCommand::Focus(change)));
        }
    }
}
