//! The panels around the views. Each shows one noun of the command set and changes it by commands.
//!
//! A side panel is a column: sections that scroll, and below a border the lists, which have what height is left and scroll for
//! themselves. So nothing moves when a list grows or another thing is chosen to paint.

pub(crate) mod bar;
pub(crate) mod brush;
pub(crate) mod brush_limits;
pub(crate) mod explosion;
pub(crate) mod falloff;
pub(crate) mod focus;
pub(crate) mod history;
pub(crate) mod keys;
pub(crate) mod labels;
pub(crate) mod layers;
pub(crate) mod look;
pub(crate) mod look_menu;
pub(crate) mod messages;
pub(crate) mod parts;
pub(crate) mod pieces;
pub(crate) mod segments;
pub(crate) mod status;
pub(crate) mod sub_volumes;
pub(crate) mod transfer;
pub(crate) mod volumes;
pub(crate) mod written;

use crate::interact::Tool;
use crate::ui::state::borders::{Border, Edge};
use crate::ui::state::layout::{BORDER, HEAD, LIST, Layout};
use crate::ui::state::look_of::shown_volume;
use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use crate::ui::window::app::App;
use crate::ui::window::folds::{is_unfolded, list_heading, section};
use egui::{Frame, Id, Panel, Rect, ScrollArea, Ui, UiBuilder, pos2, vec2};

/// Between a column's side and its contents, points.
const MARGIN: f32 = 10.0;
/// On the other side: room for the scroll bar, so that nothing moves when it appears.
const BAR: f32 = 12.0;
/// Above a column's contents.
const TOP: f32 = 4.0;
/// Above a list's heading.
const HEAD_TOP: f32 = 3.0;

impl App {
    pub(super) fn left_panel(&mut self, ui: &mut Ui) {
        if self.opened().is_none() {
            return;
        }
        let window = ui.ctx().viewport_rect().width();
        let width = self.layout.sides(window)[0];
        side(Panel::left("tools"), width).show(ui, |ui| {
            let all = ui.max_rect();
            self.backdrop.fill(all, theme::PANEL);
            let place = all.with_min_x(all.right() - BORDER);
            self.border(Edge { border: Border::Left, place, now: [width, 0.0], extent: [window, 1.0] });
            let column = all.with_max_x(all.right() - BORDER);
            let open = u8::from(is_unfolded(ui.ctx(), "Segments"));
            let (upper, lower) = self.column(ui, column, (Border::Segments, self.layout.segments, 0.0), [open, 1]);
            let whose = self.scene.as_ref().and_then(shown_volume);
            sections(ui, Border::Segments, upper, |ui| {
                if self.lists_volumes() {
                    section(ui, ("Volumes", None), |ui| self.volume_panel(ui));
                }
                // A tool that writes has its own rows in the brush's place, with the list of what it makes.
                let tool = self.interaction.tool();
                match tool {
                    Tool::Annotate | Tool::Cutaway => {
                        section(ui, ("Annotations", None), |ui| self.annotation_panel(ui));
                    }
                    Tool::Label => section(ui, ("Labels", None), |ui| self.label_panel(ui)),
                    _ => section(ui, ("Brush", None), |ui| self.brush_panel(ui)),
                }
                section(ui, ("Layers", whose.as_deref()), |ui| self.layer_panel(ui));
                section(ui, ("3D look", None), |ui| self.look_panel(ui));
                if self.lists_annotations() && !matches!(tool, Tool::Annotate | Tool::Cutaway) {
                    section(ui, ("Annotations", None), |ui| self.annotation_panel(ui));
                }
                if self.lists_labels() && tool != Tool::Label {
                    section(ui, ("Labels", None), |ui| self.label_panel(ui));
                }
            });
            let add = Rect::from_min_size(pos2(lower.right() - BAR - ROW, lower.top() + HEAD_TOP), vec2(ROW, ROW));
            self.add_segment(ui, add);
            let heads = ("Segments", whose.as_deref());
            listed(ui, lower, heads, ROW + theme::GAP, |ui, height| self.segment_panel(ui, height));
        });
    }

    pub(super) fn right_panel(&mut self, ui: &mut Ui) {
        if self.opened().is_none() {
            return;
        }
        let window = ui.ctx().viewport_rect().width();
        let width = self.layout.sides(window)[1];
        side(Panel::right("properties"), width).show(ui, |ui| {
            let all = ui.max_rect();
            self.backdrop.fill(all, theme::PANEL);
            let place = all.with_max_x(all.left() + BORDER);
            self.border(Edge { border: Border::Right, place, now: [width, 0.0], extent: [window, 1.0] });
            let column = all.with_min_x(all.left() + BORDER);
            let open = ["Parts", "History"].map(|title| is_unfolded(ui.ctx(), title));
            let count = open.iter().map(|&o| u8::from(o)).sum();
            let (upper, lower) = self.column(ui, column, (Border::Lists, self.layout.lists, 0.38), [count, 2]);
            sections(ui, Border::Lists, upper, |ui| {
                section(ui, ("Transfer function", None), |ui| self.transfer_panel(ui));
                section(ui, ("Explosion", None), |ui| self.explosion_panel(ui));
            });
            let (parts, steps) = self.divided(lower, open);
            listed(ui, parts, ("Parts", None), 0.0, |ui, height| self.part_panel(ui, height));
            listed(ui, steps, ("History", None), 0.0, |ui, height| self.history_panel(ui, height));
        });
    }

    /// Where the sections of a column lie, and where its lists, of which `open` of `heads` are unfolded: at a height by hand, else
    /// on what the sections leave, at least a share of the column.
    fn column(
        &mut self,
        ui: &Ui,
        all: Rect,
        (border, by_hand, least): (Border, Option<f32>, f32),
        [open, heads]: [u8; 2],
    ) -> (Rect, Rect) {
        let natural = ui.data(|d| d.get_temp::<f32>(natural(border))).unwrap_or(all.height());
        let height = Layout::list(by_hand, all.height(), natural, least, [open, heads]);
        let top = all.bottom() - height;
        let place = all.with_min_y(top - BORDER).with_max_y(top);
        if open > 0 {
            self.border(Edge { border, place, now: [0.0, height], extent: [1.0, all.height()] });
        } else {
            self.backdrop.fill(place, theme::DEEP);
        }
        (all.with_max_y(top - BORDER), all.with_min_y(top))
    }

    /// Where parts and steps lie below each other, unfolded or not.
    fn divided(&mut self, lower: Rect, open: [bool; 2]) -> (Rect, Rect) {
        let room = (lower.height() - 2.0 * HEAD - BORDER).max(1.0);
        let least = LIST.min(room * 0.5);
        let steps = match open {
            [true, true] => (room * self.layout.steps).clamp(least, room - least).round(),
            [true, false] => 0.0,
            [false, _] => room,
        };
        let top = lower.bottom() - HEAD - steps;
        let place = lower.with_min_y(top - BORDER).with_max_y(top);
        if open == [true, true] {
            self.border(Edge { border: Border::Steps, place, now: [0.0, steps / room], extent: [1.0, room] });
        } else {
            self.backdrop.fill(place, theme::DEEP);
        }
        (lower.with_max_y(top - BORDER), lower.with_min_y(top))
    }
}

fn side(panel: Panel, width: f32) -> Panel {
    // Our own borders are dragged.
    panel.resizable(false).show_separator_line(false).exact_size(width).frame(Frame::new())
}

/// Where the height that sections would like is remembered for the next frame.
fn natural(border: Border) -> Id {
    Id::unique(("natural height", border))
}

/// The sections of a column, scrolled where they have no room.
fn sections(ui: &mut Ui, border: Border, place: Rect, body: impl FnOnce(&mut Ui)) {
    let inner = Rect::from_min_max(place.min + vec2(MARGIN, TOP), pos2(place.right(), place.bottom()));
    let mut upper = ui.new_child(UiBuilder::new().id_salt("sections").max_rect(inner));
    upper.shrink_clip_rect(place);
    let shown = ScrollArea::vertical().id_salt("sections").auto_shrink([false, false]).show(&mut upper, |ui| {
        let width = ui.available_width() - BAR;
        ui.set_max_width(width);
        body(ui);
    });
    let height = shown.content_size.y + TOP;
    let before = ui.data_mut(|d| std::mem::replace(d.get_temp_mut_or(natural(border), 0.0), height));
    if (before - height).abs() > 0.5 {
        ui.ctx().request_repaint();
    }
}

/// A list with its heading, which leaves `beside` free at its end, in a place of its own; `body` gets the height of the list.
fn listed(ui: &mut Ui, place: Rect, heads: (&str, Option<&str>), beside: f32, body: impl FnOnce(&mut Ui, f32)) {
    let inner = Rect::from_min_max(place.min + vec2(MARGIN, HEAD_TOP), place.max - vec2(BAR, 6.0));
    let mut lower = ui.new_child(UiBuilder::new().id_salt(heads.0).max_rect(inner));
    lower.shrink_clip_rect(place);
    let mut head = lower.new_child(UiBuilder::new().id_salt("heading").max_rect(inner));
    head.set_max_width(inner.width() - beside);
    let open = list_heading(&mut head, heads);
    lower.advance_cursor_after_rect(head.min_rect());
    if open {
        let height = (inner.bottom() - lower.cursor().top()).max(0.0);
        body(&mut lower, height);
    }
}
