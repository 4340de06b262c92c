//! Commands, history, journal, projects.

mod history;
mod keep;
mod keep_support;
mod maker;
mod nouns;
mod parts;
mod projects;
mod script;
mod selection;
mod volumes;
