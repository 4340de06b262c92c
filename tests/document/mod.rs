//! Commands, history, journal, projects.

mod history;
mod maker;
mod nouns;
mod parts;
mod script;
mod keep;
mod keep_support;
