//! Mesh files against their formats: read back by what these say, they are the mesh that left.

use burin::io::{IoError, export_mesh, is_mesh, mesh_endings};
use burin::math::{Aabb, DQuat, DVec3, DVec4};
use burin::mesh::TriangleMesh;
use serde_json::Value;
use std::path::Path;

type Triangles = Vec<[[f32; 3]; 3]>;

fn sample() -> TriangleMesh {
    let bounds = Aabb { min: DVec3::new(-3.25, 10.5, 100.0), max: DVec3::new(7.0, 12.75, 104.5) };
    TriangleMesh::cuboid(&bounds)
}

fn triangles(mesh: &TriangleMesh) -> Triangles {
    mesh.triangles().iter().map(|t| t.map(|i| mesh.corners()[i as usize])).collect()
}

fn write(folder: &Path, name: &str) -> Vec<u8> {
    let path = folder.join(name);
    let said = export_mesh(&path, &sample(), "left\n lobe", [0.5, 0.25, 1.0]).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!((said.triangles, said.vertices, said.closed), (12, 8, true));
    assert_eq!(said.bytes, bytes.len() as u64);
    assert!((said.volume_mm3 - 10.25 * 2.25 * 4.5).abs() < 1e-4);
    bytes
}

fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn whole(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn vector(bytes: &[u8], at: usize) -> [f32; 3] {
    std::array::from_fn(|a| float(bytes, at + 4 * a))
}

#[test]
fn an_stl_is_eighty_bytes_a_count_and_fifty_bytes_a_triangle() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = write(folder.path(), "a.STL");
    assert!(!bytes.starts_with(b"solid"), "that would be text");
    assert!(String::from_utf8_lossy(&bytes[..80]).contains("SPACE=RAS"));
    assert_eq!(whole(&bytes, 80), 12);
    assert_eq!(bytes.len(), 84 + 12 * 50);
    let mut found = Triangles::new();
    for i in 0..12 {
        let at = 84 + i * 50;
        let corners: [[f32; 3]; 3] = std::array::from_fn(|c| vector(&bytes, at + 12 + 12 * c));
        let [a, b, c] = corners.map(|p| DVec3::from_array(p.map(f64::from)));
        let normal = DVec3::from_array(vector(&bytes, at).map(f64::from));
        assert!(normal.distance((b - a).cross(c - a).normalize()) < 1e-6);
        assert_eq!(&bytes[at + 48..at + 50], [0, 0]);
        found.push(corners);
    }
    assert_eq!(found, triangles(&sample()));
}

#[test]
fn a_ply_has_the_header_that_its_body_keeps() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = write(folder.path(), "a.ply");
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
    assert!(header.contains("\ncomment left lobe\n") && header.contains("SPACE=RAS"), "{header}");
    let properties: Vec<&str> =
        header.lines().filter(|l| l.starts_with("property") || l.starts_with("element")).collect();
    assert_eq!(
        properties,
        [
            "element vertex 8",
            "property float x",
            "property float y",
            "property float z",
            "property uchar red",
            "property uchar green",
            "property uchar blue",
            "element face 12",
            "property list uchar int vertex_indices"
        ]
    );
    assert_eq!(bytes.len(), end + 8 * 15 + 12 * 13);
    let corner = |i: usize| vector(&bytes, end + 15 * i);
    assert_eq!(bytes[end + 12..end + 15], [128, 64, 255]);
    let face = |i: usize| {
        let at = end + 8 * 15 + 13 * i;
        assert_eq!(bytes[at], 3);
        std::array::from_fn(|c| corner(whole(&bytes, at + 1 + 4 * c) as usize))
    };
    assert_eq!((0..12).map(face).collect::<Triangles>(), triangles(&sample()));
}

#[test]
fn an_obj_counts_its_corners_from_one() {
    let folder = tempfile::tempdir().unwrap();
    let text = String::from_utf8(write(folder.path(), "a.obj")).unwrap();
    let numbers = |line: &str| line.split(' ').skip(1).map(|n| n.parse::<f32>().unwrap()).collect::<Vec<_>>();
    let corners: Vec<[f32; 3]> =
        text.lines().filter(|l| l.starts_with("v ")).map(|l| numbers(l).try_into().unwrap()).collect();
    let faces = text.lines().filter(|l| l.starts_with("f ")).map(|l| {
        let [a, b, c] = numbers(l).try_into().unwrap();
        [a, b, c].map(|n| corners[n as usize - 1])
    });
    assert_eq!(faces.collect::<Triangles>(), triangles(&sample()));
    assert!(text.lines().any(|l| l == "o left lobe"));
    assert_eq!(text.lines().filter(|l| !["v", "f", "o", "#"].contains(&&l[..1])).count(), 0);
}

#[test]
fn a_glb_stands_upright_in_metres_and_says_what_its_arrays_are() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = write(folder.path(), "a.glb");
    assert_eq!((&bytes[..4], whole(&bytes, 4), whole(&bytes, 8) as usize), (&b"glTF"[..], 2, bytes.len()));
    let json = whole(&bytes, 12) as usize;
    assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
    let about: Value = serde_json::from_slice(&bytes[20..20 + json]).unwrap();
    let at = 20 + json;
    let binary = whole(&bytes, at) as usize;
    assert_eq!((&bytes[at + 4..at + 8], at + 8 + binary), (&b"BIN\0"[..], bytes.len()));
    assert_eq!(about["buffers"][0]["byteLength"], binary);
    let body = &bytes[at + 8..];
    let array = |accessor: usize, kind: u64, shape: &str| {
        let accessor = &about["accessors"][accessor];
        assert_eq!((accessor["componentType"].as_u64(), accessor["type"].as_str()), (Some(kind), Some(shape)));
        let view = &about["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let [from, length] = ["byteOffset", "byteLength"].map(|k| view[k].as_u64().unwrap() as usize);
        (body[from..from + length].to_vec(), accessor["count"].as_u64().unwrap() as usize, accessor.clone())
    };
    let primitive = &about["meshes"][0]["primitives"][0];
    let number = |v: &Value| v.as_u64().unwrap() as usize;
    let (places, count, accessor) = array(number(&primitive["attributes"]["POSITION"]), 5126, "VEC3");
    let corners: Vec<[f32; 3]> = (0..count).map(|i| vector(&places, 12 * i)).collect();
    assert_eq!(accessor["min"], serde_json::json!([-3.25, 10.5, 100.0]));
    assert_eq!(accessor["max"], serde_json::json!([7.0, 12.75, 104.5]));
    let (indices, count, _) = array(number(&primitive["indices"]), 5125, "SCALAR");
    let found: Triangles =
        (0..count / 3).map(|t| std::array::from_fn(|c| corners[whole(&indices, 12 * t + 4 * c) as usize])).collect();
    assert_eq!(found, triangles(&sample()));
    let (normals, count, _) = array(number(&primitive["attributes"]["NORMAL"]), 5126, "VEC3");
    assert_eq!(count, corners.len());
    for (i, corner) in corners.iter().enumerate() {
        let normal = DVec3::from_array(vector(&normals, 12 * i).map(f64::from));
        assert!((normal.length() - 1.0).abs() < 1e-5);
        let outward = DVec3::from_array(corner.map(f64::from)) - DVec3::new(1.875, 11.625, 102.25);
        assert!(normal.dot(outward) > 0.0);
    }
    // The root turns superior up, anterior to the front, right to −x, and makes metres of millimetres.
    assert_eq!(about["scenes"][0]["nodes"], serde_json::json!([0]));
    let root = &about["nodes"][0];
    let numbers = |v: &Value| v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
    let turn = DQuat::from_vec4(DVec4::from_slice(&numbers(&root["rotation"])));
    let scale = DVec3::from_slice(&numbers(&root["scale"]));
    for (ras, there) in [(DVec3::X, -DVec3::X), (DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::Y)] {
        assert!((turn * (ras * 1000.0 * scale)).distance(there) < 1e-12, "{ras}");
    }
    assert_eq!(about["nodes"][number(&root["children"][0])]["mesh"], 0);
    assert_eq!(about["nodes"][1]["name"], "left lobe");
    // 0.5 of what a display is given is 0.214 of light.
    let colour = numbers(&about["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]);
    for (found, expected) in colour.iter().zip([0.214_041, 0.050_876, 1.0, 1.0]) {
        assert!((found - expected).abs() < 1e-5, "{colour:?}");
    }
}

#[test]
fn a_name_that_is_no_meshs_is_refused_and_the_old_file_stays_until_the_new_one_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let error = export_mesh(&path, &sample(), "a", [0.0; 3]).unwrap_err();
    assert!(matches!(&error, IoError::Field { field, .. } if field == "extension"), "{error}");
    assert!(error.to_string().contains("found nrrd; expected one of stl, ply, obj, glb"), "{error}");
    assert!(!path.exists());
    assert_eq!(mesh_endings().flatten().copied().collect::<Vec<_>>(), [".stl", ".ply", ".obj", ".glb"]);
    assert!(is_mesh(Path::new("/a/b.GLB")) && !is_mesh(Path::new("/a/stl")));
    // No folder: nothing is left beside it either.
    let gone = folder.path().join("none/a.stl");
    assert!(export_mesh(&gone, &sample(), "a", [0.0; 3]).is_err());
    std::fs::write(folder.path().join("b.stl"), b"old").unwrap();
    write(folder.path(), "b.stl");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_mesh_with_a_gap_or_a_doubled_edge_is_not_closed() {
    let whole = sample();
    let with = |triangles: Vec<[u32; 3]>| TriangleMesh::new(whole.corners().to_vec(), triangles).unwrap();
    assert!(whole.is_closed());
    assert!(!with(whole.triangles()[1..].to_vec()).is_closed());
    let mut turned = whole.triangles().to_vec();
    turned[0].swap(0, 1);
    assert!(!with(turned).is_closed());
    assert!(!with([whole.triangles(), whole.triangles()].concat()).is_closed());
    assert!(with(Vec::new()).is_closed());
}
