//! The queries of a device: begin and end of passes, in the order in which they were made.

use std::sync::Mutex;
use std::sync::PoisonError;

/// Passes between two readings; what comes after them is refused, not left out.
pub(crate) const MOST: usize = 2048;

/// Begin and end of passes, in the order in which they were made.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    pub(crate) set: wgpu::QuerySet,
    pub(crate) passes: Mutex<Vec<&'static str>>,
}

impl Stopwatch {
    /// For a device with `TIMESTAMP_QUERY`.
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let set = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stopwatch"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST as u32,
        });
        Self { set, passes: Mutex::default() }
    }

    /// The two queries of one more pass.
    pub(crate) fn next(&self, pass: &'static str) -> Option<[u32; 2]> {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        passes.push(pass);
        let first = 2 * (passes.len() - 1);
        (passes.len() <= MOST).then_some([first as u32, first as u32 + 1])
    }
}
