//! Commands, history, journal, projects.

mod history;
mod maker;
mod nouns;
mod parts;
mod script;
