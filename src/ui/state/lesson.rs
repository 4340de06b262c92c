//! Which of the first steps on the sample is next.

/// What is done next; 3: all was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lesson(pub(crate) usize);
