//! What is connected to a place: kept alone, removed, selected or labelled, against a plain flood fill of what is meant.

use super::maker::{bytes, run, undone};
use crate::common::one::One;
use crate::common::volumes::each;
use burin::document::{Document, Origin, State};
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::sync::Arc;

pub(super) const DIMS: [u32; 3] = [70, 37, 34];

pub(super) fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

pub(super) fn refused(document: &mut Document, line: Value) -> String {
    let before = bytes(document);
    let said = run(document, &line.to_string()).unwrap_err().to_string();
    assert!(bytes(document) == before, "{line}: refused, and changed");
    said
}

/// Shows what lies above 40 and below 200.
pub(super) fn looked_at(document: &mut Document) {
    let function = json!({"colour":[[0,[1,1,1]]],"opacity":[[40,0],[60,0.5],[150,0.5],[200,0]],"unit_mm":1});
    say(document, json!({"transfer":{"set":{"function":function}}}));
}

pub(super) fn over(voxels: Voxels, dims: [u32; 3]) -> Document {
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

pub(super) fn place(v: [u32; 3], dims: [u32; 3]) -> usize {
    v[0] as usize + dims[0] as usize * (v[1] as usize + dims[1] as usize * v[2] as usize)
}

/// What of a set is connected to a voxel of it, by steps of which so many coordinates at most differ.
pub(super) fn flood(set: &[bool], dims: [u32; 3], start: [u32; 3], most: usize) -> Vec<bool> {
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
pub(super) fn lumps(seed: u64) -> Vec<u8> {
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

pub(super) fn densities(document: &Document) -> Vec<f64> {
    let field = &document.state().unwrap().one().density;
    each(DIMS, |v| field.number(v).unwrap().to_f64())
}

/// Whether the present look of these tests shows a value.
pub(super) fn shows(value: f64) -> bool {
    value > 40.0 && value < 200.0
}

/// A voxel of a set somewhere in its middle.
pub(super) fn some(set: &[bool], nth: usize) -> [u32; 3] {
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
