//! The thread that the document lives on, the line to it, and what is expected of it before it answers.

pub(crate) mod prediction;
pub(crate) mod progress;
pub(crate) mod rescue;
pub(crate) mod session;
pub(crate) mod snapshot;
pub(crate) mod stop;
pub(crate) mod view_scheduler;
pub(crate) mod worker;
