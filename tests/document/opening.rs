//! Any data opens, draws and says nothing that is no number.

use super::maker::run;
use super::values_support::{Data, ask};
use crate::common::gpu::gpu;
use crate::common::one::One;
use burin::document::ViewName;
use burin::math::DVec3;
use burin::volume::{Grid, VoxelType, Voxels};
use burin::with_voxel_type;
use serde_json::{Value, json};

const DIMS: [u32; 3] = [6, 6, 6];
const COUNT: usize = 216;

/// The lower half of the volume one value, the upper another.
fn halves<T: burin::volume::Value>(low: T, high: T) -> Data {
    Data::new(T::wrap((0..COUNT).map(|i| if i < COUNT / 2 { low } else { high }).collect()), DIMS)
}

/// Whether any number anywhere in the answer is written as `null`, but for those that may not exist.
fn nulls(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Null => found.push(path.to_owned()),
        Value::Array(all) => all.iter().enumerate().for_each(|(i, v)| nulls(v, &format!("{path}[{i}]"), found)),
        Value::Object(all) => all.iter().for_each(|(k, v)| nulls(v, &format!("{path}.{k}"), found)),
        _ => {}
    }
}

/// Opens, asks, draws; answers the least and the greatest grey of a sagittal slice.
fn drawn(what: &str, data: &Data) -> [f32; 2] {
    let (mut document, opened) = data.open(json!({}));
    let mut missing = Vec::new();
    nulls(&opened, "", &mut missing);
    let nothing_finite = (0..COUNT).all(|i| !data.value(i).is_finite());
    missing.sort();
    assert_eq!(missing, if nothing_finite { vec![".max", ".min"] } else { vec![] }, "{what}");
    let scene = ask(&mut document, &json!({"scene":{}}))["scene"].take();
    let state = document.state().unwrap();
    state.scene.transfer.check().unwrap_or_else(|e| panic!("{what}: {e}"));
    state.scene.check(&state.bounds()).unwrap_or_else(|e| panic!("{what}: {e}"));
    for name in ["level", "width"] {
        assert!(scene["window"][name].as_f64().unwrap().is_finite(), "{what} {name}");
    }
    let counted: u64 = state.one().histogram.bins.iter().sum();
    let finite = (0..COUNT).filter(|&i| data.value(i).is_finite()).count() as u64;
    assert!(counted <= finite && (counted > 0 || finite == 0), "{what}: {counted} of {finite}");
    for step in 0..=10 {
        let colour = state.scene.transfer.table(1.0)[step * 409];
        assert!(colour.iter().all(|c| (0.0..=1.0).contains(c)), "{what}: {colour:?}");
    }
    for view in [ViewName::ThreeD, ViewName::Sagittal] {
        let picture = document.picture(view, [16, 16], None).unwrap_or_else(|e| panic!("{what}: {e}"));
        // Light may shine brighter than white.
        let odd = picture.colour.iter().flatten().find(|c| !(0.0..=1.5).contains(*c));
        assert_eq!(odd, None, "{what} {view:?}");
        if view == ViewName::Sagittal {
            let greys = picture.colour.iter().filter(|c| c[3] > 0.5).map(|c| c[0]);
            return greys.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], g| [a.min(g), b.max(g)]);
        }
        // A project of it is one that opens.
        let folder = tempfile::tempdir().unwrap();
        let save = json!({"project":{"save":{"path":folder.path().join("p.burin")}}}).to_string();
        run(&mut document, &save).unwrap_or_else(|e| panic!("{what}: {e} {:?}", document.state().unwrap().scene));
    }
    unreachable!()
}

#[test]
fn two_values_however_far_or_near_are_dark_and_bright() {
    if gpu().is_none() {
        return;
    }
    let scaled = |scaling: [f32; 2], data: Data| Data { scaling, ..data };
    for (what, data) in [
        ("all of u64", halves(0, u64::MAX)),
        ("all of i64", halves(i64::MIN, i64::MAX)),
        ("ids beyond 2^53", halves((1_u64 << 60) + 1, (1 << 61) + 1)),
        ("doubles", halves(-1e308, 1e308)),
        ("all doubles", halves(f64::MIN, f64::MAX)),
        ("doubles beyond floats", halves(1e300, 2e300)),
        ("nearly all floats", halves(-1e38_f32, 1e38)),
        ("large floats", halves(1e37_f32, 1e38)),
        ("small floats", halves(1e-30_f32, 2e-30)),
        ("small doubles", halves(1e-290, 2e-290)),
        ("near doubles", halves(1.0, 1.0 + 1e-3)),
        ("bytes", halves(0_u8, 1)),
        ("a large slope", scaled([1e37, 0.0], halves(-8_i16, 8))),
        ("a slope beyond floats", scaled([3e38, -3e38], halves(-100_i16, 100))),
        ("a small slope", scaled([1e-30, 0.0], halves(0_i16, 4))),
        ("a slope downward", scaled([-2.0, 5.0], halves(100_u8, 0))),
    ] {
        let [black, white] = drawn(what, &data);
        assert!(white - black >= 0.45, "{what}: {black} to {white}");
    }
}

#[test]
fn data_of_one_value_of_none_or_with_what_marks_none_open_and_draw() {
    if gpu().is_none() {
        return;
    }
    for ty in [VoxelType::U8, VoxelType::I16, VoxelType::U32, VoxelType::I64, VoxelType::F32, VoxelType::F64] {
        for value in [0, 100] {
            let one = with_voxel_type!(ty, T => halves(value as T, value as T));
            drawn(&format!("{ty:?} {value}"), &one);
        }
    }
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e20, 1e-45, -0.0] {
        drawn(&format!("f32 {value}"), &halves(value, value));
        drawn(&format!("f32 1 and {value}"), &halves(1.0, value));
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX, 1e20, 5e-324] {
        drawn(&format!("f64 {value}"), &halves(value, value));
        drawn(&format!("f64 1 and {value}"), &halves(1.0, value));
    }
    drawn("infinities", &halves(f64::NEG_INFINITY, f64::INFINITY));
    drawn("u64", &halves(u64::MAX, u64::MAX));
    drawn("i64", &halves(i64::MIN, i64::MIN));
    drawn("subnormals", &halves(5e-324, 1e-323));
    // A few marks among what is measured.
    for mark in [f64::MAX, -f64::MAX, 1e20, -32_768.0, f64::INFINITY] {
        let mut voxels: Vec<f64> = (0..COUNT).map(|i| (i % 50) as f64 / 50.0).collect();
        voxels[7] = mark;
        drawn(&format!("marked {mark}"), &Data::new(Voxels::F64(voxels), DIMS));
    }
}

#[test]
fn a_file_that_changes_while_it_is_opened_is_not_opened() {
    use burin::document::{OpenAs, Origin, ReadDocument};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nrrd");
    let grid = Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO);
    let origin = || Origin { path: path.clone(), component: 0, frame: 0 };
    for at in [0.1, 0.5, 0.95] {
        super::maker::write_nrrd(&path, &grid, |v| v[0] as f32);
        // As long as before, a little later, once.
        let changed = std::sync::Once::new();
        let change = |share: f32| {
            if share >= at {
                changed.call_once(|| {
                    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
                    file.set_modified(std::time::SystemTime::now() + std::time::Duration::from_secs(5)).unwrap();
                });
            }
            true
        };
        let opened = ReadDocument::volume(origin(), None, OpenAs::Image, None, &change);
        assert!(changed.is_completed());
        let said = opened.map(drop).unwrap_err().to_string();
        let why = ["since it was opened", "while it was read"].iter().any(|why| said.contains(why));
        assert!(said.contains("v.nrrd") && why, "{at}: {said}");
        ReadDocument::volume(origin(), None, OpenAs::Image, None, &|_| true).unwrap();
    }
}
