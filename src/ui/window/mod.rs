//! The window's own state: what is shown where, what waits, what was said.

pub(crate) mod app;
pub(crate) mod borders;
pub(crate) mod canvas;
pub(crate) mod changes;
pub(crate) mod folds;
pub(crate) mod lesson;
pub(crate) mod notes;
pub(crate) mod opening;
pub(crate) mod reports;
pub(crate) mod saving;
pub(crate) mod start;
pub(crate) mod written;
