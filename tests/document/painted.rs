//! A brush takes every value, on any data, and what was painted comes back within the stated half step.

use super::maker::run;
use super::values_support::{Data, ask, density, voxel};
use crate::common::gpu::gpu;
use crate::common::one::One;
use crate::io::files::ALL_TYPES;
use burin::document::Document;
use burin::volume::{Brick, BrickIndex, Number, TexelFormat, Value as _, VoxelType, Voxels};
use burin::with_voxel_type;
use serde_json::{Value, json};

const DIMS: [u32; 3] = [36, 5, 3];
const COUNT: usize = 36 * 5 * 3;
const CENTRE: [f64; 3] = [31.0, 2.0, 1.0];
const RADIUS: f64 = 2.5;

fn number(value: &Value) -> f64 {
    serde_json::from_value::<Number>(value.clone()).unwrap().to_f64()
}

/// Sets a hard brush and clicks once.
fn paint(document: &mut Document, settings: Value) -> Value {
    let mut set = json!({"radius_mm":RADIUS,"falloff":"hard","strength":1,"tip":"wash","erase":false});
    set.as_object_mut().unwrap().extend(settings.as_object().unwrap().clone());
    run(document, &json!({"brush":{"set":set}}).to_string()).unwrap();
    run(document, &json!({"stroke":{"paint":{"points":[{"at":{"index":CENTRE}}]}}}).to_string()).unwrap()
}

fn half_step(document: &mut Document) -> f64 {
    ask(document, &json!({"volume":{}}))["half_step"].as_f64().unwrap()
}

/// Equation 1 as ERRATA has it: P′ = P + G·((C op P) − P). What is no finite number has nothing to mix with.
fn equation_1(p: f64, operation: &str, c: f64, g: f64) -> f64 {
    let end = match operation {
        "add" => p + c,
        "subtract" => p - c,
        _ => c,
    };
    match p.is_finite() {
        true => p + g * (end - p),
        false if g == 1.0 && operation == "replace" => c,
        false => p,
    }
}

/// Small numbers of a type, and what data of it commonly hold where there is none.
fn with_no_data(ty: VoxelType) -> Voxels {
    let mut voxels: Voxels = with_voxel_type!(ty, T => T::wrap((0..COUNT).map(|i| (i % 90) as T).collect()));
    // One in the ball that is painted, one outside.
    let (a, b) = (31 + 36 * (2 + 5), 3);
    match &mut voxels {
        Voxels::U8(v) => v[a] = 255,
        Voxels::I8(v) => v[a] = -128,
        Voxels::U16(v) => (v[a], v[b]) = (65_535, 65_535),
        Voxels::I16(v) => (v[a], v[b]) = (-32_768, 32_767),
        Voxels::U32(v) => (v[a], v[b]) = (u32::MAX, u32::MAX),
        Voxels::I32(v) => (v[a], v[b]) = (i32::MIN, i32::MAX),
        Voxels::U64(v) => (v[a], v[b]) = (u64::MAX, u64::MAX),
        Voxels::I64(v) => (v[a], v[b]) = (i64::MIN, i64::MAX),
        Voxels::F32(v) => (v[a], v[b]) = (f32::INFINITY, f32::NAN),
        Voxels::F64(v) => (v[a], v[b]) = (f64::NEG_INFINITY, -f64::MAX),
    }
    voxels
}

#[test]
fn every_stroke_is_taken_and_makes_what_equation_1_says() {
    if gpu().is_none() {
        return;
    }
    let plain = |ty: VoxelType| with_voxel_type!(ty, T => T::wrap((0..COUNT).map(|i| (i % 90) as T).collect()));
    for ty in ALL_TYPES {
        for (scaling, extra, voxels) in [
            ([0.0, 0.0], json!({}), plain(ty)),
            ([0.25, -3.0], json!({}), plain(ty)),
            ([0.0, 0.0], json!({"range":[10.0, 20.5]}), plain(ty)),
            ([0.0, 0.0], json!({}), with_no_data(ty)),
        ] {
            let data = Data { scaling, ..Data::new(voxels, DIMS) };
            let (mut document, _) = data.open(extra.clone());
            for (operation, c, g) in [
                ("add", 0.1, 1.0),
                ("replace", 88.3, 1.0),
                ("subtract", 1000.25, 1.0),
                ("replace", 5.0, 0.25),
                ("add", 7.0, 0.1),
                ("replace", 1e6, 1.0),
            ] {
                let what = format!("{ty:?} {scaling:?} {extra} {operation} {c} × {g}");
                let answer = paint(&mut document, json!({"operation":operation,"target":{"density":c},"strength":g}));
                let half_step = half_step(&mut document);
                assert!(half_step > 0.0 && half_step.is_finite(), "{what}: {half_step}");
                let mut changed = 0;
                for i in 0..COUNT {
                    let found = voxel(&mut document, data.place(i));
                    let [x, y, z]: [f64; 3] = std::array::from_fn(|a| f64::from(data.place(i)[a]) - CENTRE[a]);
                    if x * x + y * y + z * z > RADIUS * RADIUS {
                        assert_eq!(found["density"], data.said(i), "{what}: {i}");
                        continue;
                    }
                    // The strength is a 32-bit float.
                    let right = equation_1(data.value(i), operation, c, f64::from(g as f32));
                    let back = number(&found["density"]);
                    // f64 itself has no room for an offset to its largest numbers.
                    let off = if right == back { 0.0 } else { (back - right).abs() };
                    assert!(
                        off <= half_step,
                        "{what}: {back} for {right} from {}, half step {half_step}",
                        data.said(i)
                    );
                    // Near small numbers the step is small whatever else the data hold.
                    let own = found["half_step"].as_f64().unwrap();
                    assert!(own <= half_step && (right.abs() > 1e4 || own <= 0.07), "{what}: {own} at {right}");
                    changed += u64::from(found["density"] != data.said(i));
                }
                assert_eq!(answer["voxels_changed"], changed, "{what}");
                if changed > 0 {
                    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
                }
                assert_eq!(density(&mut document, [31, 2, 1]), data.said(31 + 36 * (2 + 5)), "{what}");
            }
        }
    }
}

#[test]
fn small_offsets_add_up_and_keep_their_fraction() {
    if gpu().is_none() {
        return;
    }
    for ty in [VoxelType::U8, VoxelType::I16, VoxelType::U16, VoxelType::F32] {
        let data = Data::new(with_voxel_type!(ty, T => T::wrap((0..COUNT).map(|i| (i % 100) as T).collect())), DIMS);
        let (mut document, _) = data.open(json!({}));
        let at = [31, 2, 1];
        let mut right = number(&density(&mut document, at));
        let strokes = [("add", 0.1), ("add", 0.4), ("replace", 254.3), ("add", 2.3), ("subtract", 0.1), ("add", 0.001)];
        for (n, (operation, value)) in strokes.into_iter().enumerate() {
            let set = json!({"operation":operation,"target":{"density":value},"falloff":"smooth"});
            assert!(paint(&mut document, set)["voxels_changed"].as_u64().unwrap() > 0);
            right = equation_1(right, operation, value, 1.0);
            let (back, half_step) = (number(&density(&mut document, at)), half_step(&mut document));
            assert!((back - right).abs() <= half_step * (n + 1) as f64, "{ty:?}: {back} for {right}");
            assert!(half_step < 1e-3);
        }
    }
}

#[test]
fn density_moves_to_floats_by_itself_and_back_by_undo_and_stays_so_in_a_project() {
    if gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let data = Data::new(Voxels::U16((0..COUNT).map(|i| (i * 121 % 65_536) as u16).collect()), DIMS);
    let (mut document, _) = data.open(json!({}));
    let format = |d: &Document| d.state().unwrap().one().density.format();
    let project = folder.path().join("p.burin");
    // The file is gone by now, so the project holds all of it.
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    assert_eq!(format(&document), TexelFormat::R16Unorm);
    paint(&mut document, json!({"operation":"add","target":{"density":0.1}}));
    assert_eq!(format(&document), TexelFormat::R32Float);
    let painted = density(&mut document, [31, 2, 1]);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(
        (format(&document), density(&mut document, [31, 2, 1])),
        (TexelFormat::R16Unorm, data.said(31 + 36 * 7))
    );
    run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap();
    assert_eq!((format(&document), density(&mut document, [31, 2, 1])), (TexelFormat::R32Float, painted.clone()));
    // From the journal alone, and from a save.
    for saved in [false, true] {
        if saved {
            run(&mut document, r#"{"project":{"save":{}}}"#).unwrap();
        }
        drop(document);
        document = Document::new();
        run(&mut document, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
        assert_eq!((format(&document), density(&mut document, [31, 2, 1])), (TexelFormat::R32Float, painted.clone()));
        for i in [0, 17, 70] {
            assert_eq!(density(&mut document, data.place(i)), data.said(i), "{saved}");
        }
    }
}

#[test]
fn an_export_has_the_sources_own_bytes_and_what_was_painted_in_its_type() {
    if gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for ty in ALL_TYPES {
        let data = Data { big: true, ..Data::new(with_no_data(ty), DIMS) };
        let (mut document, _) = data.open(json!({}));
        paint(&mut document, json!({"operation":"add","target":{"density":300.75}}));
        let path = folder.path().join("out.nrrd");
        run(&mut document, &json!({"volume":{"export":{"field":"density","path":path}}}).to_string()).unwrap();
        let half_step = half_step(&mut document);
        let source = burin::io::open(&path).unwrap().source(0, 0, &|_| true).unwrap();
        let out = source.read([0; 3], DIMS).unwrap();
        assert_eq!(out.voxel_type(), ty);
        let width = ty.bytes();
        for i in 0..COUNT {
            let bytes = |v: &Voxels| v.as_bytes()[i * width..(i + 1) * width].to_vec();
            let [x, y, z]: [f64; 3] = std::array::from_fn(|a| f64::from(data.place(i)[a]) - CENTRE[a]);
            if x * x + y * y + z * z > RADIUS * RADIUS || !data.value(i).is_finite() {
                assert_eq!(bytes(&out), bytes(&data.voxels), "{ty:?} {i}");
                continue;
            }
            let mut right = data.value(i) + 300.75;
            if let Some([least, greatest]) = ty.limits() {
                right = right.round().clamp(least, greatest);
            }
            assert!((out.get(i) - right).abs() <= half_step, "{ty:?}: {} for {right}", out.get(i));
        }
    }
}

#[test]
fn what_no_float_can_hold_is_refused_in_plain_words() {
    if gpu().is_none() {
        return;
    }
    let (mut document, _) = Data::new(Voxels::F32(vec![0.0; COUNT]), DIMS).open(json!({}));
    for value in [json!(1e39), json!(-1e300)] {
        let set = json!({"brush":{"set":{"target":{"density":value}}}});
        run(&mut document, &set.to_string()).unwrap();
        let stroke = r#"{"stroke":{"paint":{"points":[{"at":{"index":[3,3,1]}}]}}}"#;
        let said = run(&mut document, stroke).unwrap_err().to_string();
        assert_eq!(density(&mut document, [3, 3, 1]), 0.0);
        assert!(said.contains("brush.target.density") && said.contains("3.4e38"), "{said}");
    }
}

#[test]
fn a_wider_map_takes_unpainted_voxels_of_edited_bricks_from_the_source_and_painted_ones_as_they_were() {
    if gpu().is_none() {
        return;
    }
    for ty in [VoxelType::U8, VoxelType::I16, VoxelType::F32] {
        let data = Data::new(with_voxel_type!(ty, T => T::wrap((0..COUNT).map(|i| (i % 90) as T).collect())), DIMS);
        // Codes over a part of the values, with an edit as older projects have them.
        let (mut document, _) = data.open(json!({"range":[10, 20]}));
        let mut state = document.state().unwrap().clone();
        assert_eq!(state.one().density.format(), TexelFormat::R16Unorm);
        let (index, map) = (BrickIndex([0, 0, 0]), *state.one().density.map());
        let mut texels = state.one().density.base_brick(index).unwrap().to_texels(2);
        texels[..2].copy_from_slice(&map.encode(15.0)[..2]);
        state.one_mut().density.swap(vec![(index, Some(Brick::from_texels(texels, 2)))]).unwrap();
        document.adopt(state);
        paint(&mut document, json!({"operation":"add","target":{"density":50}}));
        assert!(*document.state().unwrap().one().density.map() != map);
        let half_step = half_step(&mut document);
        for i in 0..COUNT {
            let found = voxel(&mut document, data.place(i));
            let [x, y, z]: [f64; 3] = std::array::from_fn(|a| f64::from(data.place(i)[a]) - CENTRE[a]);
            let ball = x * x + y * y + z * z <= RADIUS * RADIUS;
            if i == 0 || ball {
                let right = if ball { data.value(i) + 50.0 } else { 15.0 };
                // The edit was rounded by both maps.
                assert!(
                    (number(&found["density"]) - right).abs() <= half_step + map.half_step(),
                    "{ty:?} {i}: {found}"
                );
            } else {
                assert_eq!((&found["density"], found["half_step"].as_f64()), (&data.said(i), Some(0.0)), "{ty:?} {i}");
            }
        }
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        assert_eq!(*document.state().unwrap().one().density.map(), map);
    }
}
