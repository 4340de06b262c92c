//! Why an annotation cannot be drawn.
//!
//! Owns one error for all of it: what was given, what would do. Knows nothing of who asked.

/// What was given and what is expected instead.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AnnotateError {
    /// A number or a length outside its range.
    #[error("{field} is {found}; {expected} expected")]
    OutOfRange {
        /// Name of the parameter.
        field: &'static str,
        /// As given.
        found: String,
        /// Its range, in words.
        expected: String,
    },
    /// Bytes that are no font, or one that has no outlines.
    #[error("font {font}: {found}; a TrueType or OpenType font with outlines expected")]
    Font {
        /// Its name, as given.
        font: String,
        /// What is wrong.
        found: String,
    },
}

impl AnnotateError {
    /// Of a parameter outside its range.
    pub fn out(field: &'static str, found: impl ToString, expected: impl ToString) -> Self {
        Self::OutOfRange { field, found: found.to_string(), expected: expected.to_string() }
    }
}

/// A length in mm that is finite and above 0, at most 1 km.
///
/// # Errors
/// Names the field otherwise.
pub fn checked_length(field: &'static str, mm: f64) -> Result<f64, AnnotateError> {
    if mm.is_finite() && mm > 0.0 && mm <= 1e6 {
        Ok(mm)
    } else {
        Err(AnnotateError::out(field, mm, "a length above 0, up to 1,000,000 mm"))
    }
}
