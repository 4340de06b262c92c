//! What the caster is asked to draw: a list of bodies under one camera and one look.
//!
//! A body is a space (its pose), a convex region of the volume, an optional mask and a look. Parts, the posed selection and
//! the plain volume are all bodies. Nothing here knows how they are marched.

use crate::gpu::picture::layer::Layers;
use crate::math::{Camera, Plane, Pose};
use crate::volume::{Lighting, Mode, Segments, TransferFunction};

/// What of the matter inside its region belongs to a body. The selection s divides extinction; iso-surfaces and MIP divide
/// at ½ (ERRATA, Exploded Views).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mask {
    /// All of it: τ.
    None,
    /// The selected part: s·τ.
    Selection,
    /// The part that is not selected: (1 − s)·τ.
    Background,
}

/// Something that can be marched.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The caller's name for it; pictures hold `id + 1`.
    pub id: u32,
    /// `world_from_rest`.
    pub pose: Pose,
    /// Bounding planes with outward normals, world mm at rest, besides the volume's box.
    pub region: Vec<Plane>,
    /// Its share of the matter.
    pub mask: Mask,
    /// Display-referred; multiplies colour.
    pub tint: Option<[f32; 3]>,
}

impl Body {
    /// The whole volume at rest.
    pub fn whole(id: u32) -> Self {
        Self { id, pose: Pose::IDENTITY, region: Vec::new(), mask: Mask::None, tint: None }
    }
}

/// How painted fields show. Opacities are 0 (hidden) to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// Painted colour over the transfer function's: `mix(table, paint, paint.a · opacity)`.
    pub colour: f32,
    /// Segment colours: `mix(colour, segment, opacity)` where a visible segment's label is.
    pub labels: f32,
    /// The selection's tint: `mix(colour, selection_colour, s · opacity)`.
    pub selection: f32,
    /// Display-referred.
    pub selection_colour: [f32; 3],
    /// Colours of the labels; hidden or missing segments leave colour alone.
    pub segments: Segments,
}

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// From where.
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Distance of samples along the ray in mm, positive.
    pub step_mm: f64,
    /// Whether a sample of direct volume rendering stands for all matter since the sample before it, instead of for a step of what
    /// lies at it: no rings on smooth surfaces, at the same step. Surfaces and maxima do not change.
    pub refine: bool,
    /// How rays become colour.
    pub mode: Mode,
    /// `None`: unshaded. MIP is never shaded.
    pub lighting: Option<Lighting>,
    /// Colour and opacity.
    pub transfer: TransferFunction,
    /// What is drawn, in any order.
    pub bodies: Vec<Body>,
    /// Painted fields.
    pub overlay: Overlay,
    /// Meshes among the bodies, what cuts and what clips them.
    pub layers: Layers,
}
