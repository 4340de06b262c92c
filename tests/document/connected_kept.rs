//! What isolating leaves: data of every type to the bit, bricks that stay, steps back and forth, projects, and a reason where it is refused.

use super::connected::{DIMS, looked_at, lumps, over, place, refused, say};
use super::maker::{bytes, run, write_nrrd};
use crate::common::one::One;
use crate::common::volumes::each;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

#[test]
fn bricks_that_stay_as_they_are_cost_nothing() {
    // Two plates far apart in many bricks: one is removed.
    let dims = [96, 96, 96];
    let plate = |v: [u32; 3], z: u32| v[2] == z && v[0] > 2 && v[1] > 2;
    let mut document = over(Voxels::U8(each(dims, |v| if plate(v, 4) || plate(v, 90) { 100 } else { 10 })), dims);
    let said = say(&mut document, json!({"component":{"remove":{"at":{"index":[50,50,90]}}}}));
    assert_eq!(said["bricks_touched"], 9);
    assert_eq!(document.state().unwrap().one().density.edits().len(), 9);
    // Steps hold what comes back: of bricks that were never edited nothing.
    let (memory, disk) = document.history().bytes();
    assert!(memory + disk < 10_000, "{memory} {disk}");
    // Whole bricks that are removed are one value.
    let mut document = over(Voxels::U8(each(dims, |v| if v[0] < 64 { 100 } else { 10 })), dims);
    say(&mut document, json!({"component":{"remove":{}}}));
    assert!(document.state().unwrap().one().density.edits().len() <= 18);
    let edits = document.state().unwrap().one().density.edits();
    assert!(edits.values().all(|brick| brick.heap_bytes() == 0));
}

#[test]
fn a_command_that_cannot_be_names_its_field() {
    let mut document = over(Voxels::U8(lumps(7)), DIMS);
    for (what, words) in [
        (json!({"keep":{"at":{"index":[0,0,0]},"matter":{"range":[9,3]}}}), "matter.range: [9, 3] found"),
        (json!({"keep":{"within":{"segment":7}}}), "within.segment: 7 found"),
        (json!({"keep":{"volume":9}}), "volume: 9 found"),
        (json!({"keep":{"matter":{"range":[300,400]}}}), "matter: none found, voxels of the range expected"),
        (json!({"keep":{"at":{"index":[1e9,0,0]}}}), "at: "),
        (json!({"remove":{"value":1e40}}), "value: 1e40 found, a value within 32-bit floats"),
        (json!({"keep":{"value":-1e40}}), "value: -1e40 found, a value within 32-bit floats"),
    ] {
        let said = refused(&mut document, json!({"component": what}));
        assert!(said.contains(words), "{said}");
    }
    for line in [
        r#"{"component":{"keep":{"neighbours":7}}}"#,
        r#"{"component":{"keep":{"how":"add"}}}"#,
        r#"{"component":{"label":{}}}"#,
        r#"{"component":{"select":{"value":3}}}"#,
    ] {
        assert!(serde_json::from_str::<burin::document::Command>(line).is_err(), "{line}");
    }
}

#[test]
fn a_project_and_a_crash_keep_what_was_isolated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let grid = Grid::aligned([40, 30, 20], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&path, &grid, |v| if v[0] < 10 || v[0] > 25 { 100.0 } else { 10.0 });
    let mut document = Document::new();
    document.keep_unsaved_in(folder.path().join("unsaved"));
    say(&mut document, json!({"volume":{"open":{"path":path}}}));
    looked_at(&mut document);
    say(&mut document, json!({"component":{"keep":{"at":{"index":[30,9,9]}}}}));
    say(&mut document, json!({"component":{"select":{"at":{"index":[30,9,9]}}}}));
    let kept = bytes(&document);
    let project = folder.path().join("p.burin");
    say(&mut document, json!({"project":{"save":{"path":project}}}));
    say(&mut document, json!({"component":{"label":{"at":{"index":[30,9,9]},"label":2}}}));
    let journaled = bytes(&document);
    // Gone without a word: what is opened again is what the journal has.
    drop(document);
    let mut again = Document::new();
    say(&mut again, json!({"project":{"open":{"path":project}}}));
    assert!(bytes(&again).0 == journaled.0);
    assert_ne!(kept.0, journaled.0);
}

#[test]
fn data_of_every_type_keep_what_is_not_removed_to_the_last_bit() {
    use super::values_support::Data;
    let dims = [9, 8, 7];
    let count = dims.iter().product::<u32>() as usize;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut pattern: Vec<u8> = (0..count).map(|_| rng.random_range(0..3)).collect();
    pattern[0] = 1;
    let of = |values: [f64; 3]| pattern.iter().map(move |p| values[usize::from(*p)]);
    let all = [
        (Voxels::U8(of([3.0, 7.0, 200.0]).map(|v| v as u8).collect()), [0.0, 0.0]),
        (Voxels::I8(of([-100.0, 7.0, 100.0]).map(|v| v as i8).collect()), [0.5, -3.0]),
        (Voxels::U16(of([0.0, 7.0, 65_535.0]).map(|v| v as u16).collect()), [0.0, 0.0]),
        (Voxels::I16(of([-1000.0, 40.0, 3000.0]).map(|v| v as i16).collect()), [0.1, 7.0]),
        (Voxels::U32(of([5.0, 1e6, 4e9]).map(|v| v as u32).collect()), [0.0, 0.0]),
        (Voxels::I32(of([-2e9, 40.0, 2e9]).map(|v| v as i32).collect()), [0.0, 0.0]),
        (Voxels::U64(pattern.iter().map(|p| (1 << 62) + u64::from(*p)).collect()), [0.0, 0.0]),
        (Voxels::I64(pattern.iter().map(|p| -(1 << 60) - i64::from(*p)).collect()), [0.0, 0.0]),
        (Voxels::F32(of([1e-30, 0.1, 3e38]).map(|v| v as f32).collect()), [0.0, 0.0]),
        (Voxels::F64(of([-1e300, 0.1, f64::INFINITY]).collect()), [0.0, 0.0]),
    ];
    for (voxels, scaling) in all {
        let ty = voxels.voxel_type();
        let data = Data { scaling, ..Data::new(voxels, dims) };
        let (mut document, _) = data.open(json!({}));
        let set: Vec<bool> = pattern.iter().map(|p| *p == 1).collect();
        let component = {
            let mut found = vec![false; count];
            let mut open = vec![0_usize];
            found[0] = true;
            while let Some(i) = open.pop() {
                let v = data.place(i);
                for a in 0..3 {
                    for step in [-1_i32, 1] {
                        let Some(to) = v[a].checked_add_signed(step).filter(|to| *to < dims[a]) else { continue };
                        let mut next = v;
                        next[a] = to;
                        let at = place(next, dims);
                        if set[at] && !std::mem::replace(&mut found[at], true) {
                            open.push(at);
                        }
                    }
                }
            }
            found
        };
        // The end of the range as a script would read it from an answer.
        let middle = data.said(0);
        let before = bytes(&document);
        let what = json!({"at":{"index":[0,0,0]},"matter":{"range":[middle, middle]},"value":2.5});
        let answer = say(&mut document, json!({"component":{"remove": what}}));
        assert_eq!(answer["voxels"], component.iter().filter(|c| **c).count(), "{ty:?}");
        for (i, &own) in component.iter().enumerate() {
            let found = super::values_support::density(&mut document, data.place(i));
            if own {
                let value = found.as_f64().unwrap();
                let most = super::values_support::voxel(&mut document, data.place(i))["half_step"].as_f64().unwrap();
                assert!((value - 2.5).abs() <= most, "{ty:?}: {value}, within {most}");
            } else {
                assert_eq!(found, data.said(i), "{ty:?} {i}");
            }
        }
        say(&mut document, json!({"history":{"undo":{}}}));
        assert!(bytes(&document) == before, "{ty:?}");
        if ty == VoxelType::F64 {
            // What doubles hold they keep, in floats a power of two smaller.
            let what = json!({"at":{"index":[0,0,0]},"matter":{"range":[middle, middle]},"value":1e300});
            say(&mut document, json!({"component":{"remove": what}}));
            let found = super::values_support::density(&mut document, [0; 3]).as_f64().unwrap();
            assert!((found / 1e300 - 1.0).abs() < 1e-6, "{found}");
        }
    }
}

#[test]
fn a_walk_of_isolations_over_two_volumes_is_walked_back_and_forth_to_the_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.nrrd");
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let noise: Vec<f32> = each([20, 18, 16], |_| [10.0, 100.0][rng.random_range(0..2)]);
    write_nrrd(&path, &Grid::aligned([20, 18, 16], DVec3::ONE, DVec3::ZERO), |v| noise[place(v, [20, 18, 16])]);
    let mut document = over(Voxels::U8(lumps(8)), DIMS);
    say(&mut document, json!({"volume":{"add":{"path":path}}}));
    let all = |document: &Document| {
        let state = document.state().unwrap();
        let fields = state.volumes.values().flat_map(|volume| {
            FieldKind::ALL.map(|kind| {
                let field = volume.field(kind);
                (format!("{:?}", field.map()), field.read(0, [0; 3], field.dims(0)).unwrap())
            })
        });
        (fields.collect::<Vec<_>>(), serde_json::to_string(&state.scene.volumes).unwrap())
    };
    let mut states = vec![all(&document)];
    for _ in 0..40 {
        let volume = rng.random_range(0..2);
        let dims = [DIMS, [20, 18, 16]][volume];
        let at: [u32; 3] = std::array::from_fn(|a| rng.random_range(0..dims[a]));
        let mut what = json!({"volume":volume});
        what["neighbours"] = json!([6, 18, 26][rng.random_range(0..3)]);
        if rng.random_range(0..3) > 0 {
            what["at"] = json!({"index":at});
        }
        what["matter"] =
            [json!("visible"), json!({"range":[50, 190]}), json!("everything")][rng.random_range(0..3)].clone();
        if rng.random_range(0..2) == 0 {
            what["within"] =
                [json!("volume"), json!("selection"), json!({"segment":0})][rng.random_range(0..3)].clone();
        }
        let verb = ["keep", "remove", "select", "label"][rng.random_range(0..4)];
        match verb {
            "select" => what["how"] = json!(["replace", "add", "subtract"][rng.random_range(0..3)]),
            "label" => what["label"] = json!(rng.random_range(0..4_u16)),
            _ => what["value"] = json!([5.0, 300.5, 0.1][rng.random_range(0..3)]),
        }
        let line = json!({"component":{verb: what}});
        let steps = document.history().undo_names().len();
        match run(&mut document, &line.to_string()) {
            Ok(_) if document.history().undo_names().len() > steps => states.push(all(&document)),
            _ => assert!(all(&document) == states[states.len() - 1], "{line}: no step, and changed"),
        }
    }
    assert!(states.len() > 6, "{}", states.len());
    for way in ["undo", "redo", "undo"] {
        let order: Vec<usize> =
            if way == "undo" { (0..states.len() - 1).rev().collect() } else { (1..states.len()).collect() };
        for at in order {
            say(&mut document, json!({"history":{way:{}}}));
            assert!(all(&document) == states[at], "{way} to {at}");
        }
    }
}
