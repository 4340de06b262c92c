//! What leaves a sub-volume: surfaces and voxels at its resolution, where it lies; and what a volume leaves with its sub-volumes in it.

use super::connected::say;
use super::connected_across::fill;
use super::maker::{run, write_nrrd};
use burin::document::Document;
use burin::math::{DAffine3, DMat3, DQuat, DVec3, Pose};
use burin::volume::*;
use serde_json::{Value, json};
use std::path::Path;

const LO: [u32; 3] = [3, 2, 4];

/// A volume that is turned, of unequal spacings, and moved by hand, with a box.
fn boxed(folder: &Path, spacing: DVec3, hi: [u32; 3], scale: [u32; 3]) -> (Document, Grid) {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let matrix3 = turned * DMat3::from_diagonal(spacing);
    let grid =
        Grid { dims: [22, 20, 21], world_from_index: DAffine3 { matrix3, translation: DVec3::new(9.0, -5.0, 7.0) } };
    let path = folder.join("a.nrrd");
    write_nrrd(&path, &grid, |[x, y, z]| (x + 2 * y + 3 * z) as f32);
    let mut document = Document::new();
    document.keep_unsaved_in(folder.join("unsaved"));
    say(&mut document, json!({"volume": {"open": {"path": path}}}));
    let pose = Pose { rotation: DQuat::from_rotation_z(0.5), translation: DVec3::new(4.0, 13.0, 2.0) };
    say(&mut document, json!({"volume": {"set": {"volume": 0, "pose": pose}}}));
    say(&mut document, json!({"sub_volume": {"add": {"lo": LO, "hi": hi, "scale": scale}}}));
    // Where its samples lie, by the parent's own numbers.
    let fine = DMat3::from_diagonal(DVec3::from_array(scale.map(|s| 1.0 / f64::from(s))));
    let own = DAffine3 { matrix3: fine, translation: DVec3::from_array(LO.map(f64::from)) };
    let lies = Grid {
        dims: std::array::from_fn(|a| (hi[a] - LO[a]) * scale[a] + 1),
        world_from_index: pose.world_from_rest() * grid.world_from_index * own,
    };
    (document, lies)
}

fn place(v: [u32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Corners and triangles of an OBJ.
fn read(path: &Path) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| line.split(' ').skip(1).map(str::to_owned).collect::<Vec<_>>();
    let of = |kind: &str| text.lines().filter(|line| line.starts_with(kind)).map(numbers).collect::<Vec<_>>();
    let corners =
        of("v ").into_iter().map(|n| DVec3::from_slice(&n.iter().map(|n| n.parse().unwrap()).collect::<Vec<f64>>()));
    let index = |n: &String| n.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
    let triangles = of("f ").into_iter().map(|n| [index(&n[0]), index(&n[1]), index(&n[2])]);
    (corners.collect(), triangles.collect())
}

/// Every edge is of two triangles that go along it in opposite ways.
fn is_closed(triangles: &[[usize; 3]]) -> bool {
    let mut edges = std::collections::HashMap::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_insert(0) += 1;
        }
    }
    !triangles.is_empty() && edges.iter().all(|((a, b), n)| *n == 1 && edges.get(&(*b, *a)) == Some(&1))
}

fn enclosed(corners: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
    triangles.iter().map(|t| corners[t[0]].dot(corners[t[1]].cross(corners[t[2]])) / 6.0).sum()
}

fn export(document: &mut Document, what: Value) -> Value {
    say(document, json!({"sub_volume": {"export": what}}))["exported"].clone()
}

#[test]
fn a_selection_of_a_box_leaves_as_the_level_set_of_its_samples_where_the_box_lies() {
    let folder = tempfile::tempdir().unwrap();
    let (hi, scale) = ([17, 15, 18], [2, 3, 1]);
    let (mut document, grid) = boxed(folder.path(), DVec3::new(0.8, 1.1, 1.7), hi, scale);
    // Soft over some samples, and out through a face of the box.
    let middle = DVec3::new(12.3, 20.2, 4.1);
    let value = |p: DVec3| ((0.5 + (9.0 - p.distance(middle)) / 6.0).clamp(0.0, 1.0) * 255.0).round();
    fill(&mut document, 1, FieldKind::Selection, |v| value(place(v)));
    let path = folder.path().join("s.obj");
    let said = export(&mut document, json!({"volume": 1, "field": "selection", "path": path}));
    let (corners, triangles) = read(&path);
    assert!(is_closed(&triangles) && said["closed"] == json!(true));
    assert_eq!(said["vertices"], json!(corners.len()));
    let texel = |v: DVec3| value(v);
    let mut inner = 0;
    for corner in &corners {
        let at = grid.index_from_world().transform_point3(*corner);
        let far = grid.dims_f64() - 1.0;
        // Beyond the outermost samples it is closed off.
        if (at - DVec3::splat(0.5)).min_element() < 0.0 || (far - 0.5 - at).min_element() < 0.0 {
            continue;
        }
        inner += 1;
        let (base, part) = (at.floor(), at - at.floor());
        let mut sum = 0.0;
        let mut slope = DVec3::ZERO;
        for corner in 0..8_u32 {
            let step = DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2));
            let share = |a: usize| if step[a] == 1.0 { part[a] } else { 1.0 - part[a] };
            sum += share(0) * share(1) * share(2) * texel(base + step);
            for a in 0..3 {
                slope[a] += (2.0 * step[a] - 1.0) * share((a + 1) % 3) * share((a + 2) % 3) * texel(base + step);
            }
        }
        let off = (sum - 127.5).abs() / slope.length();
        assert!(off <= 0.1, "{at}: {off} samples off the level");
    }
    assert!(inner > 500, "{inner}");
}

#[test]
fn a_label_of_a_box_leaves_smooth_and_as_large_as_it_is_also_where_the_box_ends() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, grid) = boxed(folder.path(), DVec3::splat(1.2), [17, 16, 18], [2; 3]);
    let middle = DVec3::new(14.2, 13.7, 14.4);
    fill(&mut document, 1, FieldKind::Labels, |v| if place(v).distance(middle) <= 12.0 { 4.0 } else { 0.0 });
    say(&mut document, json!({"segment": {"set": {"id": 4, "name": "ball"}}}));
    let path = folder.path().join("l.obj");
    export(&mut document, json!({"volume": 1, "field": "labels", "label": 4, "path": path}));
    let (corners, triangles) = read(&path);
    assert!(is_closed(&triangles));
    let sample = 0.6;
    let centre = grid.world_from_index.transform_point3(middle);
    for corner in &corners {
        let off = corner.distance(centre) / sample - 12.0;
        assert!(
            off.abs() < 1.0,
            "{off} samples: a face lies up to half of one off the ball, a corner half of one off its face"
        );
    }
    let volume = enclosed(&corners, &triangles);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * (12.0 * sample).powi(3);
    assert!((volume / ball - 1.0).abs() < 0.01, "{volume}, {ball} expected");
    let (mut sum, mut area) = (0.0, 0.0);
    for t in &triangles {
        let [a, b, c] = t.map(|i| corners[i]);
        let normal = (b - a).cross(c - a);
        let outward = ((a + b + c) / 3.0 - centre).normalize();
        sum += normal.length() * normal.normalize().dot(outward).clamp(-1.0, 1.0).acos().to_degrees().powi(2);
        area += normal.length();
    }
    let rms = (sum / area).sqrt();
    println!("normals of a ball of 12 samples: {rms:.2}° RMS");
    assert!(rms < 3.0, "{rms}");
    // All of the box: closed at its faces.
    fill(&mut document, 1, FieldKind::Labels, |_| 4.0);
    export(&mut document, json!({"volume": 1, "field": "labels", "label": 4, "path": path}));
    let (corners, triangles) = read(&path);
    assert!(is_closed(&triangles));
    let whole = grid.dims.iter().map(|d| f64::from(*d)).product::<f64>() * sample.powi(3);
    assert!((enclosed(&corners, &triangles) / whole - 1.0).abs() < 0.01);
    // Every format has the same triangles; glTF in metres.
    for ending in ["stl", "ply", "glb"] {
        let path = folder.path().join(format!("l.{ending}"));
        let said = export(&mut document, json!({"volume": 1, "field": "labels", "label": 4, "path": path}));
        assert_eq!(said["triangles"], json!(triangles.len()), "{ending}");
    }
    let glb = std::fs::read(folder.path().join("l.glb")).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let root = head["scenes"][0]["nodes"][0].as_u64().unwrap() as usize;
    let node = &head["nodes"][root];
    assert!(node["scale"] == json!([0.001, 0.001, 0.001]) && node["rotation"].is_array(), "{node}");
}

/// The numbers in brackets of a line of an NRRD's head.
fn vectors(head: &str, name: &str) -> Vec<DVec3> {
    let line = head.lines().find_map(|line| line.strip_prefix(&format!("{name}: "))).unwrap();
    let numbers: Vec<f64> =
        line.split(['(', ')', ',', ' ']).filter(|word| !word.is_empty()).filter_map(|n| n.parse().ok()).collect();
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

#[test]
fn voxels_of_a_box_leave_with_their_own_directions_and_the_first_sample_at_the_boxs_corner() {
    let folder = tempfile::tempdir().unwrap();
    let scale = [2, 3, 4];
    let (mut document, grid) = boxed(folder.path(), DVec3::new(0.8, 1.1, 1.7), [12, 9, 11], scale);
    let heads = [0, 1].map(|volume| {
        let path = folder.path().join(format!("out{volume}.nrrd"));
        say(&mut document, json!({"volume": {"export": {"volume": volume, "field": "density", "path": path}}}));
        let bytes = std::fs::read(&path).unwrap();
        let end = bytes.windows(2).position(|pair| pair == b"\n\n").unwrap();
        String::from_utf8(bytes[..end].to_vec()).unwrap()
    });
    let [parent, own] =
        heads.each_ref().map(|head| (vectors(head, "space directions"), vectors(head, "space origin")[0]));
    let mut origin = parent.1;
    for a in 0..3 {
        let expected = parent.0[a] / f64::from(scale[a]);
        assert!(own.0[a].distance(expected) < 1e-9, "{a}: {}, {expected} expected", own.0[a]);
        origin += parent.0[a] * f64::from(LO[a]);
    }
    assert!(own.1.distance(origin) < 1e-9, "{}, {origin} expected: no half sample beside it", own.1);
    assert!(heads[1].contains(&format!("sizes: {} {} {}", grid.dims[0], grid.dims[1], grid.dims[2])), "{}", heads[1]);
}

#[test]
fn a_volume_leaves_as_it_is_and_says_what_is_finer_than_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = boxed(folder.path(), DVec3::ONE, [12, 9, 11], [2; 3]);
    let file = |name: &str| folder.path().join(name);
    let export = |document: &mut Document, name: &str| {
        say(document, json!({"volume": {"export": {"volume": 0, "field": "density", "path": file(name)}}}))
    };
    let said = export(&mut document, "unedited.nrrd");
    assert_eq!(said["warnings"], json!([]), "nothing is edited");
    let density = document.state().unwrap().volumes[&VolumeId(1)].density.clone();
    fill(&mut document, 1, FieldKind::Density, |v| density.number(v).unwrap().to_f64() + 40.0);
    let said = export(&mut document, "edited.nrrd");
    assert!(said["warnings"][0].as_str().unwrap().contains("sub_volume.export"), "{said}");
    let bytes = |name: &str| std::fs::read(file(name)).unwrap();
    assert_eq!(bytes("edited.nrrd"), bytes("unedited.nrrd"), "the volume's own voxels");
    // What is baked is in the file, and is there once whether the box stays or goes.
    say(&mut document, json!({"sub_volume": {"bake": {"volume": 1}}}));
    export(&mut document, "baked.nrrd");
    say(&mut document, json!({"sub_volume": {"remove": {"volume": 1}}}));
    let said = export(&mut document, "removed.nrrd");
    assert_eq!(said["warnings"], json!([]));
    assert_eq!(bytes("baked.nrrd"), bytes("removed.nrrd"));
    assert_ne!(bytes("baked.nrrd"), bytes("unedited.nrrd"));
    // A surface that only a box has is asked for there.
    let label = |v: [u32; 3]| if v[0] > 4 { 3.0 } else { 0.0 };
    say(&mut document, json!({"sub_volume": {"add": {"lo": LO, "hi": [12, 9, 11], "scale": 2}}}));
    say(&mut document, json!({"segment": {"set": {"id": 3}}}));
    fill(&mut document, 2, FieldKind::Labels, label);
    let line = json!({"volume": {"export": {"volume": 0, "field": "labels", "label": 3, "path": file("a.stl")}}});
    let refused = run(&mut document, &line.to_string()).unwrap_err().to_string();
    assert!(refused.contains("no voxel") && refused.contains("sub_volume.export"), "{refused}");
}
