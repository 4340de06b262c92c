//! Wavefront OBJ: text, a line a corner and a line a triangle, corners counted from 1.

use crate::io::meshes::{LeavingMesh, MeshFormat, SPACE, one_line};
use std::io::{Result, Write};

pub(super) const FORMAT: MeshFormat = MeshFormat {
    name: "OBJ",
    about: "Text, in mm; nearly every 3D program reads it",
    endings: &[".obj"],
    most_bytes: u64::MAX,
    write,
};

fn write(leaving: &LeavingMesh<'_>, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "# Burin, millimetres, {SPACE}")?;
    writeln!(out, "o {}", one_line(leaving.name))?;
    for [x, y, z] in leaving.mesh.corners() {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for triangle in leaving.mesh.triangles() {
        let [a, b, c] = triangle.map(|corner| u64::from(corner) + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}
