//! STL, binary: 80 bytes of words, then every triangle with its normal and its three corners.

use crate::io::meshes::{LeavingMesh, MeshFormat, SPACE};
use crate::math::DVec3;
use std::io::{Result, Write};

pub(super) const FORMAT: MeshFormat = MeshFormat {
    name: "STL",
    about: "Triangles in mm; programs for printing and design read it",
    endings: &[".stl"],
    most_bytes: u64::MAX,
    write,
};

fn write(leaving: &LeavingMesh<'_>, out: &mut dyn Write) -> Result<()> {
    // Not "solid" at its beginning, which would mean text.
    let mut header = format!("Burin, millimetres, {SPACE}").into_bytes();
    header.resize(80, b' ');
    out.write_all(&header)?;
    let (corners, triangles) = (leaving.mesh.corners(), leaving.mesh.triangles());
    out.write_all(&(triangles.len() as u32).to_le_bytes())?;
    for triangle in triangles {
        let places = triangle.map(|i| corners[i as usize]);
        let [a, b, c] = places.map(|p| DVec3::from_array(p.map(f64::from)));
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
        let mut bytes = [0; 50];
        let numbers = std::iter::once(normal).chain(places).flatten();
        for (to, number) in bytes.chunks_exact_mut(4).zip(numbers) {
            to.copy_from_slice(&number.to_le_bytes());
        }
        out.write_all(&bytes)?;
    }
    Ok(())
}
