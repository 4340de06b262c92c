//! Pictures that lie on surfaces among the bodies: annotations, and bands about windows.
//!
//! Plain data, in the rest space of a volume. A decal is part of whatever body holds its place: it is cut where the body is cut and goes
//! where the body goes. Knows nothing of how it is drawn.

use crate::gpu::device::constants::MOST_DISTANCE;
use crate::math::DVec3;
use crate::volume::{Lighting, VolumeId};
use std::sync::Arc;

/// A corner of a decal's mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct DecalCorner {
    /// World mm at rest, from the mesh's origin.
    pub place: [f32; 3],
    /// Across its picture, left to right 0 to 1.
    pub u: f32,
    /// Outward, of length 1.
    pub normal: [f32; 3],
    /// Down its picture, top to bottom 0 to 1.
    pub v: f32,
}

/// A piece of surface. It need not be closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DecalMesh {
    /// World mm at rest that corners count from.
    pub origin: DVec3,
    /// Its corners.
    pub corners: Vec<DecalCorner>,
    /// Three corners each; both sides show.
    pub triangles: Vec<[u32; 3]>,
}

/// What the texels of a picture are, of four bytes each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texels {
    /// Colour times opacity, and opacity, 8 bits each, red lowest.
    Colours,
    /// How far inside a shape a place is, and how far inside its halo, less than 0 outside: see [`distance_texel`].
    Distances,
}

/// A texel of [`Texels::Distances`]: both distances in texels of the finest level, of a level of detail, 0 for the finest.
pub fn distance_texel([shape, halo]: [f32; 2], level: u32) -> u32 {
    let unit = MOST_DISTANCE * (level as f32).exp2();
    let whole = |d: f32| ((d / unit).clamp(-1.0, 1.0) * 32_767.0).round() as i16 as u16;
    u32::from(whole(shape)) | u32::from(whole(halo)) << 16
}

/// What a decal shows, in levels of detail: each of half as many texels either way as the one before, rounded down, to a single one.
#[derive(Clone, Debug, PartialEq)]
pub struct DecalPicture {
    /// What they mean.
    pub texels: Texels,
    /// Width and height in texels, and its texels row by row from the top.
    pub levels: Vec<([u32; 2], Vec<u32>)>,
    /// From a corner's (u, v) to places in the picture, 0..1 either way: by columns.
    pub picture_from_uv: [[f32; 2]; 3],
    /// Whether the picture is repeated in all directions.
    pub repeats: bool,
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Decal {
    /// Its surface.
    pub mesh: Arc<DecalMesh>,
    /// What is on it.
    pub picture: Arc<DecalPicture>,
    /// The volume whose matter it lies on; a sub-volume's is its root.
    pub volume: VolumeId,
    /// Whether that matter is selected: it then goes with the selection where that is a body of its own.
    pub selected: bool,
    /// Of shapes, display-referred.
    pub fill: [f32; 3],
    /// About shapes, display-referred; `None`: nothing is.
    pub halo: Option<[f32; 3]>,
    /// 0..1.
    pub opacity: f32,
    /// How its colours are lit; `None`: as they are.
    pub lighting: Option<Lighting>,
    /// How far it is moved toward the eye along each ray, mm.
    pub toward_mm: f64,
    /// Whether closed meshes that cut take it away too.
    pub is_cut: bool,
}
