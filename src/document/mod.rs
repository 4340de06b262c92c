//! The document: what is open, what can be done to it, and how it is kept.
//!
//! One command set. Buttons, shortcuts, tools, scripts and tests all call `Document::apply` with a [`Command`]; every command
//! answers with what it did.

mod command;
mod defaults;
mod error;
mod scene;
mod slice_plane;
mod state;

pub use command::*;
pub use error::DocumentError;
pub use scene::*;
pub use slice_plane::{SlicePlane, side_letter};
pub use state::State;
