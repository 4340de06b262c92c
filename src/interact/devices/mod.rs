//! What a hand holds: mouse, pen, and a pointer with six degrees of freedom, as one trait.
//!
//! Whatever points has a position, a direction, a pressure and buttons ("Direct Volume Editing", 2008, section 3.1); from them come the
//! events that tools take, the same for all. Knows no driver and no window: whoever hears a device fills in what it said.

mod passive;
mod screen;
mod stylus;

pub use passive::{Feel, Touch};
pub use screen::{Mouse, Pen, ScreenPlace};
pub use stylus::Stylus;

use crate::document::ViewName;
use crate::interact::event::{Button, Event, Hit, InSpace, Modifiers, PointerEvent};
use crate::math::{Camera, DVec2, DVec3};

/// Where a pointer is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Over a view.
    Screen(ScreenPlace),
    /// In the world at rest, mm.
    World(DVec3),
}

/// Buttons that are held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buttons {
    /// Left, a pen's tip, a stylus' own.
    pub primary: bool,
    /// Right.
    pub secondary: bool,
    /// The wheel.
    pub middle: bool,
}

impl Buttons {
    /// That one alone.
    pub fn only(button: Button) -> Self {
        Self::default().with(button, true)
    }

    /// Whether one is held.
    pub fn held(self, button: Button) -> bool {
        match button {
            Button::Primary => self.primary,
            Button::Secondary => self.secondary,
            Button::Middle => self.middle,
        }
    }

    /// The same with one held or not.
    #[must_use]
    pub fn with(mut self, button: Button, held: bool) -> Self {
        match button {
            Button::Primary => self.primary = held,
            Button::Secondary => self.secondary = held,
            Button::Middle => self.middle = held,
        }
        self
    }
}

/// Whatever a hand points with.
pub trait Pointer {
    /// Where it is.
    fn position(&self) -> Position;

    /// Where its tip looks, unit, world at rest; `None` of what lies on a table: along the sight.
    fn direction(&self) -> Option<DVec3>;

    /// How hard it is pressed, 0..1; 1 of what cannot tell.
    fn pressure(&self) -> f32;

    /// What is held.
    fn buttons(&self) -> Buttons;
}

/// What a moment of a pointer has besides the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The 3D view's camera and its size in pixels, where it is shown.
    pub seen: Option<(Camera, [u32; 2])>,
    /// Held keys.
    pub modifiers: Modifiers,
    /// Seconds, any origin.
    pub time_s: f64,
    /// What lies under a pointer of the screen in the 3D view.
    pub hit: Option<Hit>,
}

/// A pointer at one moment, as tools take it. What is in space is over the 3D view where a picture shows it, and hits itself; `None` if it
/// is behind the eye, or no 3D view is shown.
pub fn pointer_event(pointer: &dyn Pointer, moment: &Moment) -> Option<PointerEvent> {
    Some(match pointer.position() {
        Position::Screen(place) => screen_event(pointer, place, moment),
        Position::World(mm) => {
            let (camera, size) = moment.seen?;
            let (px, depth_mm) = camera.project(mm, size)?;
            let place = ScreenPlace { view: ViewName::ThreeD, px, size };
            let hit = Some(Hit { world: mm, part: None, depth_mm });
            let space = Some(InSpace { mm, direction: pointer.direction() });
            PointerEvent { hit, space, ..screen_event(pointer, place, moment) }
        }
    })
}

/// A pointer that is over a view, at one moment.
pub fn screen_event(pointer: &dyn Pointer, place: ScreenPlace, moment: &Moment) -> PointerEvent {
    let ScreenPlace { view, px, size } = place;
    let &Moment { modifiers, time_s, hit, .. } = moment;
    PointerEvent { view, px, size, modifiers, pressure: pointer.pressure(), time_s, hit, space: None }
}

/// A driver's word for how hard something is pressed, as a share.
fn share(force: f32) -> f32 {
    if force.is_nan() { 0.0 } else { force.clamp(0.0, 1.0) }
}

/// Events from what a device says again and again: which buttons went down and up, and that it moved.
#[derive(Clone, Debug, Default)]
pub struct Follower {
    held: Buttons,
    last: Option<(DVec2, Option<InSpace>)>,
}

impl Follower {
    /// What has happened since the last time.
    pub fn events(&mut self, pointer: &dyn Pointer, moment: &Moment) -> Vec<Event> {
        let Some(event) = pointer_event(pointer, moment) else {
            self.last = None;
            let held = std::mem::take(&mut self.held);
            return if held == Buttons::default() { Vec::new() } else { vec![Event::Abort] };
        };
        let (before, now) = (std::mem::replace(&mut self.held, pointer.buttons()), pointer.buttons());
        let here = (event.px, event.space);
        let mut events = Vec::new();
        if self.last.replace(here) != Some(here) {
            events.push(Event::Move(event));
        }
        for button in [Button::Primary, Button::Secondary, Button::Middle] {
            match (before.held(button), now.held(button)) {
                (false, true) => events.push(Event::Press(button, event)),
                (true, false) => events.push(Event::Release(button, event)),
                _ => {}
            }
        }
        events
    }
}
