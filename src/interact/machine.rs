//! The machine: which tool, which gesture, and what comes of an event.

use crate::document::{Command, ViewCommand, ViewName};
use crate::interact::brush::set_radius;
use crate::interact::context::Context;
use crate::interact::event::{Button, Event, PointerEvent, Wheel};
use crate::interact::gesture::Gesture;
use crate::interact::looking::{Crosshair, GreyWindow, Orbit, Pan, Zoom};
use crate::interact::tools::{Press, Tool};

/// One step of the brush's size.
pub(super) const SIZE_STEP: f64 = 1.15;
/// Largest brush in mm, and in voxels where these are large.
const LARGEST_MM: f64 = 500.0;
const LARGEST_VOXELS: f64 = 20.0;
/// One notch of zoom.
const ZOOM_STEP: f64 = 1.15;

/// The tool in hand, the gesture that runs, and what a key or a pointer makes of both.
#[derive(Debug, Default)]
pub struct Interaction {
    tool: Tool,
    gesture: Option<(Button, Box<dyn Gesture>, u32)>,
    notches: f64,
}

impl Interaction {
    /// The tool in hand.
    pub fn tool(&self) -> Tool {
        self.tool
    }

    /// Takes another tool; what runs is taken back.
    pub fn choose(&mut self, tool: Tool) -> Vec<Command> {
        let commands = self.abort();
        self.tool = tool;
        commands
    }

    /// The gesture that runs.
    pub fn gesture(&self) -> Option<&dyn Gesture> {
        self.gesture.as_ref().map(|(_, gesture, _)| &**gesture)
    }

    /// Takes in an event, answers what is to be done.
    pub fn handle(&mut self, event: Event, context: &Context<'_>) -> Vec<Command> {
        match event {
            Event::Press(button, e) => self.press(button, &e, context),
            Event::Move(e) => match &mut self.gesture {
                Some((_, gesture, _)) => gesture.drag(&e, context.scene),
                None => Vec::new(),
            },
            Event::Release(button, e) => match self.gesture.take() {
                Some((held, mut gesture, _)) if held == button => {
                    let mut commands = gesture.drag(&e, context.scene);
                    commands.extend(gesture.commit(&e, context.scene));
                    commands
                }
                other => {
                    self.gesture = other;
                    Vec::new()
                }
            },
            Event::Wheel(wheel) => self.wheel(&wheel, context),
            Event::Abort => self.abort(),
        }
    }

    /// Another size for the brush.
    pub fn sized(factor: f64, context: &Context<'_>) -> Command {
        let least = context.voxel_mm * 0.5;
        let largest = LARGEST_MM.max(LARGEST_VOXELS * context.voxel_mm);
        let radius = (context.scene.brush.radius_mm.max(least) * factor).clamp(least, largest);
        // Three digits are what a person reads; the rest would only show as noise in the field.
        let digits = 10.0_f64.powi(2 - radius.log10().floor() as i32);
        set_radius((radius * digits).round() / digits)
    }

    fn press(&mut self, button: Button, e: &PointerEvent, context: &Context<'_>) -> Vec<Command> {
        if self.gesture.is_some() {
            return Vec::new();
        }
        let Some(gesture) = self.gesture_of(button, e, context) else { return Vec::new() };
        let commands = gesture.start(e);
        self.gesture = Some((button, gesture, e.size[1]));
        commands
    }

    fn gesture_of(&self, button: Button, e: &PointerEvent, context: &Context<'_>) -> Option<Box<dyn Gesture>> {
        let (scene, view, px) = (context.scene, e.view, e.px);
        let three_d = view == ViewName::ThreeD;
        let pan = || -> Option<Box<dyn Gesture>> { Some(Box::new(Pan { view, start: px, last: px })) };
        let orbit = || -> Option<Box<dyn Gesture>> { Some(Box::new(Orbit { start: scene.views.camera, last: px })) };
        let crosshair =
            || -> Option<Box<dyn Gesture>> { Some(Box::new(Crosshair { view, start: scene.views.crosshair })) };
        match button {
            Button::Middle => return pan(),
            Button::Secondary if three_d => return Some(Box::new(Zoom { view, start: px, last: px })),
            Button::Secondary => return Some(Box::new(GreyWindow { start: scene.window(), from: px })),
            Button::Primary => {}
        }
        if e.modifiers.space {
            return pan();
        }
        if e.modifiers.alt {
            return if three_d { orbit() } else { pan() };
        }
        if e.modifiers.shift && !self.tool.has_shift() {
            let can_point = !three_d || e.hit.is_some();
            return if can_point { crosshair() } else { None };
        }
        match self.tool.does().press(e, context) {
            Press::Begins(gesture) => Some(gesture),
            Press::Looks if three_d => orbit(),
            Press::Looks => crosshair(),
            Press::Nothing => None,
        }
    }

    fn wheel(&mut self, wheel: &Wheel, context: &Context<'_>) -> Vec<Command> {
        let zoom = || {
            let factor = ZOOM_STEP.powf(-wheel.notches);
            vec![Command::View(ViewCommand::Zoom { view: wheel.view, factor })]
        };
        if wheel.modifiers.ctrl {
            return zoom();
        }
        if wheel.modifiers.shift {
            return vec![Self::sized(SIZE_STEP.powf(wheel.notches), context)];
        }
        if wheel.view == ViewName::ThreeD {
            return zoom();
        }
        // Touchpads send fractions; a slice is stepped when they make a whole one.
        self.notches += wheel.notches;
        let voxels = self.notches.trunc();
        self.notches -= voxels;
        if voxels == 0.0 {
            return Vec::new();
        }
        vec![Command::View(ViewCommand::Scroll { view: wheel.view, voxels: voxels as i32 })]
    }

    fn abort(&mut self) -> Vec<Command> {
        self.gesture.take().map_or_else(Vec::new, |(_, gesture, height)| gesture.abort(height))
    }
}
