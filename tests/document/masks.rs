//! The brush's range of values is compared in the source's own type.

use super::maker::run;
use super::values_support::{Data, ask, density, said, voxel};
use crate::common::gpu::gpu;
use crate::common::one::One;
use crate::io::files::{ALL_TYPES, random};
use burin::document::Document;
use burin::volume::{Value as _, VoxelType, Voxels};
use burin::with_voxel_type;
use rand::Rng;
use serde_json::{Value, json};

const DIMS: [u32; 3] = [35, 3, 2];
const COUNT: usize = 35 * 3 * 2;

/// Which voxels a label takes that is painted over all of the volume where values lie in a range; the labels are taken back.
fn taken(document: &mut Document, range: &Value) -> Vec<bool> {
    let set = json!({"brush":{"set":{"radius_mm":200,"falloff":"hard","operation":"replace","range":range,"target":{"label":1}}}});
    run(document, &set.to_string()).unwrap();
    let stroke = json!({"stroke":{"paint":{"points":[{"at":{"index":[3, 1, 1]}}]}}});
    let painted = run(document, &stroke.to_string()).unwrap()["voxels_changed"].as_u64().unwrap();
    let labels = document.state().unwrap().one().labels.read(0, [0; 3], DIMS).unwrap();
    let taken: Vec<bool> = labels.chunks_exact(2).map(|t| t != [0, 0]).collect();
    assert_eq!(taken.iter().filter(|&&t| t).count() as u64, painted);
    if painted > 0 {
        run(document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
    taken
}

/// Few values, so that each is held by many voxels, and neighbours that rounding would make one.
fn close(ty: VoxelType) -> Voxels {
    let mut rng = random(17);
    let mut pick = |n: usize| rng.random_range(0..n);
    match ty {
        VoxelType::U64 => {
            Voxels::U64((0..COUNT).map(|_| [u64::MAX, u64::MAX - 1, 1 << 53, (1 << 53) + 1, 7][pick(5)]).collect())
        }
        VoxelType::I64 => Voxels::I64(
            (0..COUNT).map(|_| [i64::MIN, i64::MIN + 1, -(1 << 53) - 1, -(1 << 53), (1 << 60) + 1][pick(5)]).collect(),
        ),
        VoxelType::U32 => {
            Voxels::U32((0..COUNT).map(|_| [u32::MAX, u32::MAX - 1, 1 << 24, (1 << 24) + 1, 0][pick(5)]).collect())
        }
        VoxelType::F32 => {
            let values = [0.1, 0.1_f32.next_up(), f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 3.0, -0.0];
            Voxels::F32((0..COUNT).map(|_| values[pick(8)]).collect())
        }
        VoxelType::F64 => {
            let values = [0.1, 0.1_f64.next_up(), f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 3.0, 1e-300];
            Voxels::F64((0..COUNT).map(|_| values[pick(8)]).collect())
        }
        _ => with_voxel_type!(ty, T => T::wrap((0..COUNT).map(|_| [3, 4, 5, 100, 127][pick(5)] as T).collect())),
    }
}

#[test]
fn the_value_that_a_voxel_answers_paints_the_voxels_of_that_value_and_no_other() {
    if gpu().is_none() {
        return;
    }
    for (t, ty) in ALL_TYPES.into_iter().enumerate() {
        for scaling in [[0.0, 0.0], [0.1, -7.0]] {
            let data = Data { big: t % 2 == 0, scaling, ..Data::new(close(ty), DIMS) };
            let (mut document, _) = data.open(json!({}));
            let bits = |i: usize| &data.voxels.as_bytes()[i * ty.bytes()..(i + 1) * ty.bytes()];
            let mut kinds: Vec<usize> = Vec::new();
            for i in 0..COUNT {
                if !kinds.iter().any(|&k| bits(k) == bits(i)) {
                    kinds.push(i);
                }
            }
            for &k in &kinds {
                let value = density(&mut document, data.place(k));
                if value == json!("nan") {
                    continue;
                }
                let found = taken(&mut document, &json!([value, value]));
                for (i, &found) in found.iter().enumerate() {
                    // Scaled integers of 64 bits are told, and so compared, in f64.
                    let right = data.said(i) == value || (value == 0.0 && data.value(i) == 0.0);
                    assert_eq!(found, right, "{ty:?} {scaling:?} [{value}, {value}] at {}", data.said(i));
                }
            }
        }
    }
}

#[test]
fn both_ends_belong_to_the_range_and_what_is_no_number_never_does() {
    if gpu().is_none() {
        return;
    }
    let numbers = [f32::NAN, f32::NEG_INFINITY, -2.5, 0.0, 1.0, 2.0, 3.0, f32::MAX, f32::INFINITY];
    let data = Data::new(Voxels::F32((0..COUNT).map(|i| numbers[i % 9]).collect()), DIMS);
    let (mut document, _) = data.open(json!({}));
    let ends = |a: f64, b: f64| json!([said(a), said(b)]);
    for (lo, hi) in [
        (1.0, 2.0),
        (1.0, 1.0),
        (f64::NEG_INFINITY, f64::INFINITY),
        (f64::NEG_INFINITY, f64::NEG_INFINITY),
        (f64::INFINITY, f64::INFINITY),
        (f64::NEG_INFINITY, 0.0),
        (3.0, 1e300),
        (1e39, 1e300),
        (1.1, 1.9),
        (-0.0, 0.0),
    ] {
        let found = taken(&mut document, &ends(lo, hi));
        for i in 0..COUNT {
            let value = f64::from(numbers[i % 9]);
            assert_eq!(found[i], lo <= value && value <= hi, "{value} in [{lo}, {hi}]");
        }
    }
    let set = |range: Value| json!({"brush":{"set":{"range":range}}}).to_string();
    for wrong in [json!([2, 1]), json!(["nan", 1]), json!([18_446_744_073_709_551_615_u64, 9_007_199_254_740_993_u64])]
    {
        assert!(run(&mut document, &set(wrong)).unwrap_err().to_string().contains("the first not above the second"));
    }
    let kept = run(&mut document, &set(json!([9_007_199_254_740_993_u64, "inf"]))).unwrap();
    assert_eq!(kept["brush"]["range"], json!([9_007_199_254_740_993_u64, "inf"]));
}

#[test]
fn an_end_is_meant_as_the_source_holds_it() {
    if gpu().is_none() {
        return;
    }
    // Tenths, as 32-bit floats, and as integers with a slope that the header keeps as one.
    let tenths = Data::new(Voxels::F32((0..COUNT).map(|i| (i % 50) as f32 * 0.1).collect()), DIMS);
    let scaled =
        Data { scaling: [0.1, 0.0], ..Data::new(Voxels::I16((0..COUNT).map(|i| (i % 50) as i16).collect()), DIMS) };
    for data in [tenths, scaled] {
        let (mut document, _) = data.open(json!({}));
        for (range, least, most) in [([0.1, 0.1], 1, 1), ([0.3, 0.3], 3, 3), ([0.7, 1.4], 7, 14), ([4.9, 9.0], 49, 49)]
        {
            let found = taken(&mut document, &json!(range));
            for (i, &found) in found.iter().enumerate() {
                // 3 · 0.1 is not the float nearest to 0.3; what is meant is told by the header's slope alone.
                if data.scaling[0] != 0.0 || ((i % 50) as f32 * 0.1 == ((i % 50) as f64 / 10.0) as f32) {
                    assert_eq!(found, (least..=most).contains(&(i % 50)), "{} in {range:?}", data.said(i));
                }
            }
        }
        // Between two of them there is none.
        assert!(!taken(&mut document, &json!([0.32, 0.38])).contains(&true));
    }
}

#[test]
fn a_painted_voxel_counts_by_what_was_painted() {
    if gpu().is_none() {
        return;
    }
    for ty in [VoxelType::U8, VoxelType::I16, VoxelType::F32, VoxelType::F64, VoxelType::U64] {
        let data = Data::new(with_voxel_type!(ty, T => T::wrap((0..COUNT).map(|i| (i % 7) as T).collect())), DIMS);
        let (mut document, _) = data.open(json!({}));
        for value in [3.0, 2.5, 0.1] {
            let set =
                json!({"brush":{"set":{"radius_mm":4,"falloff":"hard","any_value":true,"target":{"density":value}}}});
            run(&mut document, &set.to_string()).unwrap();
            run(&mut document, r#"{"stroke":{"paint":{"points":[{"at":{"index":[31, 1, 1]}}]}}}"#).unwrap();
            let found = taken(&mut document, &json!([value, value]));
            for (i, &found) in found.iter().enumerate() {
                let [x, y, z] = data.place(i).map(f64::from);
                let inside = (x - 31.0).powi(2) + (y - 1.0).powi(2) + (z - 1.0).powi(2) <= 16.0;
                let right = if inside { true } else { data.value(i) == value };
                assert_eq!(found, right, "{ty:?} {value} at {:?}", data.place(i));
            }
            // What is told of it is in the range too.
            let told = voxel(&mut document, [31, 1, 1])["density"].take();
            assert_eq!(taken(&mut document, &json!([told, told])), found, "{ty:?} {told}");
            assert!(ask(&mut document, &json!({"volume":{}}))["half_step"].as_f64().unwrap() >= 0.0);
        }
    }
}
