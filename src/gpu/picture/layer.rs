//! What a picture holds besides bodies: opaque meshes, closed meshes that cut, planes that clip.
//!
//! Plain data. Layers stand in the world as posed and act on all bodies, exploded ones too. Knows nothing of how they are drawn.

use crate::math::{Plane, Pose};
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
    /// Its triangles. Where they leave a hole, what lies inside is anyone's guess.
    pub mesh: Arc<TriangleMesh>,
    /// `world_from_mesh`.
    pub pose: Pose,
}

/// The layers of a frame; `Default` has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Rays end at them; their colour lies behind what a ray gathered.
    pub opaque: Vec<OpaqueMesh>,
    /// What lies inside any of them is not there.
    pub cuts: Vec<CutMesh>,
    /// Of bodies only what lies on the inner side of all of them is there. World mm.
    pub clips: Vec<Plane>,
}
