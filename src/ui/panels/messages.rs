//! What was done and what went wrong: a short word over the views that goes by itself, and the list that keeps it.
//!
//! A message about a command that failed goes when the same command has worked. Nothing here lies over a control.

use crate::io::without_numbers;
use crate::ui::browse::names::shown;
use crate::ui::state::message::Message;
use crate::ui::state::message::Toast;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::widgets::{Face, from_right, icon_button};
use crate::ui::thread::session::Severity;
use crate::ui::window::app::App;
use egui::{Align2, Area, Context, Frame, Id, Margin, Order, Panel, Rect, RichText, ScrollArea, Ui, pos2};
use std::path::{Path, PathBuf};

/// Seconds that a word over the views stays; a warning takes longer to read.
const STAYS: f64 = 8.0;
const WARNING_STAYS: f64 = 15.0;
/// Width of the ways to what was written, points.
const WAYS: f32 = 190.0;
/// Words at once.
const WORDS: usize = 3;
/// Messages that are kept: a program that fails in a loop must not fill the memory with its complaints.
const MOST: usize = 200;

const fn colour(severity: Severity) -> egui::Color32 {
    match severity {
        Severity::Note => theme::TEXT_WEAK,
        Severity::Warning => theme::WARNING,
        Severity::Error => theme::ERROR,
    }
}

impl App {
    /// Adds to the list of messages; errors open it, warnings are shown over the views.
    pub(crate) fn say(&mut self, severity: Severity, text: String) {
        let message = Message { severity, text: in_one_line(&text), path: None, topic: None };
        if severity == Severity::Warning {
            self.word(message.clone());
        }
        self.add_message(message);
    }

    fn word(&mut self, message: Message) {
        self.toasts.retain(|toast| toast.message != message);
        self.toasts.push(Toast { message, until: None });
        if self.toasts.len() > WORDS {
            self.toasts.remove(0);
        }
    }

    /// The gravest message of the list.
    pub(crate) fn gravest(&self) -> Option<Severity> {
        self.messages.iter().map(|m| m.severity).max_by_key(|severity| *severity as u8)
    }

    /// An error that goes when what failed has worked.
    pub(crate) fn complain(&mut self, topic: &str, text: String) {
        self.add_message(Message { severity: Severity::Error, text, path: None, topic: Some(topic.into()) });
    }

    /// A warning that goes when something is done.
    pub(crate) fn warn_until(&mut self, topic: &str, text: String) {
        self.add_message(Message { severity: Severity::Warning, text, path: None, topic: Some(topic.into()) });
    }

    /// A short word about what was written, with a way to it.
    pub(crate) fn confirm(&mut self, text: String, path: Option<PathBuf>) {
        let message = Message { severity: Severity::Note, text, path, topic: None };
        self.word(message.clone());
        self.add_message(message);
    }

    fn add_message(&mut self, message: Message) {
        let message = Message { text: in_one_line(&message.text), ..message };
        // The same again is no news, but it is the last one now.
        self.messages.retain(|m| m.text != message.text || m.path != message.path);
        self.messages_open |= message.severity == Severity::Error;
        self.messages.push(message);
        if self.messages.len() > MOST {
            self.messages.remove(0);
        }
    }

    /// What failed has worked: complaints about it are gone.
    pub(crate) fn mended(&mut self, topic: &str) {
        self.messages.retain(|m| m.topic.as_deref() != Some(topic));
        self.messages_open &= !self.messages.is_empty();
    }

    /// Another document is open: complaints about commands on the last one are gone.
    pub(crate) fn all_mended(&mut self) {
        self.messages.retain(|m| m.topic.is_none() || m.severity != Severity::Error);
        self.messages_open &= !self.messages.is_empty();
    }

    pub(crate) fn message_list(&mut self, ui: &mut Ui) {
        if !self.messages_open || self.messages.is_empty() {
            return;
        }
        let (mut dismissed, mut show) = (None, None);
        let frame = Frame::new().inner_margin(Margin::symmetric(10, 6));
        let list = Panel::bottom("messages").frame(frame).max_size(180.0).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new(format!("Messages ({})", self.messages.len())).color(theme::TEXT));
                from_right(ui, |ui| {
                    if ui.button("Dismiss all").on_hover_text("Empties this list").clicked() {
                        dismissed = Some(None);
                    }
                    let tip = "The button with the sign at the top right brings the list back";
                    if ui.button("Hide").accessible_name("Hide messages").on_hover_text(tip).clicked() {
                        self.messages_open = false;
                    }
                });
            });
            ScrollArea::vertical().id_salt("messages").max_height(120.0).auto_shrink([false, true]).show(ui, |ui| {
                for (i, message) in self.messages.iter().enumerate().rev() {
                    ui.horizontal(|ui| {
                        let name = format!("Dismiss message {}", i + 1);
                        if icon_button(ui, Face::small(Icon::Close, &name, "Dismiss")).clicked() {
                            dismissed = Some(Some(i));
                        }
                        let about = format!("message {}", i + 1);
                        let text = RichText::new(&message.text).color(colour(message.severity));
                        match message.path.as_deref() {
                            Some(path) => {
                                let room = (ui.available_width() - WAYS).max(120.0);
                                ui.scope(|ui| {
                                    ui.set_max_width(room);
                                    ui.add(egui::Label::new(text).wrap());
                                });
                                show = ways(ui, path, &about).or(show.take());
                            }
                            None => drop(ui.add(egui::Label::new(text).wrap())),
                        }
                    });
                }
            });
        });
        self.backdrop.fill(list.response.rect, theme::BAR);
        match dismissed {
            Some(Some(i)) => {
                self.messages.remove(i);
            }
            Some(None) => self.messages.clear(),
            None => {}
        }
        // What comes next opens the list itself if it is grave enough.
        self.messages_open &= !self.messages.is_empty();
        if let Some(way) = show {
            self.go_way(ui.ctx(), way);
        }
    }

    /// Words over the views, in the middle of their lower edge, where no control is; the last one lowest.
    pub(crate) fn show_words(&mut self, ctx: &Context, views: Rect) {
        let now = ctx.input(|i| i.time);
        // Not over a question; they are shown for their time afterwards.
        if self.dialog.is_some() {
            self.toasts.iter_mut().for_each(|toast| toast.until = None);
            return;
        }
        // The open list says them already.
        if self.messages_open && !self.messages.is_empty() {
            self.toasts.clear();
            return;
        }
        let mut way = None;
        let mut bottom = views.bottom() - 12.0;
        let mut toasts = std::mem::take(&mut self.toasts);
        for (i, toast) in toasts.iter_mut().rev().enumerate() {
            let stays = if toast.message.severity == Severity::Warning { WARNING_STAYS } else { STAYS };
            let until = *toast.until.get_or_insert(now + stays);
            let at = pos2(views.center().x, bottom);
            let area = Area::new(Id::unique(("word", &toast.message.text)))
                .order(Order::Foreground)
                .pivot(Align2::CENTER_BOTTOM)
                .fixed_pos(at);
            let shown = area.show(ctx, |ui| {
                ui.set_max_width(views.width() - 48.0);
                Frame::popup(ui.style())
                    .inner_margin(Margin::symmetric(12, 8))
                    .show(ui, |ui| word(ui, &toast.message, i))
            });
            bottom = shown.response.rect.top() - 6.0;
            let (chosen, close) = shown.inner.inner;
            if close || chosen.is_some() {
                toast.until = Some(now);
            } else if shown.response.contains_pointer() {
                // Not while it is read.
                toast.until = Some(until.max(now + STAYS * 0.5));
            }
            way = way.or(chosen);
        }
        toasts.retain(|toast| toast.until.is_none_or(|until| until > now));
        if let Some(next) = toasts.iter().filter_map(|toast| toast.until).reduce(f64::min) {
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(next - now));
        }
        self.toasts = toasts;
        if let Some(way) = way {
            self.go_way(ctx, way);
        }
    }

    fn go_way(&mut self, ctx: &Context, way: Way) {
        let path = match way {
            Way::Copy(path) => path,
            Way::Folder(path) => {
                if show_in_folder(&path) {
                    return;
                }
                self.say(Severity::Warning, "No file manager answered; the path was copied instead.".into());
                path
            }
        };
        ctx.copy_text(path.to_string_lossy().into_owned());
    }
}

/// One of them: what it says, the ways to what was written, and how to close it.
fn word(ui: &mut Ui, message: &Message, number: usize) -> (Option<Way>, bool) {
    ui.horizontal(|ui| {
        let text_colour = if message.severity == Severity::Note { theme::TEXT } else { colour(message.severity) };
        let room = ui.available_width() - if message.path.is_some() { WAYS + 30.0 } else { 40.0 };
        ui.scope(|ui| {
            ui.set_max_width(room.max(120.0));
            ui.add(egui::Label::new(RichText::new(&message.text).color(text_colour)).wrap());
        });
        ui.add_space(8.0);
        let (about, name) = match number {
            0 => ("what was written".to_owned(), "Close this word".to_owned()),
            n => (format!("what was written, {}", n + 1), format!("Close word {}", n + 1)),
        };
        let way = message.path.as_deref().and_then(|path| ways(ui, path, &about));
        (way, icon_button(ui, Face::small(Icon::Close, &name, "Close; the list of messages keeps it")).clicked())
    })
    .inner
}

enum Way {
    Folder(PathBuf),
    Copy(PathBuf),
}

/// How to get to a file.
fn ways(ui: &mut Ui, path: &Path, about: &str) -> Option<Way> {
    let full = shown(path.as_os_str());
    let folder = ui.small_button("Show in folder").accessible_name(format!("Show {about} in its folder"));
    let copy = ui.small_button("Copy path").accessible_name(format!("Copy the path of {about}"));
    if folder.on_hover_text(&full).clicked() {
        Some(Way::Folder(path.into()))
    } else {
        copy.on_hover_text(full).clicked().then(|| Way::Copy(path.into()))
    }
}

/// Without the system's numbers, and without what a name may hold to break a line.
fn in_one_line(text: &str) -> String {
    shown(without_numbers(text).as_ref())
}

/// Asks the system's file manager; `false` if there is none.
fn show_in_folder(path: &Path) -> bool {
    let mut command = if cfg!(target_os = "windows") {
        let mut explorer = std::process::Command::new("explorer");
        explorer.arg("/select,").arg(path);
        explorer
    } else if cfg!(target_os = "macos") {
        let mut finder = std::process::Command::new("open");
        finder.arg("-R").arg(path);
        finder
    } else {
        let mut manager = std::process::Command::new("xdg-open");
        manager.arg(path.parent().unwrap_or(path));
        manager
    };
    let quiet = command.stdin(std::process::Stdio::null()).stdout(std::process::Stdio::null());
    match quiet.stderr(std::process::Stdio::null()).spawn() {
        Ok(mut child) => {
            // Waited for, so that nothing of it is left behind; the window goes on.
            let waits = std::thread::Builder::new().name("file manager".into()).spawn(move || drop(child.wait()));
            waits.is_ok()
        }
        Err(_) => false,
    }
}
