//! The list of volumes: which one is painted and which besides, name, visibility, strength, place.
//!
//! It takes room only where there is something to choose: a document of one volume as it was opened has no list. It stays when volumes
//! are removed, so that nothing below it moves under the hand.

use crate::document::{BrushCommand, Command, VolumeCommand, VolumeSettings, Volumes};
use crate::interact::{Tool, readout};
use crate::math::{DVec3, Pose};
use crate::ui::panels::look_menu::NARROW;
use crate::ui::state::look_of::{LookOf, volume_name};
use crate::ui::style::icons;
use crate::ui::style::icons::Icon;
use crate::ui::style::naming::{Named, name_field};
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{
    Face, button, controls_under, from_right, icon_button, line, list, number, row, tipped,
};
use crate::ui::window::app::App;
use crate::volume::VolumeId;
use egui::{DragValue, Rect, Response, Role, Sense, Ui, WidgetInfo, vec2};

/// Rows that are in sight: more are scrolled to, fewer leave room, so that nothing below moves.
const ROWS: f32 = 3.0;
/// Between two rows.
const BETWEEN: f32 = 2.0;
/// Width of each of the two signs that say what is painted.
const MARK: f32 = 14.0;
/// Width of the strength.
const PERCENT: f32 = 45.0;
/// Farthest that a volume is moved by hand, mm.
const FARTHEST: f64 = 1e6;

/// What is changed of a volume; what is `None` stays.
#[derive(Default)]
struct Given {
    name: Option<String>,
    visible: Option<bool>,
    opacity: Option<f32>,
    pose: Option<Pose>,
    active: bool,
}

impl Given {
    fn of(self, volume: VolumeId) -> Command {
        let Self { name, visible, opacity, pose, active } = self;
        let (look, shared_look) = (None, false);
        Command::Volume(VolumeCommand::Set { volume, name, visible, opacity, look, shared_look, pose, active })
    }
}

/// Every volume, and after it the sub-volumes that are cut out of it.
fn in_order(volumes: &Volumes) -> Vec<(VolumeId, &VolumeSettings)> {
    fn with_inner<'a>(volumes: &'a Volumes, of: Option<VolumeId>, rows: &mut Vec<(VolumeId, &'a VolumeSettings)>) {
        for (&id, settings) in &volumes.all {
            if settings.sub_volume.map(|sub| sub.parent) == of {
                rows.push((id, settings));
                with_inner(volumes, Some(id), rows);
            }
        }
    }
    let mut rows = Vec::new();
    with_inner(volumes, None, &mut rows);
    rows
}

impl App {
    /// Whether there is something to choose: several volumes, one that is left of several, or one that was hidden, weakened or moved.
    pub(super) fn lists_volumes(&self) -> bool {
        let Some(scene) = &self.scene else { return false };
        let as_opened = |v: &VolumeSettings| v.visible && v.opacity == 1.0 && v.pose == Pose::IDENTITY;
        scene.volumes.next > 1 || scene.volumes.all.values().any(|volume| !as_opened(volume))
    }

    pub(super) fn volume_panel(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let volumes = scene.volumes.clone();
        let rows = in_order(&volumes);
        let height = ROWS * ROW + (ROWS - 1.0) * BETWEEN;
        self.backdrop.detail(ui, Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), height)), theme::DEEP);
        list(ui, "volumes", height, ROW, rows.len(), false, |ui, range| {
            for &(id, settings) in &rows[range] {
                let called = volume_name(&volumes, id).unwrap_or_default();
                ui.push_id(("volume", id.0), |ui| self.volume_row(ui, (id, &called), settings, id == volumes.active));
            }
        });
        ui.add_space(GAP);
    }

    fn volume_row(&mut self, ui: &mut Ui, (id, called): (VolumeId, &str), volume: &VolumeSettings, active: bool) {
        ui.horizontal(|ui| {
            if active {
                let full = Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), ROW));
                ui.painter().rect_filled(full, theme::ROUND, theme::ACCENT_FILL);
            }
            let choose = |app: &mut Self| {
                if !active {
                    app.send(Given { active: true, ..Given::default() }.of(id));
                }
            };
            let gap = std::mem::replace(&mut ui.spacing_mut().item_spacing.x, 0.0);
            if mark(ui, called, active) {
                choose(self);
            }
            ui.spacing_mut().item_spacing.x = gap;
            self.besides(ui, (id, called), volume.visible && !active);
            let show = format!("Show volume {called}");
            let (icon, tint) = if volume.visible { (Icon::Eye, theme::TEXT) } else { (Icon::EyeOff, theme::TEXT_WEAK) };
            if icon_button(ui, Face::small(icon, &show, "Show or hide this volume").tint(tint)).clicked() {
                self.send(Given { visible: Some(!volume.visible), ..Given::default() }.of(id));
            }
            let width = ui.available_width() - 3.0 * NARROW - PERCENT - 2.0 * GAP;
            let does = if active {
                "The brush paints this volume, and the panels show it. Double-click to rename it"
            } else {
                "Click to paint this volume and to see it in the panels, double-click to rename it"
            };
            let tip = format!("{}\n{does}", volume.name);
            match name_field(ui, (&format!("Name of volume {id}"), &tip), &volume.name, width) {
                Some(Named::Chosen) => choose(self),
                Some(Named::Anew(name)) => self.send(Given { name: Some(name), ..Given::default() }.of(id)),
                None => {}
            }
            from_right(ui, |ui| {
                let gap = std::mem::replace(&mut ui.spacing_mut().item_spacing.x, 0.0);
                let remove = format!("Remove volume {called}");
                let tip = "Take this volume away, with all that was painted on it; undo brings it back";
                if icon_button(ui, Face { size: NARROW, ..Face::small(Icon::Trash, &remove, tip) }).clicked() {
                    self.send(Command::Volume(VolumeCommand::Remove { volume: id }));
                }
                match volume.sub_volume {
                    Some(place) => self.box_menu(ui, (id, called), place),
                    None => self.place_menu(ui, (id, called), volume),
                }
                self.look_menu(ui, LookOf::Volume(id), &format!("volume {called}"));
                ui.spacing_mut().item_spacing.x = gap;
                ui.add_space(gap);
                self.strength(ui, (id, called), volume);
            });
        });
    }

    /// Whether strokes paint it besides the active one: a sign to click, where it can be.
    fn besides(&mut self, ui: &mut Ui, (id, called): (VolumeId, &str), can: bool) {
        let Some(scene) = self.scene.as_ref().filter(|_| can) else {
            ui.allocate_exact_size(vec2(MARK, ROW), Sense::hover());
            return;
        };
        let on = scene.also.contains(&id);
        let name = format!("Paint volume {called} too");
        let does = if on { "Strokes paint this volume as well" } else { "Let strokes paint this volume as well" };
        let icon = if on { Icon::Tool(Tool::Brush) } else { Icon::Add };
        if sign(ui, (icon, true), (Role::CheckBox, on), (&name, does)).clicked() {
            let mut also = scene.also.clone();
            if !also.remove(&id) {
                also.insert(id);
            }
            let known = also.iter().copied().filter(|id| scene.volumes.all.contains_key(id));
            self.send(Command::Brush(BrushCommand::Also { volumes: known.collect() }));
        }
    }

    fn strength(&mut self, ui: &mut Ui, (id, called): (VolumeId, &str), volume: &VolumeSettings) {
        let mut percent = f64::from(volume.opacity) * 100.0;
        let field = DragValue::new(&mut percent).range(0.0..=100.0).speed(0.5).suffix(" %");
        let about = (&*format!("Opacity of volume {called}"), "How strongly it shows. Drag, or click to type");
        let response = number(ui, PERCENT, about, "%", field, |x, chars| readout::fixed(x, 0, chars));
        if response.changed() {
            let opacity = Some((percent / 100.0) as f32);
            self.edit(&response, Given { opacity, ..Given::default() }.of(id));
        }
    }

    /// Where it lies, in numbers: a follow-up seldom lies right.
    fn place_menu(&mut self, ui: &mut Ui, (id, called): (VolumeId, &str), volume: &VolumeSettings) {
        let moved = volume.pose != Pose::IDENTITY;
        let tint = if moved { theme::WARNING } else { theme::TEXT_WEAK };
        let name = format!("Place of volume {called}");
        let tip = if moved { "It was moved by hand: shift or turn it" } else { "Shift or turn this volume" };
        let response =
            icon_button(ui, Face { size: NARROW, ..Face::small(Icon::Tool(Tool::MovePart), &name, tip).tint(tint) });
        let centre = self.opened().and_then(|open| open.centres.get(&id).copied()).unwrap_or_default();
        controls_under(&response, |ui| {
            ui.set_width(LABEL + 110.0);
            let width = ui.available_width();
            line(ui, &format!("Place of {called}"), width, theme::TEXT);
            self.place_fields(ui, id, volume.pose, centre);
            ui.add_enabled_ui(moved, |ui| {
                let tip = "No shift and no turn: where its file has it";
                if button(ui, vec2(ui.available_width(), ROW), "Back to its place", tip) {
                    self.send(Given { pose: Some(Pose::IDENTITY), ..Given::default() }.of(id));
                }
            });
        });
    }

    fn place_fields(&mut self, ui: &mut Ui, id: VolumeId, pose: Pose, centre: DVec3) {
        let (shift, angles) = pose.shift_and_angles(centre);
        let numbers: [_; 6] = std::array::from_fn(|i| if i < 3 { shift[i] } else { angles[i - 3] });
        for (i, (label, name, tip, limit)) in [
            ("Right", "Shift to the right", "Millimetres to the patient's right; below 0 to the left", FARTHEST),
            ("Front", "Shift to the front", "Millimetres to the front; below 0 to the back", FARTHEST),
            ("Up", "Shift up", "Millimetres towards the head; below 0 towards the feet", FARTHEST),
            ("Nod", "Nod", "Degrees about its middle, from left to right: above 0 the front goes up", 180.0),
            ("Tilt", "Tilt", "Degrees about its middle, from back to front: above 0 the top goes right", 90.0),
            ("Turn", "Turn", "Degrees about its middle, from feet to head: above 0 the right side goes forward", 180.0),
        ]
        .into_iter()
        .enumerate()
        {
            row(ui, label, |ui| {
                let (unit, mut value) = (if i < 3 { " mm" } else { "°" }, numbers[i]);
                let field = DragValue::new(&mut value).range(-limit..=limit).speed(0.1).suffix(unit);
                let about = (&*format!("{name} of the volume"), &*format!("{tip}. Drag, or click to type"));
                let width = ui.available_width();
                let response = number(ui, width, about, unit, field, |x, chars| readout::fixed(x + 0.0, 2, chars));
                if response.changed() {
                    let mut numbers = numbers;
                    numbers[i] = value;
                    let [right, front, up, nod, tilt, turn] = numbers;
                    let pose = Pose::by_hand(centre, DVec3::new(right, front, up), [nod, tilt, turn]);
                    self.edit(&response, Given { pose: Some(pose), ..Given::default() }.of(id));
                }
            });
        }
    }
}

/// Says which volume is painted; whether another one is to be.
fn mark(ui: &mut Ui, called: &str, active: bool) -> bool {
    let tip = if active { "The brush paints this volume" } else { "Paint this volume" };
    let brush = (Icon::Tool(Tool::Brush), false);
    sign(ui, brush, (Role::RadioButton, active), (&format!("Paint volume {called}"), tip)).clicked()
}

/// A sign that is on or off; one that is off is seen under the pointer, or always if it `stays`.
fn sign(ui: &mut Ui, (icon, stays): (Icon, bool), (role, on): (Role, bool), (name, tip): (&str, &str)) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(MARK, ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(role, true, on, name));
    let lit = response.hovered() || response.has_focus();
    if on || lit || stays {
        icons::paint_narrow(ui.painter(), rect, icon, if on { theme::TEXT } else { theme::TEXT_WEAK });
    }
    tipped(response, tip)
}
