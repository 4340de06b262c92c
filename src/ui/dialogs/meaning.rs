//! What the values of a file mean: asked only where they may name regions.

use crate::document::{Command, OpenAs, SegmentCommand, SelectionCommand};
use crate::ui::browse::glance::{Glance, glance};
use crate::ui::browse::names::shown;
use crate::ui::state::dialog::Chosen;
use crate::ui::state::dialog::Dialog;
use crate::ui::state::dialog::Glanced;
use crate::ui::state::dialog::Meaning;
use crate::ui::state::saving::OpenTarget;
use crate::ui::style::theme;
use crate::ui::style::widgets::cancel;
use crate::ui::style::widgets::{from_right_row, tipped};
use crate::ui::window::app::{App, Busy};
use egui::{Align, Button, Layout, RichText, Ui, vec2};
use std::path::{Path, PathBuf};

/// The answers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Means {
    New(OpenAs),
    Beside(OpenAs),
    IntoLabels,
    IntoSelection,
}

impl App {
    /// Opens what was chosen without a dialog.
    pub(crate) fn open_asked(&mut self, path: PathBuf) {
        self.parked = None;
        self.look_at(path, false);
    }

    /// Looks at a file, and opens it if there is nothing to ask; `beside` what is open, or in its place.
    pub(super) fn look_at(&mut self, path: PathBuf, beside: bool) {
        self.glances += 1;
        let number = self.glances;
        // Folders, and whatever is no file, are for the document to judge.
        let file = std::fs::metadata(&path).is_ok_and(|about| about.is_file());
        if !file || path.file_name().is_some_and(|name| name == "project.json") {
            self.take_image(path, beside);
            return;
        }
        let (back, wake, looked) = (self.chosen.0.clone(), self.wake(), path.clone());
        let started = std::thread::Builder::new().name("glance".into()).spawn(move || {
            let found = glance(&looked, &|| true);
            // Nobody there: the window was closed meanwhile.
            let _gone = back.send(Chosen::Glanced(Glanced { path: looked, found, number, beside }));
            wake();
        });
        match started {
            Ok(_) => {
                let what = format!("Looking at {}", shown(path.file_name().unwrap_or(path.as_os_str())));
                let since = self.context.input(|i| i.time);
                self.busy.get_or_insert(Busy { what, since, percent: None, stopping: false });
            }
            Err(_) => self.take_image(path, beside),
        }
    }

    /// Takes what there is nothing to ask about.
    fn take_image(&mut self, path: PathBuf, beside: bool) {
        if beside {
            self.add_volume(path, OpenAs::Image);
        } else {
            self.open_guarded(OpenTarget::Path(path));
        }
    }

    pub(super) fn glanced(&mut self, glanced: Glanced) {
        let Glanced { number, found, beside, .. } = glanced;
        self.busy.take_if(|busy| busy.what.starts_with("Looking at"));
        match &self.dialog {
            _ if number != self.glances => return,
            None => {}
            // The user looks for something else meanwhile.
            Some(Dialog::Browse(_) | Dialog::Meaning(_) | Dialog::Export(_) | Dialog::Picture(_)) => return,
            // What is asked of him is answered first.
            Some(_) => {
                self.later.push(Chosen::Glanced(glanced));
                return;
            }
        }
        match found {
            Glance::Image => self.take_image(glanced.path, beside),
            Glance::Segments | Glance::Regions => {
                let named = found == Glance::Segments;
                self.dialog = Some(Dialog::Meaning(Meaning { path: glanced.path, named, beside }));
            }
        }
    }

    pub(super) fn meaning_dialog(&mut self, ui: &mut Ui, meaning: Meaning) -> Option<Dialog> {
        let name = shown(meaning.path.file_name().unwrap_or(meaning.path.as_os_str()));
        let does = if meaning.beside { "Add" } else { "Open" };
        ui.add(egui::Label::new(RichText::new(format!("{does} {name} as…")).heading()).truncate());
        ui.add_space(4.0);
        let why = if meaning.named {
            "It is a file of segments."
        } else {
            "Its values look like those of regions: whole numbers, and 0 outside."
        };
        ui.label(RichText::new(why).color(theme::TEXT_WEAK));
        ui.add_space(10.0);
        let open = self.opened().map(|open| {
            let path = self.snapshot.place(open);
            path.file_name().map_or_else(|| "the open volume".into(), shown)
        });
        let mut answer = None;
        let mut first = true;
        let mut one = |ui: &mut Ui, means: Means, name: &str, what: &str| {
            if big_button(ui, name, what, std::mem::take(&mut first)) {
                answer = Some(means);
            }
        };
        if let (Some(open), false) = (&open, meaning.beside) {
            group(ui, &format!("Into {open}"));
            one(ui, Means::IntoLabels, "Labels of what is open", "Each region becomes a segment there");
            one(ui, Means::IntoSelection, "Selection of what is open", "Everything above 0 is selected there");
        }
        if let Some(open) = &open {
            group(ui, &format!("Beside {open}, on its own grid"));
        }
        if open.is_some() || meaning.beside {
            let labels = "Each region becomes a segment of a volume of its own";
            one(ui, Means::Beside(OpenAs::Labels), "Another volume", labels);
            one(ui, Means::Beside(OpenAs::Image), "Another volume of grey values", "As of a second scan");
        }
        if !meaning.beside {
            if open.is_some() {
                group(ui, "By itself");
            }
            let labels = "Each region becomes a segment, with its name and colour if it has one";
            one(ui, Means::New(OpenAs::Labels), "Labels", labels);
            one(ui, Means::New(OpenAs::Image), "Image", "Its values are grey values, as of a scan");
            if open.is_none() {
                one(ui, Means::New(OpenAs::Selection), "Selection", "Everything above 0 is selected");
            }
        }
        ui.add_space(10.0);
        let cancelled = from_right_row(ui, cancel);
        match answer {
            Some(means) => {
                self.open_meant(&meaning.path, means);
                None
            }
            None => (!cancelled).then_some(Dialog::Meaning(meaning)),
        }
    }

    fn open_meant(&mut self, path: &Path, means: Means) {
        match means {
            Means::New(open_as) => self.open_guarded(OpenTarget::Volume(path.into(), open_as)),
            Means::Beside(open_as) => self.add_volume(path.into(), open_as),
            Means::IntoLabels => {
                self.send(Command::Segment(SegmentCommand::Import {
                    path: path.into(),
                    component: 0,
                    frame: 0,
                    volume: None,
                }));
            }
            Means::IntoSelection => {
                let import =
                    SelectionCommand::Import { path: path.into(), threshold: 0.0, soften_mm: 0.0, volume: None };
                self.send(Command::Selection(import));
            }
        }
    }
}

fn group(ui: &mut Ui, name: &str) {
    ui.add_space(4.0);
    ui.add(egui::Label::new(RichText::new(name).color(theme::TEXT_WEAK)).truncate());
}

/// A button as wide as the question, with a line that says what it does.
fn big_button(ui: &mut Ui, name: &str, what: &str, first: bool) -> bool {
    let text = egui::WidgetText::from(RichText::new(name).color(theme::TEXT));
    let width = ui.available_width();
    let button = Button::new((text, RichText::new(what).small().color(theme::TEXT_WEAK)))
        .min_size(vec2(width, 34.0))
        .gap(12.0)
        .wrap_mode(egui::TextWrapMode::Truncate);
    let response = ui.with_layout(Layout::top_down_justified(Align::Min), |ui| ui.add(button)).inner;
    let response = tipped(response.accessible_name(format!("Open as: {name}")), what);
    if first && ui.memory(|m| m.focused().is_none()) {
        response.request_focus();
    }
    response.clicked()
}
