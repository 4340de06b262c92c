//! The GPU: device, brick pools, kernels, the ray caster and slices.
//!
//! One kernel is one file here and one file under `shaders/`. Owns every GPU object but the window's surface. Fields stay
//! the host's: whatever is on the device can be made again from them after a loss.

mod bindings;
mod body;
mod brush;
mod brush_cells;
mod brush_frame;
mod brush_kernel;
mod brush_memory;
mod brush_readback;
mod brush_stroke;
mod brush_submit;
mod caster;
mod device;
mod drawn;
mod error;
mod image;
mod kernel;
pub mod layout;
mod occupancy;
pub mod order;
mod pass;
mod pool;
mod pools;
mod probe;
mod readback;
mod residency;
pub mod scene;
pub mod shader;
mod sight;
mod slice;
pub mod solid;
pub mod tiles;
mod underlay;
mod visibility;

pub use bindings::FieldInfo;
pub use body::{Body, Frame, Mask, Overlay};
pub use brush::Painter;
pub use caster::Caster;
pub use device::Gpu;
pub use error::GpuError;
pub use image::{Image, ImageError};
pub use occupancy::{Shows, distances};
pub use pools::{FieldPools, Fields};
pub use probe::Hit;
pub use slice::{SliceCaster, SliceFrame};
pub use underlay::{Fill, Sheet, Shown, Underlay};
pub use visibility::Visibility;
