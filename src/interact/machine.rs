//! The machine: which tool, which gesture, and what comes of an event.

use crate::document::{Command, Scene, ViewCommand, ViewName};
use crate::explode::{Axis, Poses};
use crate::interact::brush::set_radius;
use crate::interact::event::{Button, Event, PointerEvent, Wheel};
use crate::interact::gesture::Gesture;
use crate::interact::slices::CutSlice;
use crate::interact::tool::Tool;
use crate::volume::Grid;

/// One step of the brush's size.
pub(super) const SIZE_STEP: f64 = 1.15;
/// Largest brush in mm, and in voxels where these are large.
const LARGEST_MM: f64 = 500.0;
const LARGEST_VOXELS: f64 = 20.0;
/// One notch of zoom.
const ZOOM_STEP: f64 = 1.15;

/// What a tool may look at.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// The scene as last seen.
    pub scene: &'a Scene,
    /// Where its parts stand.
    pub poses: &'a Poses,
    /// The volume's lattice, which says where slices lie.
    pub grid: &'a Grid,
    /// The smallest spacing in mm: the smallest brush that one can still grow is half of it.
    pub voxel_mm: f64,
}

/// The tool in hand, the gesture that runs, and what a key or a pointer makes of both.
#[derive(Clone, Debug, Default)]
pub struct Interaction {
    tool: Tool,
    gesture: Option<(Button, Gesture, u32)>,
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
    pub fn gesture(&self) -> Option<&Gesture> {
        self.gesture.as_ref().map(|(_, g, _)| g)
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

    fn gesture_of(&self, button: Button, e: &PointerEvent, context: &Context<'_>) -> Option<Gesture> {
        let three_d = e.view == ViewName::ThreeD;
        let orbit = Gesture::Orbit { start: context.scene.views.camera, last: e.px };
        let pan = Gesture::Pan { view: e.view, start: e.px, last: e.px };
        match button {
            Button::Middle => return Some(pan),
            Button::Secondary if three_d => return Some(Gesture::Zoom { view: e.view, start: e.px, last: e.px }),
            Button::Secondary => return Some(Gesture::Window { start: context.scene.window(), from: e.px }),
            Button::Primary => {}
        }
        if e.modifiers.space {
            return Some(pan);
        }
        if e.modifiers.alt {
            return Some(if three_d { orbit } else { pan });
        }
        let can_point = !three_d || e.hit.is_some();
        match self.tool {
            // Shift is the axis splitter's own.
            tool if e.modifiers.shift && tool != Tool::AxisSplit => {
                can_point.then_some(Gesture::Crosshair { view: e.view, start: context.scene.views.crosshair })
            }
            Tool::Navigate if three_d => Some(orbit),
            Tool::Brush if !three_d || e.hit.is_some() => {
                let fixed = context.scene.brush.erase;
                Some(Gesture::Stroke { view: e.view, last: *e, erase: e.modifiers.erase && !fixed, fixed })
            }
            Tool::LineSplit => {
                let slice = CutSlice::new(context.grid, context.scene, e.view, e.size);
                Some(Gesture::Line { view: e.view, from: e.px, to: e.px, slice })
            }
            Tool::AxisSplit | Tool::DepthSplit if can_point => {
                let axis = if e.modifiers.shift { Axis::Vertical } else { Axis::Horizontal };
                let slice = CutSlice::new(context.grid, context.scene, e.view, e.size);
                Some(Gesture::Click { tool: self.tool, from: e.px, axis, slice })
            }
            Tool::MovePart if three_d => Some(self.part_gesture(e, context).unwrap_or(orbit)),
            // Slices show the volume at rest: there is nothing to move there.
            Tool::MovePart => None,
            _ if three_d => Some(orbit),
            _ => Some(Gesture::Crosshair { view: e.view, start: context.scene.views.crosshair }),
        }
    }

    fn part_gesture(&self, e: &PointerEvent, context: &Context<'_>) -> Option<Gesture> {
        let hit = e.hit?;
        let part = context.scene.explosion.parts.iter().find(|p| Some(p.id) == hit.part)?;
        let (start, centre) = (context.poses.of(part), part.centre());
        Some(Gesture::Part { id: part.id, start, from: e.px, hit, turn: e.modifiers.ctrl, centre, moved: false })
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
