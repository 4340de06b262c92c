//! What can go wrong on the GPU floor, in words that a user can act on.
//!
//! Owns [`GpuError`] and nothing else. Out of memory and a lost device are answers here, never crashes.

use crate::volume::SourceError;

/// Errors of the GPU floor.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// There is nothing to draw with.
    #[error(
        "no graphics adapter found ({reason}); a Vulkan, Metal or Direct3D 12 driver is expected. On Debian and Ubuntu \
         software Vulkan comes with: apt install mesa-vulkan-drivers libvulkan1"
    )]
    NoAdapter {
        /// What the system said.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("the graphics adapter {adapter} gave no device: {reason}; update its driver or choose another adapter")]
    NoDevice {
        /// Adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The GPU has no room.
    #[error("out of graphics memory for {what}: {reason}; lower the memory budget or close other programs")]
    OutOfMemory {
        /// What was to be made.
        what: String,
        /// Sizes or the driver's words.
        reason: String,
    },
    /// The device refused a call: a defect of this program or of the driver.
    #[error("the graphics device refused {what}: {reason}; please report this with the adapter's name")]
    Refused {
        /// What was to be done.
        what: String,
        /// The device's words.
        reason: String,
    },
    /// The device is gone; everything on it can be made again from the host's fields.
    #[error(
        "the graphics device was lost ({reason}); nothing is lost but the picture, which is made again on a new device"
    )]
    Lost {
        /// The driver's words.
        reason: String,
    },
    /// A shader does not compose or does not validate.
    #[error("shader {file}: {reason}")]
    Shader {
        /// File under `shaders/`.
        file: String,
        /// What the compiler said.
        reason: String,
    },
    /// A request that the pools cannot hold.
    #[error(
        "{asked} bricks of {field} asked for at once, the pool holds {room}; raise the memory budget or use a smaller brush"
    )]
    PoolFull {
        /// Field.
        field: &'static str,
        /// Bricks asked for.
        asked: usize,
        /// Bricks that fit.
        room: usize,
    },
    /// The volume could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
}
