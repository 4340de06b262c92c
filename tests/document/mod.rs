//! Commands, history, journal, projects.
