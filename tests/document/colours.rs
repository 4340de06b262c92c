//! Files of colour voxels: brightness as density, colours in the colour field, kept like paint.

use super::maker::run;
use crate::common::one::One;
use burin::document::{Document, ReadDocument, ViewName, recovery};
use burin::math::{DVec2, DVec3};
use burin::volume::FieldKind;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const DIMS: [usize; 3] = [40, 20, 6];

/// Red rises with x, green with y; blue is 200 in the left half; alpha, where it is, 255 but for the first slice.
fn voxel(x: usize, y: usize, z: usize) -> [u8; 4] {
    [(x * 6) as u8, (y * 12) as u8, if x < 20 { 200 } else { 10 }, if z == 0 { 51 } else { 255 }]
}

fn voxels(channels: usize) -> Vec<u8> {
    let [nx, ny, nz] = DIMS;
    let at = |i: usize| voxel(i % nx, i / nx % ny, i / (nx * ny));
    (0..nx * ny * nz).flat_map(|i| at(i)[..channels].to_vec()).collect()
}

fn nrrd(folder: &Path, channels: usize, kind: &str) -> PathBuf {
    let [nx, ny, nz] = DIMS;
    let path = folder.join("c.nrrd");
    let mut file = format!(
        "NRRD0004\ntype: uchar\ndimension: 4\nspace: right-anterior-superior\nsizes: {channels} {nx} {ny} {nz}\n\
         space directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: {kind} domain domain domain\nencoding: raw\n\n"
    )
    .into_bytes();
    file.extend(voxels(channels));
    std::fs::write(&path, file).unwrap();
    path
}

fn nifti(folder: &Path, channels: usize) -> PathBuf {
    let mut file = vec![0_u8; 352];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (i, n) in [3, DIMS[0], DIMS[1], DIMS[2], 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &(n as i16).to_le_bytes());
        put(76 + 4 * i, &1.0_f32.to_le_bytes());
    }
    put(70, &if channels == 3 { 128_i16 } else { 2304 }.to_le_bytes());
    put(72, &(8 * channels as i16).to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    put(344, b"n+1\0");
    file.extend(voxels(channels));
    let path = folder.join("c.nii");
    std::fs::write(&path, file).unwrap();
    path
}

fn open(path: &Path, extra: Value) -> Document {
    let mut document = Document::new();
    let mut command = json!({ "path": path });
    command.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
    run(&mut document, &json!({"volume":{"open":command}}).to_string()).unwrap();
    document
}

/// Density and colour of a voxel as they are told.
fn told(document: &mut Document, at: [usize; 3]) -> (f64, Vec<f64>) {
    let said = run(document, &json!({"ask":{"voxel":{"at":{"index":at}}}}).to_string()).unwrap();
    (said["density"].as_f64().unwrap(), serde_json::from_value(said["colour"].clone()).unwrap())
}

fn check(document: &mut Document, channels: usize) {
    for at in [[0, 0, 0], [3, 4, 1], [39, 19, 5], [20, 7, 0], [31, 10, 3], [32, 10, 3]] {
        let [r, g, b, a] = voxel(at[0], at[1], at[2]).map(f64::from);
        let a = if channels == 4 { a / 255.0 } else { 1.0 };
        let (density, colour) = told(document, at);
        assert_eq!(density, ((0.2126 * r + 0.7152 * g + 0.0722 * b) * a).round(), "{at:?}");
        let off = colour.iter().zip([r / 255.0, g / 255.0, b / 255.0, a]).map(|(x, y)| (x - y).abs());
        assert!(off.fold(0.0, f64::max) < 1e-6, "{at:?}: {colour:?}");
    }
}

#[test]
fn colours_open_as_brightness_with_the_colour_field_filled() {
    let folder = tempfile::tempdir().unwrap();
    for channels in [3, 4] {
        let kinds = if channels == 3 { ["RGB-color", "3-color", "none"] } else { ["RGBA-color", "4-color", "none"] };
        for kind in kinds {
            check(&mut open(&nrrd(folder.path(), channels, kind), json!({})), channels);
        }
        check(&mut open(&nifti(folder.path(), channels), json!({})), channels);
    }
    // A component that is asked for is that component, and a vector is no colour.
    for (path, extra, component) in [
        (nrrd(folder.path(), 3, "RGB-color"), json!({ "component": 1 }), 1),
        (nrrd(folder.path(), 3, "vector"), json!({}), 0),
        (nifti(folder.path(), 3), json!({ "component": 2 }), 2),
    ] {
        let mut document = open(&path, extra);
        let (density, colour) = told(&mut document, [5, 6, 2]);
        assert_eq!(density, f64::from(voxel(5, 6, 2)[component]));
        assert_eq!(colour, [0.0; 4]);
    }
}

#[test]
fn colours_are_seen_in_slices() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut document = open(&nrrd(folder.path(), 3, "RGB-color"), json!({}));
    let rgba = document.picture(ViewName::Axial, [60, 60], None).unwrap().to_rgba8(None);
    let leads = |p: &[u8], c: usize| (0..3).all(|o| o == c || i32::from(p[c]) > i32::from(p[o]) + 30);
    let strong = |c: usize| rgba.chunks(4).filter(|p| p[3] > 200 && p[c] > 60 && leads(p, c)).count();
    assert!(strong(0) > 20 && strong(2) > 20, "red {} blue {}", strong(0), strong(2));
}

/// Between the eight voxels of the file about a place in voxels.
fn between(p: DVec3) -> [f64; 4] {
    let lo = p.floor();
    let tap = |i: usize, a: usize| (lo[a] as i64 + (i >> a & 1) as i64).clamp(0, DIMS[a] as i64 - 1) as usize;
    let weight = |i: usize, a: usize| if i >> a & 1 == 1 { p[a] - lo[a] } else { 1.0 - p[a] + lo[a] };
    std::array::from_fn(|c| {
        let share = |i: usize| (0..3).map(|a| weight(i, a)).product::<f64>();
        (0..8).map(|i| share(i) * f64::from(voxel(tap(i, 0), tap(i, 1), tap(i, 2))[c]) / 255.0).sum()
    })
}

/// Matter that lets nothing through: a pixel has the colour of the place where its ray first meets the volume.
#[test]
fn a_picture_in_three_dimensions_has_the_colours_of_the_file() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (path, channels) in [(nrrd(folder.path(), 3, "RGB-color"), 3), (nifti(folder.path(), 4), 4)] {
        let mut document = open(&path, json!({}));
        let own = [0.9, 0.1, 0.6];
        let function = json!({ "colour": [[0, own]], "opacity": [[0, 1]], "unit_mm": 1 });
        run(&mut document, &json!({"transfer":{"set":{"function":function}}}).to_string()).unwrap();
        // A sample that refines stands for a stretch, and has not one place whose colour could be told.
        run(&mut document, r#"{"view":{"look":{"mode":"dvr","shaded":false,"refine":false}}}"#).unwrap();
        for from in [[0.3, 1.0, 0.5], [-1.0, -0.4, -0.7], [0.1, 0.2, -1.0]] {
            run(&mut document, &json!({"view":{"frame":{"from":from}}}).to_string()).unwrap();
            let size = [64, 48];
            let image = document.picture(ViewName::ThreeD, size, None).unwrap();
            let camera = document.state().unwrap().scene.views.camera;
            let index_from_world = document.state().unwrap().one().grid().index_from_world();
            let mut seen = 0;
            for (i, colour) in image.colour.iter().enumerate().filter(|(_, c)| c[3] > 0.0) {
                let px = DVec2::new((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
                let at = index_from_world.transform_point3(camera.ray(px, size).at(f64::from(image.depth_mm[i])));
                let [r, g, b, a] = between(at);
                let a = if channels == 4 { a } else { 1.0 };
                for (c, paint) in [r, g, b].into_iter().enumerate() {
                    let expected = own[c] + (paint - own[c]) * a;
                    assert!(
                        (f64::from(colour[c]) - expected).abs() < 1.5 / 255.0,
                        "{at}: {colour:?} for {expected} in {c}"
                    );
                }
                seen += 1;
            }
            assert!(seen > 300, "{seen}");
        }
    }
}

#[test]
fn colours_are_kept_by_saves_and_recovery_and_are_no_step_of_undo() {
    let folder = tempfile::tempdir().unwrap();
    let path = nrrd(folder.path(), 4, "RGBA-color");
    let mut document = open(&path, json!({}));
    assert_eq!(document.history().undo_names().count(), 0);
    for density in ["whole", "linked"] {
        let project = folder.path().join(density);
        run(&mut document, &json!({"project":{"save":{"path":project,"density":density}}}).to_string()).unwrap();
        let mut again = Document::new();
        again.take(ReadDocument::project_to_read(&project, Default::default(), &|_| true).unwrap());
        check(&mut again, 4);
    }
    // A crash right after opening loses nothing, one after the first step brings it back with the colours of the file.
    let unsaved = folder.path().join("unsaved");
    let origin = burin::document::Origin { path, component: burin::document::USUAL_COMPONENT, frame: 0 };
    let opened = || ReadDocument::volume(origin.clone(), None, Default::default(), Some(&unsaved), &|_| true).unwrap();
    drop(opened());
    assert_eq!(recovery::list(&unsaved).unwrap(), []);
    let mut document = Document::new();
    document.take(opened());
    run(&mut document, r#"{"segment":{"set":{"id":1,"name":"bone"}}}"#).unwrap();
    drop(document);
    let lost = recovery::list(&unsaved).unwrap();
    assert_eq!(lost.len(), 1);
    let mut document = Document::new();
    document.take(ReadDocument::lost(&unsaved, &lost[0].id, &|_| true).unwrap());
    check(&mut document, 4);
    assert!(!document.state().unwrap().one().field(FieldKind::Colour).is_blank());
}

#[test]
fn colours_of_any_type_open_as_brightness_with_the_colour_field_filled() {
    let folder = tempfile::tempdir().unwrap();
    let [nx, ny, nz] = DIMS;
    let wide = |of: &dyn Fn(u8) -> Vec<u8>| voxels(4).iter().flat_map(|&v| of(v)).collect::<Vec<u8>>();
    let of_16_bit = wide(&|v| (u16::from(v) * 257).to_be_bytes().to_vec());
    let of_float = wide(&|v| (f32::from(v) / 255.0).to_le_bytes().to_vec());
    for (word, endian, full, data) in [("ushort", "big", 65_535.0, of_16_bit), ("float", "little", 1.0, of_float)] {
        let path = folder.path().join("w.nrrd");
        let mut file = format!(
            "NRRD0004\ntype: {word}\ndimension: 4\nsizes: 4 {nx} {ny} {nz}\nspacings: nan 1 1 1\nendian: {endian}\n\
             kinds: RGBA-color domain domain domain\nencoding: raw\n\n"
        )
        .into_bytes();
        file.extend(&data);
        std::fs::write(&path, file).unwrap();
        let mut document = open(&path, json!({}));
        for at in [[0, 0, 0], [3, 4, 1], [39, 19, 5], [20, 7, 0], [31, 10, 3], [32, 10, 3]] {
            let [r, g, b, a] = voxel(at[0], at[1], at[2]).map(|v| f64::from(v) / 255.0);
            let (density, colour) = told(&mut document, at);
            let luma = (0.2126 * r + 0.7152 * g + 0.0722 * b) * a * full;
            let exact = if full == 1.0 { 1e-6 } else { 0.5 + 1e-6 };
            assert!((density - luma).abs() <= exact, "{word} {at:?}: {density} {luma}");
            let off = colour.iter().zip([r, g, b, a]).map(|(x, y)| (x - y).abs());
            assert!(off.fold(0.0, f64::max) < 1e-6, "{word} {at:?}: {colour:?}");
        }
        // A part alone is still to be had, as the file has it.
        let green = told(&mut open(&path, json!({ "component": 1 })), [3, 4, 1]);
        let expected = f64::from(voxel(3, 4, 1)[1]) / 255.0 * full;
        assert!((green.0 - expected).abs() < 1e-6 * full && green.1 == [0.0; 4], "{word} {green:?}");
    }
}
