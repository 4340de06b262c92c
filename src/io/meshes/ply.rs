//! PLY, binary and little-endian: corners with their colour, then triangles by the numbers of their corners.

use crate::io::meshes::{LeavingMesh, MeshFormat, SPACE, one_line};
use std::io::{Result, Write};

pub(super) const FORMAT: MeshFormat = MeshFormat {
    name: "PLY",
    about: "Triangles that share corners, in mm, with a colour; MeshLab, CloudCompare and 3D Slicer read it",
    endings: &[".ply"],
    most_bytes: u64::MAX,
    write,
};

fn write(leaving: &LeavingMesh<'_>, out: &mut dyn Write) -> Result<()> {
    let (corners, triangles) = (leaving.mesh.corners(), leaving.mesh.triangles());
    // The words of a header are ASCII.
    let name: String = one_line(leaving.name).chars().map(|c| if c.is_ascii() { c } else { '?' }).collect();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment Burin, millimetres, {SPACE}\ncomment {name}\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        corners.len(),
        triangles.len()
    )?;
    let colour = leaving.colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
    for corner in corners {
        for number in corner {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&colour)?;
    }
    for triangle in triangles {
        out.write_all(&[3])?;
        for corner in triangle {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}
