//! What of a volume a brush may touch: limits alone and together, against sets of voxels found by plain loops.

use super::maker::run;
use super::maker_gpu::{labelled, made};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Voxels;
use serde_json::{Value, json};
use std::collections::BTreeSet;

const DIMS: [u32; 3] = [40, 44, 38];

type Set = BTreeSet<[u32; 3]>;

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap()
}

fn all() -> impl Iterator<Item = [u32; 3]> {
    (0..DIMS[2]).flat_map(|z| (0..DIMS[1]).flat_map(move |y| (0..DIMS[0]).map(move |x| [x, y, z])))
}

/// Values of 0 or 200 by `inside`; what is above 105 shows.
fn document(spacing: DVec3, inside: impl Fn([u32; 3]) -> bool) -> Option<Document> {
    let voxels = all().map(|v| if inside(v) { 200 } else { 0 }).collect();
    let mut document = made(Voxels::U8(voxels), DIMS, spacing)?;
    say(
        &mut document,
        json!({"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0],[100,0],[110,1]],"unit_mm":1}}}}),
    );
    say(&mut document, json!({"view":{"size":{"view":"3d","size":[128,128]}}}));
    say(&mut document, json!({"view":{"frame":{"from":[0,1,0]}}}));
    say(&mut document, json!({"brush":{"set":{"falloff":"hard"}}}));
    Some(document)
}

fn ball(centre: DVec3, spacing: DVec3, radius: f64) -> Set {
    all().filter(|v| (DVec3::from_array(v.map(f64::from)) * spacing).distance(centre) <= radius).collect()
}

fn label(document: &mut Document, label: u16, at: DVec3, settings: Value) -> (Value, Set) {
    say(document, json!({"brush":{"set":{"target":{"label":label}}}}));
    say(document, json!({"brush":{"set":settings}}));
    let answer = say(document, json!({"stroke":{"paint":{"points":[{"at":{"mm":at.to_array()}}]}}}));
    (answer, labelled(document, label).into_iter().collect())
}

#[test]
fn a_depth_reaches_no_further_behind_the_surface_that_is_seen() {
    let spacing = DVec3::new(1.0, 0.8, 1.5);
    let front = 30_u32;
    let Some(mut document) = document(spacing, |v| (16..=front).contains(&v[1])) else { return };
    let centre = DVec3::new(19.2, f64::from(front) * 0.8 + 0.3, 28.1);
    for (n, depth) in [0.0, 0.9, 2.5, 4.1].into_iter().enumerate() {
        let settings = json!({"radius_mm":8,"within_mm":depth});
        let (_, found) = label(&mut document, n as u16 + 1, centre, settings);
        // Lines of sight lean a little: only the surface's own layer is seen here, whose distance is along y alone.
        let near = |v: &[u32; 3]| (f64::from(v[1]) - f64::from(front)).abs() * 0.8 <= depth + 1e-9;
        let expected: Set = ball(centre, spacing, 8.0).into_iter().filter(near).collect();
        assert_eq!(found, expected, "{depth}");
    }
    // From behind nothing of it is seen.
    say(&mut document, json!({"view":{"frame":{"from":[0,-1,0]}}}));
    let (answer, found) = label(&mut document, 9, centre, json!({"within_mm":1.0}));
    assert!(found.is_empty());
    assert!(answer["nothing"].as_str().unwrap().contains("within 1 mm"), "{answer}");
    // Without the limit the whole ball is painted.
    let (_, found) = label(&mut document, 9, centre, json!({"any_depth":true}));
    assert_eq!(found, ball(centre, spacing, 8.0));
}

#[test]
fn sides_of_segments_and_of_the_selection_count_together_with_the_range_of_values() {
    let spacing = DVec3::new(1.0, 1.3, 0.7);
    let matter = |v: [u32; 3]| !(v[0] + v[1] * 2 + v[2]).is_multiple_of(3);
    let Some(mut document) = document(spacing, matter) else { return };
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z) * spacing;
    let (a, b, c) = (at(18.0, 20.0, 18.0), at(22.0, 22.0, 20.0), at(20.0, 18.0, 24.0));
    let (_, first) = label(&mut document, 1, a, json!({"radius_mm":8}));
    assert_eq!(first, ball(a, spacing, 8.0));
    say(&mut document, json!({"brush":{"set":{"target":{"selection":0.6},"radius_mm":7}}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":b.to_array()}}]}}}));
    let selected = ball(b, spacing, 7.0);
    // A selection of less than a half is none.
    say(&mut document, json!({"brush":{"set":{"target":{"selection":0.4},"radius_mm":4}}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":a.to_array()}}]}}}));
    let selected: Set = selected.difference(&ball(a, spacing, 4.0)).copied().collect();
    for (n, (of_segment, of_selection, range)) in [
        (Some("inside"), None, false),
        (Some("outside"), None, false),
        (None, Some("inside"), true),
        (None, Some("outside"), false),
        (Some("inside"), Some("outside"), true),
        (Some("outside"), Some("inside"), true),
    ]
    .into_iter()
    .enumerate()
    {
        let mut only = json!({});
        if let Some(side) = of_segment {
            only["segment"] = json!({"id":1,"side":side});
        }
        if let Some(side) = of_selection {
            only["selection"] = json!(side);
        }
        let mut settings = json!({"radius_mm":9,"only":only,"any_value":!range});
        if range {
            settings["range"] = json!([150, 250]);
        }
        let (_, found) = label(&mut document, n as u16 + 2, c, settings);
        let lets = |side: Option<&str>, inside: bool| side.is_none_or(|side| (side == "inside") == inside);
        let expected: Set = ball(c, spacing, 9.0)
            .into_iter()
            .filter(|v| lets(of_segment, first.contains(v)) && lets(of_selection, selected.contains(v)))
            .filter(|v| !range || matter(*v))
            .collect();
        assert!(!expected.is_empty());
        assert_eq!(found, expected, "{of_segment:?} {of_selection:?} {range}");
        say(&mut document, json!({"history":{"undo":{}}}));
    }
    let (answer, _) = label(
        &mut document,
        9,
        c,
        json!({"radius_mm":1,"any_value":true,"only":{"segment":{"id":77,"side":"inside"}}}),
    );
    assert!(answer["nothing"].as_str().unwrap().contains("inside the segment 77"), "{answer}");
}

#[test]
fn only_what_hangs_together_with_the_strokes_beginning_is_painted() {
    // Two slabs with a gap between them; a bridge joins them far from the brush, or does not.
    for bridge in [false, true] {
        let slab = |v: [u32; 3]| (4..18).contains(&v[1]) || (20..34).contains(&v[1]);
        let matter = |v: [u32; 3]| slab(v) || bridge && v[0] == 2 && v[2] == 3;
        let Some(mut document) = document(DVec3::ONE, matter) else { return };
        let centre = DVec3::new(20.0, 17.2, 18.0);
        let (_, found) = label(&mut document, 1, centre, json!({"radius_mm":9,"connected":true}));
        let near = |v: &[u32; 3]| matter(*v) && (bridge || v[1] < 18);
        let expected: Set = ball(centre, DVec3::ONE, 9.0).into_iter().filter(near).collect();
        assert_eq!(found, expected, "{bridge}");
        // Where the look shows all, all hangs together.
        let open = json!({"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0.1]],"unit_mm":1}}}});
        say(&mut document, open);
        let (_, found) = label(&mut document, 2, centre, json!({"connected":true}));
        assert_eq!(found, ball(centre, DVec3::ONE, 9.0), "{bridge}");
    }
    let Some(mut document) = document(DVec3::ONE, |v| v[1] < 10) else { return };
    let nowhere = DVec3::new(20.0, 30.0, 20.0);
    let (answer, found) = label(&mut document, 1, nowhere, json!({"radius_mm":30,"connected":true}));
    assert!(found.is_empty());
    assert!(answer["nothing"].as_str().unwrap().contains("connected"), "{answer}");
}

#[test]
fn a_limit_that_is_none_is_refused_by_name_and_old_brushes_have_none() {
    let Some(mut document) = document(DVec3::ONE, |_| true) else { return };
    for (set, said) in [
        (json!({"within_mm":-1}), "within_mm"),
        (json!({"within_mm":1,"any_depth":true}), "any_depth"),
        (json!({"mirror":{"points":[[0,0,0],[1,1,1],[2,2,2]]}}), "mirror.points"),
        (json!({"mirror":{"plane":{"normal":[0,0,2],"offset":1}}}), "mirror.plane"),
        (json!({"mirror":{"face":{"part":77,"face":0}}}), "mirror.face.part"),
        (json!({"mirror":{"face":{"part":1,"face":9}}}), "mirror.face.face"),
    ] {
        let error = run(&mut document, &json!({"brush":{"set":set}}).to_string()).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let old = r#"{"shape":"sphere","radius_mm":3.0,"falloff":"hard","strength":1.0,"operation":"replace","tip":"wash",
        "target":{"label":2},"spacing":0.25,"range":null,"erase":false}"#;
    let brush: burin::paint::Brush = serde_json::from_str(old).unwrap();
    assert!(!brush.is_limited() && brush.mirror.is_off());
}
