//! The bar at the top: file, undo and redo, tools, arrangement.

use crate::document::{Command, HistoryCommand, VolumeCommand};
use crate::interact::{Action, Tool};
use crate::ui::state::look_of::volume_name;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::widgets::{Face, from_right, icon_button, tipped};
use crate::ui::thread::session::Severity;
use crate::ui::window::app::App;
use egui::{Frame, Margin, Panel, RichText, Ui};

impl App {
    pub(crate) fn top_bar(&mut self, ui: &mut Ui) {
        let frame = Frame::new().inner_margin(Margin::symmetric(8, 4));
        let bar = Panel::top("bar").exact_size(42.0).frame(frame).show(ui, |ui| {
            ui.horizontal_centered(|ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                self.file_part(ui);
                divider(ui);
                self.tool_part(ui);
                from_right(ui, |ui| self.right_part(ui));
            });
        });
        self.backdrop.fill(bar.response.rect, theme::BAR);
    }

    fn file_part(&mut self, ui: &mut Ui) {
        let open = self.opened().is_some();
        if icon_button(ui, Face::tool(Icon::Open, "Open", "Open a volume or a project (Ctrl + O)", true)).clicked() {
            self.act(Action::Open);
        }
        ui.add_enabled_ui(self.has_document(), |ui| {
            if icon_button(ui, Face::tool(Icon::Save, "Save", "Save the project (Ctrl + S)", true)).clicked() {
                self.save();
            }
        });
        ui.add_enabled_ui(open, |ui| {
            let more = egui::Button::new("More…").min_size(egui::vec2(0.0, 32.0)).frame_when_inactive(false);
            let (response, _) = egui::containers::menu::MenuButton::from_button(more).ui(ui, |ui| self.more_menu(ui));
            tipped(response, "Save elsewhere, add a volume, import, export, pictures");
        });
        divider(ui);
        for (icon, name, tip, names, command) in [
            (Icon::Undo, "Undo", "Ctrl + Z", self.snapshot.undo.last().cloned(), HistoryCommand::Undo { steps: 1 }),
            (Icon::Redo, "Redo", "Ctrl + Y", self.snapshot.redo.first().cloned(), HistoryCommand::Redo { steps: 1 }),
        ] {
            let tip =
                names.as_ref().map_or_else(|| format!("{name} ({tip})"), |what| format!("{name} “{what}” ({tip})"));
            let clicked =
                ui.add_enabled_ui(names.is_some(), |ui| icon_button(ui, Face::tool(icon, name, &tip, false)).clicked());
            if clicked.inner {
                self.undo_redo(command);
            }
        }
    }

    fn more_menu(&mut self, ui: &mut Ui) {
        ui.set_min_width(220.0);
        let save_as = ui.add(egui::Button::new("Save as…").shortcut_text("Ctrl+Shift+S"));
        if save_as.on_hover_text("The project in another place; it is that one from then on").clicked() {
            self.act(Action::SaveAs);
        }
        ui.separator();
        let add = ui.button("Add a volume…");
        let tip = "A second scan, a follow-up, a label map: beside what is open, on its own grid and with its own look";
        if add.on_hover_text(tip).clicked() {
            self.ask(PathPurpose::Add);
        }
        self.remove_button(ui);
        if ui
            .button("Import selection…")
            .on_hover_text("Another volume of the same place: what is above 0 is selected")
            .clicked()
        {
            self.ask(PathPurpose::Selection);
        }
        let labels = ui.button("Import labels…");
        if labels.on_hover_text("A label map of the same place: each value becomes a segment").clicked() {
            self.ask(PathPurpose::Labels);
        }
        ui.separator();
        let export = ui.button("Export…");
        if export.on_hover_text("Density, labels, selection or colour as NRRD or NIfTI").clicked() {
            self.ask_export();
        }
        let picture = ui.button("Save picture…");
        if picture.on_hover_text("A view in any size, on any ground, as PNG or EXR").clicked() {
            self.ask_picture();
        }
    }

    /// The list has a button a volume; a single one has no list.
    fn remove_button(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let volume = scene.volumes.active;
        let Some(name) = volume_name(&scene.volumes, volume) else { return };
        let tip = format!("Take {name} away, with all that was painted on it; undo brings it back");
        let what = if scene.volumes.all.len() > 1 { &*name } else { "the volume" };
        if ui.add(egui::Button::new(format!("Remove {what}")).truncate()).on_hover_text(tip).clicked() {
            self.send(Command::Volume(VolumeCommand::Remove { volume }));
        }
    }

    fn tool_part(&mut self, ui: &mut Ui) {
        let open = self.opened().is_some();
        let now = self.interaction.tool();
        // Names stand beside the icons wherever there is room for all of them and for what is at the right.
        let with_text = ui.available_width() > 1120.0;
        ui.add_enabled_ui(open, |ui| {
            for tool in Tool::ALL {
                let tip = format!("{} ({})\n{}", tool.name(), tool.key(), tool.hint());
                let face = Face::tool(Icon::Tool(tool), tool.name(), &tip, with_text).on(tool == now);
                if icon_button(ui, face).clicked() {
                    self.act(Action::Choose(tool));
                }
            }
        });
    }

    fn right_part(&mut self, ui: &mut Ui) {
        ui.spacing_mut().item_spacing.x = 2.0;
        // Whoever looks for help looks for the word.
        let wide = ui.ctx().viewport_rect().width() >= 1200.0;
        let tip = "What keys and pointer do (F1)";
        if icon_button(ui, Face::tool(Icon::Keys, "Help", tip, wide).on(self.keys_open)).clicked() {
            self.act(Action::Keys);
        }
        if let Some(gravest) = self.gravest() {
            let tip = format!("What was done and what went wrong ({})", self.messages.len());
            let tint = match gravest {
                Severity::Note => theme::TEXT_WEAK,
                Severity::Warning => theme::WARNING,
                Severity::Error => theme::ERROR,
            };
            let icon = if gravest == Severity::Note { Icon::Note } else { Icon::Warning };
            let face = Face::tool(icon, "Messages", &tip, false).on(self.messages_open).tint(tint);
            if icon_button(ui, face).clicked() {
                self.messages_open = !self.messages_open;
            }
        }
        let four = self.viewports.alone().is_none();
        ui.add_enabled_ui(self.opened().is_some(), |ui| {
            if icon_button(ui, Face::tool(Icon::Four, "Four views", "All four views (F)", false).on(four)).clicked() {
                self.viewports.show_all();
            }
        });
        self.past_buttons(ui);
        ui.add_space(8.0);
        let colour = if self.snapshot.unsaved { theme::TEXT } else { theme::TEXT_WEAK };
        ui.add(egui::Label::new(RichText::new(self.document_title()).color(colour)).truncate());
    }
}

impl App {
    /// Views and looks, back and forward; from the right.
    fn past_buttons(&mut self, ui: &mut Ui) {
        let (back, forward) = (self.snapshot.back.clone(), self.snapshot.forward.clone());
        for (icon, name, keys, change, action) in [
            (Icon::Forward, "Forward to the next view", "Alt + Right", forward, Action::Forward(None)),
            (Icon::Back, "Back to the view before", "Alt + Left", back, Action::Back(None)),
        ] {
            let what = change.as_ref().map_or_else(String::new, |what| format!(" “{what}”"));
            let tip = format!("{name}{what}: cameras, slices, window and looks ({keys}; looks alone with Shift)");
            let face = Face::tool(icon, name, &tip, false);
            if ui.add_enabled_ui(change.is_some(), |ui| icon_button(ui, face).clicked()).inner {
                self.act(action);
            }
        }
    }
}

fn divider(ui: &mut Ui) {
    ui.add_space(4.0);
    let (rect, _) = ui.allocate_exact_size(egui::vec2(1.0, 22.0), egui::Sense::hover());
    ui.painter().rect_filled(rect, 0.0, theme::LINE);
    ui.add_space(4.0);
}
