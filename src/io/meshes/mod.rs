//! Formats of triangle meshes, a file each. A new one is its file and its line in [`FORMATS`].
//!
//! Meshes leave in the world's RAS+ mm, said so where a format has room for words; glTF, whose unit is the metre and whose up is y, has
//! a root node that scales and turns. Owns what a format writes; knows neither paths nor what the mesh is of.

mod glb;
mod obj;
mod ply;
mod stl;

use crate::mesh::TriangleMesh;
use std::io::Write;

/// A mesh on its way out.
#[derive(Debug)]
pub(super) struct LeavingMesh<'a> {
    /// Corners in world mm.
    pub(super) mesh: &'a TriangleMesh,
    /// What it is called.
    pub(super) name: &'a str,
    /// Display-referred red, green, blue, 0..1.
    pub(super) colour: [f32; 3],
}

/// A format that meshes can leave in.
pub(super) struct MeshFormat {
    /// What people know it by.
    pub(super) name: &'static str,
    /// What it holds or who reads it, a sentence without its stop.
    pub(super) about: &'static str,
    /// How its files' names end, lower case, the usual one first.
    pub(super) endings: &'static [&'static str],
    /// The most bytes of corners and triangles that it has room for.
    pub(super) most_bytes: u64,
    pub(super) write: fn(&LeavingMesh<'_>, &mut dyn Write) -> std::io::Result<()>,
}

/// All, the usual one first.
pub(super) const FORMATS: [MeshFormat; 4] = [stl::FORMAT, ply::FORMAT, obj::FORMAT, glb::FORMAT];

/// Words in files that say which way the axes go; 3D Slicer reads them.
const SPACE: &str = "SPACE=RAS";

/// A name on one line, without what ends it elsewhere.
fn one_line(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}
