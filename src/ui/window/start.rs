//! What the window shows while nothing is open: how to open something, what was open lately, a sample, the first three steps.

use crate::document::OpenAs;
use crate::ui::browse::names::{date, shown};
use crate::ui::state::path_purpose::{PathPurpose, formats};
use crate::ui::state::recent::Seen;
use crate::ui::state::sample::Sample;
use crate::ui::state::saving::OpenTarget;
use crate::ui::style::icons;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, ROW};
use crate::ui::style::widgets::primary;
use crate::ui::style::widgets::{Face, cut_text, from_right_row, icon_button, spinner};
use crate::ui::window::app::App;
use egui::{
    Align, Color32, Layout, Rect, RichText, Role, ScrollArea, Sense, TextStyle, Ui, UiBuilder, WidgetInfo, vec2,
};
use std::path::Path;
use std::time::SystemTime;

/// How a selection comes to be seen, in three steps.
const STEPS: [(&str, &str); 3] = [
    ("Select", "Press B and paint over what you want to see, on a slice or in 3D."),
    ("Split", "Press X and click in the 3D view: each click cuts a part in two."),
    ("Slide", "Pull “Degree” under Explosion to the right: the parts move out of the way."),
];

impl App {
    pub(crate) fn start_page(&mut self, ui: &mut Ui) {
        if self.busy.is_some() {
            self.opening(ui);
            return;
        }
        if !self.recent_looked {
            self.recent_looked = true;
            self.recent.look(self.wake());
        }
        let all = ui.max_rect();
        let width = (all.width() - 48.0).min(860.0);
        let height = (all.height() - 32.0).min(470.0);
        let rect = Rect::from_center_size(all.center(), vec2(width, height));
        let column = ((width - 40.0) * 0.5).floor();
        ui.scope_builder(UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Min)), |ui| {
            ui.allocate_ui_with_layout(vec2(column, height), Layout::top_down(Align::Min), |ui| {
                ui.set_width(column);
                self.ways_in(ui);
            });
            ui.add_space(40.0 - ui.spacing().item_spacing.x * 2.0);
            ui.allocate_ui_with_layout(vec2(column, height), Layout::top_down(Align::Min), |ui| {
                ui.set_width(column);
                self.seen_lately(ui, height);
            });
        });
    }

    /// While it opens.
    fn opening(&mut self, ui: &mut Ui) {
        let Some(busy) = self.busy.clone() else { return };
        let width = 420.0;
        let rect = Rect::from_center_size(ui.max_rect().center(), vec2(width, 120.0));
        ui.scope_builder(UiBuilder::new().max_rect(rect).layout(Layout::top_down(Align::Center)), |ui| {
            ui.label(RichText::new("One moment").size(20.0).color(theme::TEXT));
            ui.add_space(8.0);
            ui.label(RichText::new(&busy.what).color(theme::TEXT_WEAK));
            ui.add_space(16.0);
            match busy.percent {
                Some(percent) => {
                    let bar = egui::ProgressBar::new(percent as f32 / 100.0).desired_width(width * 0.5);
                    ui.add(bar.desired_height(6.0).fill(theme::ACCENT));
                }
                None => spinner(ui, 24.0),
            }
        });
    }

    fn ways_in(&mut self, ui: &mut Ui) {
        ui.label(RichText::new("Open a volume to begin").size(20.0).color(theme::TEXT));
        ui.add_space(4.0);
        let formats = format!("{}, or a Burin project. A file can also be dropped here.", formats());
        ui.add(egui::Label::new(RichText::new(formats).color(theme::TEXT_WEAK)).wrap());
        ui.add_space(12.0);
        ui.horizontal(|ui| {
            if ui.add(primary("Open…")).on_hover_text("A volume or a project (Ctrl + O)").clicked() {
                self.ask(PathPurpose::Open);
            }
            let add = egui::Button::new("Add a volume…").min_size(vec2(110.0, 30.0));
            let tip = "To the document from which all volumes were taken away; Ctrl + Z brings the last one back";
            if self.has_document() && ui.add(add).on_hover_text(tip).clicked() {
                self.ask(PathPurpose::Add);
            }
            let sample = egui::Button::new("Open the sample head").min_size(vec2(150.0, 30.0));
            let tip = "An MRI scan of a head that comes with the program, to try things on";
            if self.recent.folder().is_some() && ui.add(sample).on_hover_text(tip).clicked() {
                self.open_sample();
            }
        });
        ui.add_space(28.0);
        ui.label(RichText::new("Three first steps").size(15.0).color(theme::TEXT));
        for (i, (name, what)) in STEPS.iter().enumerate() {
            ui.add_space(10.0);
            ui.horizontal_top(|ui| {
                let (rect, _) = ui.allocate_exact_size(vec2(22.0, 22.0), Sense::hover());
                ui.painter().circle_filled(rect.center(), 11.0, theme::ACCENT_FILL);
                let font = egui::FontId::proportional(12.0);
                ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, i + 1, font, Color32::WHITE);
                ui.add_space(GAP);
                ui.vertical(|ui| {
                    ui.label(RichText::new(*name).color(theme::TEXT));
                    ui.add(egui::Label::new(RichText::new(*what).color(theme::TEXT_WEAK)).wrap());
                });
            });
        }
    }

    /// Lays the sample where it can be opened, and opens it.
    pub(crate) fn open_sample(&mut self) {
        let Some(sample) = self.recent.folder().map(Sample::below) else { return };
        match sample.lay() {
            Ok(()) => self.open_guarded(OpenTarget::Path(sample.head)),
            Err(error) => self.complain("volume.open", error),
        }
    }

    fn seen_lately(&mut self, ui: &mut Ui, height: f32) {
        let entries = self.recent.entries().to_vec();
        from_right_row(ui, |ui| {
            if !entries.is_empty() {
                let clear = egui::Button::new(RichText::new("Forget all").small()).frame_when_inactive(false);
                let tip = "Empties this list; the files stay where they are";
                if ui.add(clear).accessible_name("Forget all recent files").on_hover_text(tip).clicked() {
                    self.recent.forget_all();
                }
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.label(RichText::new("Recent").size(15.0).color(theme::TEXT));
            });
        });
        if entries.is_empty() {
            ui.label(RichText::new("What you open and save will be listed here.").color(theme::TEXT_WEAK));
            return;
        }
        let (mut open, mut forget) = (None, None);
        let now = SystemTime::now();
        ScrollArea::vertical().id_salt("recent").max_height(height - 40.0).auto_shrink([false, true]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            for (i, seen) in entries.iter().enumerate() {
                let gone = self.recent.is_gone(&seen.path);
                let mut when = date(seen.when, now);
                if let Some(meaning) = seen.open_as.and_then(meant) {
                    when = format!("{when} · {meaning}");
                }
                match recent_row(ui, i + 1, &seen.path, seen.project, gone, &when) {
                    Some(Row::Open) => open = Some(seen.clone()),
                    Some(Row::Forget) => forget = Some(seen.path.clone()),
                    None => {}
                }
            }
        });
        if let Some(path) = forget {
            self.recent.forget(&path);
        }
        match open {
            // What it means was said when it was opened first.
            Some(Seen { path, project: false, open_as: Some(open_as), .. }) => {
                self.open_guarded(OpenTarget::Volume(path, open_as));
            }
            Some(seen) => self.open_asked(seen.path),
            None => {}
        }
    }
}

/// What a volume was opened as, where that is not what it is usually.
fn meant(open_as: OpenAs) -> Option<&'static str> {
    match open_as {
        OpenAs::Image => None,
        OpenAs::Labels => Some("as labels"),
        OpenAs::Selection => Some("as selection"),
    }
}

enum Row {
    Open,
    Forget,
}

/// A name over the folder that it lies in; one that is gone is weak and says so.
fn recent_row(ui: &mut Ui, number: usize, path: &Path, project: bool, gone: bool, when: &str) -> Option<Row> {
    let full = shown(path.as_os_str());
    let name = path.file_name().map_or_else(|| full.clone(), shown);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width() - 12.0, ROW * 2.0 - 6.0), Sense::click());
    let said = format!("Recent {number}: {name}{}", if gone { ", not found" } else { "" });
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, said.clone()));
    let fill = if response.hovered() || response.has_focus() { theme::PANEL } else { Color32::TRANSPARENT };
    ui.painter().rect_filled(rect, theme::ROUND, fill);
    let square = Rect::from_center_size(rect.left_center() + vec2(16.0, 0.0), vec2(16.0, 16.0));
    let icon = if project { Icon::Project } else { Icon::File };
    icons::paint(ui.painter(), square, icon, theme::TEXT_WEAK);
    let folder = path.parent().map_or_else(String::new, |p| shown(p.as_os_str()));
    let under = if gone { format!("Not found · {folder}") } else { format!("{when} · {folder}") };
    let colour = if gone { theme::TEXT_WEAK } else { theme::TEXT };
    let small = TextStyle::Small.resolve(ui.style());
    let room = rect.width() - 72.0;
    let lines =
        [(name.as_str(), TextStyle::Body.resolve(ui.style()), colour, 4.0), (&under, small, theme::TEXT_WEAK, 22.0)];
    for (text, font, colour, y) in lines {
        let text = cut_text(ui, text, font, colour, room);
        ui.painter().galley(rect.min + vec2(34.0, y), text, colour);
    }
    let corner = Rect::from_center_size(rect.right_center() - vec2(18.0, 0.0), vec2(ROW - 2.0, ROW - 2.0));
    let mut end = ui.new_child(UiBuilder::new().max_rect(corner).layout(Layout::left_to_right(Align::Center)));
    let away = format!("Forget recent {number}");
    if icon_button(&mut end, Face::small(Icon::Close, &away, "Takes it out of this list; the file stays")).clicked() {
        return Some(Row::Forget);
    }
    let response = response.on_hover_text(&full);
    response.clicked().then_some(Row::Open)
}
