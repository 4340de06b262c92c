//! What can be wrong with an explosion or with a request to change it.

use crate::explode::state::PartId;

/// What was wrong with a request: the name of the field, what was found, what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExplodeError {
    /// No part has this id.
    #[error("part {found} does not exist; the parts are {}", list(parts))]
    NoSuchPart {
        /// What was asked for.
        found: PartId,
        /// What there is.
        parts: Vec<PartId>,
    },
    /// A splitter has no plane.
    #[error("the {splitter} splitter has no plane: {reason}")]
    NoPlane {
        /// `axis`, `depth`, `line` or `plane`.
        splitter: &'static str,
        /// What to do.
        reason: &'static str,
    },
    /// A stored or given explosion is not one.
    #[error("{field}: {found} found, {expected} expected")]
    Invalid {
        /// Path of the field, as in a project's JSON.
        field: String,
        /// What it held.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
}

impl ExplodeError {
    /// The same with `whole` before the field's name.
    #[must_use]
    pub(super) fn within(self, whole: &str) -> Self {
        match self {
            Self::Invalid { field, found, expected } => {
                Self::Invalid { field: format!("{whole}{field}"), found, expected }
            }
            other => other,
        }
    }
}

fn list(parts: &[PartId]) -> String {
    parts.iter().map(PartId::to_string).collect::<Vec<_>>().join(", ")
}
