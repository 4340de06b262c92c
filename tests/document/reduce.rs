//! What a command does to the scene is one pure function: what the window foretells is what the document does.

use super::effects::one_of_each;
use super::maker::{labelled, run};
use burin::document::{Command, Document, Ground, Scene};
use serde_json::{Value, json};

fn command(line: &Value) -> Command {
    serde_json::from_value(line.clone()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// The document's scene after a command by the reducer alone; `None` if it refuses.
fn foretold(document: &Document, line: &Value) -> Option<Scene> {
    let state = document.state().unwrap();
    let volume = state.at(None).unwrap();
    let bounds = state.bounds();
    let ground = Ground { grid: volume.grid(), bounds, histogram: &volume.volume.histogram, poses: document.poses() };
    let mut scene = state.scene.clone();
    match scene.apply(&command(line), &ground) {
        Ok(_) => Some(scene),
        Err(_) => {
            assert_eq!(scene, state.scene, "{line}: refused, and changed");
            None
        }
    }
}

#[test]
fn the_document_does_to_the_scene_what_was_foretold() {
    // What needs a picture, files, voxels or the past is not the scene's to tell, and what would write files is not tried here.
    let elsewhere = ["project", "volume", "sub_volume", "render", "stroke", "history", "selection", "component"];
    let mut held = 0;
    for line in one_of_each() {
        let noun = line.as_object().unwrap().keys().next().unwrap().clone();
        // What is given of a volume is the scene's; voxels are not.
        if elsewhere.contains(&&*noun) && line.pointer("/volume/set").is_none() {
            continue;
        }
        let mut document = labelled();
        let before = document.state().unwrap().scene.clone();
        let scene = foretold(&document, &line);
        match run(&mut document, &line.to_string()) {
            Ok(_) => {
                assert_eq!(Some(&document.state().unwrap().scene), scene.as_ref(), "{line}");
                held += usize::from(scene.as_ref() != Some(&before));
            }
            Err(_) => assert_eq!(document.state().unwrap().scene, before, "{line}"),
        }
    }
    assert!(held > 20, "only {held} commands changed the scene");
}

#[test]
fn a_refused_command_leaves_a_scene_as_it_was() {
    let document = labelled();
    for line in [
        json!({"brush":{"set":{"radius_mm":-1}}}),
        json!({"brush":{"set":{"any_value":true,"range":[1,2]}}}),
        json!({"explosion":{"degree":{"value":11}}}),
        json!({"part":{"set":{"id":1,"name":"lobe","importance":0}}}),
        json!({"part":{"set":{"id":1,"own_colour":true,"colour":[1,0,0]}}}),
        json!({"part":{"move":{"id":7,"pose":{"rotation":[0,0,0,1],"translation":[0,0,0]}}}}),
        json!({"part":{"split":{"by":{"cuts":{"cuts":[{"part":1,"plane":{"normal":[1,1,0],"offset":0}}]}}}}}),
        json!({"part":{"split":{"by":{"cuts":{"cuts":[{"part":1,"plane":{"normal":[1,0,0],"offset":0}},{"part":1,"plane":{"normal":[0,1,0],"offset":0}}]}}}}}),
        json!({"part":{"split":{"by":{"depth":{"px":[1,1]}}}}}),
        json!({"view":{"crosshair":{"at":{"pixel":{"view":"3d","px":[1,1]}}}}}),
        json!({"view":{"look":{"shaded":false,"lighting":{"ambient":0.1,"diffuse":0.1,"specular":0.1,"power":2}}}}),
        json!({"segment":{"set":{"id":0}}}),
        json!({"segment":{"remove":{"id":7}}}),
    ] {
        assert_eq!(foretold(&document, &line), None, "{line}");
    }
}

/// Cuts name parts and planes at rest, so that they cut the same whatever is seen: two of them as two splits by planes.
#[test]
fn cuts_cut_as_splits_by_planes_do() {
    let mut by_planes = labelled();
    for (point, normal) in [([5, 0, 0], [1.0, 0.0, 0.0]), ([0, 8, 0], [0.0, 1.0, 0.0])] {
        let part = by_planes.state().unwrap().scene.explosion.parts[0].id;
        let line = json!({"part":{"split":{"by":{"plane":{"point":point,"normal":normal,"part":part}}}}});
        run(&mut by_planes, &line.to_string()).unwrap();
    }
    let mut by_cuts = labelled();
    let cuts = json!([
        {"part":1,"plane":{"normal":[1,0,0],"offset":5}},
        {"part":2,"plane":{"normal":[0,1,0],"offset":8}},
    ]);
    let line = json!({"part":{"split":{"by":{"cuts":{"cuts":cuts,"name":"Two cuts"}}}}});
    let answer = run(&mut by_cuts, &line.to_string()).unwrap();
    assert_eq!((&answer["step"], &answer["parts"]), (&json!("Two cuts"), &json!(3)));
    assert_eq!(answer["halves"], json!([[2, 3], [4, 5]]));
    let parts = |d: &Document| d.state().unwrap().scene.explosion.clone();
    assert_eq!(parts(&by_cuts), parts(&by_planes));
}

/// A copy of a scene costs a pointer a component: whoever keeps one shares all that a command leaves alone.
#[test]
fn a_command_copies_the_component_that_it_changes_and_shares_the_others() {
    let mut changed = 0;
    for line in one_of_each() {
        let document = labelled();
        let before = document.state().unwrap().scene.clone();
        let Some(after) = foretold(&document, &line) else { continue };
        let Scene { volumes, shown, transfer, look, views, layers, brush, also, explosion, own_looks, focus, .. } =
            &before;
        let Scene { annotations, labels, cutaways, .. } = &before;
        let shared = [
            volumes.is_same(&after.volumes),
            shown.is_same(&after.shown),
            transfer.is_same(&after.transfer),
            look.is_same(&after.look),
            views.is_same(&after.views),
            layers.is_same(&after.layers),
            brush.is_same(&after.brush),
            also.is_same(&after.also),
            explosion.is_same(&after.explosion),
            own_looks.is_same(&after.own_looks),
            focus.is_same(&after.focus),
            annotations.is_same(&after.annotations),
            labels.is_same(&after.labels),
            cutaways.is_same(&after.cutaways),
        ];
        // How a volume is shown is asked to be changed before the document's own look is.
        let copied = shared.iter().enumerate().filter(|(i, shared)| *i != 1 && !**shared).count();
        assert!(copied <= 1, "{line}: {shared:?}");
        changed += copied;
    }
    assert!(changed > 20, "only {changed} commands changed the scene");
}
