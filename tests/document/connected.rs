//! What is connected to a place: kept alone, removed, selected or labelled, against a plain flood fill of what is meant.

use super::maker::{bytes, run, undone, write_nrrd};
use crate::common::one::One;
use crate::common::volumes::each;
use burin::document::{Document, Origin, State};
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::sync::Arc;

const DIMS: [u32; 3] = [70, 37, 34];

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn refused(document: &mut Document, line: Value) -> String {
    let before = bytes(document);
    let said = run(document, &line.to_string()).unwrap_err().to_string();
    assert!(bytes(document) == before, "{line}: refused, and changed");
    said
}

/// Shows what lies above 40 and below 200.
fn looked_at(document: &mut Document) {
    let function = json!({"colour":[[0,[1,1,1]]],"opacity":[[40,0],[60,0.5],[150,0.5],[200,0]],"unit_mm":1});
    say(document, json!({"transfer":{"set":{"function":function}}}));
}

fn over(voxels: Voxels, dims: [u32; 3]) -> Document {
    let grid = Grid::aligned(dims, DVec3::new(0.7, 1.0, 1.5), DVec3::new(-20.0, 5.0, 3.0));
    let source = Arc::new(MemorySource::new("made", grid, voxels, (1.0, 0.0)).unwrap());
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let histogram =
        Histogram { min: statistics.min - 0.5, max: statistics.max + 0.5, bins: vec![1; 4], ..Histogram::default() };
    let origin = Origin { path: "made.nrrd".into(), component: 0, frame: 0 };
    let mut document = Document::new();
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    looked_at(&mut document);
    document
}

fn place(v: [u32; 3], dims: [u32; 3]) -> usize {
    v[0] as usize + dims[0] as usize * (v[1] as usize + dims[1] as usize * v[2] as usize)
}

/// What of a set is connected to a voxel of it, by steps of which so many coordinates at most differ.
fn flood(set: &[bool], dims: [u32; 3], start: [u32; 3], most: usize) -> Vec<bool> {
    let mut found = vec![false; set.len()];
    found[place(start, dims)] = set[place(start, dims)];
    let mut open = vec![start];
    while let Some(v) = open.pop() {
        for n in 0..27_i64 {
            let by = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
            let next: [i64; 3] = std::array::from_fn(|a| i64::from(v[a]) + by[a]);
            let near = by.iter().filter(|d| **d != 0).count() <= most;
            if near && (0..3).all(|a| (0..i64::from(dims[a])).contains(&next[a])) {
                let next = next.map(|x| x as u32);
                let at = place(next, dims);
                if set[at] && !found[at] {
                    found[at] = true;
                    open.push(next);
                }
            }
        }
    }
    found
}

/// Lumps of 100 and 180 in 10 and 250, with bricks of one value among them.
fn lumps(seed: u64) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let balls: Vec<(DVec3, f64, u8)> = (0..26)
        .map(|_| {
            let at = DVec3::from_array(std::array::from_fn(|a| rng.random_range(0.0..f64::from(DIMS[a]))));
            (at, rng.random_range(1.5..7.0), [100, 180, 100, 250][rng.random_range(0..4)])
        })
        .collect();
    each(DIMS, |v| {
        let p = DVec3::from_array(v.map(f64::from));
        balls.iter().find(|(at, radius, _)| p.distance(*at) <= *radius).map_or(10, |ball| ball.2)
    })
}

fn densities(document: &Document) -> Vec<f64> {
    let field = &document.state().unwrap().one().density;
    each(DIMS, |v| field.number(v).unwrap().to_f64())
}

/// Whether the present look of these tests shows a value.
fn shows(value: f64) -> bool {
    value > 40.0 && value < 200.0
}

/// A voxel of a set somewhere in its middle.
fn some(set: &[bool], nth: usize) -> [u32; 3] {
    let all: Vec<[u32; 3]> = each(DIMS, |v| v).into_iter().filter(|v| set[place(*v, DIMS)]).collect();
    all[all.len() * nth / 5]
}

#[test]
fn what_is_connected_stays_or_goes_and_undo_brings_every_byte_back_in_one_step() {
    for (seed, neighbours, most) in [(1, 6, 1), (2, 18, 2), (3, 26, 3)] {
        let voxels = lumps(seed);
        let mut document = over(Voxels::U8(voxels.clone()), DIMS);
        let set: Vec<bool> = voxels.iter().map(|v| shows(f64::from(*v))).collect();
        let at = some(&set, 2);
        let component = flood(&set, DIMS, at, most);
        for keeps in [true, false] {
            let before = bytes(&document);
            let what = json!({"at":{"index":at},"neighbours":neighbours});
            let verb = if keeps { "keep" } else { "remove" };
            let said = say(&mut document, json!({"component":{verb: what}}));
            assert_eq!(said["voxels"], component.iter().filter(|c| **c).count());
            let value = said["value"].as_f64().unwrap();
            assert!(!shows(value), "{value}");
            let mut removed = 0;
            for ((now, &was), (&visible, &own)) in
                densities(&document).iter().zip(&voxels).zip(set.iter().zip(&component))
            {
                let goes = visible && own != keeps;
                removed += u64::from(goes);
                assert_eq!(*now, if goes { value } else { f64::from(was) });
            }
            assert_eq!(said["voxels_changed"], removed);
            assert_eq!(document.history().undo_names().len(), 1);
            say(&mut document, json!({"history":{"undo":{}}}));
            assert!(bytes(&document) == before, "undone");
        }
    }
}

#[test]
fn the_largest_is_meant_where_no_place_is_said() {
    let voxels = lumps(1);
    let mut document = over(Voxels::U8(voxels.clone()), DIMS);
    let set: Vec<bool> = voxels.iter().map(|v| shows(f64::from(*v))).collect();
    let sizes = set.iter().enumerate().filter(|(_, s)| **s).step_by(97).map(|(i, _)| {
        let [nx, ny] = [DIMS[0] as usize, DIMS[1] as usize];
        let at = [i % nx, i / nx % ny, i / nx / ny].map(|v| v as u32);
        flood(&set, DIMS, at, 1).iter().filter(|c| **c).count()
    });
    let said = say(&mut document, json!({"component":{"keep":{}}}));
    assert_eq!(said["voxels"], sizes.max().unwrap());
    assert!(said.get("nothing").is_none());
    let again = say(&mut document, json!({"component":{"keep":{}}}));
    let words = json!("All of it is connected: there is nothing else to remove.");
    assert_eq!((&again["step"], &again["nothing"], &again["components"]), (&Value::Null, &words, &json!(1)));
}

#[test]
fn a_brushed_region_bounds_what_is_connected_and_what_is_removed() {
    let voxels = lumps(4);
    let mut document = over(Voxels::U8(voxels.clone()), DIMS);
    // Selected by a half and more on one side, by less on the other.
    let region = |v: [u32; 3]| v[0] + v[2] < 60 && v[1] > 4;
    let selected = |v: [u32; 3]| if region(v) { 128 + (v[0] % 100) as u8 } else { 127 };
    let state = document.state().unwrap().clone();
    let mut state = state;
    let grid = *state.one().grid();
    let painted = crate::common::volumes::painted(FieldKind::Selection, &grid, |v| [selected(v), 0, 0, 0]);
    state.one_mut().selection = painted;
    document.adopt(state);
    let all: Vec<bool> = voxels.iter().map(|v| shows(f64::from(*v))).collect();
    let inside = each(DIMS, |v| all[place(v, DIMS)] && region(v));
    let at = some(&inside, 2);
    for (within, set) in [(None, &inside), (Some("selection"), &inside), (Some("volume"), &all)] {
        let component = flood(set, DIMS, at, 1);
        for keeps in [true, false] {
            let mut what = json!({"at":{"index":at}});
            if let Some(within) = within {
                what["within"] = json!(within);
            }
            let said = say(&mut document, json!({"component":{if keeps { "keep" } else { "remove" }: what}}));
            let value = said["value"].as_f64().unwrap();
            for ((now, &was), (&meant, &own)) in
                densities(&document).iter().zip(&voxels).zip(set.iter().zip(&component))
            {
                assert_eq!(*now, if meant && own != keeps { value } else { f64::from(was) }, "{within:?}");
            }
            say(&mut document, json!({"history":{"undo":{}}}));
        }
    }
    // What is selected by less than a half anywhere is no region.
    let mut faint = document.state().unwrap().clone();
    faint.one_mut().selection = crate::common::volumes::painted(FieldKind::Selection, &grid, |_| [127, 0, 0, 0]);
    let mut open = Document::new();
    open.adopt(faint);
    let said = say(&mut open, json!({"component":{"remove":{"at":{"index":at}}}}));
    assert_eq!(said["voxels"], flood(&all, DIMS, at, 1).iter().filter(|c| **c).count());
    // A place outside of the region is refused, and the way out is said.
    let outside = each(DIMS, |v| all[place(v, DIMS)] && !region(v));
    let at = some(&outside, 2);
    let said = refused(&mut document, json!({"component":{"keep":{"at":{"index":at}}}}));
    assert!(said.contains("in what is selected (\"within\": \"volume\" leaves the selection aside)"), "{said}");
}

#[test]
fn a_range_of_values_is_told_in_the_sources_own_numbers() {
    // 0.1 has no 16-bit code and no exact float; neighbours differ by one step of 32-bit floats.
    let step = 0.1_f32.next_up();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let voxels: Vec<f32> = each(DIMS, |_| [0.1, step, 7.0, f32::NAN][rng.random_range(0..4)]);
    let mut document = over(Voxels::F32(voxels.clone()), DIMS);
    let set: Vec<bool> = voxels.iter().map(|v| *v == 0.1).collect();
    let at = some(&set, 3);
    let component = flood(&set, DIMS, at, 1);
    let what = json!({"at":{"index":at},"matter":{"range":[0.1, 0.1]},"value":-3.5});
    let said = say(&mut document, json!({"component":{"remove": what}}));
    assert_eq!(said["voxels"], component.iter().filter(|c| **c).count());
    for ((now, &was), &own) in densities(&document).iter().zip(&voxels).zip(&component) {
        let expected = if own { -3.5 } else { f64::from(was) };
        assert!(*now == expected || now.is_nan() && expected.is_nan(), "{now} {expected}");
    }
    // NaN is of no range; all of it is of everything.
    let said = say(&mut document, json!({"component":{"select":{"matter":"everything"}}}));
    assert_eq!((said["voxels"].as_u64(), &said["components"]), (Some(voxels.len() as u64), &json!(1)));
}

#[test]
fn floats_show_by_their_texels_and_nan_shows_nowhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let values = [39.9, 40.0, 40.1, 199.9, 200.0, f32::NAN, 100.0];
    // The last bricks have one value beside NaN.
    let voxels: Vec<f32> = each(DIMS, |v| values[rng.random_range(if v[2] >= 30 { 5..7 } else { 0..7 })]);
    let mut document = over(Voxels::F32(voxels.clone()), DIMS);
    let set: Vec<bool> = voxels.iter().map(|v| shows(f64::from(*v))).collect();
    let at = some(&set, 2);
    let said = say(&mut document, json!({"component":{"select":{"at":{"index":at}}}}));
    assert_eq!(said["voxels"], flood(&set, DIMS, at, 1).iter().filter(|c| **c).count());
}

#[test]
fn hidden_segments_and_segments_with_looks_of_their_own_count_as_they_show() {
    let voxels = vec![100_u8; DIMS.iter().product::<u32>() as usize];
    let mut document = over(Voxels::U8(voxels), DIMS);
    let mut state = document.state().unwrap().clone();
    let grid = *state.one().grid();
    // Three slabs: 1, none, 2.
    let label = |v: [u32; 3]| [1, 0, 0, 2][(v[0] / 20).min(3) as usize];
    state.one_mut().labels = crate::common::volumes::painted(FieldKind::Labels, &grid, |v| [label(v), 0, 0, 0]);
    document.adopt(state);
    for id in [1, 2] {
        say(&mut document, json!({"segment":{"set":{"id":id}}}));
    }
    let [a, b] = [20, 40].map(|n: u64| n * u64::from(DIMS[1] * DIMS[2]));
    let ask = |document: &mut Document, x: u32, within: Value| {
        let mut what = json!({"at":{"index":[x, 3, 3]}});
        if !within.is_null() {
            what["within"] = within;
        }
        let said = say(document, json!({"component":{"select": what}}))["voxels"].as_u64();
        say(document, json!({"selection":{"clear":{}}}));
        said
    };
    assert_eq!(ask(&mut document, 30, Value::Null), Some(u64::from(DIMS.iter().product::<u32>())));
    assert_eq!(ask(&mut document, 30, json!({"segment":0})), Some(b));
    assert_eq!(ask(&mut document, 10, json!({"segment":1})), Some(a));
    // Of a segment that does not show, nothing is met, and what lies beyond it is apart.
    say(&mut document, json!({"segment":{"set":{"id":2,"look":{"opacity":0}}}}));
    assert_eq!(ask(&mut document, 30, Value::Null), Some(a + b));
    say(&mut document, json!({"segment":{"show_only":{"ids":[1]}}}));
    assert_eq!(ask(&mut document, 10, Value::Null), Some(a));
    let hidden = refused(&mut document, json!({"component":{"keep":{"at":{"index":[30,3,3]}}}}));
    assert!(hidden.contains("a place at matter that the 3D view shows"), "{hidden}");
    // A surface shows what lies above it.
    say(&mut document, json!({"segment":{"show_only":{}}}));
    say(&mut document, json!({"segment":{"set":{"id":1,"look":{"mode":{"iso":101}}}}}));
    assert_eq!(ask(&mut document, 30, Value::Null), Some(b));
}

#[test]
fn selecting_replaces_adds_and_takes_away_and_labels_spare_what_is_locked() {
    let voxels = lumps(5);
    let mut document = over(Voxels::U8(voxels.clone()), DIMS);
    let set: Vec<bool> = voxels.iter().map(|v| shows(f64::from(*v))).collect();
    let (a, b) = (some(&set, 1), some(&set, 3));
    let [first, second] = [a, b].map(|at| flood(&set, DIMS, at, 1));
    assert_ne!(first, second);
    let selection = |document: &Document| {
        let field = &document.state().unwrap().one().selection;
        each(DIMS, |v| field.texel(v).unwrap()[0])
    };
    let hold = |document: &Document, expected: &dyn Fn(usize) -> bool| {
        for (i, texel) in selection(document).into_iter().enumerate() {
            assert_eq!(texel, if expected(i) { 255 } else { 0 }, "{i}");
        }
    };
    say(&mut document, json!({"component":{"select":{"at":{"index":a}}}}));
    hold(&document, &|i| first[i]);
    say(&mut document, json!({"component":{"select":{"at":{"index":b},"how":"add"}}}));
    hold(&document, &|i| first[i] || second[i]);
    say(&mut document, json!({"component":{"select":{"at":{"index":a},"how":"subtract"}}}));
    hold(&document, &|i| second[i] && !first[i]);
    say(&mut document, json!({"component":{"select":{"at":{"index":a}}}}));
    hold(&document, &|i| first[i]);
    let undone_to = undone(&document);
    let labelled = say(&mut document, json!({"component":{"label":{"at":{"index":a},"label":3}}}));
    assert_eq!(labelled["kept_locked"], 0);
    say(&mut document, json!({"segment":{"set":{"id":3,"locked":true}}}));
    let again = say(&mut document, json!({"component":{"label":{"at":{"index":b},"label":4,"within":"volume"}}}));
    assert_eq!(again["kept_locked"], first.iter().zip(&second).filter(|(a, b)| **a && **b).count());
    let kept = say(&mut document, json!({"component":{"label":{"at":{"index":a},"label":5}}}));
    assert_eq!(kept["kept_locked"], kept["voxels"]);
    assert_eq!((&kept["step"], &kept["nothing"]), (&Value::Null, &json!("The segment that is there is locked.")));
    assert!(document.state().unwrap().scene.segments().get(5).is_none());
    let again = say(&mut document, json!({"component":{"select":{"at":{"index":a}}}}));
    assert_eq!((&again["step"], &again["nothing"]), (&Value::Null, &json!("The selection is so already.")));
    let labels = &document.state().unwrap().one().labels;
    for (i, v) in each(DIMS, |v| v).into_iter().enumerate() {
        let expected = if first[i] {
            3.0
        } else if second[i] {
            4.0
        } else {
            0.0
        };
        assert_eq!(labels.value(v).unwrap(), expected);
    }
    assert!(document.state().unwrap().scene.segments().get(4).is_some(), "made with its first voxel");
    say(&mut document, json!({"history":{"undo":{"steps":3}}}));
    assert!(undone(&document) == undone_to);
}

#[test]
fn what_is_removed_becomes_what_erasing_sets_or_another_value_that_does_not_show() {
    let ball = |v: [u32; 3]| (DVec3::from_array(v.map(f64::from)) - 17.0).length() < 6.0;
    let dims = [40, 35, 34];
    let made = |inside: u8, outside: u8| over(Voxels::U8(each(dims, |v| if ball(v) { inside } else { outside })), dims);
    let remove = json!({"component":{"remove":{"at":{"index":[17,17,17]}}}});
    let mut document = made(100, 10);
    assert_eq!(say(&mut document, remove.clone())["value"], 10.0);
    say(&mut document, json!({"history":{"undo":{}}}));
    say(&mut document, json!({"brush":{"set":{"erase_density":{"to":3.0}}}}));
    assert_eq!(say(&mut document, remove.clone())["value"], 3.0, "beyond what 16 bits had room for");
    let state = document.state().unwrap();
    assert_eq!(state.one().density.number([17, 17, 17]).unwrap().to_f64(), 3.0);
    say(&mut document, json!({"history":{"undo":{}}}));
    assert_eq!(document.state().unwrap().one().density.edits().len(), 0);
    // One that shows is not taken.
    say(&mut document, json!({"brush":{"set":{"erase_density":{"to":90.0}}}}));
    assert_eq!(say(&mut document, remove.clone())["value"], 10.0);
    // The least shows here, the greatest does not.
    assert_eq!(say(&mut made(100, 255), remove.clone())["value"], 255.0);
    // Neither does: something beside what shows.
    let mut both = made(100, 60);
    let value = say(&mut both, remove.clone())["value"].as_f64().unwrap();
    assert!(!shows(value), "{value}");
    assert!(!shows(both.state().unwrap().one().density.number([17, 17, 17]).unwrap().to_f64()));
    // Everything shows.
    let mut all = made(100, 10);
    say(&mut all, json!({"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0.5]],"unit_mm":1}}}}));
    let said = refused(&mut all, remove);
    assert!(said.contains("every value shows under the present look"), "{said}");
    let given = say(&mut all, json!({"component":{"remove":{"matter":{"range":[90,110]},"value":-70.25}}}));
    assert_eq!(given["value"], -70.25);
    assert_eq!(all.state().unwrap().one().density.number([17, 17, 17]).unwrap().to_f64(), -70.25);
}

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
fn a_volume_that_was_moved_is_met_where_it_lies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.nrrd");
    let grid = Grid::aligned([20, 18, 16], DVec3::new(1.0, 1.5, 2.0), DVec3::new(3.0, -4.0, 7.0));
    // Two lumps in one row.
    let lump = |v: [u32; 3]| (2..7).contains(&v[0]) || (11..17).contains(&v[0]);
    write_nrrd(&path, &grid, |v| if lump(v) && v[1] > 2 { 100.0 } else { 10.0 });
    let mut document = over(Voxels::U8(lumps(6)), DIMS);
    say(&mut document, json!({"volume":{"add":{"path":path}}}));
    let pose = json!({"rotation":[0.0,0.0,-0.28,0.96],"translation":[4.0,13.0,2.0]});
    let function = json!({"colour":[[0,[1,1,1]]],"opacity":[[40,0],[60,0.5],[150,0.5],[200,0]],"unit_mm":1});
    say(&mut document, json!({"volume":{"set":{"volume":1,"pose":pose,"look":{"transfer":function}}}}));
    let first = bytes(&document);
    let subject = document.state().unwrap().at(Some(VolumeId(1))).unwrap();
    let world = subject.grid().world_from_index.transform_point3(DVec3::new(13.2, 8.4, 7.3));
    let said = say(&mut document, json!({"component":{"keep":{"at":{"mm":world.to_array()},"volume":1}}}));
    assert_eq!((said["volume"].as_u64(), said["voxels"].as_u64()), (Some(1), Some(6 * 15 * 16)));
    let density = |document: &Document, v: [u32; 3]| {
        document.state().unwrap().volumes[&VolumeId(1)].density.number(v).unwrap().to_f64().round()
    };
    assert_eq!([4, 13].map(|x| density(&document, [x, 8, 7])), [10.0, 100.0]);
    assert!(bytes(&document).0 == first.0, "the other volume is as it was");
    // The step can be done again elsewhere: its place is in mm, its volume named.
    let history = say(&mut document, json!({"ask":{"history":{"commands":true}}}));
    let commands = history["undo_commands"].as_array().unwrap();
    let last = commands.iter().flat_map(|c| c.as_array().unwrap()).find(|c| c["command"]["component"].is_object());
    let keep = &last.unwrap()["command"]["component"]["keep"];
    assert_eq!(keep["volume"], 1);
    assert!(keep["at"]["mm"].is_array(), "{keep}");
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
fn a_pixel_of_the_3d_view_means_what_it_shows_of_whatever_volume() {
    let dims = [64, 48, 40];
    let block =
        |v: [u32; 3], x: std::ops::Range<u32>| x.contains(&v[0]) && (8..40).contains(&v[1]) && (8..32).contains(&v[2]);
    let voxels = each(dims, |v| if block(v, 6..26) || block(v, 38..58) { 200_u8 } else { 0 });
    let Some(mut document) = super::maker_gpu::made(Voxels::U8(voxels), dims, DVec3::ONE) else { return };
    let function = json!({"colour":[[0,[1,0.8,0.6]]],"opacity":[[90,0],[110,0.9]],"unit_mm":1});
    say(&mut document, json!({"transfer":{"set":{"function":function}}}));
    // Another block above both, in a volume of its own.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("above.nrrd");
    let grid = Grid::aligned([30, 20, 20], DVec3::ONE, DVec3::new(17.0, 10.0, 45.0));
    write_nrrd(&path, &grid, |v| if v.iter().all(|x| (3..17).contains(x)) { 200.0 } else { 0.0 });
    say(&mut document, json!({"volume":{"add":{"path":path}}}));
    say(&mut document, json!({"volume":{"set":{"volume":1,"look":{"transfer":function}}}}));
    say(&mut document, json!({"view":{"size":{"view":"3d","size":[96,96]}}}));
    say(&mut document, json!({"view":{"frame":{"from":[0,-1,0]}}}));
    let shown = |document: &mut Document, rest: [f64; 3]| {
        // The pixel that shows the place, found by looking at all.
        let mut best = (f64::INFINITY, [0.0; 2]);
        for i in 0..24 * 24 {
            let px = [f64::from(i % 24) * 4.0 + 2.0, f64::from(i / 24) * 4.0 + 2.0];
            let hit = say(document, json!({"ask":{"pick":{"px":px}}}))["hit"].take();
            let Some(mm) = hit["rest_mm"].as_array() else { continue };
            let far: f64 = mm.iter().zip(rest).map(|(a, b)| (a.as_f64().unwrap() - b).powi(2)).sum();
            if far < best.0 {
                best = (far, px);
            }
        }
        assert!(best.0 < 16.0, "nothing shows near {rest:?}");
        best.1
    };
    let (left, right, above) = (
        shown(&mut document, [16.0, 8.0, 20.0]),
        shown(&mut document, [48.0, 8.0, 20.0]),
        shown(&mut document, [27.0, 13.0, 55.0]),
    );
    let pick = |document: &mut Document, px: [f64; 2]| say(document, json!({"ask":{"pick":{"px":px}}}))["hit"].take();
    let at = |px: [f64; 2]| json!({"pixel":{"view":"3d","px":px}});
    let said = say(&mut document, json!({"component":{"keep":{"at":at(left)}}}));
    assert_eq!((&said["volume"], &said["voxels"], &said["components"]), (&json!(0), &json!(20 * 32 * 24), &json!(2)));
    assert!(pick(&mut document, left).is_object() && pick(&mut document, above).is_object());
    assert!(pick(&mut document, right).is_null(), "the picture follows");
    say(&mut document, json!({"history":{"undo":{}}}));
    assert!(pick(&mut document, right).is_object());
    let said = say(&mut document, json!({"component":{"remove":{"at":at(above)}}}));
    assert_eq!((&said["volume"], &said["voxels"]), (&json!(1), &json!(14 * 14 * 14)));
    assert!(pick(&mut document, above).is_null());
    let said = refused(&mut document, json!({"component":{"keep":{"at":at(above)}}}));
    assert!(said.contains("where nothing is visible"), "{said}");
    // A volume that is named is meant, whatever hides it.
    let said = refused(&mut document, json!({"component":{"keep":{"at":at(left),"volume":1}}}));
    assert!(said.contains("at: "), "{said}");
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

#[test]
fn hidden_parts_and_matter_that_its_part_or_the_selection_hides_are_not_met() {
    let voxels = vec![100_u8; DIMS.iter().product::<u32>() as usize];
    let mut document = over(Voxels::U8(voxels), DIMS);
    let grid = *document.state().unwrap().at(None).unwrap().grid();
    let world = |v: [u32; 3]| grid.world_from_index.transform_point3(DVec3::from_array(v.map(f64::from)));
    // Oblique, through bricks.
    let (normal, offset) = (DVec3::new(0.8, 0.6, 0.0), 26.3);
    let cut = json!({"plane":{"normal":normal.to_array(),"point":(normal * offset).to_array()}});
    say(&mut document, json!({"part":{"split":{"by":cut}}}));
    let parts = document.state().unwrap().scene.explosion.parts.clone();
    assert_eq!(parts.len(), 2);
    let beyond = |v: [u32; 3]| world(v).dot(normal) > offset;
    let hidden = parts.iter().find(|part| part.centre().dot(normal) > offset).unwrap().id.0;
    let ask = |document: &mut Document, within: &str| {
        let said = say(document, json!({"component":{"label":{"label":9,"at":{"index":[0,0,0]},"within":within}}}));
        let found = document.state().unwrap().one().labels.clone();
        say(document, json!({"history":{"undo":{}}}));
        (said["voxels"].as_u64().unwrap(), each(DIMS, |v| found.value(v).unwrap() == 9.0))
    };
    let all = u64::from(DIMS.iter().product::<u32>());
    assert_eq!(ask(&mut document, "volume").0, all, "cut, and all of it shown");
    let near: Vec<bool> = each(DIMS, |v| !beyond(v));
    for change in [json!({"visible":false}), json!({"visible":true,"look":{"opacity":0}})] {
        let mut set = change.clone();
        set["id"] = json!(hidden);
        say(&mut document, json!({"part":{"set":set}}));
        assert!(ask(&mut document, "volume").1 == near, "{change}");
    }
    say(&mut document, json!({"part":{"set":{"id":hidden,"look":"inherit"}}}));
    assert_eq!(ask(&mut document, "volume").0, all);
    // What is selected is no part's, and has its own look.
    let region = |v: [u32; 3]| v[2] > 20 && v[0] < 50;
    let mut state = document.state().unwrap().clone();
    let own = *state.one().grid();
    state.one_mut().selection =
        crate::common::volumes::painted(FieldKind::Selection, &own, |v| [if region(v) { 200 } else { 0 }, 0, 0, 0]);
    document.adopt(state);
    say(&mut document, json!({"selection":{"set":{"look":{"opacity":0}}}}));
    assert!(ask(&mut document, "volume").1 == each(DIMS, |v| !region(v)));
    say(&mut document, json!({"selection":{"set":{"look":"inherit"}}}));
    say(&mut document, json!({"part":{"set":{"id":hidden,"visible":false}}}));
    assert!(
        ask(&mut document, "volume").1 == each(DIMS, |v| region(v) || !beyond(v)),
        "selected matter shows though its part is hidden"
    );
}
