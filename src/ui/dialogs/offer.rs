//! What went wrong and can be put right: said in a sentence, with the one button that does it.

use crate::io::without_numbers;
use crate::ui::state::dialog::Dialog;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::style::theme;
use crate::ui::style::widgets::from_right_row;
use crate::ui::style::widgets::{cancel, primary};
use crate::ui::thread::session::{Offer, Then};
use crate::ui::window::app::App;
use egui::{RichText, ScrollArea, Ui};

impl App {
    pub(super) fn offer_dialog(&mut self, ui: &mut Ui, offer: Offer) -> Option<Dialog> {
        ui.heading(&offer.title);
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(200.0).show(ui, |ui| {
            ui.label(RichText::new(without_numbers(&offer.text)).color(theme::TEXT_WEAK));
        });
        ui.add_space(16.0);
        let label = match &offer.then {
            Then::Do(label, _) => label.as_str(),
            Then::FindSource(_) => "Find the file…",
        };
        let (yes, no) = from_right_row(ui, |ui| (ui.add(primary(label)).clicked(), cancel(ui)));
        match offer.then {
            Then::Do(_, command) if yes => self.send(command),
            Then::FindSource(project) if yes => self.ask(PathPurpose::Source(project)),
            then if !no => return Some(Dialog::Offer(Box::new(Offer { then, ..offer }))),
            _ => {}
        }
        None
    }
}
