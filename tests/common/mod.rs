//! What the tests share: data makers and pictures, no formula under test.

pub mod gpu;
pub mod volumes;
