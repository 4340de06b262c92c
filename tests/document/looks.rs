//! Looks that volumes, the selection, parts and segments have for themselves: commands, undo, what is kept.

use super::maker::{labelled, run};
use burin::document::Document;
use serde_json::{Value, json};

const GREEN: &str = r#"{"colour":[[0.0,[0.0,1.0,0.0]]],"opacity":[[90.0,0.0],[110.0,1.0]],"unit_mm":1.0}"#;

fn own(document: &mut Document) -> Value {
    run(document, r#"{"ask":{"scene":{}}}"#).unwrap()["scene"]["own_looks"].clone()
}

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

#[test]
fn a_segment_a_part_and_the_selection_have_looks_that_inherit_what_they_do_not_say_and_are_undone() {
    let set = |of: &str, look: Value| match of {
        "segments" => json!({"segment":{"set":{"id":1,"look":look}}}),
        "parts" => json!({"part":{"set":{"id":1,"look":look}}}),
        _ => json!({"selection":{"set":{"look":look}}}),
    };
    for (of, place, step) in [
        ("segments", "/segments/0/1", "Look of segment Segment 1"),
        ("parts", "/parts/1", "Look of Part 1"),
        ("selections", "/selections/0", "Look of the selection"),
    ] {
        let mut document = labelled();
        let transfer: Value = serde_json::from_str(GREEN).unwrap();
        let answer = say(&mut document, set(of, json!({"transfer": transfer, "opacity": 0.5})));
        assert_eq!((&answer["step"], &answer["look"]["opacity"]), (&json!(step), &json!(0.5)), "{answer}");
        // What is not said is not kept: it goes on being inherited.
        let look = own(&mut document).pointer(place).cloned().unwrap();
        assert_eq!(look, answer["look"]);
        assert_eq!((&look["transfer"], look.get("mode"), look.get("lighting")), (&transfer, None, None));
        // A second change keeps what it does not name.
        let answer = say(&mut document, set(of, json!({"mode": {"iso": 100.0}, "shaded": false})));
        let look = &answer["look"];
        assert_eq!((&look["transfer"], &look["opacity"]), (&transfer, &json!(0.5)));
        assert_eq!((&look["mode"], &look["lighting"]), (&json!({"iso": 100.0}), &Value::Null));
        assert!(look.as_object().unwrap().contains_key("lighting"), "no light is said");
        let lit = say(&mut document, set(of, json!({"shaded": true})));
        assert!(lit["look"]["lighting"]["diffuse"].is_number(), "{lit}");
        say(&mut document, json!({"history":{"undo":{}}}));
        say(&mut document, json!({"history":{"undo":{}}}));
        assert_eq!(own(&mut document).pointer(place).unwrap()["transfer"], transfer);
        let kept = own(&mut document);
        say(&mut document, set(of, json!("inherit")));
        assert_eq!(own(&mut document), Value::Null, "as if nobody had said anything");
        say(&mut document, json!({"history":{"undo":{}}}));
        assert_eq!(own(&mut document), kept);
        for (wrong, field) in [
            (json!({"opacity": 1.5}), "look.opacity"),
            (json!({"shaded": false, "lighting": {"ambient":0,"diffuse":1,"specular":0,"power":1}}), "look.lighting"),
            (json!({"mode": {"iso": f64::INFINITY}}), "look.mode"),
        ] {
            let line = set(of, wrong).to_string();
            match serde_json::from_str(&line) {
                Ok(command) => {
                    let error = document.apply(command).unwrap_err().to_string();
                    assert!(error.contains(field), "{error}");
                }
                Err(error) => assert!(field == "look.mode", "{error}"),
            }
        }
        assert_eq!(own(&mut document), kept, "what was refused changed nothing");
    }
    let error = serde_json::from_str::<burin::document::Command>(&set("parts", json!({"opaque": 1})).to_string());
    assert!(error.unwrap_err().to_string().contains("opaque"), "a wrong field is named");
}

#[test]
fn a_volumes_look_may_be_said_in_part_and_given_up_again() {
    let mut document = labelled();
    let shown =
        |document: &mut Document, look: Value| say(document, json!({"volume":{"set":{"volume":0,"look":look}}}));
    let before = document.state().unwrap().scene.transfer.clone();
    let answer = shown(&mut document, json!({"mode": "mip", "opacity": 0.25}));
    assert_eq!((&answer["look"]["mode"], &answer["opacity"]), (&json!("mip"), &json!(0.25)));
    assert_eq!(answer["look"]["transfer"], json!(*before), "as it was shown until then");
    let answer = shown(&mut document, json!({"lighting": null}));
    assert_eq!((&answer["look"]["mode"], &answer["look"]["lighting"]), (&json!("mip"), &Value::Null));
    assert_eq!(shown(&mut document, json!("inherit"))["look"], Value::Null);
    let both = json!({"volume":{"set":{"volume":0,"opacity":0.5,"look":{"opacity":0.5}}}});
    assert!(run(&mut document, &both.to_string()).unwrap_err().to_string().contains("look.opacity"));
    say(&mut document, json!({"history":{"undo":{"steps":3}}}));
    let state = document.state().unwrap();
    assert_eq!(state.scene.volumes.all[&burin::volume::VolumeId::FIRST].opacity, 1.0);
}

#[test]
fn labels_shown_alone_are_known_ones_and_all_show_again() {
    let mut document = labelled();
    let answer = say(&mut document, json!({"segment":{"show_only":{"ids":[2, 0]}}}));
    assert_eq!((&answer["only"], &answer["step"]), (&json!([0, 2]), &json!("Show some segments alone")));
    let error = run(&mut document, r#"{"segment":{"show_only":{"ids":[1, 77]}}}"#).unwrap_err().to_string();
    assert!(error.contains("77"), "{error}");
    assert_eq!(own(&mut document)["only"]["0"], json!([0, 2]));
    say(&mut document, json!({"segment":{"show_only":{}}}));
    assert_eq!(own(&mut document), Value::Null);
    say(&mut document, json!({"history":{"undo":{}}}));
    assert_eq!(own(&mut document)["only"]["0"], json!([0, 2]));
}

#[test]
fn halves_look_as_what_was_cut_and_what_is_gone_leaves_no_look_behind() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = labelled();
    document.keep_unsaved_in(dir.path().join("unsaved"));
    say(&mut document, json!({"part":{"set":{"id":1,"look":{"mode":"mip"}}}}));
    say(&mut document, json!({"segment":{"set":{"id":2,"look":{"opacity":0.3}}}}));
    let said = say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[0,0,0],"normal":[1,0,0]}}}}}));
    let halves = said["halves"][0].clone();
    say(&mut document, json!({"part":{"set":{"id":halves[0],"look":{"opacity":0.5}}}}));
    // Both are cut again.
    let said = say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[0,0,0],"normal":[0,1,0]}}}}}));
    let looks = own(&mut document);
    for (pair, opacity) in said["halves"].as_array().unwrap().iter().zip([Some(0.5), None]) {
        for id in pair.as_array().unwrap() {
            let look = looks.pointer(&format!("/parts/{id}")).unwrap();
            assert_eq!((&look["mode"], look["opacity"].as_f64()), (&json!("mip"), opacity), "{looks}");
        }
    }
    assert_eq!(looks["parts"].as_object().unwrap().len(), 4);
    // A plane that only some of them meet leaves the others as they are.
    let weak =
        |looks: &Value| looks["parts"].as_object().unwrap().values().filter(|look| look["opacity"] == 0.5).count();
    let bounds = document.state().unwrap().at(None).unwrap().grid().world_bounds();
    let mut weaker = Vec::new();
    for x in [bounds.min.x * 0.5, bounds.max.x * 0.5] {
        say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[x,0,0],"normal":[1,0,0]}}}}}));
        let cut = own(&mut document);
        let same = |id: &String, look: &Value| cut["parts"].get(id) == Some(look);
        let kept = looks["parts"].as_object().unwrap().iter().filter(|&(id, look)| same(id, look)).count();
        assert_eq!((cut["parts"].as_object().unwrap().len(), kept), (6, 2), "{looks}, then {cut}");
        weaker.push(weak(&cut));
        say(&mut document, json!({"history":{"undo":{}}}));
    }
    weaker.sort_unstable();
    assert_eq!((weak(&looks), weaker), (2, vec![2, 4]), "two of a look became four of it, or stayed two");
    say(&mut document, json!({"selection":{"set":{"look":{"mode":"mip"}}}}));
    say(&mut document, json!({"segment":{"show_only":{"ids":[0, 1]}}}));
    let looks = own(&mut document);
    // A project keeps them.
    let path = dir.path().join("p.burin");
    say(&mut document, json!({"project":{"save":{"path":path}}}));
    let mut again = Document::new();
    let copy = dir.path().join("copy.burin");
    say(&mut document, json!({"project":{"save":{"path":copy}}}));
    again.keep_unsaved_in(dir.path().join("unsaved"));
    say(&mut again, json!({"project":{"open":{"path":path}}}));
    assert_eq!(own(&mut again), looks);
    say(&mut document, json!({"segment":{"remove":{"id":2}}}));
    assert_eq!(own(&mut document).get("segments"), None);
    say(&mut document, json!({"part":{"reset":{}}}));
    assert_eq!(own(&mut document).as_object().unwrap().keys().collect::<Vec<_>>(), ["selections", "only"]);
    say(&mut document, json!({"history":{"undo":{"steps":2}}}));
    assert_eq!(own(&mut document), looks);
    say(&mut document, json!({"volume":{"remove":{"volume":0}}}));
    assert_eq!(own(&mut document).as_object().unwrap().keys().collect::<Vec<_>>(), ["parts"], "parts are of no volume");
    say(&mut document, json!({"history":{"undo":{}}}));
    assert_eq!(own(&mut document), looks);
}

#[test]
fn a_segment_that_is_removed_is_no_more_among_those_that_are_shown_alone_until_it_is_back() {
    let mut document = labelled();
    let only = |document: &mut Document| own(document).pointer("/only/0").cloned();
    for (shown, left) in [
        (json!([0, 1, 2]), Some(json!([0, 1]))),
        (json!([2, 1]), Some(json!([1]))),
        // Nothing would be left to be seen.
        (json!([2]), None),
        (json!([1]), Some(json!([1]))),
    ] {
        say(&mut document, json!({"segment":{"show_only":{"ids":shown}}}));
        let before = only(&mut document);
        say(&mut document, json!({"segment":{"remove":{"id":2}}}));
        assert_eq!(only(&mut document), left, "of {shown}");
        // One of the same number is another segment.
        say(&mut document, json!({"segment":{"set":{"id":2,"name":"Another"}}}));
        assert_eq!(only(&mut document), left, "of {shown}");
        say(&mut document, json!({"history":{"undo":{"steps":2}}}));
        assert_eq!(only(&mut document), before, "undone");
        say(&mut document, json!({"history":{"redo":{}}}));
        assert_eq!(only(&mut document), left, "done again");
        say(&mut document, json!({"history":{"undo":{}}}));
    }
}

#[test]
fn what_is_to_be_lit_is_lit_as_it_was_until_then_and_what_is_changed_beside_leaves_the_light() {
    let light = |ambient: f64| json!({"ambient": ambient, "diffuse": 0.5, "specular": 0.25, "power": 8.0});
    for noun in ["segment", "part", "selection", "volume"] {
        let mut document = labelled();
        say(&mut document, json!({"view":{"look":{"lighting": light(0.5)}}}));
        let mut given = |look: Value| {
            let fields = match noun {
                "selection" => json!({ "look": look }),
                "volume" => json!({"volume": 0, "look": look}),
                _ => json!({"id": 1, "look": look}),
            };
            say(&mut document, json!({noun:{"set":fields}}))["look"]["lighting"].clone()
        };
        assert_eq!(given(json!({"shaded": true})), light(0.5), "{noun}: as it is seen");
        assert_eq!(given(json!({"lighting": light(0.75)})), light(0.75), "{noun}");
        assert_eq!(given(json!({"shaded": true})), light(0.75), "{noun}: as its own was");
        assert_eq!(given(json!({"mode": "mip"})), light(0.75), "{noun}: another mode");
    }
}
