//! How far a long command has got, told from whichever thread works, and whether it shall stop.
//!
//! The window sets the wish to stop, the worker takes it back before the next command. Knows of commands only that they are watched, and what is said meanwhile.

use crate::document::effects::Lasts;
use crate::document::{Command, Watch};
use crate::ui::thread::session::Report;
use crate::ui::thread::stop::Stop;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::Sender;

/// Tells each percent of a long command once, and hears the wish to stop.
#[derive(Clone, Debug, Default)]
pub(crate) struct PercentTold {
    stop: Stop,
    /// One more than the percent told last.
    told: Arc<AtomicU32>,
}

impl PercentTold {
    pub(crate) fn new(stop: Stop) -> Self {
        Self { stop, told: Arc::default() }
    }

    /// Before a long command.
    pub(crate) fn begin(&self) {
        self.stop.set(false);
        self.told.store(0, Ordering::Relaxed);
    }

    /// What the document tells: each percent is told once and never goes back.
    pub(crate) fn watch(&self, reports: Sender<Report>, wake: egui::Context) -> Watch {
        let Self { stop, told } = self.clone();
        Watch::new(move |share| {
            let percent = (share.clamp(0.0, 1.0) * 100.0) as u32;
            if told.fetch_max(percent + 1, Ordering::Relaxed) <= percent {
                // Nobody there: the worker finds out by itself.
                let _gone = reports.send(Report::Progress(percent));
                wake.request_repaint();
            }
            !stop.is_set()
        })
    }
}

/// What is said while a command runs that may take over a tenth of a second.
pub(super) fn doing(command: &Command, lasts: Lasts) -> Option<String> {
    match lasts {
        Lasts::AtOnce => None,
        Lasts::AWhile(doing) => Some(doing.into()),
        Lasts::AWhileWith(doing) => {
            let path = command.path().unwrap_or_default();
            Some(format!("{doing} {}", path.file_name().unwrap_or_default().to_string_lossy()))
        }
    }
}
