//! What a picture holds besides bodies: opaque meshes, closed meshes that cut, pictures on surfaces, planes that clip.
//!
//! Plain data. Layers stand in the world as posed and act on all bodies, exploded ones too. Knows nothing of how they are drawn.

use crate::gpu::device::constants::{KEEPS_BEFORE, KEEPS_BEHIND, KEEPS_INSIDE};
use crate::gpu::picture::decal::Decal;
use crate::math::{DVec3, Plane, Pose};
use crate::mesh::TriangleMesh;
use crate::volume::Lighting;
use std::sync::Arc;

/// Something opaque among the bodies. Both of its sides show.
#[derive(Clone, Debug, PartialEq)]
pub struct OpaqueMesh {
    /// The caller's name for it, among those of bodies; pictures hold `id + 1`.
    pub id: u32,
    /// Its triangles; they need not be closed.
    pub mesh: Arc<TriangleMesh>,
    /// `world_from_mesh`.
    pub pose: Pose,
    /// Display-referred.
    pub colour: [f32; 3],
    /// By the normals of its triangles; `None`: its colour as it is, whatever the frame's light.
    pub lighting: Option<Lighting>,
}

/// A closed mesh; rays leave out what of bodies lies inside it, where the mesh winds about a place. An iso-surface is capped there.
#[derive(Clone, Debug, PartialEq)]
pub struct CutMesh {
    /// The caller's name for it; see [`Body::spared_by`](crate::gpu::Body).
    pub id: u32,
    /// Its triangles. Where they leave a hole, what lies inside is anyone's guess.
    pub mesh: Arc<TriangleMesh>,
    /// `world_from_mesh`.
    pub pose: Pose,
}

/// A ball that divides every ray into the pieces before it, inside it and behind it, of which one is drawn. A surface is capped where
/// it begins at the ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// World mm, as posed.
    pub centre: DVec3,
    /// Positive.
    pub radius_mm: f64,
    /// The piece.
    pub keeps: Keeps,
    /// Whether only contours of it are drawn.
    pub contour: bool,
}

/// A piece of a ray. One that misses the ball lies before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keeps {
    /// Up to the ball.
    Before,
    /// In it.
    Inside,
    /// From where the ray leaves it.
    Behind,
}

impl Keeps {
    /// As shaders have it.
    pub(crate) fn number(self) -> u32 {
        match self {
            Self::Before => KEEPS_BEFORE,
            Self::Inside => KEEPS_INSIDE,
            Self::Behind => KEEPS_BEHIND,
        }
    }
}

/// The layers of a frame; `Default` has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Rays end at them; their colour lies behind what a ray gathered.
    pub opaque: Vec<OpaqueMesh>,
    /// What lies inside any of them is not there.
    pub cuts: Vec<CutMesh>,
    /// Pictures on surfaces, each among the matter that it lies on.
    pub decals: Vec<Decal>,
    /// Of bodies only what lies on the inner side of all of them is there. World mm.
    pub clips: Vec<Plane>,
    /// Of every ray only a piece is drawn.
    pub ball: Option<Ball>,
}
