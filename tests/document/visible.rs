//! Strokes that keep to what is visible, where the look at it is difficult: pictures coarser than voxels, an eye within the ball;
//! what is seen of a stroke that still runs, and which looks count.

use super::maker::run;
use super::maker_gpu::{block, labelled, made};
use crate::common::one::One;
use burin::document::{Document, ViewName};
use burin::math::{DVec2, DVec3};
use burin::volume::Voxels;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::time::Duration;

const DIMS: [u32; 3] = [64; 3];

/// A plate whose front face is the layer y = 53, seen from the front in a picture of this many pixels.
fn plate(size: u32) -> Option<Document> {
    let inside = |x: u32, y: u32, z: u32| (4..60).contains(&x) && (40..54).contains(&y) && (4..60).contains(&z);
    let voxels = (0..DIMS.iter().product::<u32>())
        .map(|i| if inside(i % 64, i / 64 % 64, i / 4096) { 200 } else { 0 })
        .collect();
    let mut document = made(Voxels::U8(voxels), DIMS, DVec3::ONE)?;
    for line in [
        json!({"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0],[100,0],[110,1]],"unit_mm":1}}}}),
        json!({"view":{"size":{"view":"3d","size":[size, size]}}}),
        json!({"view":{"frame":{"from":[0,1,0]}}}),
        json!({"brush":{"set":{"falloff":"hard","target":{"label":1},"visible_only":true}}}),
    ] {
        run(&mut document, &line.to_string()).unwrap();
    }
    Some(document)
}

/// Paints at one place of the world, mm.
fn click(document: &mut Document, at: DVec3, radius: f64) -> Value {
    run(document, &json!({"brush":{"set":{"radius_mm":radius}}}).to_string()).unwrap();
    let line = json!({"stroke":{"paint":{"points":[{"at":{"mm":at.to_array()}}]}}});
    run(document, &line.to_string()).unwrap()
}

/// The voxels of the front layer in a ball.
fn layer(centre: DVec3, radius: f64) -> BTreeSet<[u32; 3]> {
    let all = (4..60).flat_map(|x| (4..60).map(move |z| [x, 53, z]));
    all.filter(|v| DVec3::from_array(v.map(f64::from)).distance(centre) <= radius).collect()
}

#[test]
fn a_picture_coarser_than_the_voxels_leaves_no_hole_in_what_is_painted() {
    for size in [256, 40, 16] {
        for projection in ["perspective", "orthographic"] {
            let Some(mut document) = plate(size) else { return };
            if projection == "orthographic" {
                let camera = json!({"eye":[31.5,120,31.5],"target":[31.5,31.5,31.5],"up":[0,0,1],
                    "projection":{"orthographic":{"height_mm":90}}});
                run(&mut document, &json!({"view":{"camera":{"camera":camera}}}).to_string()).unwrap();
            }
            let centre = DVec3::new(27.3, 53.4, 35.8);
            click(&mut document, centre, 13.0);
            let painted: BTreeSet<_> = labelled(&document, 1).into_iter().collect();
            let wanted = layer(centre, 13.0);
            let missing = wanted.difference(&painted).count();
            let beneath = painted.iter().filter(|v| v[1] != 53).count();
            assert_eq!((missing, beneath), (0, 0), "of {}, {projection}, {size} pixels", wanted.len());
        }
    }
}

#[test]
fn a_ball_about_the_eye_paints_what_is_seen_within_it() {
    let Some(mut document) = plate(128) else { return };
    // The eye is 6 mm before the face, the ball's centre 2 mm behind the eye, or a little before it.
    for (label, centre) in [(1, 62.0), (2, 57.0)] {
        let eye = 60.0;
        let camera = json!({"eye":[31.5,eye,31.5],"target":[31.5,31.5,31.5],"up":[0,0,1],
            "projection":{"perspective":{"fov_y_deg":60}}});
        run(&mut document, &json!({"view":{"camera":{"camera":camera}}}).to_string()).unwrap();
        run(&mut document, &json!({"brush":{"set":{"target":{"label":label}}}}).to_string()).unwrap();
        let centre = DVec3::new(31.5, centre, 31.5);
        let answer = click(&mut document, centre, 10.0);
        // Within the cone of 60 degrees, 6.5 mm away: 3.75 mm to each side, and a voxel less at its rim.
        let seen: BTreeSet<[u32; 3]> = layer(centre, 10.0)
            .into_iter()
            .filter(|v| [v[0], v[2]].iter().all(|&c| (f64::from(c) - 31.5).abs() < 2.7))
            .collect();
        assert!(seen.len() >= 16);
        let painted: BTreeSet<_> = labelled(&document, label).into_iter().collect();
        assert!(
            seen.is_subset(&painted),
            "{answer}: {} of {} painted",
            seen.intersection(&painted).count(),
            seen.len()
        );
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
    // Far behind the eye nothing is looked at.
    let answer = click(&mut document, DVec3::new(31.5, 90.0, 31.5), 10.0);
    assert!(answer["nothing"].is_string(), "{answer}");
}

#[test]
fn matter_that_is_painted_into_the_clear_is_seen_before_the_stroke_ends() {
    let Some(mut document) = block() else { return };
    run(&mut document, r#"{"brush":{"set":{"target":{"density":200},"radius_mm":3,"falloff":"hard"}}}"#).unwrap();
    // Over the block, where all is clear.
    let at = DVec3::new(30.0, 24.0, 36.0);
    let camera = document.state().unwrap().scene.views.camera;
    let px = camera.project(at, [96, 96]).unwrap().0;
    let covered = |document: &mut Document| {
        let image = document.picture(ViewName::ThreeD, [96, 96], None).unwrap();
        let DVec2 { x, y } = px.floor();
        image.colour[x as usize + 96 * y as usize][3]
    };
    assert_eq!(covered(&mut document), 0.0);
    let begin = json!({"stroke":{"begin":{"points":[{"at":{"mm":at.to_array()}}]}}});
    run(&mut document, &begin.to_string()).unwrap();
    let shows = (0..1000).any(|_| {
        std::thread::sleep(Duration::from_millis(2));
        covered(&mut document) > 0.5
    });
    assert!(shows && document.is_painting());
    run(&mut document, r#"{"stroke":{"cancel":{}}}"#).unwrap();
    assert_eq!(covered(&mut document), 0.0);
}

#[test]
fn strokes_that_keep_to_the_visible_go_by_the_looks_of_segments_and_of_the_selection() {
    let Some(mut document) = plate(96) else { return };
    let say = |document: &mut Document, line: Value| run(document, &line.to_string()).unwrap();
    let centre = DVec3::new(31.5, 53.4, 31.5);
    click(&mut document, centre, 13.0);
    say(&mut document, json!({"brush":{"set":{"target":{"label":2}}}}));
    // The first layer's segment is not there any more: the one under it is seen and painted.
    say(&mut document, json!({"segment":{"set":{"id":1,"look":{"opacity":0}}}}));
    click(&mut document, centre, 6.0);
    let painted: BTreeSet<_> = labelled(&document, 2).into_iter().collect();
    let under = layer(centre + DVec3::Y, 6.0).into_iter().map(|[x, _, z]| [x, 52, z]).collect();
    assert_eq!(painted, under);
    say(&mut document, json!({"history":{"undo":{}}}));
    say(&mut document, json!({"segment":{"set":{"id":1,"look":"inherit"}}}));
    // Nothing is seen but what is selected.
    say(&mut document, json!({"selection":{"from_label":{"label":1}}}));
    let seen = document.state().unwrap().scene.transfer.clone();
    say(&mut document, json!({"selection":{"set":{"look":{"transfer":*seen}}}}));
    let clear = json!({"colour":[[0,[1,1,1]]],"opacity":[[0,0]],"unit_mm":1});
    say(&mut document, json!({"transfer":{"set":{"function":clear}}}));
    click(&mut document, centre, 6.0);
    let painted: BTreeSet<_> = labelled(&document, 2).into_iter().collect();
    assert_eq!(layer(centre, 6.0).difference(&painted).count(), 0);
}

#[test]
fn a_surface_takes_the_whole_of_the_colour_that_is_painted_on_what_shows() {
    let Some(mut document) = plate(96) else { return };
    let say = |document: &mut Document, line: Value| run(document, &line.to_string()).unwrap();
    // Seen at an angle, so that the surface lies between other voxels from pixel to pixel.
    say(&mut document, json!({"view":{"frame":{"from":[0.5,1,0.3]}}}));
    say(&mut document, json!({"view":{"look":{"mode":{"iso":110},"shaded":false}}}));
    let brush = json!({"target":{"colour":[0.1,0.9,0.3,1]},"radius_mm":12,"visible_only":true});
    say(&mut document, json!({"brush":{"set":brush}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":[31.5,53.4,31.5]}}]}}}));
    let camera = document.state().unwrap().scene.views.camera;
    let image = document.picture(ViewName::ThreeD, [96, 96], None).unwrap();
    for at in [[31.5, 53.4, 31.5], [27.0, 53.4, 35.0], [36.0, 53.4, 30.0]] {
        let px = camera.project(DVec3::from_array(at), [96, 96]).unwrap().0.floor();
        let shown = image.colour[px.x as usize + 96 * px.y as usize];
        for (shown, painted) in shown.iter().zip([0.1, 0.9, 0.3]) {
            assert!((shown - painted).abs() < 2.5 / 255.0, "{at:?}: {shown} instead of {painted}");
        }
    }
    // Nothing lies behind the first surface: of the layers that are not mixed into it none is painted.
    let colour = &document.state().unwrap().one().colour;
    let painted = |y: u32| (20..44).any(|x| colour.texel([x, y, 31]).unwrap()[3] != 0);
    assert!(painted(53) && painted(54) && !painted(52) && !painted(55));
}

#[test]
fn what_is_painted_in_part_follows_the_transfer_function_that_is_set_afterwards() {
    let Some(mut document) = plate(96) else { return };
    let say = |document: &mut Document, line: Value| run(document, &line.to_string()).unwrap();
    say(&mut document, json!({"view":{"look":{"mode":{"iso":110},"shaded":false}}}));
    let (painted, share) = ([0.9, 0.1, 0.2], 0.4);
    let set = json!({"target":{"colour":[0.9,0.1,0.2,1]},"strength":share,"radius_mm":12});
    say(&mut document, json!({"brush":{"set":set}}));
    let at = DVec3::new(31.5, 53.4, 31.5);
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":at.to_array()}}]}}}));
    let camera = document.state().unwrap().scene.views.camera;
    let px = camera.project(at, [96, 96]).unwrap().0.floor();
    for matter in [[0.2, 0.3, 0.9], [0.9, 0.8, 0.1]] {
        let function = json!({"colour":[[0,matter]],"opacity":[[0,0],[100,0],[110,1]],"unit_mm":1});
        say(&mut document, json!({"transfer":{"set":{"function":function}}}));
        let image = document.picture(ViewName::ThreeD, [96, 96], None).unwrap();
        let shown = image.colour[px.x as usize + 96 * px.y as usize];
        for c in 0..3 {
            // Paint lies over matter by its opacity.
            let expected = share * painted[c] + (1.0 - share) * matter[c];
            assert!(
                (f64::from(shown[c]) - expected).abs() < 3.0 / 255.0,
                "{c}: {shown:?} where {matter:?} lies under it"
            );
        }
    }
}
