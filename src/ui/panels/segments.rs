//! The table of segments: colour, name, look, visibility, lock, and which of them 3D shows alone.

use crate::document::{Command, SegmentCommand};
use crate::paint::Target;
use crate::ui::panels::look_menu::NARROW;
use crate::ui::state::left_out::{ShownAlone, show_only};
use crate::ui::state::look_of::LookOf;
use crate::ui::style::colour::colour_button;
use crate::ui::style::icons::Icon;
use crate::ui::style::naming::{Named, name_field};
use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use crate::ui::style::widgets::{Face, button, empty, from_right, icon_button, line, list, tick};
use crate::ui::window::app::App;
use crate::volume::Segment;
use egui::{Rect, Sense, Ui, vec2};

impl App {
    pub(super) fn segment_panel(&mut self, ui: &mut Ui, height: f32) {
        let Some(scene) = &self.scene else { return };
        let alone = ShownAlone::of(scene, scene.volumes.active);
        let segments = scene.segments().0.clone();
        let painted = match scene.brush.target {
            Target::Label(id) => Some(id),
            _ => None,
        };
        let top = ui.cursor().top();
        if let Some(alone) = &alone {
            self.left_out_rows(ui, alone);
        }
        let height = (height - (ui.cursor().top() - top)).max(0.0);
        let place = Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), height));
        self.backdrop.detail(ui, place, theme::DEEP);
        // Hundreds of segments are normal: only the rows in sight are laid out.
        let before = usize::from(alone.is_some());
        list(ui, "segments", height, ROW, before + segments.len(), false, |ui, range| {
            for row in range {
                match (&alone, row.checked_sub(before)) {
                    (Some(alone), None) => self.unlabelled_row(ui, alone),
                    (_, i) => {
                        let Some(segment) = segments.get(i.unwrap_or(0)) else { continue };
                        self.segment_row(ui, segment, painted == Some(segment.id), alone.as_ref());
                    }
                }
            }
        });
        if segments.is_empty() {
            let mut hint = ui.new_child(egui::UiBuilder::new().max_rect(place.shrink(theme::GAP)));
            empty(&mut hint, "None yet. Paint a label (1 … 9), or add one with +.");
        }
    }

    /// Says that 3D leaves some out, and brings them back.
    fn left_out_rows(&mut self, ui: &mut Ui, alone: &ShownAlone) {
        ui.horizontal(|ui| {
            let button_width = 70.0;
            let width = ui.available_width() - button_width - theme::GAP;
            line(ui, &alone.words(), width, theme::WARNING);
            let tip = "Shows all segments in 3D again; nothing of them was changed";
            if button(ui, vec2(button_width, ROW), "Show all", tip)
                && let Some(scene) = &self.scene
            {
                self.send(show_only(None, scene.volumes.active));
            }
        });
    }

    /// Whether 3D shows, around those that are shown alone, what no segment has.
    fn unlabelled_row(&mut self, ui: &mut Ui, alone: &ShownAlone) {
        ui.horizontal(|ui| {
            ui.set_min_height(ROW);
            let mut rest = alone.shows(0);
            let tip = "Whether 3D shows the matter that no segment has, around those that are shown";
            if tick(ui, &mut rest, "Also what has no label", tip) {
                self.send(alone.with(0, rest));
            }
        });
    }

    /// At the end of the list's heading.
    pub(super) fn add_segment(&mut self, ui: &mut Ui, place: Rect) {
        let Some(scene) = &self.scene else { return };
        let free = scene.segments().free();
        let mut corner = ui.new_child(egui::UiBuilder::new().id_salt("add segment").max_rect(place));
        let face = Face::small(Icon::Add, "Add segment", "A new, empty segment; the brush paints it from now on");
        if icon_button(&mut corner, face).clicked()
            && let Some(next) = free
        {
            let add = SegmentCommand::Set {
                id: next,
                name: None,
                colour: None,
                visible: None,
                locked: None,
                look: None,
                volume: None,
            };
            self.send(Command::Segment(add));
            self.paint_with(Target::Label(next));
        }
    }

    fn segment_row(&mut self, ui: &mut Ui, segment: &Segment, painted: bool, alone: Option<&ShownAlone>) {
        let Some(volume) = self.scene.as_ref().map(|scene| scene.volumes.active) else { return };
        let id = segment.id;
        let same = |name, colour, visible, locked| {
            Command::Segment(SegmentCommand::Set { id, name, colour, visible, locked, look: None, volume: None })
        };
        ui.push_id(("segment", id), |ui| {
            ui.horizontal(|ui| {
                let full = egui::Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), ROW));
                if painted {
                    ui.painter().rect_filled(full, theme::ROUND, theme::ACCENT_FILL);
                }
                let (rect, pick) = ui.allocate_exact_size(vec2(22.0, ROW), Sense::click());
                let name = format!("Paint segment {}", segment.name);
                pick.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, painted, &name));
                let font = egui::TextStyle::Monospace.resolve(ui.style());
                ui.painter().text(
                    rect.right_center() - vec2(2.0, 0.0),
                    egui::Align2::RIGHT_CENTER,
                    id,
                    font,
                    theme::TEXT,
                );
                if pick.on_hover_text("Click to paint this segment").clicked() {
                    self.paint_with(Target::Label(id));
                }
                let mut colour = segment.colour;
                let response = colour_button(ui, &format!("Colour of {}", segment.name), &mut colour);
                if response.changed() {
                    self.edit(&response, same(None, Some(colour), None, None));
                }
                let icons = if alone.is_some() { 5.0 } else { 4.0 };
                let width = ui.available_width() - icons * NARROW - theme::GAP;
                let about =
                    (&*format!("Name of segment {id}"), "Click to paint this segment, double-click to rename it");
                match name_field(ui, about, &segment.name, width) {
                    Some(Named::Chosen) => self.paint_with(Target::Label(id)),
                    Some(Named::Anew(name)) => self.send(same(Some(name), None, None, None)),
                    None => {}
                }
                from_right(ui, |ui| {
                    ui.spacing_mut().item_spacing.x = 0.0;
                    let small = |icon, name, tip| Face { size: NARROW, ..Face::small(icon, name, tip) };
                    let remove = format!("Remove {}", segment.name);
                    if icon_button(ui, small(Icon::Trash, &remove, "Remove this segment and its voxels’ label"))
                        .clicked()
                    {
                        self.send(Command::Segment(SegmentCommand::Remove { id, volume: None }));
                    }
                    let lock = format!("Lock {}", segment.name);
                    let icon = if segment.locked { Icon::Lock } else { Icon::Unlock };
                    let tint = if segment.locked { theme::WARNING } else { theme::TEXT_WEAK };
                    let tip = "A locked segment's voxels are never painted over";
                    if icon_button(ui, small(icon, &lock, tip).tint(tint)).clicked() {
                        self.send(same(None, None, None, Some(!segment.locked)));
                    }
                    let show = format!("Show {}", segment.name);
                    let icon = if segment.visible { Icon::Eye } else { Icon::EyeOff };
                    let tint = if segment.visible { theme::TEXT } else { theme::TEXT_WEAK };
                    if icon_button(ui, small(icon, &show, "Show or hide this segment").tint(tint)).clicked() {
                        self.send(same(None, None, Some(!segment.visible), None));
                    }
                    self.look_menu(ui, LookOf::Segment(volume, id), &segment.name);
                    if let Some(alone) = alone {
                        let shown = alone.shows(id);
                        let show = format!("Show {} in 3D", segment.name);
                        let (tint, tip) = match shown {
                            true => (theme::ACCENT, "It is among those that 3D shows alone: click to hide it there"),
                            false => (theme::TEXT_WEAK, "It is hidden in 3D, not gone: click to show it there too"),
                        };
                        let face = small(Icon::Solid, &show, tip).tint(tint);
                        if icon_button(ui, face).clicked() {
                            self.send(alone.with(id, !shown));
                        }
                    }
                });
            });
        });
    }
}
