//! The browser's list as it is drawn: what a folder holds, with size and date, sorted by a click on a column.

use crate::interact::readout::bytes;
use crate::ui::browse::listing::{By, Entry, Kind, Order, Reading};
use crate::ui::browse::names::{date, shown};
use crate::ui::browse::{Asks, Browser};
use crate::ui::style::icons;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use crate::ui::style::widgets::{cut_text, tipped};
use egui::{Align2, Color32, Key, Response, RichText, Role, ScrollArea, Sense, TextStyle, Ui, WidgetInfo, vec2};
use std::path::PathBuf;
use std::time::SystemTime;

/// Widths of the columns for size and date.
const COLUMNS: [f32; 2] = [76.0, 104.0];

/// The list; answers the path that was taken by a double click.
pub(super) fn list(ui: &mut Ui, browser: &mut Browser, height: f32) -> Option<PathBuf> {
    heads(ui, browser);
    let moved = browser.take_moved();
    let chosen = browser.row();
    let now = SystemTime::now();
    let (mut clicked, mut taken) = (None, false);
    ui.spacing_mut().item_spacing.y = 0.0;
    let mut area = ScrollArea::vertical().id_salt(("list", browser.folder())).auto_shrink([false, false]);
    area = area.max_height(height - ROW);
    if let Some(row) = chosen.filter(|_| moved) {
        // Near the middle, so that what is before and behind it is seen.
        area = area.vertical_scroll_offset((row as f32 * ROW - height * 0.4).max(0.0));
    }
    area.show_rows(ui, ROW, browser.len().max(1), |ui, rows| {
        if browser.is_empty() {
            let text = match browser.reading() {
                Reading::On => "Reading…",
                Reading::Failed(_) => "",
                _ if browser.purpose().asks == Asks::SaveFolder => "No folder is in here.",
                _ if browser.shows().0 => "This folder is empty.",
                _ if browser.purpose().asks == Asks::Open => {
                    "Nothing here that can be opened. “All files” shows the rest."
                }
                _ => "No file of this kind is here yet.",
            };
            ui.label(RichText::new(text).color(theme::TEXT_WEAK));
            return;
        }
        for row in rows {
            let Some(entry) = browser.entry(row) else { continue };
            let tip = shown(browser.folder().join(&entry.name).as_os_str());
            let response = tipped(one_entry(ui, entry, chosen == Some(row), now), &tip);
            if response.clicked() {
                clicked = Some(row);
                // A row that was reached by Tab.
                taken |= ui.input(|i| i.key_pressed(Key::Enter));
            }
            taken |= response.double_clicked();
        }
    });
    if *browser.reading() == Reading::Cut {
        ui.label(RichText::new("There is more in this folder; type the name.").color(theme::TEXT_WEAK));
    }
    if let Some(row) = clicked {
        browser.choose(row);
        // It was clicked where it lies.
        browser.take_moved();
    }
    if taken { browser.activate() } else { None }
}

fn heads(ui: &mut Ui, browser: &mut Browser) {
    let width = ui.available_width() - 12.0;
    let widths = [width - COLUMNS[0] - COLUMNS[1], COLUMNS[0], COLUMNS[1]];
    ui.spacing_mut().item_spacing = vec2(0.0, 0.0);
    ui.horizontal(|ui| {
        for (i, (by, name)) in [(By::Name, "Name"), (By::Size, "Size"), (By::Date, "Changed")].into_iter().enumerate() {
            let (rect, response) = ui.allocate_exact_size(vec2(widths[i], ROW), Sense::click());
            response
                .widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Sort by {}", name.to_lowercase())));
            let colour = if response.hovered() || response.has_focus() { Color32::WHITE } else { theme::TEXT_WEAK };
            let (at, align) = match by {
                By::Size => (rect.right_center() - vec2(10.0, 0.0), Align2::RIGHT_CENTER),
                _ => (rect.left_center() + vec2(if i == 0 { 24.0 } else { 4.0 }, 0.0), Align2::LEFT_CENTER),
            };
            let drawn = ui.painter().text(at, align, name, TextStyle::Small.resolve(ui.style()), colour);
            let now = browser.order();
            if now.by == by {
                // A small wedge: broad where the larger ones are.
                let beside = if by == By::Size {
                    drawn.left_center() - vec2(8.0, 0.0)
                } else {
                    drawn.right_center() + vec2(8.0, 0.0)
                };
                let up = if now.falling { 3.0 } else { -3.0 };
                let points = [vec2(-4.0, -up), vec2(4.0, -up), vec2(0.0, up)].map(|v| beside + v * 0.8).to_vec();
                ui.painter().add(egui::Shape::convex_polygon(points, colour, egui::Stroke::NONE));
            }
            if tipped(response, "Sorts the list; once more, the other way round").clicked() {
                browser.sort(Order::by(by));
            }
        }
    });
}

fn one_entry(ui: &mut Ui, entry: &Entry, on: bool, now: SystemTime) -> Response {
    let (icon, kind) = match entry.kind {
        Kind::Folder => (Icon::Folder, "Folder"),
        Kind::Project => (Icon::Project, "Project"),
        Kind::File => (Icon::File, "File"),
    };
    let name = shown(&entry.name);
    let response = entry_row(ui, on, &format!("{kind} {name}"));
    paint_name(ui, &response, icon, &name, COLUMNS[0] + COLUMNS[1] + 12.0);
    let rect = response.rect;
    let font = TextStyle::Small.resolve(ui.style());
    let right = rect.right() - 12.0;
    if entry.kind == Kind::File {
        let at = egui::pos2(right - COLUMNS[1] - 10.0, rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, bytes(entry.bytes), font.clone(), theme::TEXT_WEAK);
    }
    if let Some(changed) = entry.changed {
        let at = egui::pos2(right - COLUMNS[1] + 4.0, rect.center().y);
        ui.painter().text(at, Align2::LEFT_CENTER, date(changed, now), font, theme::TEXT_WEAK);
    }
    response
}

/// A row that is clicked, with its ground.
pub(super) fn entry_row(ui: &mut Ui, on: bool, name: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::ListItem, true, on, name));
    let fill = match (on, response.hovered() || response.has_focus()) {
        (true, _) => theme::ACCENT_FILL,
        (false, true) => theme::CONTROL,
        (false, false) => Color32::TRANSPARENT,
    };
    ui.painter().rect_filled(rect, theme::ROUND, fill);
    response
}

/// An icon and a name that is cut where the row ends.
pub(super) fn paint_name(ui: &Ui, row: &Response, icon: Icon, name: &str, right: f32) {
    let rect = row.rect;
    let square = egui::Rect::from_center_size(rect.left_center() + vec2(12.0, 0.0), vec2(16.0, 16.0));
    icons::paint(ui.painter(), square, icon, theme::TEXT_WEAK);
    let font = TextStyle::Body.resolve(ui.style());
    let text = cut_text(ui, name, font, theme::TEXT, (rect.width() - 28.0 - right).max(20.0));
    let at = rect.left_center() + vec2(24.0, -text.size().y * 0.5);
    ui.painter().galley(at, text, theme::TEXT);
}
