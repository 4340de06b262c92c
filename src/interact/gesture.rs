//! What a held button does, from its press to its release: start, commit and abort are explicit.

use crate::document::{Command, HistoryCommand, Scene, ViewName};
use crate::interact::event::PointerEvent;
use crate::interact::mark::{Ink, Mark};
use crate::math::DVec2;
use std::fmt::Debug;

/// A press this close to its release, in pixels, is a click; a hand that lets go of key and button moves no further between.
pub(super) const CLICK_PX: f64 = 4.0;
/// Degrees that a drag across the picture's height turns.
pub(super) const DEGREES_PER_HEIGHT: f64 = 180.0;

/// A held button. What it does is one step of history. Positions are pixels of the view where it began.
pub trait Gesture: Debug {
    /// Whether it changes things while it is held, rather than at its end alone.
    fn is_live(&self) -> bool {
        true
    }

    /// Commands of its start.
    fn start(&self, _e: &PointerEvent) -> Vec<Command> {
        self.is_live().then_some(Command::History(HistoryCommand::Begin {})).into_iter().collect()
    }

    /// The pointer moved.
    fn drag(&mut self, e: &PointerEvent, scene: &Scene) -> Vec<Command>;

    /// The button went up.
    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        vec![Command::History(HistoryCommand::End {})]
    }

    /// Everything as it was at the start. `height` is the view's, in pixels.
    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        self.is_live().then_some(Command::History(HistoryCommand::Cancel {})).into_iter().collect()
    }

    /// The line under the hand, and the view that it is drawn over.
    fn line(&self) -> Option<(ViewName, [DVec2; 2])> {
        None
    }

    /// What is drawn of it over a view.
    fn marks(&self, view: ViewName) -> Vec<Mark> {
        let line = self.line().filter(|(of, _)| *of == view);
        line.into_iter().map(|(_, [from, to])| Mark::Line { from, to, ink: Ink::Accent }).collect()
    }
}
