//! Brushes by command: thin lines, the end of a stroke, the rim of labels, erasing to the end, and what is said where nothing
//! changed.

use super::maker::{bytes, run, write_nrrd};
use super::maker_gpu::{block, labelled, made as of};
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde_json::{Value, json};

fn brush(document: &mut Document, settings: Value) -> Value {
    run(document, &json!({"brush":{"set":settings}}).to_string()).unwrap()["brush"].clone()
}

/// A stroke through places in continuous indices.
fn stroke(document: &mut Document, places: &[[f64; 3]]) -> Value {
    let points: Vec<_> = places.iter().map(|p| json!({"at":{"index":p}})).collect();
    run(document, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap()
}

#[test]
fn a_thin_line_is_every_voxel_that_its_path_passes() {
    let Some(mut document) = of(Voxels::U8(vec![0; 64 * 32 * 32]), [64, 32, 32], DVec3::ONE) else { return };
    for (label, radius) in [(1, 0.3), (2, 0.0), (3, 1e-3)] {
        brush(&mut document, json!({"radius_mm":radius,"falloff":"hard","target":{"label":label}}));
        let y = 16.4 + f64::from(label);
        assert_eq!(stroke(&mut document, &[[2.0, y, 16.4], [60.0, y, 16.4]])["voxels_changed"], 59);
        let row: Vec<_> = (2..=60).map(|x| [x, 16 + u32::from(label as u16), 16]).collect();
        assert_eq!(labelled(&document, label as u16), row, "radius {radius}");
    }
    // A click, at a corner between eight voxels.
    brush(&mut document, json!({"radius_mm":0.2,"target":{"label":9}}));
    let click = stroke(&mut document, &[[7.49, 5.49, 3.49]]);
    assert_eq!((&click["voxels_changed"], &click["bricks_touched"]), (&json!(1), &json!(1)));
    assert_eq!(labelled(&document, 9), [[7, 5, 3]]);
}

#[test]
fn a_thin_line_between_thick_slices_has_no_gap_and_keeps_masks_and_locks() {
    let dims = [40, 24, 12];
    let spacing = DVec3::new(0.5, 0.5, 5.0);
    let value = |i: u32| if i % dims[0] < 20 { 10 } else { 200 };
    let voxels = Voxels::U8((0..dims.iter().product()).map(value).collect());
    let Some(mut document) = of(voxels, dims, spacing) else { return };
    brush(&mut document, json!({"radius_mm":0.6,"falloff":"linear","target":{"selection":1.0},"strength":0.5}));
    // Halfway between two slices, then obliquely through several.
    stroke(&mut document, &[[3.0, 4.0, 5.49], [35.0, 4.0, 5.49], [36.2, 20.1, 9.3]]);
    let field = document.state().unwrap().one().field(FieldKind::Selection);
    for i in 0..=1000 {
        let t = f64::from(i) / 1000.0;
        for (a, b) in [([3.0, 4.0, 5.49], [35.0, 4.0, 5.49]), ([35.0, 4.0, 5.49], [36.2, 20.1, 9.3])] {
            let p = DVec3::from_array(a).lerp(DVec3::from_array(b), t);
            let voxel = (p + 0.5).floor().to_array().map(|v| v as u32);
            assert_eq!(field.texel(voxel).unwrap()[0], 128, "{voxel:?}: strength times pressure, whatever the falloff");
        }
    }
    brush(&mut document, json!({"radius_mm":0.1,"target":{"label":1},"range":[100,255],"strength":1.0}));
    stroke(&mut document, &[[3.0, 8.0, 5.49], [35.0, 8.0, 5.49]]);
    assert_eq!(labelled(&document, 1), (20..=35).map(|x| [x, 8, 5]).collect::<Vec<_>>());
    run(&mut document, r#"{"segment":{"set":{"id":1,"locked":true}}}"#).unwrap();
    brush(&mut document, json!({"target":{"label":2},"any_value":true}));
    stroke(&mut document, &[[3.0, 8.0, 5.0], [35.0, 8.0, 5.0]]);
    assert_eq!(labelled(&document, 2), (3..20).map(|x| [x, 8, 5]).collect::<Vec<_>>());
}

#[test]
fn a_stroke_covers_its_last_sample_live_and_at_once() {
    let Some(mut document) = of(Voxels::U8(vec![0; 96 * 64 * 64]), [96, 64, 64], DVec3::ONE) else { return };
    brush(&mut document, json!({"radius_mm":20,"falloff":"hard","target":{"label":1}}));
    stroke(&mut document, &[[30.0, 32.0, 32.0], [39.9, 32.0, 32.0]]);
    let at_once = labelled(&document, 1);
    assert!(at_once.contains(&[59, 32, 32]) && !at_once.contains(&[60, 32, 32]), "39.9 + 20 = 59.9");
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    for (verb, x) in [("begin", 30.0), ("extend", 33.3), ("extend", 39.9)] {
        let point = json!({"at":{"index":[x, 32.0, 32.0]}});
        run(&mut document, &json!({"stroke":{verb:{"points":[point]}}}).to_string()).unwrap();
    }
    // Whatever ends it.
    run(&mut document, r#"{"brush":{"set":{"radius_mm":3}}}"#).unwrap();
    assert_eq!(labelled(&document, 1), at_once);
}

#[test]
fn a_break_between_points_leaves_what_lies_between_alone() {
    let Some(mut document) = of(Voxels::U8(vec![0; 64 * 32 * 32]), [64, 32, 32], DVec3::ONE) else { return };
    brush(&mut document, json!({"radius_mm":2,"target":{"label":1}}));
    let points = json!([{"at":{"index":[5,16,16]}}, {"at":{"index":[12,16,16]}},
        {"at":{"index":[40,16,16]},"breaks":true}, {"at":{"index":[45.5,16,16]}}]);
    run(&mut document, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap();
    let row: Vec<_> = labelled(&document, 1).into_iter().filter(|v| v[1] == 16 && v[2] == 16).map(|v| v[0]).collect();
    assert_eq!(row, (3..=14).chain(38..=47).collect::<Vec<_>>());
    // Without a break the points are a path as given.
    brush(&mut document, json!({"target":{"label":2}}));
    stroke(&mut document, &[[5.0, 16.0, 16.0], [45.0, 16.0, 16.0]]);
    let row = labelled(&document, 2).into_iter().filter(|v| v[1] == 16 && v[2] == 16).count();
    assert_eq!(row, 45);
}

#[test]
fn labels_fill_the_radius_whatever_the_falloff_and_start_hard() {
    let Some(mut document) = of(Voxels::U8(vec![0; 32 * 32 * 32]), [32; 3], DVec3::ONE) else { return };
    let ball = |r: f64| {
        let within = |v: &[u32; 3]| v.iter().map(|&c| (f64::from(c) - 16.0).powi(2)).sum::<f64>() <= r * r;
        each([32; 3]).filter(within).collect::<Vec<_>>()
    };
    for (label, falloff, strength) in [(1, "smooth", 1.0), (2, "linear", 0.5), (3, "hard", 0.5), (4, "smooth", 0.5)] {
        brush(
            &mut document,
            json!({"radius_mm":5,"falloff":falloff,"strength":strength,"target":{"label":label},"tip":"wash"}),
        );
        stroke(&mut document, &[[16.0, 16.0, 16.0]]);
        assert_eq!(labelled(&document, label), ball(5.0), "{falloff} {strength}");
    }
    // Choosing a label makes the edge hard, unless it is said otherwise; changing the label leaves it.
    brush(&mut document, json!({"falloff":"smooth","target":{"selection":1}}));
    assert_eq!(brush(&mut document, json!({"target":{"label":1}}))["falloff"], "hard");
    brush(&mut document, json!({"falloff":"smooth","target":{"selection":1}}));
    assert_eq!(brush(&mut document, json!({"target":{"label":1},"falloff":"linear"}))["falloff"], "linear");
    assert_eq!(brush(&mut document, json!({"target":{"label":2}}))["falloff"], "linear");
}

#[test]
fn the_edge_from_before_labels_comes_back_with_what_is_painted_next() {
    let Some(mut document) = of(Voxels::U8(vec![0; 16 * 16 * 16]), [16; 3], DVec3::ONE) else { return };
    for (next, kept) in [("selection", json!(1.0)), ("density", json!(3.0)), ("colour", json!([1.0, 0.0, 0.0, 1.0]))] {
        for falloff in ["smooth", "linear", "hard"] {
            brush(&mut document, json!({"falloff":falloff,"target":{"selection":1}}));
            brush(&mut document, json!({"target":{"label":1}}));
            brush(&mut document, json!({"target":{"label":7},"radius_mm":3}));
            assert_eq!(brush(&mut document, json!({"target":{next:kept}}))["falloff"], falloff, "label, then {next}");
            assert_eq!(brush(&mut document, json!({"radius_mm":4}))["falloff"], falloff);
        }
    }
    // What is said while a label is painted stays.
    brush(&mut document, json!({"falloff":"smooth","target":{"selection":1}}));
    brush(&mut document, json!({"target":{"label":1}}));
    brush(&mut document, json!({"falloff":"linear"}));
    assert_eq!(brush(&mut document, json!({"target":{"selection":0.5}}))["falloff"], "linear");
}

fn each(dims: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..dims[2]).flat_map(move |z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| [x, y, z])))
}

#[test]
fn a_hundred_weak_erasures_reach_the_end_exactly() {
    let of_16_bit = Voxels::U16((0..16 * 16 * 16).map(|i| (i * 16 % 65_536) as u16).collect());
    let of_8_bit = Voxels::U8((0..16 * 16 * 16).map(|i| (i % 256) as u8).collect());
    for (voxels, wide) in [(of_16_bit, true), (of_8_bit, false)] {
        let Some(mut document) = of(voxels, [16; 3], DVec3::ONE) else { return };
        // 250.4 is no code of 16-bit data: density is in floats from there on.
        for target in [
            json!({"density":250.0}),
            json!({"density":250.4}),
            json!({"selection":1.0}),
            json!({"colour":[0.9,0.3,0.1,1.0]}),
        ] {
            let untouched = bytes(&document).0;
            let settings = json!({"radius_mm":4,"falloff":"hard","strength":1.0,"erase":false,"target":target});
            brush(&mut document, settings);
            assert!(stroke(&mut document, &[[8.0, 8.0, 8.0]])["voxels_changed"].as_u64().unwrap() > 200);
            brush(&mut document, json!({"erase":true,"strength":0.1}));
            for _ in 0..100 {
                stroke(&mut document, &[[8.0, 8.0, 8.0]]);
            }
            // Every voxel is the source's own again.
            if target["density"].is_number() {
                let field = document.state().unwrap().one().field(FieldKind::Density);
                let same = |v: [u32; 3]| {
                    let i = v[0] + 16 * (v[1] + 16 * v[2]);
                    f64::from(field.value(v).unwrap()) == f64::from(if wide { i * 16 } else { i % 256 })
                };
                assert!(each([16; 3]).all(same), "{target}");
            } else {
                let after = bytes(&document).0;
                let arrays = after.iter().zip(&untouched).enumerate().skip(1);
                arrays
                    .filter(|(_, (a, _))| a.len() > 4000)
                    .for_each(|(i, (a, b))| assert!(a == b, "{target} array {i}"));
            }
            let nothing = stroke(&mut document, &[[8.0, 8.0, 8.0]]);
            assert_eq!((&nothing["step"], &nothing["voxels_changed"]), (&Value::Null, &json!(0)), "{target}");
        }
    }
}

#[test]
fn weak_strokes_reach_the_end_in_floats_too() {
    // With an infinite voxel no codes serve.
    let voxels = Voxels::F32((0..512).map(|i| if i == 0 { f32::INFINITY } else { i as f32 * 0.37 - 20.0 }).collect());
    let Some(mut document) = of(voxels, [8; 3], DVec3::ONE) else { return };
    let same = |document: &Document| {
        let field = document.state().unwrap().one().field(FieldKind::Density);
        let own = |v: [u32; 3]| (v[0] + 8 * (v[1] + 8 * v[2])) as f32 * 0.37 - 20.0;
        each([8; 3]).skip(1).all(|v| field.value(v).unwrap() == own(v))
    };
    brush(&mut document, json!({"radius_mm":1,"falloff":"hard","target":{"density":17.5}}));
    stroke(&mut document, &[[4.0, 4.0, 4.0]]);
    assert!(!same(&document));
    brush(&mut document, json!({"erase":true,"strength":0.1}));
    let strokes = (0..260).take_while(|_| stroke(&mut document, &[[4.0, 4.0, 4.0]])["step"] != Value::Null).count();
    assert!(strokes > 50 && strokes <= 100, "{strokes}");
    assert!(same(&document), "after {strokes} strokes");
}

#[test]
fn erasing_density_restores_or_removes_to_the_value_that_was_set() {
    let Some(mut document) = block() else { return };
    let value = |d: &mut Document| {
        run(d, r#"{"ask":{"voxel":{"at":{"index":[30,20,20]}}}}"#).unwrap()["density"].as_f64().unwrap()
    };
    let paint = |d: &mut Document| stroke(d, &[[30.0, 20.0, 20.0]]);
    let set = brush(&mut document, json!({"radius_mm":3,"falloff":"hard","target":{"density":120.0}}));
    assert_eq!(set["erase_density"], "restore");
    paint(&mut document);
    brush(&mut document, json!({"erase":true}));
    paint(&mut document);
    assert_eq!(value(&mut document), 200.0, "the file's own");
    // On untouched tissue restoring does nothing, and says what to do.
    let said = paint(&mut document)["nothing"].as_str().unwrap().to_owned();
    assert!(said.contains("Nothing to restore") && said.contains("remove"), "{said}");
    brush(&mut document, json!({"erase_density":{"to":-7.0}}));
    assert_eq!(paint(&mut document)["step"], "Erase density");
    assert!((value(&mut document) + 7.0).abs() < 1e-3, "removed, also where the codes did not reach");
    // Weak ones arrive as well.
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    brush(&mut document, json!({"erase_density":{"to":0.0},"strength":0.1}));
    (0..100).for_each(|_| drop(paint(&mut document)));
    assert_eq!(value(&mut document), 0.0);
}

#[test]
fn a_stroke_that_changes_nothing_says_why() {
    let Some(mut document) = block() else { return };
    let mut says = |settings: Value, points: Value, words: &str| {
        let base = json!({"radius_mm":3,"falloff":"hard","strength":1.0,"erase":false,"any_value":true,"operation":"replace",
            "erase_density":"restore"});
        brush(&mut document, base);
        brush(&mut document, settings);
        let answer = run(&mut document, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap();
        assert_eq!((&answer["step"], &answer["voxels_changed"]), (&Value::Null, &json!(0)), "{words}");
        let said = answer["nothing"].as_str().unwrap_or_default().to_owned();
        assert!(said.contains(words), "{said}: {words} expected");
    };
    let here = json!([{"at":{"index":[30,20,20]}}]);
    let seen = |x: f64| json!([{"at":{"pixel":{"view":"3d","px":[x,1.0],"size":[96,96]}}}]);
    says(json!({"target":{"selection":1}}), json!([]), "no points");
    says(json!({"target":{"selection":1}}), seen(1.0), "Nothing was hit");
    says(json!({"target":{"selection":1},"strength":0}), here.clone(), "strength is 0");
    says(json!({"target":{"selection":1}}), json!([{"at":{"index":[30,20,20]},"pressure":0}]), "pressure was 0");
    says(json!({"target":{"selection":1}}), json!([{"at":{"index":[300,20,20]}}]), "outside the volume");
    says(json!({"target":{"label":3},"strength":0.3}), here.clone(), "30 %");
    says(json!({"target":{"label":3},"range":[7,9]}), here.clone(), "from 7 to 9");
    says(json!({"target":{"selection":1},"erase":true}), here.clone(), "Nothing is selected");
    says(json!({"target":{"colour":[1,0,0,1]},"erase":true}), here.clone(), "Nothing is coloured");
    says(json!({"target":{"label":3},"erase":true}), here.clone(), "No segment");
    says(json!({"target":{"density":3},"erase":true}), here.clone(), "Nothing to restore");
    says(json!({"target":{"density":200}}), here.clone(), "already");
    run(&mut document, r#"{"brush":{"set":{"target":{"label":4},"radius_mm":6}}}"#).unwrap();
    run(&mut document, &json!({"stroke":{"paint":{"points":here}}}).to_string()).unwrap();
    run(&mut document, r#"{"segment":{"set":{"id":4,"locked":true,"name":"Liver"}}}"#).unwrap();
    let mut says = |settings: Value, words: &str| {
        brush(&mut document, json!({"radius_mm":3,"falloff":"hard","strength":1.0,"any_value":true,"erase":false}));
        brush(&mut document, settings);
        let said = stroke(&mut document, &[[30.0, 20.0, 20.0]]);
        assert!(said["nothing"].as_str().unwrap_or_default().contains(words), "{said}: {words} expected");
    };
    says(json!({"target":{"label":5}}), "locked: Liver");
    says(json!({"target":{"label":5},"erase":true}), "locked: Liver");
    says(json!({"target":{"label":5},"operation":"subtract"}), "locked: Liver");
}

#[test]
fn the_same_stroke_paints_the_same_voxels_whatever_the_unit() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let dims = [40, 36, 34];
    let folder = tempfile::tempdir().unwrap();
    let mut painted = Vec::new();
    // Voxels of 0.9 × 0.8 × 1.3 of a nanometre, a micrometre, a millimetre and a metre.
    for mm in [1e-6, 1e-3, 1.0, 1e3] {
        let path = folder.path().join("v.nrrd");
        let grid = Grid::aligned(dims, DVec3::new(0.9, 0.8, 1.3) * mm, DVec3::new(-3.0, 8.0, 1.7) * mm);
        write_nrrd(&path, &grid, |v| v[0] as f32);
        let mut document = Document::new();
        run(&mut document, &json!({"volume":{"open":{"path":path}}}).to_string()).unwrap();
        // The brush to begin with is one that can be used.
        let first = document.state().unwrap().scene.brush.radius_mm;
        assert!(if mm == 1.0 { first == 5.0 } else { (first / (0.8 * mm) - 5.0).abs() < 1e-9 }, "{mm}: {first}");
        let mut rng = StdRng::seed_from_u64(8);
        let mut all = Vec::new();
        for (i, radius) in [4.3, 0.21, 0.0, 6.0].into_iter().enumerate() {
            for (shape, target) in [("sphere", json!({"label":i + 1})), ("disc", json!({"selection":1.0}))] {
                let set = json!({"radius_mm":radius * mm,"falloff":"hard","shape":shape,"target":target});
                brush(&mut document, set);
                let place = |rng: &mut StdRng| std::array::from_fn(|a| rng.random_range(0.0..f64::from(dims[a])));
                let places = [place(&mut rng), place(&mut rng), place(&mut rng)];
                all.push(stroke(&mut document, &places)["voxels_changed"].clone());
            }
        }
        all.push(json!(bytes(&document).0[4..].concat()));
        painted.push(all);
    }
    for other in &painted[1..] {
        assert_eq!(other[..8], painted[0][..8]);
        assert!(other[8] == painted[0][8]);
    }
}

#[test]
fn a_locked_segment_is_left_alone_whatever_its_number() {
    let Some(mut document) = of(Voxels::U8(vec![0; 32 * 8 * 8]), [32, 8, 8], DVec3::ONE) else { return };
    let ids = [1_u16, 31, 32, 33, 64, 255, 300, 32_767, 32_768, 65_535];
    for (i, id) in ids.iter().enumerate() {
        brush(&mut document, json!({"radius_mm":0,"target":{"label":id}}));
        stroke(&mut document, &[[i as f64 * 3.0, 4.0, 4.0]]);
        // One beside it that differs in the lowest bit, and is not locked.
        brush(&mut document, json!({"target":{"label":id ^ 1}}));
        stroke(&mut document, &[[i as f64 * 3.0 + 1.0, 4.0, 4.0]]);
    }
    for id in ids {
        run(&mut document, &json!({"segment":{"set":{"id":id,"locked":true}}}).to_string()).unwrap();
    }
    brush(&mut document, json!({"radius_mm":40,"target":{"label":9}}));
    stroke(&mut document, &[[16.0, 4.0, 4.0]]);
    let label = |x: u32| document.state().unwrap().one().labels.value([x, 4, 4]).unwrap();
    for (i, id) in (0..).zip(ids) {
        assert_eq!(label(3 * i), f32::from(id));
        let beside = id ^ 1;
        let expected = if beside == 0 {
            9.0
        } else if ids.contains(&beside) {
            f32::from(beside)
        } else {
            9.0
        };
        assert_eq!(label(3 * i + 1), expected, "{beside}");
    }
}

#[test]
fn full_strength_is_the_value_itself_however_large_what_was_there() {
    let voxels = Voxels::F32((0..64).map(|i| if i == 0 { f32::INFINITY } else { 1e8 }).collect());
    let Some(mut document) = of(voxels, [4; 3], DVec3::ONE) else { return };
    brush(&mut document, json!({"radius_mm":0,"target":{"density":0.1}}));
    stroke(&mut document, &[[2.0, 2.0, 2.0]]);
    assert_eq!(document.state().unwrap().one().density.value([2, 2, 2]).unwrap(), 0.1);
    assert_eq!(document.state().unwrap().one().density.value([1, 2, 2]).unwrap(), 1e8);
}

#[test]
fn colour_too_weak_for_a_step_of_opacity_leaves_nothing() {
    let Some(mut document) = of(Voxels::U8(vec![7; 512]), [8; 3], DVec3::ONE) else { return };
    brush(&mut document, json!({"radius_mm":2,"falloff":"hard","strength":0.0015,"target":{"colour":[1,0.5,0.2,1]}}));
    let answer = stroke(&mut document, &[[4.0, 4.0, 4.0]]);
    assert_eq!((&answer["step"], &answer["voxels_changed"]), (&Value::Null, &json!(0)), "0.38 of a step");
    assert!(document.state().unwrap().one().colour.is_blank());
    brush(&mut document, json!({"strength":0.0025}));
    stroke(&mut document, &[[4.0, 4.0, 4.0]]);
    // 0.64 of a step of opacity is one, and the hue is whole.
    assert_eq!(document.state().unwrap().one().colour.texel([4, 4, 4]).unwrap(), [255, 128, 51, 1]);
}

#[test]
fn a_hundred_weak_removals_reach_the_value_that_was_asked_for() {
    for voxels in [Voxels::U8(vec![250; 16 * 16 * 16]), Voxels::U16((0..16 * 16 * 16).map(|i| i * 16).collect())] {
        let Some(mut document) = of(voxels, [16; 3], DVec3::ONE) else { return };
        let settings = json!({"radius_mm":4,"falloff":"hard","strength":0.1,"erase":true,"target":{"density":1},
            "erase_density":{"to":7}});
        brush(&mut document, settings);
        for _ in 0..100 {
            stroke(&mut document, &[[8.0, 8.0, 8.0]]);
        }
        let value = |v: [u32; 3]| document.state().unwrap().one().density.value(v).unwrap();
        let inside = |v: &[u32; 3]| DVec3::from_array(v.map(f64::from)).distance(DVec3::splat(8.0)) < 4.0;
        let other: Vec<_> = each([16; 3]).filter(inside).filter(|&v| value(v) != 7.0).collect();
        assert!(other.is_empty(), "{} voxels are not 7, one is {}", other.len(), value(other[0]));
    }
}
