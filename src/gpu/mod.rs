//! The GPU: device, brick pools, kernels, the ray caster and slices.
//!
//! One kernel is one file here and one file under `shaders/`. Owns every GPU object but the window's surface. Fields stay
//! the host's: whatever is on the device can be made again from them after a loss.

mod backdrop;
pub(crate) mod brush;
pub mod cast;
pub mod device;
pub(crate) mod fields;
mod layers;
pub(crate) mod picture;
mod slice;
mod trace;

pub use backdrop::{Backdrop, BackdropDraw, BackdropPicture, Fill};
pub use brush::painter::{PaintedBricks, Painter};
pub use cast::caster::Caster;
pub use cast::forms::Form;
pub use cast::probe::Hit;
pub use cast::visibility::Visibility;
pub use device::adapter::AdapterChoice;
pub use device::error::GpuError;
pub use device::gpu::Gpu;
pub use device::shared::all as shared_structs;
pub use fields::bindings::FieldInfo;
pub use fields::demand::SliceCut;
pub use fields::matter::{LabelValues, Matter, Showing};
pub use fields::pools::FieldPools;
pub use fields::skip_maps::distances;
pub use fields::visible_values::VisibleValues;
pub use fields::volumes::{Fields, VolumeFields};
pub use picture::decal::{Decal, DecalCorner, DecalMesh, DecalPicture, Texels, distance_texel};
pub use picture::focus::{Context, Focus};
pub use picture::frame::{Body, FineBox, Frame, LabelLooks, Look, LookRef, Mask, Overlay};
pub use picture::image::{Image, ImageError};
pub use picture::layer::{Ball, CutMesh, Keeps, Layers, OpaqueMesh};
pub use picture::object_id::ObjectId;
pub use slice::{SliceCaster, SliceFrame, SliceLayer};
pub use trace::request::{Bend, GridRequest, Heading, TracedGrid, TracedVertex};
pub use trace::tracer::Tracer;
