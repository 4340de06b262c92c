//! The document: what is open, what can be done to it, and how it is kept.
//!
//! One command set. Buttons, shortcuts, tools, scripts and tests all call `Document::apply` with a [`Command`]; every command
//! answers with what it did.

mod command;
mod scene;

pub use command::*;
pub use scene::*;
