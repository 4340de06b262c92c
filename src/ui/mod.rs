//! The window: panels and views in egui.
//!
//! Owns layout, theme and the thread that the document lives on. Knows the document by its commands and snapshots only: whatever
//! a control or a tool wants done goes through `Document::apply`, as a script's line does.

pub mod browse;
mod dialogs;
mod panels;
pub(crate) mod state;
pub mod style;
pub(crate) mod thread;
pub(crate) mod views;
pub(crate) mod window;

pub use browse::glance::{Glance, glance};
pub use state::layout::Layout;
pub use state::recent::{Recent, Seen};
pub use state::sample::Sample;
pub use thread::session::{
    Offer, OpenDocument, Picture, Report, Request, Session, Severity, Snapshot, Then, WorkerEnd,
};
pub use thread::stop::Stop;
pub use thread::worker::spawn;
pub use window::app::App;
pub use window::canvas::Canvas;

use crate::document::{Document, recovery};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

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
        .with_maximized(true)
        .with_min_inner_size([900.0, 600.0]);
    // Flat colours have nothing to dither, and software drivers feel it.
    let native = eframe::NativeOptions { viewport, dithering: false, ..Default::default() };
    let mut document = Document::new();
    // Without a place for a journal work goes on; the first save makes it safe.
    let mut recent = Recent::default();
    let unsafe_until_saved = match recovery::state_dir() {
        Ok(folder) => {
            document.keep_unsaved_in(folder.clone());
            recent = Recent::kept_in(folder);
            None
        }
        Err(error) => Some(format!("work is not safe from a crash until it is saved: {error}")),
    };
    let thread = Arc::new(Mutex::new(None));
    let started = thread.clone();
    let closed = eframe::run_native(
        "burin",
        native,
        Box::new(move |cc| {
            let (session, thread) = spawn(document, cc.egui_ctx.clone())?;
            if let Ok(mut place) = started.lock() {
                *place = Some(thread);
            }
            let state = cc.wgpu_render_state.as_ref().ok_or("no graphics device for the window")?;
            let app = App::new(session).with_canvas(Canvas::new(state)?);
            let mut app = app.with_files(recent, std::env::home_dir()).with_system_dialogs();
            if let Ok(folder) = recovery::state_dir() {
                app = app.with_layout(folder.join("window.json"));
            }
            app.start(options.open.as_deref(), unsafe_until_saved);
            Ok(Box::new(app))
        }),
    );
    // What is being written is written to its end.
    if let Some(thread) = thread.lock().ok().and_then(|mut place| place.take())
        && thread.join().is_err()
    {
        return Err("the part of the program that keeps the volume has failed; start again to recover your work".into());
    }
    closed.map_err(|error| {
        format!("the window did not open: {error}; a display (X11 or Wayland) and a Vulkan driver are needed")
    })
}
