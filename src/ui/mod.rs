//! The window: panels and views in egui.
//!
//! Owns layout, theme and the thread that the document lives on. Knows the document by its commands and snapshots only: whatever
//! a control or a tool wants done goes through `Document::apply`, as a script's line does.

mod app;
mod dialogs;
mod echo;
mod icons;
mod overlay;
mod panels;
mod pictures;
mod pointer;
mod session;
pub mod theme;
mod viewport;
mod widgets;

pub use app::App;
pub use session::{Far, Gravity, Opened, Picture, Report, Request, Session, Snapshot};
