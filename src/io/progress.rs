//! How far a long reading or writing has got, and whether it goes on.

/// Gets the share done, 0..1, and answers whether to go on.
pub type Progress<'a> = &'a (dyn Fn(f32) -> bool + Sync);
