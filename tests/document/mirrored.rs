//! Strokes that are mirrored across a plane: both sides are painted in one step.

use super::maker::run;
use super::maker_gpu::{labelled, made};
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::{FieldKind, Voxels};
use serde_json::{Value, json};
use std::collections::BTreeSet;

const DIMS: [u32; 3] = [40; 3];

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap()
}

fn cube(spacing: DVec3) -> Option<Document> {
    made(Voxels::U8(vec![7; 64_000]), DIMS, spacing)
}

fn stroke(document: &mut Document, settings: Value) -> BTreeSet<[u32; 3]> {
    say(document, json!({"brush":{"set":settings}}));
    say(
        document,
        json!({"stroke":{"paint":{"points":[{"at":{"index":[6.3,11.2,9.1]}},{"at":{"index":[14.0,20.5,17.7]}}]}}}),
    );
    labelled(document, 1).into_iter().collect()
}

/// What a stroke paints on both sides is what it paints on one, and the image of that.
fn both_sides(spacing: DVec3, mirror: Value, image: impl Fn([u32; 3]) -> [u32; 3]) {
    let settings = json!({"falloff":"hard","radius_mm":3.1,"target":{"label":1}});
    let Some(mut plain) = cube(spacing) else { return };
    let one = stroke(&mut plain, settings.clone());
    let Some(mut document) = cube(spacing) else { return };
    let mut settings = settings;
    settings["mirror"] = mirror;
    let found = stroke(&mut document, settings);
    let images: BTreeSet<_> = one.iter().map(|v| image(*v)).collect();
    assert_ne!(one, images);
    assert_eq!(found, one.union(&images).copied().collect::<BTreeSet<_>>());
    say(&mut document, json!({"history":{"undo":{}}}));
    assert!(labelled(&document, 1).is_empty(), "one step takes both sides back");
    say(&mut document, json!({"history":{"redo":{}}}));
    assert_eq!(labelled(&document, 1).len(), found.len());
}

#[test]
fn a_stroke_has_its_image_across_the_volumes_middle() {
    let spacing = DVec3::new(0.7, 1.0, 1.6);
    both_sides(spacing, json!({"axis":"x"}), |[x, y, z]| [39 - x, y, z]);
    both_sides(spacing, json!({"axis":"y"}), |[x, y, z]| [x, 39 - y, z]);
    both_sides(spacing, json!({"axis":"z"}), |[x, y, z]| [x, y, 39 - z]);
}

#[test]
fn a_stroke_has_its_image_across_three_points_and_any_plane() {
    both_sides(DVec3::ONE, json!({"points":[[0,0,0],[5,5,0],[0,0,9]]}), |[x, y, z]| [y, x, z]);
    both_sides(DVec3::ONE, json!({"plane":{"normal":[0,0,1],"offset":15.5}}), |[x, y, z]| [x, y, 31 - z]);
}

#[test]
fn a_parts_face_is_a_plane_to_mirror_across() {
    let Some(mut document) = cube(DVec3::ONE) else { return };
    say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[16.5,0,0],"normal":[1,0,0]}}}}}));
    let parts = say(&mut document, json!({"ask":{"parts":{}}}));
    let part = &parts["parts"][0];
    let faces = part["faces"].as_array().unwrap();
    let face = faces.iter().position(|f| f["cut"] == true).unwrap();
    let settings = json!({"falloff":"hard","radius_mm":3.1,"target":{"label":1},
        "mirror":{"face":{"part":part["id"],"face":face}}});
    let found = stroke(&mut document, settings);
    assert!(!found.is_empty());
    assert!(found.iter().all(|[x, y, z]| *x > 33 || found.contains(&[33 - x, *y, *z])), "symmetric about 16.5");
    assert!(found.contains(&[6, 11, 9]) && found.contains(&[27, 11, 9]));
}

#[test]
fn a_dab_on_the_plane_adds_up_once() {
    let texels = |document: &Document| {
        document.state().unwrap().one().field(FieldKind::Selection).read(0, [0; 3], DIMS).unwrap()
    };
    let mut painted = Vec::new();
    for mirror in [json!("off"), json!({"axis":"x"})] {
        let Some(mut document) = cube(DVec3::ONE) else { return };
        let settings =
            json!({"radius_mm":4,"strength":0.4,"tip":"build_up","target":{"selection":1.0},"mirror":mirror});
        say(&mut document, json!({"brush":{"set":settings}}));
        say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"index":[19.5,20,20]}}]}}}));
        painted.push(texels(&document));
    }
    assert!(painted[0].iter().any(|v| *v > 0));
    assert_eq!(painted[0], painted[1]);
}
