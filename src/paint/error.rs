//! What can be wrong with a brush or a stroke.

/// Why a brush or a stroke cannot be painted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PaintError {
    /// A setting of the brush is out of its range.
    #[error("brush.{field} is {found}; expected {expected}")]
    Brush {
        /// The setting, as scripts name it.
        field: &'static str,
        /// What it is.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// A sample of the stroke is not a place or not a pressure.
    #[error("sample {index} of the stroke: {field} is {found}; expected {expected}")]
    Sample {
        /// Its number within the samples given, from 0.
        index: usize,
        /// `position`, `normal` or `pressure`.
        field: &'static str,
        /// What it is.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// The path needs more dabs than one event can sensibly hold.
    #[error(
        "the stroke runs {length_mm} mm to sample {index}, which takes {dabs} dabs at a distance of {step_mm} mm; expected at \
         most {most}: use a larger radius or a shorter stroke"
    )]
    TooLong {
        /// Number of the sample that is too far away.
        index: usize,
        /// Length from the sample before it.
        length_mm: f64,
        /// Dabs on the way.
        dabs: u64,
        /// Distance between dabs.
        step_mm: f64,
        /// The most dabs of one event.
        most: u64,
    },
}
