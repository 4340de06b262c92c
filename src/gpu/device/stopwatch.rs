//! How long passes take on the device itself, for benches and the check of a graphics card.
//!
//! Owns the query set. A device that was not asked for times, or has none, has no stopwatch, and its passes none to write.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::pass_queries::MOST;
use std::sync::PoisonError;

impl Gpu {
    /// What a render pass writes its times to; `pass` names it in [`pass_times`](Self::pass_times).
    pub(crate) fn render_times(&self, pass: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let watch = self.stopwatch()?;
        let [begin, end] = watch.next(pass)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &watch.set,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        })
    }

    /// The same of a compute pass.
    pub(crate) fn compute_times(&self, pass: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let watch = self.stopwatch()?;
        let [begin, end] = watch.next(pass)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &watch.set,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        })
    }

    /// Name and milliseconds on the device of every timed pass since the last reading, once all of them are done; `None` where the
    /// device has no times or was not asked for them ([`headless_timed`](Self::headless_timed)).
    ///
    /// # Errors
    /// A lost device, or more passes than are held.
    pub fn pass_times(&self) -> Result<Option<Vec<(&'static str, f64)>>, GpuError> {
        let Some(watch) = self.stopwatch() else { return Ok(None) };
        let passes = std::mem::take(&mut *watch.passes.lock().unwrap_or_else(PoisonError::into_inner));
        if passes.is_empty() {
            return Ok(Some(Vec::new()));
        }
        if passes.len() > MOST {
            let reason = format!("{} passes found, at most {MOST} expected between two readings", passes.len());
            return Err(GpuError::Refused { what: "times of passes".into(), reason });
        }
        let bytes = 16 * passes.len() as u64;
        let ticks = self.scoped("times of passes", || {
            let buffer = |usage| {
                self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("stopwatch"),
                    size: bytes,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
            let read = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.resolve_query_set(&watch.set, 0..2 * passes.len() as u32, &resolved, 0);
            encoder.copy_buffer_to_buffer(&resolved, 0, &read, 0, bytes);
            self.queue.submit([encoder.finish()]);
            self.read_buffer(&read, "times of passes")
        })?;
        let ms = f64::from(self.queue.get_timestamp_period()) * 1e-6;
        let ticks: Vec<u64> = ticks.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let times = ticks.chunks_exact(2).map(|t| t[1].saturating_sub(t[0]) as f64 * ms);
        Ok(Some(passes.into_iter().zip(times).collect()))
    }
}
