//! Benchmarks: one an operation.
fn main() {}
