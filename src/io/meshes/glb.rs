//! glTF 2.0 in one binary file (Khronos: "glTF 2.0 Specification", 2021): a header, a piece of JSON and the arrays.
//!
//! The mesh keeps its corners in RAS+ mm under a root node that makes metres of them and turns them to where glTF has things: up is
//! +y, the front looks along +z, and right, as whoever looks out of it has it, is −x.

use crate::io::meshes::{LeavingMesh, MeshFormat, one_line};
use crate::math::DVec3;
use serde_json::json;
use std::io::{Result, Write};

pub(super) const FORMAT: MeshFormat = MeshFormat {
    name: "glTF",
    about: "In metres and upright, with colour and normals; viewers on the web and Blender read it",
    endings: &[".glb"],
    // Lengths are of 32 bits.
    most_bytes: u32::MAX as u64 / 2,
    write,
};

/// Of a piece of the file.
const JSON: &[u8; 4] = b"JSON";
const BINARY: &[u8; 4] = b"BIN\0";
/// What an array is for, and what its numbers are.
const ARRAY: u32 = 34_962;
const ELEMENTS: u32 = 34_963;
const FLOATS: u32 = 5126;
const WHOLE: u32 = 5125;
/// Half a turn about the bisector of y and z: right becomes −x, front z, up y.
const UPRIGHT: [f64; 4] = [0.0, std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 0.0];
const METRES_PER_MM: f64 = 0.001;

fn write(leaving: &LeavingMesh<'_>, out: &mut dyn Write) -> Result<()> {
    let (corners, triangles) = (leaving.mesh.corners(), leaving.mesh.triangles());
    let [places, indices] = [corners.len() * 12, triangles.len() * 12];
    let ends = |pick: fn(f32, f32) -> f32, start: f32| {
        corners.iter().fold([start; 3], |ends, c| std::array::from_fn(|a| pick(ends[a], c[a])))
    };
    // Colours of a material are linear.
    let linear = leaving.colour.map(|c| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) });
    let (name, metres) = (one_line(leaving.name), [METRES_PER_MM; 3]);
    let about = json!({
        "asset": {"version": "2.0", "generator": "Burin"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "RAS millimetres", "rotation": UPRIGHT, "scale": metres, "children": [1]},
            {"name": name, "mesh": 0},
        ],
        "meshes": [{"name": name, "primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0, "mode": 4,
        }]}],
        "materials": [{"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": [linear[0], linear[1], linear[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6,
        }}],
        "accessors": [
            {"bufferView": 0, "componentType": FLOATS, "count": corners.len(), "type": "VEC3",
             "min": ends(f32::min, f32::INFINITY), "max": ends(f32::max, f32::NEG_INFINITY)},
            {"bufferView": 1, "componentType": FLOATS, "count": corners.len(), "type": "VEC3"},
            {"bufferView": 2, "componentType": WHOLE, "count": triangles.len() * 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": places, "target": ARRAY},
            {"buffer": 0, "byteOffset": places, "byteLength": places, "target": ARRAY},
            {"buffer": 0, "byteOffset": 2 * places, "byteLength": indices, "target": ELEMENTS},
        ],
        "buffers": [{"byteLength": 2 * places + indices}],
    });
    let mut text = serde_json::to_vec(&about)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = 2 * places + indices;
    out.write_all(b"glTF")?;
    for number in [2, 12 + 8 + text.len() + 8 + binary, text.len()] {
        out.write_all(&(number as u32).to_le_bytes())?;
    }
    out.write_all(JSON)?;
    out.write_all(&text)?;
    out.write_all(&(binary as u32).to_le_bytes())?;
    out.write_all(BINARY)?;
    for number in corners.iter().chain(&normals(corners, triangles)).flatten() {
        out.write_all(&number.to_le_bytes())?;
    }
    for corner in triangles.iter().flatten() {
        out.write_all(&corner.to_le_bytes())?;
    }
    Ok(())
}

/// Of each corner the direction outward, of length 1: the mean of its triangles' by their area.
fn normals(corners: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; corners.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| DVec3::from_array(corners[i as usize].map(f64::from)));
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|i| sums[*i as usize] += normal);
    }
    // A corner without a direction of its own has any.
    sums.into_iter().map(|sum| sum.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array()).collect()
}
