//! Looks of labels, selections and parts as a document draws them: what is hidden stays so, and slices let what lies under them through.

use super::looks_drawn::{SIZE, body, compare, looks, say, three, value};
use crate::common::gpu::gpu;
use burin::document::{Document, SlicePlane, ViewName};
use burin::gpu::{Body, LabelLooks, Look, Mask};
use burin::math::DVec2;
use burin::volume::*;
use serde_json::{Value, json};
use std::sync::Arc;

#[test]
fn hidden_labels_stay_hidden_whatever_their_look_and_light_and_surfaces_are_those_of_their_segment() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    say(&mut document, json!({"view":{"layer":{"field":"labels","visible":false,"opacity":0.5}}}));
    for id in [0, 1] {
        say(&mut document, json!({"volume":{"set":{"volume":id,"visible":false}}}));
    }
    say(&mut document, json!({"view":{"look":{"step_voxels":0.5 / 2.3}}}));
    let segment = |document: &mut Document, id: u32, look: Value| {
        say(document, json!({"segment":{"set":{"id":id,"volume":2,"look":look}}}));
    };
    // In one piece at rest it is the body that is no part.
    let by_label = |default, rows: &[(u16, Option<usize>)]| {
        let table = LabelLooks { default, by_label: rows.iter().copied().collect() };
        Body { labels: Some(Arc::new(table)), look: None, ..body(0, 2) }
    };
    let flat = looks().remove(2);
    segment(&mut document, 3, json!({"opacity": 0.5}));
    say(&mut document, json!({"segment":{"show_only":{"ids":[0, 1],"volume":2}}}));
    let alone = by_label(None, &[(0, Some(0)), (1, Some(0))]);
    compare(&mut document, vec![alone], vec![flat.clone()], "two labels alone");
    say(&mut document, json!({"segment":{"show_only":{"volume":2}}}));
    segment(&mut document, 3, json!({"shaded": true, "opacity": 1}));
    let lit = Look { lighting: Some(Lighting::default()), ..flat.clone() };
    compare(&mut document, vec![by_label(Some(0), &[(3, Some(1))])], vec![flat.clone(), lit], "one of them lit");
    segment(&mut document, 3, json!("inherit"));
    segment(&mut document, 1, json!({"mode": {"iso": 0.8}}));
    segment(&mut document, 3, json!({"mode": {"iso": 3.4}}));
    let surface = |value| Look { mode: Mode::Iso(value), ..flat.clone() };
    let two = vec![by_label(Some(0), &[(1, None), (3, None)]), by_label(None, &[(1, Some(1)), (3, Some(2))])];
    compare(&mut document, two, vec![flat.clone(), surface(0.8), surface(3.4)], "two surfaces");
    for id in [1, 3] {
        segment(&mut document, id, json!("inherit"));
    }
    // Nothing has a look for itself but what is selected.
    say(&mut document, json!({"selection":{"from_label":{"label":2,"volume":2}}}));
    say(&mut document, json!({"selection":{"set":{"volume":2,"look":{"opacity":0.2}}}}));
    let masked = |id, look, mask| Body { look: Some(look), mask, ..body(id, 2) };
    let weak = Look { opacity: 0.2, ..flat.clone() };
    let bodies = vec![masked(1, 0, Mask::Background), masked(0, 1, Mask::Selection)];
    compare(&mut document, bodies, vec![flat.clone(), weak], "the selection alone");
    say(&mut document, json!({"selection":{"clear":{"volume":2}}}));
    // A part that is hidden hides its share of every volume.
    let split = json!({"part":{"split":{"by":{"plane":{"point":[18,12,12],"normal":[1,0.2,0]}}}}});
    let halves = say(&mut document, split)["halves"][0].clone();
    say(&mut document, json!({"part":{"set":{"id":halves[1],"visible":false}}}));
    let id = halves[0].as_u64().unwrap() as u32;
    let left = document.state().unwrap().scene.explosion.parts.iter().find(|part| part.id.0 == id);
    let region = left.unwrap().faces.iter().filter(|face| face.cut).map(|face| face.plane).collect();
    compare(&mut document, vec![Body { region, ..masked(id, 0, Mask::None) }], vec![flat], "one half");
    say(&mut document, json!({"part":{"reset":{}}}));
    // Where no voxel has a label that is shown, nothing is.
    say(&mut document, json!({"volume":{"set":{"volume":2,"visible":false}}}));
    say(&mut document, json!({"volume":{"set":{"volume":0,"visible":true}}}));
    say(&mut document, json!({"segment":{"set":{"id":1,"volume":0}}}));
    say(&mut document, json!({"segment":{"show_only":{"ids":[1],"volume":0}}}));
    let image = document.picture(ViewName::ThreeD, SIZE, None).unwrap();
    assert!(image.colour.iter().all(|c| c[3] == 0.0), "nothing of it has the label");
}

#[test]
fn slices_let_what_lies_under_maps_of_labels_and_hidden_densities_through() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    for (id, level, width) in [(0, 450.0, 500.0), (1, 400.0, 700.0)] {
        say(&mut document, json!({"view":{"window":{"volume":id,"level":level,"width":width}}}));
    }
    say(&mut document, json!({"view":{"size":{"view":"axial","size":SIZE}}}));
    for (active, seen, hidden) in [(0, [0, 2], None), (2, [0, 2], None), (1, [0, 1], Some(1)), (1, [0, 1], Some(0))] {
        for id in [0, 1, 2] {
            say(&mut document, json!({"view":{"layer":{"field":"density","visible":hidden != Some(id),"volume":id}}}));
            let line = json!({"volume":{"set":{"volume":id,"visible":seen.contains(&id),"active":id == active}}});
            say(&mut document, line);
        }
        let picture = document.picture(ViewName::Axial, SIZE, None).unwrap();
        let state = document.state().unwrap();
        let plane = SlicePlane::new(state.at(None).unwrap().grid(), &state.scene.views, ViewName::Axial).unwrap();
        let map = state.subject(VolumeId(2)).unwrap();
        let (mut both, mut largest) = (0, 0.0_f64);
        for (i, got) in picture.colour.iter().enumerate() {
            let px = DVec2::new((i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5);
            let world = plane.world(px);
            let [Some(low), Some(high)] = seen.map(|id| value(state, id, world)) else { continue };
            let grey = |value: f64, level: f64, width: f64| ((value - level) / width + 0.5).clamp(0.0, 1.0);
            let (low, high) = (grey(low, 450.0, 500.0), grey(high, 400.0, 700.0));
            let over = f64::from(0.7_f32);
            let expected = match hidden {
                Some(1) => [low; 3],
                Some(_) => [high * over; 3],
                None => {
                    let place = map.grid().index_from_world().transform_point3(world) + 0.5;
                    if place.to_array().iter().any(|v| (v - v.round()).abs() < 1e-3) {
                        continue;
                    }
                    let label = map.labels.value(place.floor().to_array().map(|v| v as u32)).unwrap() as u16;
                    let colour = map.settings.segments.colour_of(label).map(f64::from);
                    colour.map(|c| if label > 0 { 0.5 * low + 0.5 * c } else { low })
                }
            };
            both += 1;
            let [r, g, b] = expected;
            let off = (0..4).map(|c| (f64::from(got[c]) - [r, g, b, 1.0][c]).abs()).fold(0.0, f64::max);
            largest = largest.max(off * 255.0);
        }
        assert!(both > 200 && largest <= 1.5, "active {active}, hidden {hidden:?}: off by {largest}, {both} pixels");
    }
}

#[test]
fn a_part_is_seen_in_its_colour_and_its_look_goes_with_the_last_volume() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    let own_looks = |document: &mut Document| say(document, json!({"ask":{"scene":{}}}))["scene"]["own_looks"].clone();
    for id in [1, 2] {
        say(&mut document, json!({"volume":{"set":{"volume":id,"visible":false}}}));
    }
    say(&mut document, json!({"part":{"set":{"id":1,"colour":[0.2,0.5,1.0],"look":{"opacity":0.5}}}}));
    if gpu().is_some() {
        let weak = Look { opacity: 0.5, ..looks().remove(0) };
        let tinted = Body { tint: Some([0.2, 0.5, 1.0]), look: Some(0), ..body(1, 0) };
        compare(&mut document, vec![tinted], vec![weak], "tinted");
    }
    let dressed = own_looks(&mut document);
    assert_eq!(dressed["parts"]["1"]["opacity"], 0.5);
    for id in [0, 1, 2] {
        say(&mut document, json!({"volume":{"remove":{"volume":id}}}));
    }
    // What comes next is in one piece that nobody has said anything of.
    say(&mut document, json!({"volume":{"add":{"path":dir.path().join("a.nrrd")}}}));
    assert_eq!(own_looks(&mut document), Value::Null);
    say(&mut document, json!({"history":{"undo":{"steps":4}}}));
    assert_eq!(own_looks(&mut document), dressed);
}
