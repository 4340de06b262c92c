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
mod worker;

pub use app::App;
pub use session::{Far, Gravity, Opened, Picture, Report, Request, Session, Snapshot};

use crate::document::Document;
use std::path::PathBuf;

/// How the window starts.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// A volume or a project folder to open.
    pub open: Option<PathBuf>,
}

/// Opens the window and comes back when it is closed.
///
/// # Errors
/// A sentence that says what the system lacks: a display, a GPU or its driver.
pub fn run(options: Options) -> Result<(), String> {
    let viewport = egui::ViewportBuilder::default()
        .with_title("Burin")
        .with_app_id("burin")
        .with_inner_size([1280.0, 800.0])
        .with_min_inner_size([960.0, 600.0]);
    let native = eframe::NativeOptions { viewport, ..Default::default() };
    eframe::run_native(
        "burin",
        native,
        Box::new(move |cc| {
            let session = worker::spawn(Document::new(), cc.egui_ctx.clone())?;
            let mut app = App::new(session);
            if let Some(path) = &options.open {
                app.open(path);
            }
            Ok(Box::new(app))
        }),
    )
    .map_err(|error| {
        format!("the window did not open: {error}; a display (X11 or Wayland) and a Vulkan driver are needed")
    })
}
