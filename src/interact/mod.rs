//! Tools as small state machines: pointer and keys in, commands out.
//!
//! Owns which tool is chosen and which gesture runs; every gesture has an explicit start, commit and abort. Knows no window: time,
//! pixels and what lies under the pointer come with the event, so a test drives a tool as a user would. It changes nothing
//! itself; what it wants done are [`Command`](crate::document::Command)s.

mod aim;
pub mod boxes;
mod brush;
mod click;
mod context;
pub mod curve;
pub mod devices;
mod event;
mod footprint;
mod gesture;
mod keys;
mod looking;
mod machine;
mod mark;
pub mod preview;
mod projection;
pub mod readout;
mod slices;
pub mod surface;
mod tools;
mod writing;
mod written;

pub use aim::{Aim, Aimed};
pub use brush::{brush_change, reach};
pub use context::Context;
pub use event::{Button, Event, Hit, InSpace, Key, Modifiers, PointerEvent, Wheel};
pub use footprint::Form;
pub use gesture::Gesture;
pub use keys::{Action, SHORTCUTS, Shortcut, action_of};
pub use machine::Interaction;
pub use mark::{Ink, Mark, Pen};
pub use projection::projected;
pub use slices::CutSlice;
pub use tools::Tool;
pub use writing::{Writing, WritingKind, Written};
