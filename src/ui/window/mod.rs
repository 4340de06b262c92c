//! The window's own state: what is shown where, what waits, what was said.

pub(crate) mod app;
pub(crate) mod borders;
pub(crate) mod changes;
pub(crate) mod folds;
pub(crate) mod layout;
pub(crate) mod lesson;
pub(crate) mod notes;
pub(crate) mod recent;
pub(crate) mod reports;
pub(crate) mod rescue;
pub(crate) mod sample;
pub(crate) mod saving;
pub(crate) mod start;
