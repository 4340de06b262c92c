//! The GPU: device, brick pools, kernels, the ray caster and slices.
//!
//! One kernel is one file here and one file under `shaders/`. Owns every GPU object but the window's surface. Fields stay
//! the host's: whatever is on the device can be made again from them after a loss.

mod bindings;
mod body;
mod brush;
mod brush_frame;
mod brush_kernel;
mod brush_memory;
mod brush_readback;
mod device;
mod error;
pub mod layout;
mod occupancy;
mod pool;
mod pools;
mod residency;
pub mod shader;
mod sight;
mod slice;

pub use bindings::FieldInfo;
pub use body::{Body, Frame, Mask, Overlay};
pub use brush::Painter;
pub use device::Gpu;
pub use error::GpuError;
pub use occupancy::{Shows, distances};
pub use pools::{FieldPools, Fields};
pub use slice::{SliceCaster, SliceFrame};
