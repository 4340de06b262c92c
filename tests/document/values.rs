//! Values are the source's own, to the last bit, by every door.

use super::maker::run;
use super::values_support::{Data, ask, density, voxel};
use crate::common::one::One;
use crate::io::files::{ALL_TYPES, keep, noise, random};
use burin::document::Document;
use burin::volume::{Brick, BrickIndex, Number, Value as _, VoxelType, Voxels};
use burin::with_voxel_type;
use rand::Rng;
use serde_json::{Value, json};

/// Random bits, and the ends of the type and what lies by them.
fn hostile(ty: VoxelType, count: usize, seed: u64) -> Voxels {
    let mut voxels = noise(ty, count, seed);
    match &mut voxels {
        Voxels::U64(v) => v[..4].copy_from_slice(&[u64::MAX, u64::MAX - 1, 1 << 53 | 1, 0]),
        Voxels::I64(v) => v[..4].copy_from_slice(&[i64::MIN, i64::MIN + 1, i64::MAX, -((1 << 53) | 1)]),
        Voxels::U32(v) => v[..3].copy_from_slice(&[u32::MAX, (1 << 24) + 1, 0]),
        Voxels::F32(v) => {
            v[..6].copy_from_slice(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e-45]);
        }
        Voxels::F64(v) => {
            v[..6].copy_from_slice(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 5e-324]);
        }
        _ => {}
    }
    voxels
}

#[test]
fn every_door_tells_what_the_source_holds() {
    let folder = tempfile::tempdir().unwrap();
    for (t, ty) in ALL_TYPES.into_iter().enumerate() {
        for (s, scaling) in [[0.0, 0.0], [1.0, 0.0], [0.5, -3.0], [-0.1, 7.25]].into_iter().enumerate() {
            let data =
                Data { big: (t + s) % 2 == 0, scaling, ..Data::new(hostile(ty, 60, (10 * t + s) as u64), [5, 4, 3]) };
            let (mut document, opened) = data.open(json!({}));
            let what = format!("{ty:?} {scaling:?}");
            for i in 0..60 {
                let found = voxel(&mut document, data.place(i));
                assert_eq!(found["density"], data.said(i), "{what} {i}");
                assert_eq!(found["half_step"], 0.0, "{what} {i}");
            }
            // Smallest and largest of the finite, and the sum.
            let finite: Vec<usize> = (0..60).filter(|&i| data.value(i).is_finite()).collect();
            let least =
                finite.iter().copied().min_by(|&a, &b| exactly(&data, a).partial_cmp(&exactly(&data, b)).unwrap());
            let most =
                finite.iter().copied().max_by(|&a, &b| exactly(&data, a).partial_cmp(&exactly(&data, b)).unwrap());
            let (least, most) = (data.said(least.unwrap()), data.said(most.unwrap()));
            let field = ask(&mut document, &json!({"field":{"field":"density"}}));
            let info = burin::io::info(keep(&folder, "v.nii", &data.file()), &|_| true).unwrap();
            let info = serde_json::to_value(info).unwrap();
            for (door, told) in [("volume.open", &opened), ("ask.field", &field), ("info", &info)] {
                assert!(same(&told["min"], &least), "{what} {door}: {} {least}", told["min"]);
                assert!(same(&told["max"], &most), "{what} {door}: {} {most}", told["max"]);
                let sum: f64 = finite.iter().map(|&i| data.value(i)).sum();
                let size: f64 = finite.iter().map(|&i| data.value(i).abs()).sum();
                let told = serde_json::from_value::<Number>(told["sum"].clone()).unwrap().to_f64();
                assert!(!size.is_finite() || (told - sum).abs() <= 1e-14 * size, "{what} {door}: {told} {sum}");
            }
            assert_eq!(info["nan_count"], (0..60).filter(|&i| data.value(i).is_nan()).count());
        }
    }
}

/// Without rounding, whatever the type.
fn exactly(data: &Data, i: usize) -> Number {
    serde_json::from_value(data.said(i)).unwrap()
}

/// Equal as numbers to the last bit; an integer may be written as a float where that loses nothing.
fn same(a: &Value, b: &Value) -> bool {
    let [a, b]: [Number; 2] = [a, b].map(|v| serde_json::from_value(v.clone()).unwrap());
    a == b
}

#[test]
fn integers_of_64_bits_are_told_as_integers_and_summed_to_the_last_digit() {
    let ids: Vec<u64> = vec![u64::MAX - 5, 3, (1 << 60) + 1, (1 << 53) + 1];
    let (mut document, opened) = Data::new(Voxels::U64(ids.clone()), [4, 1, 1]).open(json!({}));
    assert_eq!((&opened["min"], &opened["max"]), (&json!(3), &json!(u64::MAX - 5)));
    assert_eq!(ask(&mut document, &json!({"volume":{}}))["max"], json!(u64::MAX - 5));
    assert_eq!(ask(&mut document, &json!({"field":{"field":"density"}}))["max"], json!(u64::MAX - 5));
    let below: Vec<i64> = vec![i64::MIN, i64::MIN + 1, 7, (1 << 53) + 1];
    let (mut document, opened) = Data::new(Voxels::I64(below.clone()), [2, 2, 1]).open(json!({}));
    let sum: i64 = below[1..].iter().sum();
    assert_eq!((&opened["min"], &opened["max"]), (&json!(i64::MIN), &json!((1_i64 << 53) + 1)));
    assert_eq!(density(&mut document, [1, 0, 0]), json!(i64::MIN + 1));
    // Without the least, so that the sum is within 64 bits.
    let (mut document, opened) = Data::new(Voxels::I64(below[1..].to_vec()), [3, 1, 1]).open(json!({}));
    assert_eq!(
        (&opened["sum"], &ask(&mut document, &json!({"field":{"field":"density"}}))["sum"]),
        (&json!(sum), &json!(sum))
    );
    // And kept in a project.
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p.burin");
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    drop(document);
    let mut again = Document::new();
    let reopened = run(&mut again, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    assert_eq!((&reopened["min"], &reopened["sum"]), (&json!(i64::MIN + 1), &json!(sum)));
    assert_eq!(density(&mut again, [0, 0, 0]), json!(i64::MIN + 1));
}

#[test]
fn numbers_are_compared_without_rounding_and_read_as_they_are_written() {
    let n = |text: &str| serde_json::from_str::<Number>(text).unwrap();
    assert!(n("9007199254740993") > n("9007199254740992.0") && n("9007199254740993") != n("9007199254740992"));
    assert!(n("18446744073709551615") < n("18446744073709551616.0"));
    assert!(n("3") == n("3.0") && n("3") < n("3.5") && n("-3") > n("-3.5") && n("4") > n("3.5") && n("-4") < n("-3.5"));
    assert!(n("-9223372036854775808") > n("\"-inf\"") && n("18446744073709551615") < n("\"inf\""));
    assert!(n("\"nan\"") != n("\"nan\"") && n("\"nan\"").partial_cmp(&n("1")).is_none() && n("1") != n("\"nan\""));
    for text in ["18446744073709551615", "-9223372036854775808", "0.1", "1e300", "\"inf\"", "\"-inf\"", "\"nan\""] {
        let again = serde_json::to_string(&n(text)).unwrap();
        assert_eq!(serde_json::from_str::<Value>(text).unwrap(), serde_json::from_str::<Value>(&again).unwrap());
    }
    assert!(serde_json::from_str::<Number>("\"infinite\"").unwrap_err().to_string().contains("\"inf\""));
}

#[test]
fn boxes_that_begin_and_end_inside_bricks_have_their_painted_values() {
    // Rows of 40 voxels: boxes of values start in the middle of bricks.
    let dims = [40, 37, 35];
    let count = dims.iter().product::<u32>() as usize;
    for ty in ALL_TYPES {
        let voxels: Voxels = with_voxel_type!(ty, T => T::wrap((0..count).map(|i| (i % 100) as T).collect()));
        let data = Data::new(voxels, dims);
        let (document, _) = data.open(json!({}));
        let mut state = document.state().unwrap().clone();
        let mut rng = random(9);
        let map = *state.one().density.map();
        // Painted here and there to 50, which every map holds to its half step.
        let index = BrickIndex([0, 1, 1]);
        let mut texels = state.one().density.base_brick(index).unwrap().to_texels(map.format.bytes());
        let mut painted = std::collections::BTreeSet::new();
        for _ in 0..200 {
            let at = [rng.random_range(0..32), rng.random_range(0..5), rng.random_range(0..3)];
            let width = map.format.bytes();
            let from = (at[0] + 32 * (at[1] + 32 * at[2])) as usize * width;
            texels[from..from + width].copy_from_slice(&map.encode(50.0)[..width]);
            painted.insert([at[0], at[1] + 32, at[2] + 32]);
        }
        state.one_mut().density.swap(vec![(index, Some(Brick::from_texels(texels, map.format.bytes())))]).unwrap();
        for (lo, size) in
            [([0; 3], dims), ([3, 33, 33], [30, 4, 2]), ([31, 36, 34], [9, 1, 1]), ([1, 0, 31], [8, 37, 3])]
        {
            let mut wrong = 0;
            state.one().density.values(lo, size).unwrap().each(|i, number| {
                let [nx, ny, _] = size.map(|s| s as usize);
                let at = [i % nx, i / nx % ny, i / (nx * ny)];
                let at: [u32; 3] = std::array::from_fn(|a| lo[a] + at[a] as u32);
                let own = (at[0] + dims[0] * (at[1] + dims[1] * at[2])) % 100;
                let right = if painted.contains(&at) { 50.0 } else { f64::from(own) };
                let off = (number.to_f64() - right).abs();
                wrong += usize::from(if painted.contains(&at) { off > map.half_step() } else { off > 0.0 });
            });
            assert_eq!(wrong, 0, "{ty:?} {lo:?}");
        }
    }
}

#[test]
fn the_status_line_shows_a_value_so_that_it_can_be_typed_in_again() {
    let shown = |number: Number, ty| burin::interact::readout::value(number, ty);
    for (number, ty, right) in [
        (Number::Whole(i128::from(u64::MAX)), VoxelType::U64, "18446744073709551615"),
        (Number::Whole(-3), VoxelType::I8, "-3"),
        (Number::Real(f64::from(0.1_f32)), VoxelType::F32, "0.1"),
        (Number::Real(f64::from(0.1_f32.next_up())), VoxelType::F32, "0.10000001"),
        (Number::Real(0.1 + 0.2), VoxelType::F64, "0.30000000000000004"),
        (Number::Real(7.0), VoxelType::F32, "7"),
        (Number::Real(100.101_167_3), VoxelType::U8, "100.101"),
        (Number::Real(f64::NAN), VoxelType::F32, "not a number"),
        (Number::Real(f64::INFINITY), VoxelType::F64, "infinite"),
    ] {
        assert_eq!(shown(number, ty), right);
    }
}
