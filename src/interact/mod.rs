//! Tools as small state machines: pointer and keys in, commands out.
//!
//! Owns which tool is chosen and which gesture runs; every gesture has an explicit start, commit and abort. Knows no window: time,
//! pixels and what lies under the pointer come with the event, so a test drives a tool as a user would. It changes nothing
//! itself; what it wants done are [`Command`](crate::document::Command)s.

mod brush;
pub mod curve;
mod event;
mod gesture;
mod keys;
mod machine;
pub mod preview;
mod projection;
pub mod readout;
mod slices;
pub mod surface;
mod tool;

pub use brush::{brush_change, reach};
pub use event::{Button, Event, Hit, Key, Modifiers, PointerEvent, Wheel};
pub use gesture::Gesture;
pub use keys::{Action, SHORTCUTS, Shortcut, action_of};
pub use machine::{Context, Interaction};
pub use projection::projected;
pub use slices::{Cut, CutSlice};
pub use tool::Tool;
