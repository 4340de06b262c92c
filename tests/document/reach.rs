//! How density in 32-bit floats is painted at its ends: a hundred weak erasures arrive on any data, weak strokes far from their end
//! go by equation 1, and doubles beyond all 32-bit floats are painted too.

use super::maker::run;
use super::values_support::Data;
use burin::document::Document;
use burin::volume::*;
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde_json::{Value, json};

const N: u32 = 6;

/// A document that opened these voxels from a file.
fn of(voxels: Voxels) -> Option<Document> {
    crate::common::gpu::gpu()?;
    Some(Data::new(voxels, [N; 3]).open(json!({})).0)
}

fn brush(document: &mut Document, settings: Value) {
    run(document, &json!({"brush":{"set":settings}}).to_string()).unwrap();
}

fn click(document: &mut Document) -> Value {
    run(document, r#"{"stroke":{"paint":{"points":[{"at":{"index":[3,3,3]}}]}}}"#).unwrap()
}

fn at(document: &mut Document, index: [u32; 3]) -> Value {
    run(document, &json!({"ask":{"voxel":{"at":{"index":index}}}}).to_string()).unwrap()
}

fn number(document: &mut Document, index: [u32; 3]) -> f64 {
    at(document, index)["density"].as_f64().unwrap()
}

fn doubles(of: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..(N * N * N) as usize).map(of).collect()
}

fn floats(of: impl Fn(usize) -> f64) -> Voxels {
    Voxels::F32(doubles(of).into_iter().map(|v| v as f32).collect())
}

/// No two alike.
fn spread(i: usize) -> f64 {
    ((i * 37) % 216) as f64 * 0.37 - 20.3
}

#[test]
fn a_hundred_weak_erasures_arrive_on_data_of_any_type() {
    let nothing_measured = |i: usize| if i == 0 { f64::from(f32::MIN) } else { spread(i) };
    let all = [
        floats(spread),
        floats(|i| if i == 0 { f64::NAN } else { spread(i) }),
        floats(|i| if i == 0 { f64::INFINITY } else { spread(i) }),
        floats(nothing_measured),
        floats(|_| 3.25),
        Voxels::F64(doubles(|i| spread(i) * 1e-30)),
        Voxels::F64(doubles(|i| spread(i) * 1e300)),
        Voxels::F64(doubles(|i| 1e6 + spread(i))),
        Voxels::I32(doubles(spread).into_iter().map(|v| v as i32 * 40_000).collect()),
        Voxels::U64(doubles(spread).into_iter().map(|v| (1 << 60) + v as u64).collect()),
    ];
    for voxels in all {
        let what = format!("{:?} {:?}", voxels.voxel_type(), voxels.get(1));
        let size = doubles(|i| voxels.get(i)).into_iter().skip(1).fold(0.0, |a: f64, b| a.max(b.abs()));
        let Some(mut document) = of(voxels) else { return };
        let own = at(&mut document, [3, 3, 3])["density"].clone();
        for (value, end) in [(size * 1.37, None), (-size * 40.1, None), (size * 0.77, Some(0.0)), (0.3, Some(size))] {
            brush(
                &mut document,
                json!({"radius_mm":1.5,"falloff":"hard","strength":1.0,"erase":false,"target":{"density":value}}),
            );
            click(&mut document);
            assert_ne!(at(&mut document, [3, 3, 3])["density"], own, "{what}");
            let erases = end.map_or(json!("restore"), |end| json!({ "to": end }));
            brush(&mut document, json!({"erase":true,"strength":0.1,"erase_density":erases}));
            for _ in 0..100 {
                click(&mut document);
            }
            let found = at(&mut document, [3, 3, 3])["density"].clone();
            match end {
                None => assert_eq!(found, own, "{what} {value}"),
                // The number as 32-bit floats keep it.
                Some(end) => assert!((found.as_f64().unwrap() - end).abs() <= size * 1.2e-7, "{what} {found} {end}"),
            }
            if end == Some(0.0) {
                assert_eq!(found.as_f64(), Some(0.0), "{what}");
            }
            let said = click(&mut document);
            assert_eq!((&said["step"], &said["voxels_changed"]), (&Value::Null, &json!(0)), "{what} {value}");
        }
    }
}

#[test]
fn a_hundred_weak_erasures_arrive_in_a_project_that_was_opened_again() {
    let Some(mut document) = of(floats(|_| 0.0)) else { return };
    brush(&mut document, json!({"radius_mm":1.5,"falloff":"hard","target":{"density":123.4}}));
    click(&mut document);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p");
    run(&mut document, &json!({"project":{"save":{"path":path}}}).to_string()).unwrap();
    drop(document);
    let mut document = Document::new();
    run(&mut document, &json!({"project":{"open":{"path":path}}}).to_string()).unwrap();
    brush(&mut document, json!({"erase":true,"strength":0.1}));
    for _ in 0..100 {
        click(&mut document);
    }
    assert_eq!(at(&mut document, [3, 3, 3])["density"], json!(0.0));
    assert_eq!(run(&mut document, r#"{"ask":{"field":{"field":"density"}}}"#).unwrap()["edited_bricks"], 0);
}

#[test]
fn a_weak_stroke_far_from_its_end_goes_by_equation_1_on_any_data() {
    // Integers that need floats; measurements beside a voxel that has none.
    let wide = Voxels::I32(doubles(|i| (i * 463) as f64).into_iter().map(|v| v as i32).collect());
    let void = floats(|i| if i == 0 { f64::from(f32::MIN) } else { 100.0 + spread(i) });
    for voxels in [wide, void] {
        let what = format!("{:?}", voxels.voxel_type());
        let Some(mut document) = of(voxels) else { return };
        for (strength, end) in [(1e-5_f32, 0.0), (1e-3, 0.0), (0.1, 0.0), (0.01, 50.0)] {
            let before = number(&mut document, [3, 3, 3]);
            brush(
                &mut document,
                json!({"radius_mm":0.5,"falloff":"hard","strength":strength,"erase":true,
                "erase_density":{"to":end},"target":{"density":1.0}}),
            );
            click(&mut document);
            let expected = before + f64::from(strength) * (end - before);
            let found = at(&mut document, [3, 3, 3]);
            let (value, half_step) = (found["density"].as_f64().unwrap(), found["half_step"].as_f64().unwrap());
            assert!((value - expected).abs() <= half_step, "{what} {strength}: {value} {expected} ± {half_step}");
        }
    }
}

#[test]
fn doubles_beyond_32_bit_floats_are_painted_within_the_stated_half_step() {
    let void = |i: usize| if i == 0 { f64::MIN } else { spread(i) };
    for (data, value, operation) in [
        (doubles(spread), 1e39, "replace"),
        (doubles(spread), -1e60, "blend"),
        (doubles(spread), 1.7e308, "replace"),
        (doubles(void), 5e38, "replace"),
        (doubles(|i| spread(i) * 3e36), 3.3e38, "add"),
        (doubles(|i| spread(i) * 3e36), 3.3e38, "subtract"),
    ] {
        let what = format!("{operation} {value:e} on {:e}", data[1]);
        let own = data[(3 + N * (3 + N * 3)) as usize];
        let Some(mut document) = of(Voxels::F64(data.clone())) else { return };
        let settings = json!({"radius_mm":0.5,"falloff":"hard","strength":1.0,"operation":operation});
        brush(&mut document, settings);
        brush(&mut document, json!({"target":{"density":value}}));
        click(&mut document);
        let found = at(&mut document, [3, 3, 3]);
        let expected = match operation {
            "add" => own + value,
            "subtract" => own - value,
            _ => value,
        };
        let (painted, half_step) = (found["density"].as_f64().unwrap(), found["half_step"].as_f64().unwrap());
        assert!((painted - expected).abs() <= half_step && half_step <= value.abs() * 1e-6, "{what}: {painted}");
        // What was not painted is the source's own; undo brings the rest back.
        assert_eq!(number(&mut document, [2, 3, 3]), data[(2 + N * (3 + N * 3)) as usize], "{what}");
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        assert_eq!(number(&mut document, [3, 3, 3]), own, "{what}");
    }
    // Other types have no such numbers.
    let Some(mut document) = of(floats(spread)) else { return };
    brush(&mut document, json!({"target":{"density":1e39}}));
    let refused = run(&mut document, r#"{"stroke":{"paint":{"points":[{"at":{"index":[3,3,3]}}]}}}"#).unwrap_err();
    assert!(refused.to_string().contains("target.density"), "{refused}");
}

/// Paints by an operation; the answer's step is there.
fn paint(document: &mut Document, operation: &str, strength: f32, value: f64) {
    let settings = json!({"radius_mm":0.5,"falloff":"hard","strength":strength,"operation":operation,
        "target":{"density":value}});
    brush(document, settings);
    click(document);
}

#[test]
fn large_integers_beside_each_other_are_painted_and_not_refused() {
    let near = |base: i128| (0..(N * N * N) as i128).map(move |i| base + (i * 37) % 101);
    for voxels in [
        Voxels::U32(near((1 << 31) - 201).map(|v| v as u32).collect()),
        Voxels::I32(near(16_777_217).map(|v| v as i32).collect()),
        Voxels::I32(near(-(1 << 31)).map(|v| v as i32).collect()),
        Voxels::U64(near(9_007_199_254_740_994).map(|v| v as u64).collect()),
        Voxels::I64(near(-(1 << 60)).map(|v| v as i64).collect()),
    ] {
        let place = (3 + N * (3 + N * 3)) as usize;
        let (what, own) = (format!("{:?} {}", voxels.voxel_type(), voxels.get(0)), voxels.get(place));
        let Some(mut document) = of(voxels) else { return };
        for (operation, value) in
            [("replace", own + 16.0), ("add", 0.0), ("add", 1024.0), ("subtract", 4096.0), ("replace", own + 99.0)]
        {
            let before = number(&mut document, [3, 3, 3]);
            paint(&mut document, operation, 1.0, value);
            let expected = match operation {
                "add" => before + value,
                "subtract" => before - value,
                _ => value,
            };
            let found = number(&mut document, [3, 3, 3]);
            let half_step = run(&mut document, r#"{"ask":{"volume":{}}}"#).unwrap()["half_step"].as_f64().unwrap();
            assert!(
                (found - expected).abs() <= half_step,
                "{what} {operation} {value}: {found} {expected} ± {half_step}"
            );
        }
    }
}

#[test]
fn the_stated_half_step_covers_what_large_numbers_lose_on_the_way() {
    let mut random = StdRng::seed_from_u64(5);
    let near = |base: i128| (0..(N * N * N) as i128).map(move |i| base + (i * 37) % 101);
    for voxels in [
        Voxels::U32(near((1 << 31) - 201).map(|v| v as u32).collect()),
        Voxels::U64(near(1 << 53).map(|v| v as u64).collect()),
        Voxels::F64(doubles(|i| spread(i) * 1e9)),
        floats(spread),
        Voxels::U16(doubles(|i| i as f64).into_iter().map(|v| v as u16).collect()),
    ] {
        let what = format!("{:?} {}", voxels.voxel_type(), voxels.get(0));
        let (least, greatest) = (voxels.get(0) - 100.0, voxels.get(0) + 1000.0);
        let Some(mut document) = of(voxels) else { return };
        for _ in 0..40 {
            let before = number(&mut document, [3, 3, 3]);
            let value =
                if random.random() { before + random.random::<f64>() } else { random.random_range(least..greatest) };
            let operation = ["replace", "add", "subtract"][random.random_range(0..3)];
            let strength = [1.0_f32, 0.5, 0.01][random.random_range(0..3)];
            paint(&mut document, operation, strength, value);
            let g = f64::from(strength);
            let expected = match operation {
                "add" => before + g * value,
                "subtract" => before - g * value,
                _ => before * (1.0 - g) + g * value,
            };
            let found = at(&mut document, [3, 3, 3]);
            let (found, half_step) = (found["density"].as_f64().unwrap(), found["half_step"].as_f64().unwrap());
            // A stroke that is too weak for a step leaves the voxel, and one to within its texel leaves it the source's.
            let whole = run(&mut document, r#"{"ask":{"volume":{}}}"#).unwrap()["half_step"].as_f64().unwrap();
            let half_step = if half_step == 0.0 || found == before { whole } else { half_step };
            assert!(half_step <= whole, "{what}");
            let off = (found - expected).abs();
            assert!(
                off <= half_step,
                "{what} {operation} {strength} {value} on {before}: {found} {expected} ± {half_step}"
            );
        }
    }
}
