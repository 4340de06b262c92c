//! Gestures that every tool shares: they turn, shift and zoom a view, move the crosshair and set the grey window.

use crate::document::{Command, HistoryCommand, Place, Scene, ViewCommand, ViewName, Window};
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{DEGREES_PER_HEIGHT, Gesture};
use crate::interact::slices::{crosshair, set_window, windowed};
use crate::math::{Camera, DVec2, DVec3};

const END: Command = Command::History(HistoryCommand::End {});

/// Turns the camera; one change of view, as pan, zoom and crosshair are. `start` comes back on abort.
#[derive(Debug)]
pub(super) struct Orbit {
    pub(super) start: Camera,
    pub(super) last: DVec2,
}

impl Gesture for Orbit {
    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let d = (e.px - self.last) / f64::from(e.size[1].max(1)) * DEGREES_PER_HEIGHT;
        self.last = e.px;
        vec![Command::View(ViewCommand::Orbit { azimuth_deg: -d.x, elevation_deg: d.y })]
    }

    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        vec![Command::View(ViewCommand::Camera { camera: self.start }), END]
    }
}

/// Shifts a view.
#[derive(Debug)]
pub(super) struct Pan {
    pub(super) view: ViewName,
    pub(super) start: DVec2,
    pub(super) last: DVec2,
}

impl Gesture for Pan {
    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let px = (e.px - self.last).to_array();
        self.last = e.px;
        vec![Command::View(ViewCommand::Pan { view: self.view, px })]
    }

    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        vec![Command::View(ViewCommand::Pan { view: self.view, px: (self.start - self.last).to_array() }), END]
    }
}

/// Zooms a view.
#[derive(Debug)]
pub(super) struct Zoom {
    pub(super) view: ViewName,
    pub(super) start: DVec2,
    pub(super) last: DVec2,
}

impl Gesture for Zoom {
    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let factor = zoom_factor(self.last, e.px, e.size[1]);
        self.last = e.px;
        vec![Command::View(ViewCommand::Zoom { view: self.view, factor })]
    }

    fn abort(self: Box<Self>, height: u32) -> Vec<Command> {
        let factor = zoom_factor(self.last, self.start, height);
        vec![Command::View(ViewCommand::Zoom { view: self.view, factor }), END]
    }
}

fn zoom_factor(from: DVec2, to: DVec2, height: u32) -> f64 {
    ((to.y - from.y) / f64::from(height.max(1)) * 3.0).exp2()
}

/// Grey window of the slices; one step of history.
#[derive(Debug)]
pub(super) struct GreyWindow {
    pub(super) start: Window,
    pub(super) from: DVec2,
}

impl Gesture for GreyWindow {
    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        vec![set_window(windowed(self.start, e.px - self.from, e.size[1]))]
    }
}

/// Crosshair follows; `start` comes back on abort.
#[derive(Debug)]
pub(super) struct Crosshair {
    pub(super) view: ViewName,
    pub(super) start: DVec3,
}

impl Gesture for Crosshair {
    fn start(&self, e: &PointerEvent) -> Vec<Command> {
        vec![Command::History(HistoryCommand::Begin {}), crosshair(self.view, e.px, e.size)]
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        vec![crosshair(self.view, e.px, e.size)]
    }

    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        vec![Command::View(ViewCommand::Crosshair { at: Place::Mm(self.start.to_array()) }), END]
    }
}
