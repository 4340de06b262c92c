//! The file browser as it is drawn: places, the list, the field that takes names and paths. What it does is `ui::browse`.

use crate::ui::browse::listing::Reading;
use crate::ui::browse::names::shown;
use crate::ui::browse::places::Place;
use crate::ui::browse::{Asks, Browser};
use crate::ui::dialogs::browser_list::{entry_row, list, paint_name};
use crate::ui::state::dialog::{Browse, Dialog};
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::GAP;
use crate::ui::style::widgets::{Face, from_right_row, icon_button, tipped};
use crate::ui::style::widgets::{cancel, plain, primary};
use crate::ui::window::app::App;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Button, Color32, Event, Id, Key, Modifiers, RichText, ScrollArea, TextEdit, TextStyle, Ui, vec2};
use std::path::PathBuf;

/// Rows that Page up and Page down move by.
const PAGE: isize = 10;
/// Width of the places.
const PLACES: f32 = 152.0;
impl App {
    pub(super) fn browser_dialog(&mut self, ui: &mut Ui, mut browse: Box<Browse>) -> Option<Dialog> {
        let Browse { what, browser, places, held } = browse.as_mut();
        browser.poll();
        let field = Id::unique("browsed path");
        hold_back(ui, held);
        let mut answer = keys(ui, browser, field);
        ui.heading(what.title());
        ui.label(RichText::new(what.hint()).color(theme::TEXT_WEAK));
        ui.add_space(8.0);
        way(ui, browser);
        ui.add_space(GAP);
        let height = (ui.ctx().viewport_rect().height() - 380.0).clamp(110.0, 340.0);
        ui.allocate_ui_with_layout(
            vec2(ui.available_width(), height),
            egui::Layout::left_to_right(egui::Align::Min),
            |ui| {
                go_to(ui, browser, places, height);
                ui.add_space(8.0);
                ui.vertical(|ui| answer = answer.take().or_else(|| list(ui, browser, height)));
            },
        );
        ui.add_space(6.0);
        let cannot = browser.error().map(str::to_owned).or_else(|| match browser.reading() {
            Reading::Failed(why) => Some(why.clone()),
            _ => None,
        });
        // Its line is always there, so that nothing moves when something is wrong.
        let said = cannot.as_deref().unwrap_or(" ");
        ui.add(egui::Label::new(RichText::new(said).color(theme::ERROR)).wrap());
        if let Some(replaced) = browser.replaces().map(|p| shown(p.file_name().unwrap_or_default())) {
            return match replace_question(ui, &replaced) {
                Some(true) => {
                    let path = browser.replace();
                    self.browsed(browse, path)
                }
                Some(false) => {
                    browser.back_out();
                    Some(Dialog::Browse(browse))
                }
                None => Some(Dialog::Browse(browse)),
            };
        }
        path_field(ui, browser, field);
        ui.add_space(10.0);
        let (mut yes, mut no) = (false, false);
        from_right_row(ui, |ui| {
            let can = browser.row().is_some() || !browser.text().trim().is_empty();
            let name = format!("{} at this path", what.title());
            let button = ui.add_enabled(can, primary(what.action())).accessible_name(name);
            yes = tipped(button, "Takes what is typed or chosen above (Enter)").clicked();
            no = cancel(ui);
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| kinds(ui, browser));
        });
        if no {
            return None;
        }
        if yes {
            answer = answer.or_else(|| browser.enter());
        }
        self.browsed(browse, answer)
    }

    fn browsed(&mut self, browse: Box<Browse>, path: Option<PathBuf>) -> Option<Dialog> {
        match path {
            Some(path) => {
                self.choose_by(browse, path);
                None
            }
            None => Some(Dialog::Browse(browse)),
        }
    }
}

/// In a slow frame Enter may come together with the text before it: the field takes its text first, the key waits a frame.
fn hold_back(ui: &Ui, held: &mut Vec<Event>) {
    let moves = [Key::Enter, Key::ArrowUp, Key::ArrowDown, Key::PageUp, Key::PageDown];
    ui.input_mut(|i| {
        i.events.splice(0..0, held.drain(..));
        let mut typed = false;
        let cut = i.events.iter().position(|event| {
            typed |= matches!(event, Event::Text(_) | Event::Paste(_));
            typed && matches!(event, Event::Key { key, pressed: true, .. } if moves.contains(key))
        });
        if let Some(cut) = cut {
            *held = i.events.split_off(cut);
        }
    });
    if !held.is_empty() {
        ui.ctx().request_repaint();
    }
}

/// The keys that move through folders, while the field has the keyboard.
fn keys(ui: &Ui, browser: &mut Browser, field: Id) -> Option<PathBuf> {
    let focused = ui.memory(|m| m.focused());
    if focused.is_some_and(|id| id != field) || browser.replaces().is_some() {
        return None;
    }
    let empty = browser.text().is_empty();
    let (alt, ctrl, none) = (Modifiers::ALT, Modifiers::COMMAND, Modifiers::NONE);
    let (up, hidden, refresh, rows, enter) = ui.input_mut(|i| {
        let up = i.consume_key(alt, Key::ArrowUp) || (empty && i.consume_key(none, Key::Backspace));
        let mut rows = 0;
        for (key, step) in [(Key::ArrowDown, 1), (Key::ArrowUp, -1), (Key::PageDown, PAGE), (Key::PageUp, -PAGE)] {
            rows += step * i.count_and_consume_key(none, key) as isize;
        }
        let (hidden, refresh) = (i.consume_key(ctrl, Key::H), i.consume_key(none, Key::F5));
        (up, hidden, refresh, rows, i.consume_key(none, Key::Enter))
    });
    if up {
        browser.up();
    }
    if hidden {
        let (all, hidden) = browser.shows();
        browser.show(all, !hidden);
    }
    if refresh {
        browser.refresh();
    }
    if rows != 0 {
        browser.step(rows);
    }
    if enter { browser.enter() } else { None }
}

/// Where the folder lies: each folder on the way can be clicked.
fn way(ui: &mut Ui, browser: &mut Browser) {
    let mut go = None;
    let mut make = false;
    from_right_row(ui, |ui| {
        if browser.purpose().asks != Asks::Open {
            let new = ui.add_enabled(browser.new_folder().is_none(), plain("New folder"));
            make = new.on_hover_text("Makes a folder in the one that is shown").clicked();
            ui.add_space(8.0);
        }
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            let above = browser.folder().parent().is_some();
            let face = Face::small(Icon::Up, "Folder above", "The folder above (Alt + Up)");
            if ui.add_enabled_ui(above, |ui| icon_button(ui, face).clicked()).inner {
                go = browser.folder().parent().map(PathBuf::from);
            }
            ui.add_space(GAP);
            let font = TextStyle::Button.resolve(ui.style());
            let width =
                |text: &str| ui.painter().layout_no_wrap(text.into(), font.clone(), Color32::WHITE).size().x + 24.0;
            let mut room = ui.available_width() - 24.0;
            let mut steps = Vec::new();
            for folder in browser.folder().ancestors() {
                let name = folder.file_name().map_or_else(|| shown(folder.as_os_str()), shown);
                room -= width(&name).min(240.0);
                if room < 0.0 && !steps.is_empty() {
                    break;
                }
                steps.push((name, folder.to_path_buf()));
            }
            for (i, (name, folder)) in steps.iter().enumerate().rev() {
                let colour = if i == 0 { theme::TEXT } else { theme::TEXT_WEAK };
                let button = Button::new(RichText::new(name).color(colour)).truncate().frame_when_inactive(false);
                let full = shown(folder.as_os_str());
                let small = ui.scope(|ui| {
                    ui.set_max_width(240.0);
                    ui.add(button).accessible_name(format!("Show {full}")).on_hover_text(&full).clicked()
                });
                if small.inner {
                    go = Some(folder.clone());
                }
                if i > 0 {
                    ui.label(RichText::new("›").color(theme::TEXT_WEAK));
                }
            }
        });
    });
    if let Some(folder) = go {
        browser.go(&folder);
    }
    if make {
        browser.name_folder(String::new());
    }
    if let Some(name) = browser.new_folder() {
        let mut name = name.to_owned();
        let (mut done, mut stop) = (false, false);
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut name).hint_text("Name of the new folder").desired_width(260.0);
            let response = ui.add(field).accessible_name("Name of the new folder");
            let response = tipped(response, "It is made in the folder that is shown (Enter)");
            if make {
                response.request_focus();
            }
            done = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            let made = ui.add(plain("Make")).accessible_name("Make the folder");
            done |= tipped(made, "Makes the folder and goes there").clicked();
            let left = ui.add(plain("Leave")).accessible_name("Make no folder");
            stop = tipped(left, "Makes none (Esc)").clicked();
        });
        browser.name_folder(name);
        if stop {
            browser.back_out();
        } else if done {
            browser.make_folder();
        }
    }
}

fn go_to(ui: &mut Ui, browser: &mut Browser, places: &[Place], height: f32) {
    ui.allocate_ui_with_layout(vec2(PLACES, height), egui::Layout::top_down(egui::Align::Min), |ui| {
        ui.set_width(PLACES);
        ScrollArea::vertical().id_salt("places").auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let mut lately = false;
            for place in places {
                if place.recent && !lately {
                    ui.add_space(8.0);
                    ui.label(RichText::new("Used lately").small().color(theme::TEXT_WEAK));
                    lately = true;
                }
                let icon = if place.recent { Icon::Recent } else { Icon::Folder };
                let name = format!("Go to {}", shown(place.path.as_os_str()));
                let here = place.path == browser.folder();
                let row = entry_row(ui, here, &name);
                paint_name(ui, &row, icon, &place.name, 0.0);
                if row.on_hover_text(shown(place.path.as_os_str())).clicked() {
                    browser.go(&place.path);
                }
            }
        });
    });
}

fn path_field(ui: &mut Ui, browser: &mut Browser, field: Id) {
    let mut text = browser.text().to_owned();
    let (label, hint) = match browser.purpose().asks {
        Asks::Open => ("File", "Type a name or a path; ~ is your home folder"),
        Asks::SaveFile | Asks::SaveFolder => ("Name", "A name, or a path; ~ is your home folder"),
    };
    ui.horizontal(|ui| {
        ui.label(RichText::new(label).color(theme::TEXT_WEAK));
        let edit = TextEdit::singleline(&mut text).id(field).desired_width(f32::INFINITY).hint_text(hint);
        let response = ui.add(edit).accessible_name("Path");
        let response = tipped(response, "Typing jumps in the list; arrows move, Enter takes, Backspace goes up");
        // Whatever has no keyboard of its own leaves it to the field.
        if ui.memory(|m| m.focused().is_none()) {
            response.request_focus();
            // The cursor is seen a frame later.
            ui.ctx().request_repaint();
            if browser.take_fresh() {
                mark_stem(ui, field, browser);
            }
        }
        if response.changed() {
            browser.type_text(text);
        }
    });
}

/// What is typed first takes the place of the name, and leaves its ending.
fn mark_stem(ui: &Ui, field: Id, browser: &Browser) {
    let (name, ending) = (browser.text(), browser.ending_offered());
    let stem = name.strip_suffix(ending).filter(|stem| !stem.is_empty()).unwrap_or(name).chars().count();
    let mut state = TextEditState::load(ui.ctx(), field).unwrap_or_default();
    let range = CCursorRange::two(CCursor::new(0), CCursor::new(stem));
    state.cursor.set_char_range(Some(range));
    state.store(ui.ctx(), field);
}

fn kinds(ui: &mut Ui, browser: &mut Browser) {
    let (was_all, was_hidden) = browser.shows();
    let (mut all, mut hidden) = (was_all, was_hidden);
    if browser.purpose().asks != Asks::SaveFolder {
        let endings = browser.purpose().endings.join(", ");
        ui.checkbox(&mut all, "All files").on_hover_text(format!("Otherwise folders and {endings}"));
        ui.add_space(8.0);
    }
    ui.checkbox(&mut hidden, "Hidden").on_hover_text("Names that begin with a dot (Ctrl + H)");
    if (all, hidden) != (was_all, was_hidden) {
        browser.show(all, hidden);
    }
}

/// Whether a file that is there may be written over.
fn replace_question(ui: &mut Ui, name: &str) -> Option<bool> {
    ui.add(egui::Label::new(format!("“{name}” is there already. Write over it?")).truncate());
    ui.add_space(10.0);
    from_right_row(ui, |ui| {
        let keep = tipped(ui.add(plain("Keep it")), "Nothing is written; another name can be typed");
        // The answer that loses nothing is the one under Enter.
        if ui.memory(|m| m.focused().is_none()) {
            keep.request_focus();
        }
        let replace = Button::new(RichText::new("Write over it").color(theme::ERROR)).min_size(vec2(120.0, 30.0));
        let replace = tipped(ui.add(replace), "What the file holds now is lost");
        match (replace.clicked(), keep.clicked()) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    })
}
