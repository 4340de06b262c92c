//! The device: how it is asked for, what it can do, and how its failures become answers.
//!
//! Owns [`Gpu`]. One descriptor serves the window, headless pictures and tests. Uncaptured errors and loss of the device are
//! recorded and never panic; [`Gpu::scoped`] turns errors of a piece of work into [`GpuError`].

use crate::gpu::device::adapter::AdapterChoice;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::pass_queries::Stopwatch;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::Features;

/// Features that are used where the adapter has them.
const WANTED: Features = Features::TEXTURE_FORMAT_16BIT_NORM.union(Features::FLOAT32_FILTERABLE);

/// A device and its queue. Clones share them.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: Arc<wgpu::AdapterInfo>,
    health: Arc<Health>,
    stopwatch: Option<Arc<Stopwatch>>,
}

#[derive(Debug, Default)]
struct Health {
    lost: AtomicBool,
    words: Mutex<Option<String>>,
}

impl Health {
    fn say(&self, words: String) {
        self.words.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(words);
    }
}

impl Gpu {
    /// A device without a window, of the adapter that `BURIN_ADAPTER` names, else of the best.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] and [`GpuError::NoDevice`].
    pub fn headless() -> Result<Self, GpuError> {
        Self::headless_with(WANTED)
    }

    /// The same, which tells [`pass_times`](Self::pass_times) where the adapter has them.
    ///
    /// # Errors
    /// As [`headless`](Self::headless).
    pub fn headless_timed() -> Result<Self, GpuError> {
        let gpu = Self::headless_on(&AdapterChoice::from_env(), WANTED, Features::TIMESTAMP_QUERY)?;
        let timed = gpu.device.features().contains(Features::TIMESTAMP_QUERY);
        let stopwatch = timed.then(|| Arc::new(Stopwatch::new(&gpu.device)));
        Ok(Self { stopwatch, ..gpu })
    }

    /// A device of the adapter that is wanted.
    ///
    /// # Errors
    /// As [`headless`](Self::headless).
    pub fn headless_of(wanted: &AdapterChoice) -> Result<Self, GpuError> {
        Self::headless_on(wanted, WANTED, Features::empty())
    }

    /// The same, without using features beyond `allowed`: to try what a lesser adapter would do.
    ///
    /// # Errors
    /// As [`headless`](Self::headless).
    pub fn headless_with(allowed: Features) -> Result<Self, GpuError> {
        Self::headless_on(&AdapterChoice::from_env(), allowed, Features::empty())
    }

    /// `allowed`: of the features that are wanted anyway; `more`: others, where the adapter has them.
    fn headless_on(wanted: &AdapterChoice, allowed: Features, more: Features) -> Result<Self, GpuError> {
        let mut instance = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        // OpenGL lacks what the kernels need, and asks for a display.
        instance.backends = wgpu::Backends::PRIMARY.with_env();
        let backends = instance.backends;
        let instance = wgpu::Instance::new(instance);
        let adapter = if *wanted == AdapterChoice::Best {
            let options = wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..Default::default()
            };
            pollster::block_on(instance.request_adapter(&options))
                .map_err(|e| GpuError::NoAdapter { reason: e.to_string() })?
        } else {
            let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
            let infos: Vec<_> = adapters.iter().map(wgpu::Adapter::get_info).collect();
            let at = wanted.among(&infos).map_err(|reason| GpuError::NoAdapter { reason })?;
            adapters.swap_remove(at)
        };
        let mut descriptor = Self::device_descriptor(&adapter);
        descriptor.required_features &= allowed;
        descriptor.required_features |= adapter.features() & more;
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::NoDevice { adapter: adapter.get_info().name, reason: e.to_string() })?;
        Self::from_wgpu(&adapter, device, queue)
    }

    /// Takes over a device that a window made with [`device_descriptor`](Self::device_descriptor).
    ///
    /// # Errors
    /// [`GpuError::NoDevice`] if it cannot hold 3D textures of a slot's size.
    pub fn from_wgpu(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        if device.limits().max_texture_dimension_3d < 256 {
            return Err(GpuError::NoDevice {
                adapter: info.name,
                reason: format!(
                    "3D textures of {} texels found, 256 expected",
                    device.limits().max_texture_dimension_3d
                ),
            });
        }
        let health = Arc::new(Health::default());
        let on_error = Arc::clone(&health);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            tracing::error!(%error, "uncaptured error of the graphics device");
            on_error.say(error.to_string());
        }));
        let on_loss = Arc::clone(&health);
        device.set_device_lost_callback(move |reason, words| {
            on_loss.say(format!("{reason:?}: {words}"));
            on_loss.lost.store(true, Ordering::Release);
        });
        Ok(Self { device, queue, info: Arc::new(info), health, stopwatch: None })
    }

    /// What every device of this program is asked for: the features it uses, the adapter's own limits.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("burin"),
            required_features: adapter.features() & WANTED,
            required_limits: adapter.limits(),
            ..Default::default()
        }
    }

    /// The device and its queue, for the window and for tests' own kernels.
    pub fn raw(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.device, &self.queue)
    }

    pub(crate) fn stopwatch(&self) -> Option<&Stopwatch> {
        self.stopwatch.as_deref()
    }

    /// Whether the adapter is a program on the processor. Its clock runs beside its work and says little of a pass.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        &self.info.name
    }

    /// Adapter, driver and what is missing, for `burin info` and reports.
    pub fn describe(&self) -> String {
        let i = &self.info;
        let density = if self.has_unorm16() { "16-bit density" } else { "no 16-bit density: 32-bit instead" };
        format!("{} ({:?}, {:?}, {} {}), {density}", i.name, i.backend, i.device_type, i.driver, i.driver_info)
    }

    /// Whether `r16unorm` textures exist.
    pub fn has_unorm16(&self) -> bool {
        self.device.features().contains(Features::TEXTURE_FORMAT_16BIT_NORM)
    }

    /// Whether a sampler may filter `r32float`.
    pub fn filters_float(&self) -> bool {
        self.device.features().contains(Features::FLOAT32_FILTERABLE)
    }

    /// Whether the device is gone. Everything on it must then be made again, on a new `Gpu`.
    pub fn lost(&self) -> bool {
        self.health.lost.load(Ordering::Acquire)
    }

    /// Fails if the device is gone.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn check(&self) -> Result<(), GpuError> {
        if !self.lost() {
            return Ok(());
        }
        let words = self.health.words.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Err(GpuError::Lost { reason: words.unwrap_or_else(|| "no reason given".into()) })
    }

    /// Does `work` and waits for the device's opinion of it. `what` names the work in errors.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Refused`] or [`GpuError::Lost`]; errors of `work` itself come first.
    pub fn scoped<T>(&self, what: &str, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
        self.check()?;
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let result = work();
        let internal = pollster::block_on(internal.pop());
        let validation = pollster::block_on(validation.pop());
        let memory = pollster::block_on(memory.pop());
        let result = result?;
        match memory.or(internal).or(validation) {
            None => Ok(result),
            Some(error) => {
                self.check()?;
                let (what, reason) = (what.to_string(), error.to_string());
                Err(match error {
                    wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { what, reason },
                    _ => GpuError::Refused { what, reason },
                })
            }
        }
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn wait(&self) -> Result<(), GpuError> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        polled.map(drop).map_err(|e| GpuError::Lost { reason: e.to_string() })
    }

    /// Copies a buffer with `MAP_READ` to the host, after everything submitted.
    ///
    /// # Errors
    /// [`GpuError::Lost`] or [`GpuError::Refused`].
    pub fn read_buffer(&self, buffer: &wgpu::Buffer, what: &str) -> Result<Vec<u8>, GpuError> {
        self.look_into(buffer, buffer.size(), what, <[u8]>::to_vec)
    }

    /// Looks at the first bytes of a buffer with `MAP_READ` where they lie, after everything submitted.
    ///
    /// # Errors
    /// As [`read_buffer`](Self::read_buffer); the buffer is then of no further use.
    pub(crate) fn look_into<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        what: &str,
        look: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let refused = |reason: String| GpuError::Refused { what: what.to_string(), reason };
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // The receiver is gone only if waiting failed first.
            let _ = sender.send(result);
        });
        self.wait()?;
        receiver.recv().map_err(|e| refused(e.to_string()))?.map_err(|e| refused(e.to_string()))?;
        let seen = look(&buffer.get_mapped_range(..bytes).map_err(|e| refused(e.to_string()))?);
        buffer.unmap();
        Ok(seen)
    }
}
