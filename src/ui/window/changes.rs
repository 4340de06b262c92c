//! What is one change to a person: all that happens while a control is held, or until the wheel rests, becomes one step.
//!
//! Owns where such a change begins and ends; what is changed is the caller's. Undo waits until nothing is held.

use crate::document::{Command, HistoryCommand};
use crate::ui::window::app::App;
use egui::Response;

/// Seconds after which the wheel is at rest.
const WHEEL_RESTS_S: f64 = 0.6;

impl App {
    /// Sends what a control changed. All that happens while its button is held is one step of history.
    pub(crate) fn edit(&mut self, response: &Response, command: Command) {
        let held = response.ctx.input(|i| i.pointer.any_down());
        if held && self.group != Some(response.id) {
            self.end_wheel();
            self.end_group();
            self.group = Some(response.id);
            self.send(Command::History(HistoryCommand::Begin {}));
        }
        self.send(command);
    }

    /// The same of what takes the document its time: while it works on the last one only the newest waits.
    pub(crate) fn edit_slowly(&mut self, response: &Response, command: Command) {
        if self.group == Some(response.id) && self.is_behind() {
            self.expect(&command);
            self.waiting = Some(command);
            return;
        }
        self.waiting = None;
        self.edit(response, command);
    }

    fn is_behind(&self) -> bool {
        self.snapshot.serial < self.session.serial()
    }

    /// Sends what waits once the document has caught up, or the control is at rest.
    fn send_waiting(&mut self, rests: bool) {
        if self.waiting.is_some()
            && (rests || !self.is_behind())
            && let Some(command) = self.waiting.take()
        {
            self.send(command);
        }
    }

    pub(crate) fn end_group(&mut self) {
        self.send_waiting(true);
        if self.group.take().is_some() {
            self.send(Command::History(HistoryCommand::End {}));
        }
    }

    /// Ends a control's change once the button is up.
    pub(crate) fn rest_control(&mut self, ctx: &egui::Context) {
        self.send_waiting(false);
        if self.group.is_some() && !ctx.input(|i| i.pointer.any_down()) {
            self.end_group();
        }
    }

    /// The wheel turns a view: until it rests that is one change of view.
    pub(crate) fn begin_wheel(&mut self, now: f64) {
        if self.group.is_none() && self.interaction.gesture().is_none() && self.wheeled.replace(now).is_none() {
            self.send(Command::History(HistoryCommand::Begin {}));
        }
    }

    /// The wheel rests.
    pub(crate) fn end_wheel(&mut self) {
        if self.wheeled.take().is_some() {
            self.send(Command::History(HistoryCommand::End {}));
        }
    }

    /// Ends the wheel's change once it rests, or something else is done.
    pub(crate) fn rest_wheel(&mut self, ctx: &egui::Context) {
        let Some(since) = self.wheeled else { return };
        let (now, other) = ctx.input(|i| {
            let press = |e: &egui::Event| {
                matches!(e, egui::Event::PointerButton { pressed: true, .. } | egui::Event::Key { pressed: true, .. })
            };
            (i.time, i.events.iter().any(press))
        });
        if other || now - since > WHEEL_RESTS_S {
            self.end_wheel();
        } else {
            ctx.request_repaint_after(std::time::Duration::from_millis(100));
        }
    }

    /// Undo or redo, unless a drag is under way.
    pub(crate) fn undo_redo(&mut self, command: HistoryCommand) {
        if self.group.is_none() && self.interaction.gesture().is_none() {
            self.send(Command::History(command));
        }
    }
}
